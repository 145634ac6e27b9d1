"""Threads of this process, for work that is compiled and lets go of Python's lock."""

from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from typing import final

from shakerproc import checks
from shakerproc.executors.base import AbstractExecutor, Task, TaskOutcome, Work


@final
@dataclass(frozen=True, slots=True)
class ThreadExecutor(AbstractExecutor):
    """Threads of this process; nothing is isolated, and an exception ends it all.

    Attributes
    ----------
    n_workers : int
        Threads at a time.
    """

    n_workers: int

    def __post_init__(self) -> None:
        checks.positive("n_workers", self.n_workers, "threads")

    def run(self, work: Work, tasks: Sequence[Task]) -> Iterator[TaskOutcome]:
        with ThreadPoolExecutor(self.n_workers) as pool:
            waiting = {pool.submit(work, task.argument): task for task in tasks}
            try:
                for done in as_completed(waiting):
                    yield TaskOutcome(waiting[done].name, done.result())
            finally:
                pool.shutdown(cancel_futures=True)
