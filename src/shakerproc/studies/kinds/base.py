"""What every kind of study is: independent jobs, and a result made of what they found."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from types import MappingProxyType
from typing import ClassVar, final

from shakerproc.models import Model
from shakerproc.studies.placing import placed
from shakerproc.studies.results import Columns, StudyResult
from shakerproc.studies.study import Claim, Run, Study


@final
@dataclass(frozen=True, slots=True, eq=False)
class Job:
    """One combination of the varied parameters.

    Attributes
    ----------
    model : Model or None
        With the values set.
    run : Run or None
        With the values set.
    values : tuple of float
        One of each variation [SI].
    texts : tuple of str
        The values as the study writes them.
    """

    model: Model | None
    run: Run | None
    values: tuple[float, ...] = ()
    texts: tuple[str, ...] = ()

    def require(self) -> tuple[Model, Run]:
        """Return model and run of a kind that needs both.

        Raises
        ------
        ValueError
            If one is missing.
        """
        if self.model is None or self.run is None:
            raise ValueError("this kind of study needs a model and a run")
        return self.model, self.run


class AbstractKind(ABC):
    """A kind of study.

    Attributes
    ----------
    options : mapping of str to str
        Options it knows and their SI units.
    needs : tuple of str
        What it cannot do without: ``model``, ``run``, ``vary``.
    """

    options: ClassVar[Mapping[str, str]] = MappingProxyType({})
    needs: ClassVar[tuple[str, ...]] = ("model",)

    @abstractmethod
    def compute(self, study: Study, job: Job) -> Columns:
        """Return what one job finds, as columns of one length; jobs run side by side."""

    @abstractmethod
    def result(
        self, study: Study, jobs: Sequence[Job], found: Sequence[Columns]
    ) -> StudyResult:
        """Return tables and panels of what all jobs found, in their order."""

    @final
    def check(self, study: Study) -> None:
        """Pass a study that has what this kind needs.

        Raises
        ------
        ValueError
            If something is missing.
        """
        for name in self.needs:
            if not getattr(study, name):
                raise ValueError(f"needs the key {name!r}")


def jobs_of(study: Study) -> tuple[Job, ...]:
    """Return every combination of the varied parameters, the first varying slowest."""
    if study.model is None:
        return (Job(None, study.run),)
    jobs = []
    for choice in product(*(range(len(v.values)) for v in study.vary)):
        model, run = study.model, study.run
        for variation, i in zip(study.vary, choice, strict=True):
            model, run = placed(model, run, variation.places, variation.values[i], study.warmth)
        values = tuple(v.values[i] for v, i in zip(study.vary, choice, strict=True))
        texts = tuple(v.texts[i] for v, i in zip(study.vary, choice, strict=True))
        jobs.append(Job(model, run, values, texts))
    return tuple(jobs)


def label_of(study: Study, job: Job, leave_out: int = -1) -> str:
    """Return the values of a job for a legend: ``a = 0.5 mm, n = 3``."""
    named = zip(study.vary, job.texts, strict=True)
    return ", ".join(
        f"{variation.name} = {text}"
        for i, (variation, text) in enumerate(named)
        if i != leave_out
    )


def said(claim: Claim | None, verdict: str = "") -> tuple[str, str]:
    """Return statement and verdict of a claim."""
    if claim is None:
        return "", ""
    return claim.statement, "; ".join(part for part in (verdict, claim.comment) if part)
