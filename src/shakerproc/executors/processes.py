"""Processes of this machine with one task at a time, and their threads."""

import contextlib
import json
import multiprocessing
import multiprocessing.connection
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
import traceback
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, final

from shakerproc import checks
from shakerproc.errors import ShakerprocError
from shakerproc.executors import (
    AbstractExecutor,
    Cause,
    Task,
    TaskOutcome,
    Work,
    limit_memory,
)
from shakerproc.late import seek_garbage_seldom


def main() -> None:
    """Serve the connection whose handle the command line says, within its limit of memory."""
    seek_garbage_seldom()
    handle, memory_limit = map(int, sys.argv[1:])
    if sys.platform == "win32":
        from multiprocessing.connection import PipeConnection

        serve(PipeConnection(handle), memory_limit)
    else:
        serve(Connection(handle), memory_limit)


def serve(connection: Connection, memory_limit: int) -> None:
    """Run the ordered function with each argument that arrives, until the pipe closes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    work: Callable[[Any], object] = _nothing
    limited = False
    while True:
        try:
            kind, content = connection.recv()
        except EOFError:
            return
        if kind == "task":
            connection.send_bytes(_attempt(work, content))
            continue
        work = _ordered(content)
        if not limited:
            limit_memory(memory_limit)
            limited = True
        connection.send_bytes(b"ready")


def _nothing(_: object) -> dict[str, object]:
    return {}


def _ordered(content: bytes) -> Callable[[Any], object]:
    """Return the ordered function, all made ready for it; or the message why it cannot be."""
    try:
        work, prepare = pickle.loads(content)  # noqa: S301 - from our parent, by its own pipe
        if prepare is not None:
            prepare()
    except Exception as error:  # noqa: BLE001 - each task is to say it
        problem = error

        def fail(_: object) -> object:
            raise problem

        return fail
    return work  # type: ignore[no-any-return]


def _end_with_parent() -> None:
    """End at once when the parent is gone, even if it was killed: standard input ends then."""
    while os.read(sys.stdin.fileno(), 1):
        pass
    os._exit(1)


def _attempt(work: Callable[[Any], object], argument: bytes) -> bytes:
    """Return the report on one task as JSON, whatever happens in it."""
    try:
        given = pickle.loads(argument)  # noqa: S301 - from our parent, by its own pipe
        report = {"value": work(given), "cause": "", "error": "", "detail": ""}
        # JSON: what does not unpickle would cost the other runs of the pool (decision 4)
        return json.dumps(report, allow_nan=False).encode()
    except MemoryError:
        return _failure(
            "memory limit", "stopped at the memory limit; allow more with --memory-limit", ""
        )
    except ShakerprocError as error:
        return _failure("input", str(error), "")
    except BaseException as error:  # noqa: BLE001 - what a run does must not end the batch
        line = traceback.format_exception_only(error)[-1].strip()
        return _failure("error", line, traceback.format_exc())


def _failure(cause: str, error: str, detail: str) -> bytes:
    return json.dumps({"value": {}, "cause": cause, "error": error, "detail": detail}).encode()


_STARTUP_LIMIT: Final = 180.0  # [s]; imports from a slow network disk

_SERVE: Final = "from shakerproc.executors.processes import main; main()"

_ONE_THREAD_EACH: Final = MappingProxyType(
    dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
)

_LOOKED: Final = 1.0
"""How often a process is looked at that neither says anything nor reaches a limit [s]."""


@final
@dataclass(frozen=True, slots=True)
class Limits:
    """Limits of time and memory of one task.

    Attributes
    ----------
    time : float
        Longest that it may take [s].
    memory : float
        Most that its process may allocate, on Linux [byte].
    """

    time: float = 600.0
    memory: float = 4e9

    def __post_init__(self) -> None:
        checks.positive("time limit", self.time, "s")
        checks.positive("memory limit", self.memory, "byte")


NO_MORE: Final = Limits()
"""What a task may take where nobody says otherwise."""


@final
@dataclass(frozen=True, slots=True)
class ProcessExecutor(AbstractExecutor):
    """Processes of this machine; no task can harm another.

    A process that fails in any way is replaced. A task whose process was killed from outside
    is set aside and tried once more, alone, when the others are done.

    Attributes
    ----------
    n_workers : int
        Processes at a time.
    limits : Limits
        What one task may take.
    prepare : callable, optional
        What a new process does before its first task, such as slow imports.
    """

    n_workers: int
    limits: Limits = NO_MORE
    prepare: Callable[[], None] | None = None

    def __post_init__(self) -> None:
        checks.positive("n_workers", self.n_workers, "processes")

    def run(self, work: Work, tasks: Sequence[Task]) -> Iterator[TaskOutcome]:
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
    ) -> Iterator[tuple[TaskOutcome, Task]]:
        """Yield each task with its outcome."""
        waiting = deque(tasks)
        orders = packed_work(work, self.prepare)
        pool: list[Child] = []
        of: dict[str, Task] = {task.name: task for task in tasks}
        try:
            while waiting or any(process.task for process in pool):
                while waiting and len(pool) < n_workers:
                    pool.append(Child(self.limits, orders))
                    _give(pool[-1], waiting.popleft())
                wait(pool)
                for process in list(pool):
                    outcome = process.look()
                    if process.ended:
                        pool.remove(process)
                    elif not process.task and waiting:
                        _give(process, waiting.popleft())
                    if outcome is not None:
                        yield outcome, of[outcome.name]
        finally:
            for process in pool:
                process.kill()


def _give(process: "Child", task: Task) -> None:
    process.give(task.name, packed_task(task.argument))


def packed_work(work: Work, prepare: Callable[[], None] | None) -> bytes:
    """Return the work of a child process on every argument, pickled."""
    return pickle.dumps(("work", pickle.dumps((work, prepare))))


def packed_task(argument: object) -> bytes:
    """Return an argument as a child process takes it."""
    return pickle.dumps(("task", pickle.dumps(argument)))


@final
class Child:
    """One process and its task.

    Attributes
    ----------
    task : str
        Name of what it is doing; empty where it waits.
    ended : bool
        Whether it is gone.
    """

    def __init__(self, limits: Limits, orders: bytes) -> None:
        self.task = ""
        self.ended = False
        self.deadline = 0.0
        self._limits = limits
        self._ready = False
        self.connection, theirs = multiprocessing.Pipe()
        self.process = _started(theirs.fileno(), int(limits.memory))
        theirs.close()
        self.order(orders)

    @property
    def alive(self) -> bool:
        """Whether its process runs."""
        return self.process.poll() is None

    def order(self, orders: bytes) -> None:
        """Send it the pickled function that takes the arguments to come."""
        self._ready = False
        self._send(orders)

    def give(self, name: str, argument: bytes) -> None:
        """Send it a task."""
        self.task = name
        limit = self._limits.time if self._ready else _STARTUP_LIMIT
        self.deadline = time.monotonic() + limit
        self._send(argument)

    def _send(self, message: bytes) -> None:
        with contextlib.suppress(BrokenPipeError, ConnectionResetError):  # look() finds it dead
            self.connection.send_bytes(message)

    def look(self) -> TaskOutcome | None:
        """Return the outcome of the task, if it has ended."""
        message = self._received()
        if message is not None and not self._ready:
            self._ready = True
            self.deadline = time.monotonic() + self._limits.time
            return None
        if message is not None:
            return self._finished(json.loads(message))
        if not self.alive:
            return self._failed("killed", _how_it_died(self.process.returncode))
        if self.task and time.monotonic() > self.deadline:
            limit = f"{self._limits.time:g} s" if self._ready else "start"
            return self._failed(
                "time limit",
                f"stopped at the time limit ({limit}); allow more with --time-limit",
            )
        return None

    def _received(self) -> bytes | None:
        try:
            return self.connection.recv_bytes() if self.connection.poll() else None
        except (EOFError, ConnectionResetError, BrokenPipeError):
            with contextlib.suppress(subprocess.TimeoutExpired):
                self.process.wait(timeout=5.0)
            return None

    def _finished(self, report: Mapping[str, Any]) -> TaskOutcome | None:
        name, self.task = self.task, ""
        if report["cause"]:
            self.kill()
        return TaskOutcome(name, **report) if name else None

    def _failed(self, cause: Cause, error: str) -> TaskOutcome | None:
        name, self.task = self.task, ""
        self.kill()
        return TaskOutcome(name, cause=cause, error=error) if name else None

    def kill(self) -> None:
        """End it and wait for its end."""
        self.ended = True
        self.process.kill()
        self.process.communicate()
        self.connection.close()


def wait(pool: Sequence[Child]) -> None:
    """Wait until a process says something, dies, or has reached its deadline."""
    deadline = min(p.deadline for p in pool if p.task)
    longest = max(0.0, deadline - time.monotonic()) + 0.01
    multiprocessing.connection.wait([p.connection for p in pool], min(longest, _LOOKED))


def _started(handle: int, memory: int) -> "subprocess.Popen[bytes]":
    """Start a process that serves a connection, and ends when its standard input does.

    It is an interpreter of its own and not one of multiprocessing's, which would run the
    caller's script once more in each of them.
    """
    path = os.pathsep.join(entry or str(Path.cwd()) for entry in sys.path)
    environment = {**os.environ, **_ONE_THREAD_EACH, "PYTHONPATH": path}
    with _passed_on(handle) as how:
        return subprocess.Popen(  # noqa: S603 - this interpreter, with two numbers
            [sys.executable, "-P", "-c", _SERVE, str(handle), str(memory)],
            stdin=subprocess.PIPE,
            env=environment,
            **how,
        )


@contextlib.contextmanager
def _passed_on(handle: int) -> Iterator[dict[str, Any]]:
    """Say how a process that is started inherits a handle, and no Ctrl-C of the terminal."""
    if sys.platform == "win32":
        os.set_handle_inheritable(handle, True)  # noqa: FBT003 - has no name
        given = subprocess.STARTUPINFO(lpAttributeList={"handle_list": [handle]})
        yield {"startupinfo": given}
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield {"pass_fds": (handle,)}
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _how_it_died(exitcode: int | None) -> str:
    if exitcode is not None and exitcode < 0:
        name = signal.Signals(-exitcode).name if -exitcode in set(signal.Signals) else "signal"
        hint = "; the machine may have run out of memory" if name == "SIGKILL" else ""
        return f"its process was killed ({name}), also when it ran alone{hint}"
    return (
        f"its process ended with status {exitcode}, also when it ran alone; a library may have "
        "given up at the memory limit (--memory-limit)"
    )


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
