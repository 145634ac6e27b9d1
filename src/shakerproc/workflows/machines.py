"""Which machines work: the processes of this one, or a cluster; and where recordings lie."""

import os
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from shakerproc.executors import AbstractExecutor, ClusterExecutor, Limits, ProcessExecutor
from shakerproc.testlog import TestLog

LONG: Final = 7 * 86400.0
"""How long a part of a study or a diagnosis may take on a cluster [s]."""

MUCH: Final = 1e12
"""What it may allocate there [byte]."""


@dataclass(frozen=True, slots=True)
class Machines:
    """Where the tests of a log are processed.

    Attributes
    ----------
    workers : int, optional
        Processes at a time; by default one for each processor. A cluster has its own number.
    time_limit : float
        Longest time for one test [s].
    memory_limit : float
        Most that one test may allocate [byte].
    scheduler : str, optional
        Address of a dask scheduler; this machine alone where there is none.
    recordings : str, optional
        Folder or URL of the recordings as the workers see it; by default the log's folder.
    """

    workers: int | None = None
    time_limit: float = 600.0
    memory_limit: float = 4e9
    scheduler: str | None = None
    recordings: str | None = None

    def executor(self, prepare: Callable[[], None] | None = None) -> AbstractExecutor:
        """Return the executor that runs the tests."""
        limits = Limits(self.time_limit, self.memory_limit)
        if self.scheduler is not None:
            quiet_cluster()
            return ClusterExecutor(self.scheduler, limits, prepare)
        return ProcessExecutor(self.workers or os.cpu_count() or 1, limits, prepare)

    def source(self, log: TestLog) -> str:
        """Return where the recordings are, as the workers see it."""
        return str(log.folder) if self.recordings is None else self.recordings


def quiet_cluster() -> None:
    """Keep what dask logs of workers that come and go from the terminal; we say what counts."""
    try:
        import dask
    except ImportError:
        return  # the executor will say so
    dask.config.set({"logging": {"distributed": "critical", "distributed.client": "critical"}})
