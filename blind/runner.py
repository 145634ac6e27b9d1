"""Trials in processes of their own: one that hangs or dies costs itself only."""

import os
import signal
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any

from blind import next_test
from blind.trial import Trial, attempt, diagnose, read_trials, without_answer

Task = tuple[int, str]
Work = Callable[[int, str, float], Trial]
"""What is done with seed, class and limit in the other process."""
WALL_OVER_PROCESSOR = 8.0
"""Longest time by the clock over that of the processor, which others use too [-]."""


@dataclass
class Worker:
    """A process, the end of its pipe here, and what it is at."""

    process: BaseProcess
    pipe: Connection
    task: Task | None = None
    since: float = field(default=0.0)

    def give(self, task: Task, limit: float) -> None:
        """Hand a task over."""
        self.task, self.since = task, time.perf_counter()
        self.pipe.send((task, limit))

    def late(self, limit: float) -> bool:
        """Whether the task takes too long by the clock."""
        waited = time.perf_counter() - self.since
        return self.task is not None and waited > WALL_OVER_PROCESSOR * limit

    def end(self) -> None:
        """Stop the process."""
        self.process.kill()
        self.process.join()
        self.pipe.close()


def run(
    tasks: list[Task], work: Work, jobs: int, limit: float, nice: int = 0
) -> Iterator[Trial]:
    """Yield the trial of every task as it ends; `limit` is in seconds of processor time.

    A trial beyond its limit, or whose process dies, is a miss that says so. Whoever stops
    listening, or Ctrl-C, ends the processes.
    """
    waiting = list(reversed(tasks))
    workers = [_start(work, nice) for _ in range(min(jobs, len(tasks)))]
    try:
        for worker in workers:
            worker.give(waiting.pop(), limit)
        while any(worker.task for worker in workers):
            ready = wait([w.pipe for w in workers if w.task], timeout=1.0)
            for i in range(len(workers)):
                if workers[i].pipe not in ready and not workers[i].late(limit):
                    continue
                trial = _outcome(workers[i], limit)
                workers[i].task = None
                if trial.problem.startswith(("timeout", "died")):
                    workers[i] = _start(work, nice)
                if waiting:
                    workers[i].give(waiting.pop(), limit)
                yield trial
    finally:
        for worker in workers:
            worker.end()


def _outcome(worker: Worker, limit: float) -> Trial:
    """Return what a worker says, or what became of it."""
    seed, kind = worker.task or (0, "none")
    try:
        if not worker.late(limit):
            trial: Trial = worker.pipe.recv()
            return trial
    except (EOFError, ConnectionResetError):
        pass
    worker.process.join(timeout=1.0)
    seconds = time.perf_counter() - worker.since
    timeout = worker.process.exitcode in {None, -signal.SIGPROF}
    worker.end()
    problem = f"timeout: more than {limit:g} s of processor time"
    if not timeout:
        problem = f"died: exit code {worker.process.exitcode}"
    return without_answer(seed, kind, problem, limit if timeout else seconds)


def _start(work: Work, nice: int) -> Worker:
    here, there = get_context("spawn").Pipe()
    process = get_context("spawn").Process(target=_serve, args=(there, work, nice), daemon=True)
    process.start()
    there.close()
    return Worker(process, here)


def _serve(pipe: Any, work: Work, nice: int) -> None:
    """Do tasks until the pipe closes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.nice(nice)
    while True:
        try:
            (seed, kind), limit = pipe.recv()
        except EOFError:
            return
        pipe.send(work(seed, kind, limit))


def first(seed: int, kind: str, limit: float) -> Trial:
    """Return the trial of a campaign."""
    return attempt(seed, kind, limit=limit)


def retest(seed: int, kind: str, limit: float, *, path: Path) -> Trial:
    """Return the trial of a file after the test that it proposes."""
    known = {(trial.seed, trial.kind): trial for trial in read_trials(path)}
    return next_test.again(known[seed, kind], diagnose, limit=limit)
