"""Interface of a study: independent jobs, and a result made of their findings."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from math import cos, degrees, isclose, sin
from types import MappingProxyType
from typing import ClassVar, Final, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.models import Model
from shakerproc.simulation.inputs import MOST_SAMPLES
from shakerproc.studies.results import (
    Check,
    Checked,
    Columns,
    StudyPanel,
    StudyResult,
    above,
    below,
    equals,
    trends,
)
from shakerproc.studies.study import Study, StudyRun, check_measure, check_run, placed

EXACT: Final = 1e-9
"""Resolution of a quantity that is computed without bins, as a share of the largest [-]."""

_NOTHING: Final[Mapping[str, float]] = MappingProxyType({})


@final
@dataclass(frozen=True, slots=True)
class Option:
    """Type, limits and meaning of one option of a kind.

    Attributes
    ----------
    unit : str
        SI unit.
    least, most : float
        Between which it lies [unit of the option].
    whole : bool
        Whether it counts something.
    """

    unit: str
    least: float = 0.0
    most: float = MOST_SAMPLES
    whole: bool = False

    def problem(self, value: float) -> str:
        """Return the condition that a value does not meet; empty where it does."""
        if self.least <= value <= self.most and not (self.whole and value % 1.0):
            return ""
        kind = "a whole number" if self.whole else "a value"
        unit = "" if self.unit == "1" else f" {self.unit}"
        return f"expected {kind} from {self.least:g} to {self.most:g}{unit}"


@final
@dataclass(frozen=True, slots=True, eq=False)
class StudyJob:
    """One combination of the varied parameters.

    Attributes
    ----------
    model : Model or None
        With the values set.
    run : StudyRun or None
        With the values set.
    values : tuple of float
        One of each variation [SI].
    texts : tuple of str
        The values as the study writes them.
    """

    model: Model | None
    run: StudyRun | None
    values: tuple[float, ...] = ()
    texts: tuple[str, ...] = ()

    def require(self) -> tuple[Model, StudyRun]:
        """Return model and run of a kind that needs both.

        Raises
        ------
        ValueError
            If one is missing.
        """
        if self.model is None or self.run is None:
            raise ValueError("this kind of study needs a model and a run")
        return self.model, self.run


@final
@dataclass(frozen=True, slots=True, eq=False)
class JobFinding:
    """Finding of one job.

    Attributes
    ----------
    columns : mapping of str to (n,) array
        Its part of the table.
    quantities : mapping of str to float
        What checks may be made of, by the names that the kind declares; NaN where the job has
        no such value.
    resolutions : mapping of str to float
        What a difference of a quantity between two jobs must exceed to count, in its unit;
        1e-9 of the largest value where nothing is said.
    """

    columns: Columns
    quantities: Mapping[str, float]
    resolutions: Mapping[str, float] = field(default_factory=lambda: _NOTHING)


@final
@dataclass(frozen=True, slots=True, eq=False)
class Drawing:
    """Table, panels and method of a study, without its verdict.

    Attributes
    ----------
    columns : mapping of str to (n,) array
        The table.
    panels : tuple of StudyPanel
        The figure.
    method : str
        How the numbers came about.
    """

    columns: Columns
    panels: tuple[StudyPanel, ...]
    method: str


class AbstractKind(ABC):
    """A kind of study.

    Attributes
    ----------
    options : mapping of str to Option
        Options it knows.
    needs : tuple of str
        What it cannot do without: ``model``, ``run``, ``vary``.
    averages : bool
        Whether what is read of a chaotic run is a mean over neighbouring runs.
    quantities : mapping of str to str
        What checks may be made of, and their SI units. A kind that runs a model in time has
        ``growth`` and ``chaotic`` among them.
    """

    options: ClassVar[Mapping[str, Option]] = MappingProxyType({})
    needs: ClassVar[tuple[str, ...]] = ("model",)
    averages: ClassVar[bool] = False
    quantities: ClassVar[Mapping[str, str]] = MappingProxyType({})

    @abstractmethod
    def compute(self, study: Study, job: StudyJob) -> JobFinding:
        """Return the finding of one job; jobs run side by side."""

    def check_job(self, study: Study, job: StudyJob) -> None:
        """Raise where a job cannot be computed; a kind without runs says its needs.

        Raises
        ------
        ValueError
            If it cannot be.
        """
        if job.run is not None:
            check_run(job.run)
            check_measure(study.measure, job.run)

    @abstractmethod
    def drawing(
        self, study: Study, jobs: Sequence[StudyJob], tables: Sequence[Columns]
    ) -> Drawing:
        """Return table and panels of the findings of all jobs, in their order."""

    @final
    def result(
        self, study: Study, jobs: Sequence[StudyJob], findings: Sequence[JobFinding]
    ) -> StudyResult:
        """Return tables and panels of the findings of all jobs, with every check."""
        drawn = self.drawing(study, jobs, [one.columns for one in findings])
        claim = study.claim
        return StudyResult(
            title=study.title,
            figure=study.figure,
            columns=drawn.columns,
            panels=drawn.panels,
            method=drawn.method,
            quantities=_table(study, jobs, findings),
            statement="" if claim is None else claim.statement,
            checks=() if claim is None else checked(study, jobs, findings),
            comment="" if claim is None else claim.comment,
            notes=_chaos(findings, study.measure.ensemble if self.averages else 0),
        )

    @final
    def check(self, study: Study) -> None:
        """Raise where a study lacks a need of this kind.

        Raises
        ------
        ValueError
            If something is missing.
        """
        for name in self.needs:
            if not getattr(study, name):
                raise ValueError(f"needs the key {name!r}")


def jobs_of(study: Study) -> tuple[StudyJob, ...]:
    """Return every combination of the varied parameters, the first varying slowest."""
    if study.model is None:
        return (StudyJob(None, study.run),)
    jobs = []
    for choice in product(*(range(len(v.values)) for v in study.vary)):
        model, run = study.model, study.run
        for variation, i in zip(study.vary, choice, strict=True):
            model, run = placed(model, run, variation.places, variation.values[i], study.warmth)
        values = tuple(v.values[i] for v, i in zip(study.vary, choice, strict=True))
        texts = tuple(v.texts[i] for v, i in zip(study.vary, choice, strict=True))
        jobs.append(StudyJob(model, run, values, texts))
    return tuple(jobs)


def label_of(study: Study, job: StudyJob, leave_out: int = -1) -> str:
    """Return the values of a job for a legend: ``a = 0.5 mm, n = 3``."""
    named = zip(study.vary, job.texts, strict=True)
    return ", ".join(
        f"{variation.name} = {text}"
        for i, (variation, text) in enumerate(named)
        if i != leave_out
    )


def column_of(name: str, unit: str) -> str:
    """Return the header of a column: the name, its unit at the end."""
    words = {"N/m": "n_per_m", "m/s^2": "m_per_s2", "N s/m": "ns_per_m", "m/s": "m_per_s"}
    end = words.get(unit, unit.lower().replace("/", "_per_").replace("^", "").replace(" ", "_"))
    return name if unit == "1" else f"{name}_{end}"


def groups_of(jobs: Sequence[StudyJob], along: int) -> list[NDArray[np.intp]]:
    """Return the jobs that differ in one variation alone, group by group."""
    keys = [tuple(v for i, v in enumerate(job.values) if i != along) for job in jobs]
    return [np.flatnonzero([key == wanted for key in keys]) for wanted in dict.fromkeys(keys)]


def checked(
    study: Study, jobs: Sequence[StudyJob], findings: Sequence[JobFinding]
) -> tuple[Checked, ...]:
    """Return the outcome of every check of a study."""
    checks = () if study.claim is None else study.claim.checks
    return tuple(_outcome(study, check, jobs, findings) for check in checks)


def _outcome(
    study: Study, check: Check, jobs: Sequence[StudyJob], findings: Sequence[JobFinding]
) -> Checked:
    values = np.array([one.quantities[check.quantity] for one in findings])
    if check.relation == "equals":
        within = 0.0 if check.within is None else check.within
        return equals(check.quantity, values, check.bound, within, relative=check.relative)
    if check.relation == "above":
        return above(check.quantity, values, check.bound)
    if check.relation == "below":
        return below(check.quantity, values, check.bound)
    slack = _resolution(check, values, findings)
    along = next(i for i, v in enumerate(study.vary) if v.name == check.along)
    x = np.array([job.values[along] for job in jobs])
    groups = [(x[rows], values[rows], slack[rows]) for rows in groups_of(jobs, along)]
    return trends(check.quantity, groups, check.relation, check.along)


def _resolution(check: Check, values: FloatArray, findings: Sequence[JobFinding]) -> FloatArray:
    """Return the least difference that counts, for each value."""
    known = values[np.isfinite(values)]
    largest = float(np.max(np.abs(known), initial=0.0))
    if check.within is not None:
        return np.full(values.size, check.within * (largest if check.relative else 1.0))
    return np.array([one.resolutions.get(check.quantity, EXACT * largest) for one in findings])


def _table(study: Study, jobs: Sequence[StudyJob], findings: Sequence[JobFinding]) -> Columns:
    """Return the quantities of every job beside the values that it had."""
    columns: dict[str, NDArray[np.generic]] = {
        column_of(variation.name, variation.unit): np.array([job.values[i] for job in jobs])
        for i, variation in enumerate(study.vary)
    }
    names = findings[0].quantities if findings else ()
    return columns | {name: np.array([f.quantities[name] for f in findings]) for name in names}


def _chaos(findings: Sequence[JobFinding], several: int) -> tuple[str, ...]:
    """Return a sentence on the runs that are chaotic, whatever the kind of study."""
    chaotic = [one.quantities for one in findings if one.quantities.get("chaotic", 0.0) > 0.0]
    if not chaotic:
        return ()
    largest = max(one["growth"] for one in chaotic)
    text = (
        f"what is read of them is the mean of {several} neighbouring runs"
        if several >= 2
        else "what is read of them is of a single run, and another run differs"
    )
    return (
        f"{len(chaotic)} of {len(findings)} runs are chaotic: ensemble only (a disturbance of "
        f"1e-10 grows up to {largest:.1e} times); {text}",
    )


def driven(study: Study) -> str:
    """Return the excitation of the runs, for people."""
    run = study.run
    if run is None:
        return ""
    varied = [v.name for v in study.vary if any(p.startswith("run.") for p in v.places)]
    method = {"exact": "", "Newmark": ", by Newmark's method"}.get(
        run.method, f", by {run.method} at a relative tolerance of {run.tolerance:g}"
    )
    return _in_general(run) + method + (f", {' and '.join(varied)} varied" if varied else "")


def _in_general(run: StudyRun) -> str:
    start = ""
    if run.initial_displacement or run.initial_velocity:
        start = f", from {run.initial_displacement:.4g} m and {run.initial_velocity:.4g} m/s"
    if run.excitation == "free":
        return f"free motion of {run.duration:g} s{start}"
    if run.excitation == "sine":
        return (
            f"sine of {run.frequency:.4g} Hz for {run.duration:g} s, begun "
            f"{sine_start(run.phase)}{start}"
        )
    if run.excitation == "random":
        return f"random {run.from_hz:g} to {run.to_hz:g} Hz, seed {run.seed}{start}"
    ends = (run.to_hz, run.from_hz) if run.down else (run.from_hz, run.to_hz)
    way, per = ("down" if run.down else "up"), ("octave" if run.octaves else "hertz")
    return (
        f"sweep {way} from {ends[0]:g} to {ends[1]:g} Hz in {run.duration:g} s, as long for "
        f"every {per}{start}"
    )


def sine_start(phase: float) -> str:
    """Return how a sine begins, for people.

    Parameters
    ----------
    phase : float
        Phase at the start [rad].
    """
    if isclose(cos(phase), 1.0, abs_tol=1e-9):
        return "at 0 and rising"
    if isclose(sin(phase), 1.0, abs_tol=1e-9):
        return "at its largest value (a cosine)"
    return f"at a phase of {degrees(phase):.4g} deg"
