"""Where tasks run: one interface; threads, processes or a cluster of machines behind it."""

from shakerproc.executors.base import AbstractExecutor, Cause, Outcome, Task, Work
from shakerproc.executors.cluster import ClusterExecutor
from shakerproc.executors.memory import limited_memory
from shakerproc.executors.processes import Limits, ProcessExecutor
from shakerproc.executors.threads import ThreadExecutor

__all__ = [
    "AbstractExecutor",
    "Cause",
    "ClusterExecutor",
    "Limits",
    "Outcome",
    "ProcessExecutor",
    "Task",
    "ThreadExecutor",
    "Work",
    "limited_memory",
]
