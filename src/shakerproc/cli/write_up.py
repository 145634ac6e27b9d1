"""What a batch leaves behind: tables, trends, the report, and a few lines on the terminal."""

import shlex
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from shakerproc import __version__, files
from shakerproc.batch.campaign import Campaign
from shakerproc.batch.collecting import write_tables
from shakerproc.batch.manifest import settle
from shakerproc.cli import output
from shakerproc.cli.evidence import NONE, Evidence, document, methods_of, sections_of
from shakerproc.report.page import Report, write_report
from shakerproc.report.trend_figures import draw_trend
from shakerproc.runs import RunSummary, telling, trends
from shakerproc.runs.remarks import by_tests
from shakerproc.runs.trends import Trend

SCHEMA: Final = "shakerproc-report/1"


@dataclass(frozen=True, slots=True)
class Wish:
    """What a person wants of the trends.

    Attributes
    ----------
    channel : str, optional
        Whose omega_e; by default the response that moves most.
    against, by : tuple of str
        Further trends: columns along the axis, and columns that make the series.
    figures : bool
        Whether to draw files.
    """

    channel: str | None = None
    against: tuple[str, ...] = ()
    by: tuple[str, ...] = ()
    figures: bool = True


def _channel(wish: Wish, runs: Sequence[RunSummary]) -> str:
    """Return the channel of the trends."""
    known = list(dict.fromkeys(channel.name for run in runs for channel in run.channels))
    if wish.channel is None or not known:
        return wish.channel or trends.trend_channel(runs)
    return trends.chosen_channel(wish.channel, known)


def write_up(
    title: str,
    campaign: Campaign,
    root: Path,
    wish: Wish,
    *,
    evidence: Evidence = NONE,
    verdict: str = "",
) -> dict[str, Any]:
    """Write everything that concerns the whole campaign; return what report.json holds.

    What an earlier batch wrote of the kind, and this one does not, is removed.
    """
    with files.noted() as written:
        content = _written_up(title, campaign, root, wish, evidence, verdict)
    settle(root, written)
    return content


def _written_up(
    title: str, campaign: Campaign, root: Path, wish: Wish, evidence: Evidence, verdict: str
) -> dict[str, Any]:
    runs = campaign.runs
    channel = _channel(wish, runs)
    requests = [
        *(trends.chosen_trend(runs, x, wish.by) for x in wish.against),
        *trends.standard_trends(runs),
    ]
    drawn = {request.title: trends.trend(runs, request, channel) for request in requests}
    found = [trend for trend in drawn.values() if trend is not None]
    missing = [title for title, trend in drawn.items() if trend is None]
    write_tables(runs, found, channel, root)
    if wish.figures:
        for trend in found:
            draw_trend(trend, root / "trends" / f"{trend.name}.png")
    report = Report(
        title,
        runs,
        found,
        channel,
        command(),
        {},
        verdict,
        sections_of(root, evidence),
        missing,
        evidence.inputs,
        methods_of(runs, evidence),
    )
    write_report(root / "report.html", report)
    content = {**_document(title, runs, found, channel), **document(evidence)}
    if verdict:
        content["verdict"] = verdict
    files.write_json(root / "report.json", content)
    return content


def command() -> str:
    """Return the command line, as one may type it again."""
    return shlex.join(["shakerproc", *sys.argv[1:]])


def _document(
    title: str, runs: Sequence[RunSummary], found: Sequence[Trend], channel: str
) -> dict[str, Any]:
    return {
        "schema": SCHEMA,
        "shakerproc": __version__,
        "title": title,
        "command": command(),
        "counts": counts(runs),
        "verdict": telling.trend_sentence(runs, channel),
        "trend_channel": channel,
        "trends": found,
        "left_out_of_trends": [run.left_out for run in runs if run.left_out],
        "runs": runs,
    }


def counts(runs: Sequence[RunSummary]) -> dict[str, int]:
    """Return how many tests there are of each kind."""
    done = [run for run in runs if run.status == "done"]
    return {
        "processed": len(done),
        "failed": sum(run.status == "failed" for run in runs),
        "incomplete": sum(run.incomplete for run in done),
        "flagged": sum(bool(run.flags) for run in done),
        "discarded": sum(run.status == "discarded" for run in runs),
    }


def tell(
    campaign: Campaign, document: dict[str, Any], root: Path, json_target: str | None
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
            "omega_e [Hz]",
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
    for line in by_tests((run.test, run.remarks) for run in runs):
        output.message(line)
    number = document["counts"]
    parts = [f"{n} {name}" for name, n in number.items() if n or name == "processed"]
    whose = f" (omega_e of {channel})" if channel else ""
    output.data(f"{', '.join(parts)}{whose}", json_target=json_target)
    if document["verdict"]:
        output.data(document["verdict"], json_target=json_target)
    output.data(f"report: {root / 'report.html'}", json_target=json_target)


def _row(run: RunSummary, channel: str) -> tuple[object, ...]:
    peak = trends.omega_e(run, channel)
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
