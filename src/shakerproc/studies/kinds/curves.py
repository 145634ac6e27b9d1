"""Curves that need no run: force laws, response curves, backbones."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from types import MappingProxyType
from typing import ClassVar, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.models import AbstractMemorylessEffect
from shakerproc.models.surroundings import resolved
from shakerproc.simulate.harmonic_balance import (
    backbone,
    frequency_response,
    gap_severity,
    samples_of_branch,
)
from shakerproc.studies.kinds.base import AbstractKind, Job, label_of, said
from shakerproc.studies.results import Columns, Line, Panel, StudyResult
from shakerproc.studies.study import Study


@final
class ForceLaw(AbstractKind):
    """Static force against displacement, of all elements between base and first mass."""

    options: ClassVar[Mapping[str, str]] = MappingProxyType({
        "to": "m",
        "points": "1",
        "load": "N",
    })

    def compute(self, study: Study, job: Job) -> Columns:
        if job.model is None:
            raise ValueError("a force law needs a model")
        reach = study.option("to", 1e-3)
        z = np.linspace(-reach, reach, int(study.option("points", 1001)))
        force = np.zeros_like(z)
        for element in resolved(job.model):
            if isinstance(element.effect, AbstractMemorylessEffect):
                force += element.effect.force_at(z, np.zeros_like(z))
        return {"displacement_m": z, "force_n": force}

    def result(
        self, study: Study, jobs: Sequence[Job], found: Sequence[Columns]
    ) -> StudyResult:
        lines = tuple(
            Line(
                one["displacement_m"].astype(np.float64),
                one["force_n"].astype(np.float64),
                label_of(study, job),
                "line",
                i,
            )
            for i, (job, one) in enumerate(zip(jobs, found, strict=True))
        )
        load = study.option("load", 0.0)
        ends = found[0]["displacement_m"][[0, -1]].astype(np.float64)
        levels = tuple(
            Line(ends, np.full(2, side * load), "load" if side > 0.0 else "", "dashed", 6)
            for side in (1.0, -1.0)
            if load > 0.0
        )
        statement, verdict = said(study.claim)
        return StudyResult(
            title=study.title,
            figure=study.figure,
            columns=_numbered(found),
            panels=(Panel("displacement [m]", "force [N]", lines + levels),),
            method="the force law itself",
            statement=statement,
            verdict=verdict,
        )


@final
class ResponseKind(AbstractKind):
    """Amplitude against frequency by harmonic balance, stable and unstable."""

    options: ClassVar[Mapping[str, str]] = MappingProxyType({
        "harmonics": "1",
        "from": "Hz",
        "to": "Hz",
    })
    needs: ClassVar[tuple[str, ...]] = ("model", "run")

    def compute(self, study: Study, job: Job) -> Columns:
        model, run = job.require()
        found = frequency_response(
            model,
            run.level,
            from_hz=study.option("from", run.from_hz),
            to_hz=study.option("to", run.to_hz),
            harmonics=int(study.option("harmonics", 31)),
        )
        severity = max(gap_severity(model, run.level).values(), default=np.nan)
        tables = []
        for number, branch in enumerate(found.branches, start=1):
            size = branch.frequency.size
            first = samples_of_branch(branch, 512)[:, 0]
            tables.append({
                "branch": np.full(size, number),
                "frequency_hz": branch.frequency,
                "amplitude_m": np.max(np.abs(first), axis=-1),
                "stable": branch.stable,
                "force_over_ka": np.full(size, severity),
            })
        return {name: np.concatenate([t[name] for t in tables]) for name in tables[0]}

    def result(
        self, study: Study, jobs: Sequence[Job], found: Sequence[Columns]
    ) -> StudyResult:
        lines: list[Line] = []
        for i, (job, one) in enumerate(zip(jobs, found, strict=True)):
            lines += _response_lines(one, label_of(study, job), i)
        statement, verdict = said(study.claim)
        severities = [float(one["force_over_ka"][0]) for one in found]
        method = f"harmonic balance, {study.option('harmonics', 31):g} harmonics"
        if np.isfinite(severities).any():
            method += f"; F / (k a) = {', '.join(f'{s:.4g}' for s in severities)}"
        return StudyResult(
            title=study.title,
            figure=study.figure,
            columns=_numbered(found),
            panels=(
                Panel("frequency [Hz]", "largest displacement [m]", tuple(lines), log_y=True),
            ),
            method=f"{method}; solid stable, dashed unstable",
            statement=statement,
            verdict=verdict,
        )


@final
class BackboneKind(AbstractKind):
    """Frequency of free motion against its amplitude, by harmonic balance."""

    options: ClassVar[Mapping[str, str]] = MappingProxyType({
        "harmonics": "1",
        "from": "m",
        "to": "m",
    })

    def compute(self, study: Study, job: Job) -> Columns:
        if job.model is None:
            raise ValueError("a backbone needs a model")
        found = backbone(
            job.model,
            (study.option("from", 1e-4), study.option("to", 1e-2)),
            harmonics=int(study.option("harmonics", 31)),
        )
        return {
            "frequency_hz": found.frequency,
            "amplitude_m": found.amplitude,
            "damping_ratio": found.damping_ratio,
        }

    def result(
        self, study: Study, jobs: Sequence[Job], found: Sequence[Columns]
    ) -> StudyResult:
        lines = tuple(
            Line(
                one["amplitude_m"].astype(np.float64),
                one["frequency_hz"].astype(np.float64),
                label_of(study, job),
                "line",
                i,
            )
            for i, (job, one) in enumerate(zip(jobs, found, strict=True))
        )
        statement, verdict = said(study.claim)
        return StudyResult(
            title=study.title,
            figure=study.figure,
            columns=_numbered(found),
            panels=(Panel("amplitude [m]", "frequency of free motion [Hz]", lines),),
            method=f"harmonic balance, {study.option('harmonics', 31):g} harmonics",
            statement=statement,
            verdict=verdict,
        )


def _numbered(found: Sequence[Columns]) -> Columns:
    """Return the columns of all jobs one below the other, with the number of the job."""
    sizes = [next(iter(one.values())).size for one in found]
    return {
        "run": np.repeat(np.arange(len(found)), sizes),
        **{name: np.concatenate([one[name] for one in found]) for name in found[0]},
    }


def _response_lines(one: Columns, label: str, style: int) -> Iterator[Line]:
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
                yield Line(x[part], y[part], label, "line", style)
                label = ""
            else:
                yield Line(x[part], y[part], "", "dashed", style)
