"""Grids of parameters in, tables out: the figures of the thesis' chapters 3, 4, 5 and 6."""

import base64
import hashlib
import io
import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from shakerproc import __version__, files
from shakerproc.errors import SimulationError
from shakerproc.executors import AbstractExecutor, Task, ThreadExecutor
from shakerproc.studies.kinds import KINDS
from shakerproc.studies.kinds.base import JobFinding, StudyJob, jobs_of
from shakerproc.studies.reading import read_study
from shakerproc.studies.results import StudyResult
from shakerproc.studies.study import Measure, Study, StudyRun, Variation

LAYOUT = 2
"""Of the files that keep what a job found: columns, quantities and resolutions."""


def run_study(
    study: Study,
    *,
    folder: Path | None = None,
    workers: int = 1,
    executor: AbstractExecutor | None = None,
    progress: Callable[[str], None] | None = None,
) -> StudyResult:
    """Return the result of a study.

    Parameters
    ----------
    study : Study
        What to do.
    folder : Path, optional
        Where the result of each job is kept; a job that is there already is not run again.
    workers : int
        Jobs that run side by side (the steppers are compiled and let go of Python's lock).
    executor : AbstractExecutor, optional
        Where the jobs run; by default in `workers` threads.
    progress : function, optional
        Called after each job with the values that it had.

    Raises
    ------
    SimulationError
        If a job fails where it runs.
    """
    kind, jobs = KINDS[study.kind], jobs_of(study)
    findings = {
        i: kept for i, job in enumerate(jobs) if (kept := _earlier_finding(study, job, folder))
    }
    for i in findings:
        _tell(progress, jobs[i])
    tasks = [Task(str(i), (study, job)) for i, job in enumerate(jobs) if i not in findings]
    for outcome in (executor or ThreadExecutor(max(1, workers))).run(compute, tasks):
        job = jobs[int(outcome.name)]
        if outcome.cause:
            raise SimulationError(f"{study.title}: {', '.join(job.texts)}: {outcome.error}")
        content = base64.b64decode(outcome.value["columns"])
        if folder is not None:
            files.write_bytes(folder / f"{_key(study, job)}.npz", content)
        findings[int(outcome.name)] = _finding(content)
        _tell(progress, job)
    return kind.result(study, jobs, [findings[i] for i in range(len(jobs))])


def compute(given: tuple[Study, StudyJob]) -> Mapping[str, str]:
    """Return the finding of a job, its columns bit by bit as text."""
    study, job = given
    buffer = io.BytesIO()
    finding = KINDS[study.kind].compute(study, job)
    parts: dict[str, Any] = {
        **{f"column {name}": values for name, values in finding.columns.items()},
        **{f"quantity {name}": value for name, value in finding.quantities.items()},
        **{f"resolution {name}": value for name, value in finding.resolutions.items()},
    }
    np.savez(buffer, **parts)
    return {"columns": base64.b64encode(buffer.getvalue()).decode("ascii")}


def _earlier_finding(study: Study, job: StudyJob, folder: Path | None) -> JobFinding | None:
    """Return the finding of an earlier run, if it left a file."""
    path = None if folder is None else folder / f"{_key(study, job)}.npz"
    return _finding(path.read_bytes()) if path is not None and path.is_file() else None


def _finding(content: bytes) -> JobFinding:
    with np.load(io.BytesIO(content), allow_pickle=False) as kept:
        parts = [(*name.split(" ", 1), kept[name]) for name in kept.files]
    return JobFinding(
        {name: values for part, name, values in parts if part == "column"},
        {name: float(value) for part, name, value in parts if part == "quantity"},
        {name: float(value) for part, name, value in parts if part == "resolution"},
    )


def _tell(progress: Callable[[str], None] | None, job: StudyJob) -> None:
    if progress is not None:
        progress(", ".join(job.texts))


def _key(study: Study, job: StudyJob) -> str:
    """Return a hash of all that the result of a job depends on, its layout included."""
    everything = [
        __version__,
        LAYOUT,
        study.kind,
        study.formula,
        repr(job.model),
        repr(job.run),
        repr(study.measure),
        repr(study.options),
    ]
    return hashlib.sha256(json.dumps(everything).encode()).hexdigest()[:20]
