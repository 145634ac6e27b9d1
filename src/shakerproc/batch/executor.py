"""Where tasks run: the interface, and the processes of this machine behind it."""

import contextlib
import json
import multiprocessing
import multiprocessing.connection
import signal
import sys
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from multiprocessing.process import BaseProcess
from typing import Any, Final, Literal, TypeAlias, final

from shakerproc import checks
from shakerproc.batch import worker

Work: TypeAlias = Callable[[Any], Mapping[str, Any]]
"""A function at the top of a module: from a picklable argument to what JSON can hold."""

Cause: TypeAlias = Literal["", "input", "error", "killed", "time limit", "memory limit"]

_STARTUP_LIMIT: Final = 180.0  # [s]; imports from a slow network disk


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
class Outcome:
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
    """Something that runs tasks and lets none of them harm another."""

    @abstractmethod
    def run(self, work: Work, tasks: Sequence[Task]) -> Iterator[Outcome]:
        """Yield the outcome of each task as it ends, in any order, one for each task."""


@final
@dataclass(frozen=True, slots=True)
class ProcessExecutor(AbstractExecutor):
    """Processes of this machine, each with one task at a time.

    A process that fails in any way is replaced. A task whose process was killed from outside
    is set aside and tried once more, alone, when the others are done.

    Attributes
    ----------
    n_workers : int
        Processes at a time.
    time_limit : float
        Longest that one task may take [s].
    memory_limit : float
        Most that one process may allocate, on Linux [byte].
    prepare : callable, optional
        What a new process does before its first task, such as slow imports.
    """

    n_workers: int
    time_limit: float = 600.0
    memory_limit: float = 4e9
    prepare: Callable[[], None] | None = None

    def __post_init__(self) -> None:
        checks.positive("n_workers", self.n_workers, "processes")
        checks.positive("time_limit", self.time_limit, "s")
        checks.positive("memory_limit", self.memory_limit, "byte")

    def run(self, work: Work, tasks: Sequence[Task]) -> Iterator[Outcome]:
        quarantine: list[Task] = []
        for outcome, task in self._pass(work, tasks, self.n_workers):
            if outcome.cause == "killed":
                quarantine.append(task)
            else:
                yield outcome
        for outcome, _ in self._pass(work, quarantine, 1):
            yield outcome

    def _pass(
        self, work: Work, tasks: Sequence[Task], n_workers: int
    ) -> Iterator[tuple[Outcome, Task]]:
        """Yield each task with its outcome."""
        waiting = deque(tasks)
        pool: list[_Process] = []
        try:
            while waiting or any(process.task for process in pool):
                while waiting and len(pool) < n_workers:
                    pool.append(_Process(self, work, waiting.popleft()))
                _wait(pool)
                for process in list(pool):
                    task, outcome = process.task, process.look()
                    if process.ended:
                        pool.remove(process)
                    elif process.task is None and waiting:
                        process.give(waiting.popleft())
                    if outcome is not None and task is not None:
                        yield outcome, task
        finally:
            for process in pool:
                process.kill()


@final
class _Process:
    """One worker process and what it is doing."""

    def __init__(self, executor: ProcessExecutor, work: Work, task: Task) -> None:
        self.executor = executor
        self.task: Task | None = None
        self.ready = False
        self.ended = False
        context = multiprocessing.get_context("spawn")
        self.connection, theirs = context.Pipe()
        self.process: BaseProcess = context.Process(
            target=worker.serve, args=(theirs, int(executor.memory_limit)), daemon=True
        )
        _start_without_interrupts(self.process)
        theirs.close()
        self._send((work, executor.prepare))
        self.give(task)
        self.deadline = time.monotonic() + _STARTUP_LIMIT

    def give(self, task: Task) -> None:
        """Send it a task."""
        self.task = task
        self.deadline = time.monotonic() + self.executor.time_limit
        self._send(task.argument)

    def _send(self, message: object) -> None:
        with contextlib.suppress(BrokenPipeError, ConnectionResetError):  # look() finds it dead
            self.connection.send(message)

    def look(self) -> Outcome | None:
        """Return the outcome of the task, if it has ended."""
        message = self._received()
        if message is not None and not self.ready:
            self.ready = True
            self.deadline = time.monotonic() + self.executor.time_limit
            return None
        if message is not None:
            return self._finished(json.loads(message))
        if not self.process.is_alive():
            return self._failed("killed", _how_it_died(self.process.exitcode))
        if time.monotonic() > self.deadline:
            limit = f"{self.executor.time_limit:g} s" if self.ready else "start"
            return self._failed(
                "time limit",
                f"stopped at the time limit ({limit}); allow more with --time-limit",
            )
        return None

    def _received(self) -> bytes | None:
        try:
            return self.connection.recv_bytes() if self.connection.poll() else None
        except (EOFError, ConnectionResetError, BrokenPipeError):
            self.process.join(timeout=5.0)
            return None

    def _finished(self, report: Mapping[str, Any]) -> Outcome | None:
        task, self.task = self.task, None
        if report["cause"]:
            self.kill()
        return None if task is None else Outcome(task.name, **report)

    def _failed(self, cause: Cause, error: str) -> Outcome | None:
        task, self.task = self.task, None
        self.kill()
        return None if task is None else Outcome(task.name, cause=cause, error=error)

    def kill(self) -> None:
        """End it and wait for its end."""
        self.ended = True
        self.process.kill()
        self.process.join()
        self.connection.close()


def _wait(pool: Sequence[_Process]) -> None:
    """Wait until a process says something, dies, or has reached its deadline."""
    watched = [p.connection for p in pool] + [p.process.sentinel for p in pool]
    deadline = min(p.deadline for p in pool if p.task is not None)
    multiprocessing.connection.wait(watched, max(0.0, deadline - time.monotonic()) + 0.01)


def _start_without_interrupts(process: BaseProcess) -> None:
    """Start a process that a Ctrl-C in the terminal does not reach: its parent ends it."""
    if sys.platform == "win32":
        process.start()
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        process.start()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _how_it_died(exitcode: int | None) -> str:
    if exitcode is not None and exitcode < 0:
        name = signal.Signals(-exitcode).name if -exitcode in set(signal.Signals) else "signal"
        hint = "; the machine may have run out of memory" if name == "SIGKILL" else ""
        return f"its process was killed ({name}), also when it ran alone{hint}"
    return f"its process ended with status {exitcode}, also when it ran alone"
