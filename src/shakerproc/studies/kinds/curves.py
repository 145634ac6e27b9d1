"""Curves that need no run: force laws, response curves, backbones."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise
from types import MappingProxyType
from typing import ClassVar, Final, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.models import AbstractMemorylessEffect, Model
from shakerproc.models.coordinates import resolved
from shakerproc.simulation.harmonic_balance import (
    backbone,
    difference_from_simulation,
    frequency_response,
    gap_severity,
    samples_of_branch,
)
from shakerproc.studies.kinds.base import (
    AbstractKind,
    Drawing,
    JobFinding,
    Option,
    StudyJob,
    label_of,
)
from shakerproc.studies.results import Columns, StudyLine, StudyPanel
from shakerproc.studies.study import Study, StudyRun

SMALLEST: Final = 1e-12
"""Of what must be above 0: any option in SI is larger."""

MOST_POINTS: Final = 1_000_000
"""Of a curve in a table."""

HARMONICS: Final = Option("1", least=1, most=1000, whole=True)
"""A balance of 1000 harmonics solves 2001 equations for each mass."""

HALVINGS: Final = 40
"""Of the interval in which a jump is sought."""

Force: TypeAlias = Callable[[FloatArray], FloatArray]


@final
class ForceLaw(AbstractKind):
    """Static force against displacement, of all elements between base and first mass."""

    options: ClassVar[Mapping[str, Option]] = MappingProxyType({
        "to": Option("m", least=SMALLEST),
        "points": Option("1", least=3, most=MOST_POINTS, whole=True),
        "load": Option("N"),
    })
    quantities: ClassVar[Mapping[str, str]] = MappingProxyType({
        "inner_stiffness_n_per_m": "N/m",
        "outer_stiffness_n_per_m": "N/m",
        "jump_n": "N",
        "nonlinearity": "1",
        "displacement_at_load_m": "m",
    })

    def check_job(self, study: Study, job: StudyJob) -> None:
        """Pass any model: nothing is driven."""

    def compute(self, study: Study, job: StudyJob) -> JobFinding:
        if job.model is None:
            raise ValueError("a force law needs a model")
        model, reach = job.model, study.option("to", 1e-3)
        z = np.linspace(-reach, reach, int(study.option("points", 1001)))

        def force_at(at: FloatArray) -> FloatArray:
            return _static_force(model, at)

        force = force_at(z)
        quantities = {
            "inner_stiffness_n_per_m": _slope(force_at, 0.0, 1e-3 * reach),
            "outer_stiffness_n_per_m": _slope(force_at, reach, 1e-3 * reach),
            "jump_n": _jump(force_at, z, force),
            "nonlinearity": _off_a_line(z, force),
            "displacement_at_load_m": _reached(z, force, study.option("load", 0.0)),
        }
        return JobFinding({"displacement_m": z, "force_n": force}, quantities)

    def drawing(
        self, study: Study, jobs: Sequence[StudyJob], tables: Sequence[Columns]
    ) -> Drawing:
        lines = tuple(
            StudyLine(
                one["displacement_m"].astype(np.float64),
                one["force_n"].astype(np.float64),
                label_of(study, job),
                "line",
                i,
            )
            for i, (job, one) in enumerate(zip(jobs, tables, strict=True))
        )
        load = study.option("load", 0.0)
        ends = tables[0]["displacement_m"][[0, -1]].astype(np.float64)
        levels = tuple(
            StudyLine(ends, np.full(2, side * load), "load" if side > 0.0 else "", "dashed", 6)
            for side in (1.0, -1.0)
            if load > 0.0
        )
        return Drawing(
            columns=_numbered(tables),
            panels=(StudyPanel("displacement [m]", "force [N]", lines + levels),),
            method="the force law itself",
        )


@final
class ResponseKind(AbstractKind):
    """Amplitude against frequency by harmonic balance, stable and unstable."""

    options: ClassVar[Mapping[str, Option]] = MappingProxyType({
        "harmonics": HARMONICS,
        "from": Option("Hz", least=SMALLEST),
        "to": Option("Hz", least=SMALLEST),
    })
    needs: ClassVar[tuple[str, ...]] = ("model", "run")
    quantities: ClassVar[Mapping[str, str]] = MappingProxyType({
        "peak_hz": "Hz",
        "peak_m": "m",
        "folds": "1",
        "difference_from_simulation": "1",
    })

    @staticmethod
    def _band(study: Study, run: StudyRun) -> tuple[float, float]:
        return study.option("from", run.from_hz), study.option("to", run.to_hz)

    def check_job(self, study: Study, job: StudyJob) -> None:
        _, run = job.require()
        _check_rising(self._band(study, run), "Hz")
        if not run.level > 0.0:
            raise ValueError(f"harmonic balance needs a level above 0, not {run.level:g}")

    def compute(self, study: Study, job: StudyJob) -> JobFinding:
        model, run = job.require()
        low, high = self._band(study, run)
        result = frequency_response(
            model,
            run.level,
            from_hz=low,
            to_hz=high,
            harmonics=int(study.option("harmonics", 31)),
        )
        severity = max(gap_severity(model, run.level).values(), default=np.nan)
        tables = []
        for number, branch in enumerate(result.branches, start=1):
            size = branch.frequency.size
            first = samples_of_branch(branch, 512)[:, 0]
            tables.append({
                "branch": np.full(size, number),
                "frequency_hz": branch.frequency,
                "amplitude_m": np.max(np.abs(first), axis=-1),
                "stable": branch.stable,
                "force_over_ka": np.full(size, severity),
            })
        columns = {name: np.concatenate([t[name] for t in tables]) for name in tables[0]}
        steady = np.where(columns["stable"], columns["amplitude_m"], 0.0)
        tallest = int(np.argmax(steady))
        return JobFinding(
            columns,
            {
                "peak_hz": float(columns["frequency_hz"][tallest]),
                "peak_m": float(steady[tallest]),
                "folds": float(sum(len(branch.folds) for branch in result.branches)),
                "difference_from_simulation": difference_from_simulation(result),
            },
        )

    def drawing(
        self, study: Study, jobs: Sequence[StudyJob], tables: Sequence[Columns]
    ) -> Drawing:
        lines: list[StudyLine] = []
        for i, (job, one) in enumerate(zip(jobs, tables, strict=True)):
            lines += _response_lines(one, label_of(study, job), i)
        severities = [float(one["force_over_ka"][0]) for one in tables]
        method = f"harmonic balance, {study.option('harmonics', 31):g} harmonics"
        if np.isfinite(severities).any():
            method += f"; F / (k a) = {', '.join(f'{s:.4g}' for s in severities)}"
        return Drawing(
            columns=_numbered(tables),
            panels=(
                StudyPanel(
                    "frequency [Hz]", "largest displacement [m]", tuple(lines), log_y=True
                ),
            ),
            method=f"{method}; solid stable, dashed unstable",
        )


@final
class BackboneKind(AbstractKind):
    """Frequency of free motion against its amplitude, by harmonic balance."""

    options: ClassVar[Mapping[str, Option]] = MappingProxyType({
        "harmonics": HARMONICS,
        "from": Option("m", least=SMALLEST),
        "to": Option("m", least=SMALLEST),
    })
    quantities: ClassVar[Mapping[str, str]] = MappingProxyType({
        "first_hz": "Hz",
        "last_hz": "Hz",
        "rise_hz": "Hz",
        "least_step_hz": "Hz",
    })

    @staticmethod
    def _amplitudes(study: Study) -> tuple[float, float]:
        return study.option("from", 1e-4), study.option("to", 1e-2)

    def check_job(self, study: Study, job: StudyJob) -> None:
        _check_rising(self._amplitudes(study), "m")

    def compute(self, study: Study, job: StudyJob) -> JobFinding:
        if job.model is None:
            raise ValueError("a backbone needs a model")
        curve = backbone(
            job.model,
            self._amplitudes(study),
            harmonics=int(study.option("harmonics", 31)),
        )
        rising = curve.frequency[np.argsort(curve.amplitude, kind="stable")]
        return JobFinding(
            {
                "frequency_hz": curve.frequency,
                "amplitude_m": curve.amplitude,
                "damping_ratio": curve.damping_ratio,
            },
            {
                "first_hz": float(rising[0]),
                "last_hz": float(rising[-1]),
                "rise_hz": float(rising[-1] - rising[0]),
                "least_step_hz": float(np.min(np.diff(rising))) if rising.size > 1 else np.nan,
            },
        )

    def drawing(
        self, study: Study, jobs: Sequence[StudyJob], tables: Sequence[Columns]
    ) -> Drawing:
        lines = tuple(
            StudyLine(
                one["amplitude_m"].astype(np.float64),
                one["frequency_hz"].astype(np.float64),
                label_of(study, job),
                "line",
                i,
            )
            for i, (job, one) in enumerate(zip(jobs, tables, strict=True))
        )
        return Drawing(
            columns=_numbered(tables),
            panels=(StudyPanel("amplitude [m]", "frequency of free motion [Hz]", lines),),
            method=f"harmonic balance, {study.option('harmonics', 31):g} harmonics",
        )


def _check_rising(ends: tuple[float, float], unit: str) -> None:
    """Pass a range above 0 that rises.

    Raises
    ------
    ValueError
        If it does not.
    """
    low, high = ends
    if not 0.0 < low < high:
        raise ValueError(
            f"expected from above 0 {unit}, and to above from, got {low:g} {unit} to "
            f"{high:g} {unit}"
        )


def _static_force(model: Model, at: FloatArray) -> FloatArray:
    """Return the static force of all elements between base and first mass, (n,) array [N]."""
    force = np.zeros_like(at)
    for element in resolved(model):
        if isinstance(element.effect, AbstractMemorylessEffect):
            force += element.effect.force_at(at, np.zeros_like(at))
    return force


def _slope(force_at: Force, at: float, step: float) -> float:
    """Return the mean slope of a force over a step to either side [N/m]."""
    ends = force_at(np.array([at - step, at + step]))
    return float((ends[1] - ends[0]) / (2.0 * step))


def _jump(force_at: Force, z: FloatArray, force: FloatArray) -> float:
    """Return the height of the largest jump of a force [N].

    The steepest step is halved again and again, each time the half with the larger rise: of
    a force without a jump nothing is left.
    """
    steepest = int(np.argmax(np.abs(np.diff(force))))
    low, high = float(z[steepest]), float(z[steepest + 1])
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        ends = force_at(np.array([low, middle, high]))
        first, second = np.abs(np.diff(ends))
        low, high = (low, middle) if first > second else (middle, high)
    ends = force_at(np.array([low, high]))
    return float(abs(ends[1] - ends[0]))


def _off_a_line(z: FloatArray, force: FloatArray) -> float:
    """Return how far a force is from its best straight line, rms over rms [-]."""
    line = np.polyval(np.polyfit(z, force, 1), z)
    size = float(np.sqrt(np.mean(force**2)))
    return float(np.sqrt(np.mean((force - line) ** 2))) / size if size > 0.0 else float("nan")


def _reached(z: FloatArray, force: FloatArray, load: float) -> float:
    """Return the first displacement above 0 at which a force reaches a load [m], or NaN."""
    right = z >= 0.0
    beyond = np.flatnonzero(force[right] >= load)
    if load <= 0.0 or beyond.size == 0 or beyond[0] == 0:
        return float("nan")
    i = int(beyond[0])
    x, y = z[right][i - 1 : i + 1], force[right][i - 1 : i + 1]
    return float(x[0] + (x[1] - x[0]) * (load - y[0]) / (y[1] - y[0]))


def _numbered(tables: Sequence[Columns]) -> Columns:
    """Return the columns of all jobs one below the other, with the number of the job."""
    sizes = [next(iter(one.values())).size for one in tables]
    return {
        "run": np.repeat(np.arange(len(tables)), sizes),
        **{name: np.concatenate([one[name] for one in tables]) for name in tables[0]},
    }


def _response_lines(one: Columns, label: str, style: int) -> Iterator[StudyLine]:
    """Yield the stretches of a response curve, solid where stable."""
    for number in np.unique(one["branch"].astype(np.int64)):
        rows = np.flatnonzero(one["branch"].astype(np.int64) == number)
        x: FloatArray = one["frequency_hz"][rows].astype(np.float64)
        y: FloatArray = one["amplitude_m"][rows].astype(np.float64)
        stable: NDArray[np.bool_] = one["stable"][rows].astype(np.bool_)
        edges = [0, *(np.flatnonzero(np.diff(stable)) + 1), stable.size]
        for start, stop in pairwise(edges):
            part = slice(int(start), min(int(stop) + 1, stable.size))
            if stable[start]:
                yield StudyLine(x[part], y[part], label, "line", style)
                label = ""
            else:
                yield StudyLine(x[part], y[part], "", "dashed", style)
