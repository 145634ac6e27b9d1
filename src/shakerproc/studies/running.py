"""Running the jobs of a study side by side, and taking up again what an earlier run found."""

import hashlib
import json
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

import numpy as np

from shakerproc import __version__, files
from shakerproc.studies.kinds import KINDS
from shakerproc.studies.kinds.base import Job, jobs_of
from shakerproc.studies.results import Columns, StudyResult
from shakerproc.studies.study import Study


def run_study(
    study: Study,
    *,
    folder: Path | None = None,
    workers: int = 1,
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
    progress : function, optional
        Called after each job with the values that it had.
    """
    kind, jobs = KINDS[study.kind], jobs_of(study)
    found: dict[int, Columns] = {}
    with ThreadPoolExecutor(max_workers=max(1, workers)) as pool:
        waiting = {pool.submit(_found, study, job, folder): i for i, job in enumerate(jobs)}
        for done in as_completed(waiting):
            i = waiting[done]
            found[i] = done.result()
            if progress is not None:
                progress(", ".join(jobs[i].texts))
    return kind.result(study, jobs, [found[i] for i in range(len(jobs))])


def _found(study: Study, job: Job, folder: Path | None) -> Columns:
    """Return what a job finds, from its file where an earlier run left one."""
    kind = KINDS[study.kind]
    if folder is None:
        return kind.compute(study, job)
    path = folder / f"{_key(study, job)}.npz"
    if path.is_file():
        with np.load(path, allow_pickle=False) as kept:
            return {name: kept[name] for name in kept.files}
    columns = kind.compute(study, job)
    with files.atomic_path(path) as temporary, temporary.open("wb") as stream:
        np.savez(stream, **columns)  # type: ignore[arg-type]
    return columns


def _key(study: Study, job: Job) -> str:
    """Return a hash of all that the result of a job depends on."""
    everything = [
        __version__,
        study.kind,
        study.formula,
        repr(job.model),
        repr(job.run),
        repr(study.measure),
        repr(study.options),
    ]
    return hashlib.sha256(json.dumps(everything).encode()).hexdigest()[:20]
