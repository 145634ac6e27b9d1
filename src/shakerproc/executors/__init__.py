"""Where tasks run: one interface; threads, processes or a cluster of machines behind it."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from shakerproc.executors.base import (
    AbstractExecutor,
    Cause,
    Task,
    TaskOutcome,
    Work,
    limited_memory,
)
from shakerproc.late import loaded

if TYPE_CHECKING:
    from shakerproc.executors.cluster import ClusterExecutor
    from shakerproc.executors.processes import Limits, ProcessExecutor, ThreadExecutor

__all__ = [
    "AbstractExecutor",
    "Cause",
    "ClusterExecutor",
    "Limits",
    "ProcessExecutor",
    "Task",
    "TaskOutcome",
    "ThreadExecutor",
    "Work",
    "limited_memory",
]

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
