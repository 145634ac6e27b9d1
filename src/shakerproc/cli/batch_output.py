"""Terminal output of a batch: its progress, and what came of it."""

from contextlib import ExitStack
from pathlib import Path
from typing import Any

from shakerproc.campaign import trends
from shakerproc.campaign.batch import CampaignResult, Progress
from shakerproc.campaign.jobs import Products
from shakerproc.cli import output
from shakerproc.runs import RunSummary
from shakerproc.runs.flags import EXPIRED
from shakerproc.runs.remarks import by_tests
from shakerproc.testlog import TestLog
from shakerproc.workflows.campaign import run_log
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


def tell_outdated(count: int, why: str) -> None:
    """Say how many tests are computed again though their recordings are the same, and why."""
    output.message(f"{count} test{'s' if count > 1 else ''} computed again: {why}")


def tell(
    campaign: CampaignResult, document: dict[str, Any], root: Path, json_target: str | None
) -> None:
    """Say on the terminal what came of a batch."""
    channel = document["trend_channel"]
    rows = [_row(run, channel) for run in campaign.runs if run.status != "discarded"]
    output.print_table(
        (
            "test",
            "status",
            "joint",
            "clearance",
            "orientation",
            "excitation",
            "level",
            "peak frequency [Hz]",
            "Q",
            "coherence",
            "flags",
        ),
        rows,
        json_target=json_target,
        spare=("orientation", "excitation", "joint", "coherence", "Q"),
        elsewhere=f"{root / 'runs.csv'} and peaks.csv",
    )
    for run in campaign.runs:
        if run.status == "failed":
            output.message(f"test {run.test} failed: {run.error}")
        if run.left_out:
            output.warning(run.left_out)
    runs = [run for run in campaign.runs if run.status == "done"]
    expired = [[f.message for f in run.flags if f.kind == EXPIRED] for run in runs]
    told = ((r.test, (*r.remarks, *more)) for r, more in zip(runs, expired, strict=True))
    for line in by_tests(told):
        output.message(line)
    number = document["counts"]
    parts = [f"{n} {name}" for name, n in number.items() if n or name == "processed"]
    whose = f" (peak frequency of {channel})" if channel else ""
    output.data(f"{', '.join(parts)}{whose}", json_target=json_target)
    if document["verdict"]:
        output.data(document["verdict"], json_target=json_target)
    output.data(f"report: {root / 'report.html'}", json_target=json_target)


def _row(run: RunSummary, channel: str) -> tuple[object, ...]:
    peak = trends.main_peak(run, channel)
    seen = next((c for c in run.channels if c.name == channel), None)
    response = seen.response_peaks[0] if seen and seen.response_peaks else None
    return (
        run.test,
        run.told_status,
        run.facts.get("joint"),
        trends.shown("clearance_m", run.facts.get("clearance_m")),
        run.facts.get("orientation"),
        run.facts.get("excitation"),
        trends.shown("level", run.facts.get("level")),
        peak.frequency_hz if peak else None,
        response.quality if response else None,
        seen.coherence if seen else None,
        ", ".join(dict.fromkeys(flag.kind for flag in run.flags)),
    )
