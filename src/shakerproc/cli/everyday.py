"""The everyday job: every test of a log in processes, with a progress bar."""

import os
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from shakerproc.batch.campaign import Campaign, Products, run_batch
from shakerproc.batch.executor import ProcessExecutor
from shakerproc.cli import output
from shakerproc.cli.work import prepare, work_through
from shakerproc.testlog import TestLog


@dataclass(frozen=True, slots=True)
class Limits:
    """What the processes may take.

    Attributes
    ----------
    workers : int, optional
        Processes at a time; by default one for each processor.
    time_limit : float
        Longest that one test may take [s].
    memory_limit : float
        Most that one test may allocate [byte].
    """

    workers: int | None = None
    time_limit: float = 600.0
    memory_limit: float = 4e9


def work_through_log(
    log: TestLog,
    root: Path,
    products: Products,
    limits: Limits,
    *,
    accept_changed: bool = False,
) -> Campaign:
    """Work the tests of a log through, with a progress bar."""
    executor = ProcessExecutor(
        limits.workers or os.cpu_count() or 1,
        limits.time_limit,
        limits.memory_limit,
        prepare if products.figures else None,
    )
    with ExitStack() as stack:
        advance = [lambda _text: None]

        def start(to_do: int, kept: int) -> None:
            if kept:
                output.message(f"{kept} tests stand from an earlier batch")
            if to_do:
                advance[0] = stack.enter_context(output.progress("tests", to_do))

        return run_batch(
            log,
            root,
            work=work_through,
            executor=executor,
            products=products,
            accept_changed=accept_changed,
            on_start=start,
            on_end=lambda test: advance[0](f"(test {test} ended)"),
        )
