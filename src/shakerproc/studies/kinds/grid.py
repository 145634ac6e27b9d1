"""Peak frequency on a grid of parameters: against a, k, zeta, n, A, r."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.models import Model
from shakerproc.simulation.harmonic_balance import gap_severity, natural_frequencies
from shakerproc.simulation.harmonic_balance.system import system_of_model
from shakerproc.studies.kinds.base import (
    AbstractKind,
    Drawing,
    JobFinding,
    StudyJob,
    column_of,
    driven,
    groups_of,
    label_of,
)
from shakerproc.studies.readings import (
    SimulatedMotion,
    in_words,
    peak_frequency,
    read_run,
    spectrum,
)
from shakerproc.studies.results import Columns, StudyLine, StudyPanel
from shakerproc.studies.study import TEMPERATURE, Measure, Study, StudyRun, clearance_of


@final
class Grid(AbstractKind):
    """Peak frequency of every combination; where chaotic, the spread of neighbouring runs."""

    needs: ClassVar[tuple[str, ...]] = ("model", "run", "vary")
    averages: ClassVar[bool] = True
    quantities: ClassVar[Mapping[str, str]] = MappingProxyType({
        "peak_frequency_hz": "Hz",
        "peak_over_natural_frequency": "1",
        "spread_hz": "Hz",
        "peak_over_forcing": "1",
        "from_forcing_multiple_hz": "Hz",
        "force_over_ka": "1",
        "growth": "1",
        "chaotic": "1",
    })

    def compute(self, study: Study, job: StudyJob) -> JobFinding:
        model, run = job.require()
        peak = peak_of_run(model, run, study.measure)
        natural = _closed_frequency(model, run)
        forcing = run.frequency if run.excitation == "sine" else np.nan
        severity = max(gap_severity(model, run.level).values(), default=np.nan)
        relative = 1.0 / natural if natural > 0.0 else np.nan
        order = max(1.0, float(np.round(peak.value / forcing))) if forcing > 0.0 else np.nan
        quantities = {
            "peak_frequency_hz": peak.value,
            "peak_over_natural_frequency": peak.value * relative,
            "spread_hz": peak.spread,
            "peak_over_forcing": peak.value / forcing if forcing > 0.0 else np.nan,
            "from_forcing_multiple_hz": abs(peak.value - order * forcing),
            "force_over_ka": severity,
            "growth": peak.growth,
            "chaotic": float(peak.chaotic),
        }
        columns = {
            "peak_frequency_hz": np.array([peak.single]),
            "omega_n_hz": np.array([natural]),
            "peak_over_natural_frequency": np.array([peak.single * relative]),
            "force_over_ka": np.array([severity]),
            "growth": np.array([peak.growth]),
            "chaotic": np.array([peak.chaotic]),
            "mean_hz": np.array([peak.mean]),
            "spread_hz": np.array([peak.spread]),
            "bin_width_hz": np.array([peak.bin_width]),
        }
        finest = {
            "peak_frequency_hz": peak.resolution,
            "peak_over_natural_frequency": peak.resolution * relative,
            "from_forcing_multiple_hz": peak.resolution,
            "peak_over_forcing": peak.resolution / forcing,
        }
        return JobFinding(columns, quantities, finest)

    def drawing(
        self, study: Study, jobs: Sequence[StudyJob], tables: Sequence[Columns]
    ) -> Drawing:
        columns: dict[str, NDArray[np.generic]] = {
            column_of(variation.name, variation.unit): np.array([job.values[i] for job in jobs])
            for i, variation in enumerate(study.vary)
        }
        if any(TEMPERATURE in variation.places for variation in study.vary):
            models = [job.model for job in jobs if job.model is not None]
            columns["clearance_m"] = np.array([clearance_of(model) for model in models])
        columns |= {name: np.concatenate([f[name] for f in tables]) for name in tables[0]}
        widths = columns["bin_width_hz"].astype(np.float64)
        method = in_words(study.measure, float(np.max(widths)))
        return Drawing(
            columns,
            (_panel(study, jobs, columns),),
            f"{method}; {driven(study)}{_severity(columns)}",
        )


@final
@dataclass(frozen=True, slots=True)
class PeakOfRun:
    """Peak frequency of a run, with its scatter, resolution and growth.

    Attributes
    ----------
    single : float
        Of the run itself [Hz].
    mean, spread : float
        Over neighbouring runs where the run is chaotic; else NaN [Hz].
    resolution : float
        What a difference must exceed to count: a bin, or twice the standard error of the
        mean where that is more [Hz].
    bin_width : float
        Distance of the bins [Hz].
    growth : float
        How much a small disturbance grew [-].
    chaotic : bool
        Whether the trajectory cannot be trusted to the end.
    """

    single: float
    mean: float
    spread: float
    resolution: float
    bin_width: float
    growth: float
    chaotic: bool

    @property
    def value(self) -> float:
        """Compared frequency: the mean of neighbouring runs where there is one [Hz]."""
        return self.single if np.isnan(self.mean) else self.mean


def peak_of_run(model: Model, run: StudyRun, measure: Measure) -> PeakOfRun:
    """Return the peak frequency of a run by the estimator of a measure."""

    def read(motion: SimulatedMotion) -> dict[str, float]:
        lines = spectrum(motion.of(measure.of), motion.sample_rate, measure)
        return {"peak": peak_frequency(lines, measure), "bin_width": lines.bin_width}

    motion, values, errors = read_run(model, run, measure.ensemble, read)
    single, error = read(motion), errors.get("peak", np.nan)
    return PeakOfRun(
        single=single["peak"],
        mean=values["peak"] if errors else np.nan,
        spread=0.5 * error * float(np.sqrt(measure.ensemble)),
        resolution=float(np.fmax(single["bin_width"], error)),
        bin_width=single["bin_width"],
        growth=motion.growth,
        chaotic=motion.chaotic,
    )


def _closed_frequency(model: Model, run: StudyRun) -> float:
    """Return the lowest natural frequency with every gap closed [Hz]; 0 without stiffness."""
    frequencies = natural_frequencies(system_of_model(model, run.level))
    return float(frequencies[0])


def _severity(columns: Columns) -> str:
    """Return the range of F / (k a), for people; empty without free play."""
    severities = columns["force_over_ka"].astype(np.float64)
    known = severities[np.isfinite(severities)]
    if not known.size:
        return ""
    return f"; F / (k a) from {np.min(known):.4g} to {np.max(known):.4g}"


def _panel(study: Study, jobs: Sequence[StudyJob], columns: Columns) -> StudyPanel:
    """Return the quantity against the last variation, a line for each of the others."""
    first = next(iter(study.claim.checks), None) if study.claim is not None else None
    drawn = first is not None and first.quantity in columns
    quantity = first.quantity if first is not None and drawn else "peak_frequency_hz"
    along = len(study.vary) - 1
    if first is not None and first.along:
        along = next(i for i, v in enumerate(study.vary) if v.name == first.along)
    variation = study.vary[along]
    x = columns[column_of(variation.name, variation.unit)].astype(np.float64)
    y = columns[quantity].astype(np.float64)
    lines = []
    for number, rows in enumerate(groups_of(jobs, along)):
        ordered = rows[np.argsort(x[rows], kind="stable")]
        label = label_of(study, jobs[int(rows[0])], along)
        lines.append(StudyLine(x[ordered], y[ordered], label, "marked", number))
        spread = columns["spread_hz"][ordered].astype(np.float64)
        if quantity == "peak_frequency_hz" and np.isfinite(spread).any():
            mean = columns["mean_hz"][ordered].astype(np.float64)
            for side in (-1.0, 1.0):
                lines.append(StudyLine(x[ordered], mean + side * spread, "", "dotted", number))
    unit = "" if variation.unit == "1" else f" [{variation.unit}]"
    label = {"peak_frequency_hz": "peak frequency [Hz]"}.get(quantity, quantity)
    values = np.array(sorted(set(x[x > 0.0])))
    wide = values.size > 3 and float(values[-1] / values[0]) > 50.0 and bool(np.all(x > 0.0))
    return StudyPanel(f"{variation.name}{unit}", label, tuple(lines), log_x=wide)
