"""The everyday job: every test of a log in processes, with a progress bar."""

from contextlib import ExitStack
from pathlib import Path

from shakerproc.campaign.batch import CampaignResult, Progress
from shakerproc.campaign.jobs import Products
from shakerproc.cli import output
from shakerproc.testlog import TestLog
from shakerproc.workflows.log_runs import run_log
from shakerproc.workflows.machines import Machines


def work_through_log(
    log: TestLog,
    root: Path,
    products: Products,
    machines: Machines,
    *,
    accept_changed: bool = False,
) -> CampaignResult:
    """Process the tests of a log, with a progress bar."""
    with ExitStack() as stack:
        advance = [lambda _text: None]

        def start(to_do: int, kept: int) -> None:
            if kept:
                tests = "test" if kept == 1 else "tests"
                output.message(f"{kept} {tests} reused from an earlier batch")
            if to_do:
                advance[0] = stack.enter_context(output.progress("tests", to_do))

        try:
            return run_log(
                log,
                root,
                products,
                machines,
                accept_changed=accept_changed,
                progress=Progress(
                    start, tell_outdated, lambda test: advance[0](f"(test {test} ended)")
                ),
            )
        except KeyboardInterrupt as stopped:
            raise KeyboardInterrupt(output.GO_ON) from stopped


def tell_outdated(count: int) -> None:
    """Say how many tests are computed again though nothing of them has changed."""
    output.message(
        f"{count} test{'s' if count > 1 else ''} computed again: an older shakerproc took the "
        "SHA-256 at another time than it read the recording"
    )
