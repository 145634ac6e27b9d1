"""The interface: tasks in, outcomes out."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, TypeAlias

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
