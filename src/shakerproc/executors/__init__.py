"""Where tasks run: one interface; threads, processes or a cluster of machines behind it."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, Literal, TypeAlias

from shakerproc.late import loaded

if TYPE_CHECKING:
    from shakerproc.executors.cluster import ClusterExecutor
    from shakerproc.executors.processes import Limits, ProcessExecutor, ThreadExecutor


Work: TypeAlias = Callable[[Any], Mapping[str, Any]]
"""A function at the top of a module: from a picklable argument to what JSON can hold."""

Cause: TypeAlias = Literal["", "input", "error", "killed", "time limit", "memory limit"]


@dataclass(frozen=True, slots=True)
class Task:
    """One thing to do.

    Attributes
    ----------
    name : str
        Name in every message.
    argument : object
        What the work is called with.
    """

    name: str
    argument: Any


@dataclass(frozen=True, slots=True)
class TaskOutcome:
    """How one task ended.

    Attributes
    ----------
    name : str
        Name of the task.
    value : mapping
        What the work returned; empty where it failed.
    cause : Cause
        Why it failed; empty where it did not.
    error, detail : str
        One line, and the traceback where there is one.
    """

    name: str
    value: Mapping[str, Any] = field(default_factory=dict)
    cause: Cause = ""
    error: str = ""
    detail: str = ""


class AbstractExecutor(ABC):
    """Something that runs tasks."""

    @abstractmethod
    def run(self, work: Work, tasks: Sequence[Task]) -> Iterator[TaskOutcome]:
        """Yield the outcome of each task as it ends, in any order, one for each task."""


def limit_memory(limit: int) -> tuple[int, int] | None:
    """Let allocations fail that would take more than `limit` bytes from now on.

    Returns the limits as they were; None where the system has none.
    """
    status = Path("/proc/self/status")
    if not status.exists():
        return None
    import resource

    used = next(
        int(line.split()[1]) * 1024
        for line in status.read_text(encoding="ascii").splitlines()
        if line.startswith("VmData:")
    )
    former = resource.getrlimit(resource.RLIMIT_DATA)
    known = [one for one in former if one != resource.RLIM_INFINITY]
    resource.setrlimit(resource.RLIMIT_DATA, (min([used + limit, *known]), former[1]))
    return former


@contextmanager
def limited_memory(limit: int) -> Iterator[None]:
    """Let allocations fail within a ``with`` that would take more than `limit` bytes."""
    former = limit_memory(limit)
    try:
        yield
    finally:
        if former is not None:
            import resource

            resource.setrlimit(resource.RLIMIT_DATA, former)


_LATE: Final[Mapping[str, str]] = MappingProxyType({
    "ClusterExecutor": "cluster",
    "Limits": "processes",
    "ProcessExecutor": "processes",
    "ThreadExecutor": "processes",
})
"""Module of each executor: a process that has tasks given needs none."""


def __getattr__(name: str) -> Any:
    if name not in _LATE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return loaded(f"{__name__}.{_LATE[name]}:{name}")
