"""omega_e on a grid of parameters: against a, k, zeta, n, A, r."""

from collections.abc import Sequence
from typing import ClassVar, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.models import Model
from shakerproc.simulate.harmonic_balance import gap_severity, natural_frequencies
from shakerproc.simulate.harmonic_balance.from_model import system_of_model
from shakerproc.studies.estimators import in_words, omega_e, spectrum
from shakerproc.studies.kinds.base import AbstractKind, Job, label_of, said
from shakerproc.studies.placing import TEMPERATURE, clearance_of
from shakerproc.studies.results import Columns, Line, Panel, StudyResult
from shakerproc.studies.simulated import Motion, ensemble, simulated
from shakerproc.studies.study import Claim, Run, Study


@final
class Grid(AbstractKind):
    """omega_e of every combination; where it is chaotic, the spread of neighbouring runs."""

    needs: ClassVar[tuple[str, ...]] = ("model", "run", "vary")

    def compute(self, study: Study, job: Job) -> Columns:
        model, run = job.require()
        motion = simulated(model, run)
        found = spectrum(motion.of(study.measure.of), motion.sample_rate, study.measure)
        several = _spread(study, model, run, motion)
        natural = _closed_frequency(model, run)
        value = omega_e(found, study.measure)
        severity = max(gap_severity(model, run.level).values(), default=np.nan)
        return {
            "omega_e_hz": np.array([value]),
            "omega_n_hz": np.array([natural]),
            "omega_e_over_omega_n": np.array([value / natural if natural > 0.0 else np.nan]),
            "force_over_ka": np.array([severity]),
            "growth": np.array([motion.growth]),
            "chaotic": np.array([motion.chaotic]),
            "mean_hz": np.array([np.mean(several) if several.size else np.nan]),
            "spread_hz": np.array([np.std(several) if several.size else np.nan]),
            "bin_width_hz": np.array([found.bin_width]),
        }

    def result(
        self, study: Study, jobs: Sequence[Job], found: Sequence[Columns]
    ) -> StudyResult:
        columns: dict[str, NDArray[np.generic]] = {
            column_of(variation.name, variation.unit): np.array([job.values[i] for job in jobs])
            for i, variation in enumerate(study.vary)
        }
        if any(TEMPERATURE in variation.places for variation in study.vary):
            models = [job.model for job in jobs if job.model is not None]
            columns["clearance_m"] = np.array([clearance_of(model) for model in models])
        columns |= {name: np.concatenate([f[name] for f in found]) for name in found[0]}
        verdict = _verdict(study, columns)
        statement, verdict = said(study.claim, verdict)
        widths = columns["bin_width_hz"].astype(np.float64)
        method = in_words(study.measure, float(np.max(widths)))
        chaotic = columns["chaotic"].astype(bool)
        notes: tuple[str, ...] = ()
        if chaotic.any():
            notes = (
                f"{int(chaotic.sum())} of {chaotic.size} runs are chaotic: ensemble only, "
                f"mean and spread of {study.measure.ensemble} neighbouring runs",
            )
        return StudyResult(
            title=study.title,
            figure=study.figure,
            columns=columns,
            panels=(_panel(study, jobs, columns),),
            method=f"{method}; {driven(study)}{_severity(columns)}",
            statement=statement,
            verdict=verdict,
            notes=notes,
        )


def column_of(name: str, unit: str) -> str:
    """Return the header of a column: the name, its unit at the end."""
    words = {"N/m": "n_per_m", "m/s^2": "m_per_s2", "N s/m": "ns_per_m", "m/s": "m_per_s"}
    end = words.get(unit, unit.lower().replace("/", "_per_").replace("^", "").replace(" ", "_"))
    return name if unit == "1" else f"{name}_{end}"


def trend_of(x: FloatArray, y: FloatArray, slack: float) -> str:
    """Return how a quantity changes: ``falls``, ``rises``, ``neither`` or ``stays``."""
    change = np.diff(y[np.argsort(x, kind="stable")])
    total = float(np.sum(change))
    if np.all(np.abs(change) <= slack) and abs(total) <= slack:
        return "stays"
    if np.all(change <= slack) and total < 0.0:
        return "falls"
    if np.all(change >= -slack) and total > 0.0:
        return "rises"
    return "neither"


def _spread(study: Study, model: Model, run: Run, motion: Motion) -> FloatArray:
    """Return omega_e of neighbouring runs where the motion is chaotic; else nothing."""
    if not motion.chaotic or study.measure.ensemble < 2:
        return np.empty(0)
    runs = ensemble(model, run, study.measure.ensemble)
    return np.array([
        omega_e(spectrum(m.of(study.measure.of), m.sample_rate, study.measure), study.measure)
        for m in runs
    ])


def _closed_frequency(model: Model, run: Run) -> float:
    """Return the lowest natural frequency with every gap closed [Hz]; 0 without stiffness."""
    found = natural_frequencies(system_of_model(model, run.level))
    return float(found[0])


def _verdict(study: Study, columns: Columns) -> str:
    """Return whether the claimed trend held in the table, with its ends."""
    claim = study.claim
    if claim is None or claim.trend is None:
        return ""
    place = next(i for i, v in enumerate(study.vary) if v.name == claim.along)
    variation = study.vary[place]
    x = columns[column_of(variation.name, variation.unit)].astype(np.float64)
    y = columns[claim.quantity].astype(np.float64)
    slack = float(np.max(columns["bin_width_hz"].astype(np.float64)))
    if claim.quantity == "omega_e_over_omega_n":
        slack /= float(np.max(columns["omega_n_hz"].astype(np.float64)))
    groups = _groups(study, place, columns)
    trends = {trend_of(x[rows], y[rows], slack) for rows in groups}
    ends = [(y[rows[np.argmin(x[rows])]], y[rows[np.argmax(x[rows])]]) for rows in groups]
    return _in_words(claim, trends, "; ".join(f"{a:.4g} to {b:.4g}" for a, b in ends))


def _groups(study: Study, along: int, columns: Columns) -> list[NDArray[np.intp]]:
    """Return the rows of the table that differ in one variation alone."""
    others = [
        columns[column_of(v.name, v.unit)].astype(np.float64)
        for i, v in enumerate(study.vary)
        if i != along
    ]
    size = next(iter(columns.values())).size
    keys = list(zip(*others, strict=True)) if others else [()] * size
    return [np.flatnonzero([key == wanted for key in keys]) for wanted in dict.fromkeys(keys)]


def _in_words(claim: Claim, trends: set[str], numbers: str) -> str:
    if trends == {claim.trend}:
        return f"held: {claim.quantity} {claim.trend} with {claim.along}, {numbers}"
    found = " or ".join(sorted(trends)).replace("neither", "goes up and down")
    if claim.trend in trends:
        return f"held in part: with {claim.along} it {found}, {numbers}"
    return f"did not hold: with {claim.along} it {found}, {numbers}"


def _severity(columns: Columns) -> str:
    """Return the range of F / (k a), for people; empty without free play."""
    found = columns["force_over_ka"].astype(np.float64)
    known = found[np.isfinite(found)]
    if not known.size:
        return ""
    return f"; F / (k a) from {np.min(known):.4g} to {np.max(known):.4g}"


def driven(study: Study) -> str:
    """Return what drove the runs, for people."""
    run = study.run
    if run is None:
        return ""
    varied = [v.name for v in study.vary if any(p.startswith("run.") for p in v.places)]
    method = {"exact": "", "Newmark": ", by Newmark's method"}.get(
        run.method, f", by {run.method} at a relative tolerance of {run.tolerance:g}"
    )
    return _in_general(run) + method + (f", {' and '.join(varied)} varied" if varied else "")


def _in_general(run: Run) -> str:
    start = ""
    if run.initial_displacement or run.initial_velocity:
        start = f", from {run.initial_displacement:.4g} m and {run.initial_velocity:.4g} m/s"
    if run.excitation == "free":
        return f"free motion of {run.duration:g} s{start}"
    if run.excitation == "sine":
        return f"sine of {run.frequency:.4g} Hz for {run.duration:g} s{start}"
    if run.excitation == "random":
        return f"random {run.from_hz:g} to {run.to_hz:g} Hz, seed {run.seed}{start}"
    ends = (run.to_hz, run.from_hz) if run.down else (run.from_hz, run.to_hz)
    way, per = ("down" if run.down else "up"), ("octave" if run.octaves else "hertz")
    return (
        f"sweep {way} from {ends[0]:g} to {ends[1]:g} Hz in {run.duration:g} s, as long for "
        f"every {per}{start}"
    )


def _panel(study: Study, jobs: Sequence[Job], columns: Columns) -> Panel:
    """Return the quantity against the last variation, a line for each of the others."""
    quantity = study.claim.quantity if study.claim is not None else "omega_e_hz"
    along = len(study.vary) - 1
    if study.claim is not None and study.claim.along:
        along = next(i for i, v in enumerate(study.vary) if v.name == study.claim.along)
    variation = study.vary[along]
    x = columns[column_of(variation.name, variation.unit)].astype(np.float64)
    y = columns[quantity].astype(np.float64)
    lines = []
    for number, rows in enumerate(_groups(study, along, columns)):
        ordered = rows[np.argsort(x[rows], kind="stable")]
        label = label_of(study, jobs[int(rows[0])], along)
        lines.append(Line(x[ordered], y[ordered], label, "marked", number))
        spread = columns["spread_hz"][ordered].astype(np.float64)
        if quantity == "omega_e_hz" and np.isfinite(spread).any():
            mean = columns["mean_hz"][ordered].astype(np.float64)
            for side in (-1.0, 1.0):
                lines.append(Line(x[ordered], mean + side * spread, "", "dotted", number))
    unit = "" if variation.unit == "1" else f" [{variation.unit}]"
    label = {"omega_e_hz": "omega_e [Hz]"}.get(quantity, quantity)
    values = np.array(sorted(set(x[x > 0.0])))
    wide = values.size > 3 and float(values[-1] / values[0]) > 50.0 and bool(np.all(x > 0.0))
    return Panel(f"{variation.name}{unit}", label, tuple(lines), log_x=wide)
