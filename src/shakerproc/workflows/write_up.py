"""Products of a batch: tables, trends and the report."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from shakerproc import __version__, files
from shakerproc.campaign import trends
from shakerproc.campaign.batch import CampaignResult
from shakerproc.campaign.earlier import Earlier, change_columns, changes
from shakerproc.campaign.manifest import settle
from shakerproc.campaign.tables import write_tables
from shakerproc.campaign.trend import Trend
from shakerproc.campaign.trends import trend_sentence
from shakerproc.errors import ArgumentError
from shakerproc.report.figures.units import USUAL, ShownUnits
from shakerproc.report.page.header import HeaderView
from shakerproc.report.page.page import Report, Watched, write_report
from shakerproc.report.page.sections import ReportSection
from shakerproc.report.runs.in_units import trend_in
from shakerproc.report.trends import draw_trends, earlier_section
from shakerproc.runs import RunSummary
from shakerproc.testlog import ChosenUnits, TestLog, chosen_units
from shakerproc.workflows.arguments import text_of
from shakerproc.workflows.evidence import (
    NONE,
    SCHEMA,
    Evidence,
    document,
    methods_of,
    sections_of,
)


@dataclass(frozen=True, slots=True)
class TrendWish:
    """Wishes for the trends.

    Attributes
    ----------
    channel : str, optional
        Whose peak frequency; by default that of the largest response.
    against, by : tuple of str
        Further trends: columns along the axis, and columns that make the series.
    figures : bool
        Whether to draw files.
    command : str
        How the report was asked for, as one may type it again.
    header : HeaderView, optional
        What stands at the top of the report; by default nothing but the title.
    watched : Watched, optional
        How the page follows a folder that is watched; by default it does not.
    units : mapping
        Units of the page, as `chosen_units` returns them; by default the usual ones.
    earlier : Earlier, optional
        Campaign to set this one beside.
    thesis : bool
        Whether trends that the thesis has carry the numbers of its figures.
    """

    channel: str | None = None
    against: tuple[str, ...] = ()
    by: tuple[str, ...] = ()
    figures: bool = True
    command: str = ""
    header: HeaderView | None = None
    watched: Watched | None = None
    units: ChosenUnits = field(default_factory=dict)
    earlier: Earlier | None = None
    thesis: bool = False


def units_of(log: TestLog, words: str | None = None) -> ChosenUnits:
    """Return the units of the report: those of an option, else those of the log.

    Raises
    ------
    ArgumentError
        If a word of the option is no unit that can be chosen.
    """
    if words is None:
        return {} if log.header is None else log.header.units
    try:
        return chosen_units(text_of("units", words, "units such as SI").split(","))
    except ValueError as error:
        raise ArgumentError("units", str(error)) from error


def _channel(wish: TrendWish, runs: Sequence[RunSummary]) -> str:
    """Return the channel of the trends."""
    known = list(dict.fromkeys(channel.name for run in runs for channel in run.channels))
    if wish.channel is None or not known:
        return wish.channel or trends.trend_channel(runs)
    return trends.chosen_channel(wish.channel, known)


@dataclass(frozen=True, slots=True)
class Trends:
    """The trends of a campaign.

    Attributes
    ----------
    channel : str
        Whose peak frequency.
    found : tuple of Trend
        Those in which two values of a quantity have a run.
    missing : tuple of str
        Titles of the others.
    """

    channel: str
    found: tuple[Trend, ...]
    missing: tuple[str, ...]


def trends_of(runs: Sequence[RunSummary], wish: TrendWish) -> Trends:
    """Return the trends that a person wants, and the usual ones."""
    channel = _channel(wish, runs)
    requests = [
        *(trends.chosen_trend(runs, x, wish.by) for x in wish.against),
        *trends.standard_trends(runs, thesis=wish.thesis),
    ]
    drawn = {request.title: trends.trend(runs, request, channel) for request in requests}
    return Trends(
        channel,
        tuple(trend for trend in drawn.values() if trend is not None),
        tuple(title for title, trend in drawn.items() if trend is None),
    )


def write_up(
    title: str,
    campaign: CampaignResult,
    root: Path,
    wish: TrendWish,
    *,
    evidence: Evidence = NONE,
    verdict: str = "",
    further: Sequence[ReportSection] = (),
) -> dict[str, Any]:
    """Write everything that concerns the whole campaign; return what report.json holds.

    `further` are sections of the report besides those of runs, trends and evidence.
    What an earlier batch wrote of the kind, and this one does not, is removed.
    """
    with files.noted() as written:
        content = _written_up(
            title, campaign, root, wish, evidence=evidence, verdict=verdict, further=further
        )
    settle(root, written)
    return content


def _written_up(
    title: str,
    campaign: CampaignResult,
    root: Path,
    wish: TrendWish,
    *,
    evidence: Evidence,
    verdict: str,
    further: Sequence[ReportSection],
) -> dict[str, Any]:
    runs = campaign.runs
    told = trends_of(runs, wish)
    channel, found, missing = told.channel, told.found, told.missing
    write_tables(runs, found, channel, root)
    if wish.figures:
        draw_trends([trend_in(one, USUAL) for one in found], root / "trends")
    units, sections = ShownUnits(wish.units), [*further, *sections_of(root, evidence)]
    if wish.earlier is not None:
        rows = changes(runs, wish.earlier.runs).rows
        files.write_csv(root / "against.csv", change_columns(rows))
        sections.insert(0, earlier_section(runs, wish.earlier, units))
    report = Report(
        title,
        runs,
        found,
        channel,
        wish.command,
        {},
        verdict,
        sections,
        missing,
        evidence.inputs,
        methods_of(runs, evidence),
        wish.watched,
        wish.header,
        units,
    )
    write_report(root / "report.html", report)
    content = {**_document(title, runs, found, channel, wish.command), **document(evidence)}
    if verdict:
        content["verdict"] = verdict
    files.write_json(root / "report.json", content)
    return content


def _document(
    title: str, runs: Sequence[RunSummary], found: Sequence[Trend], channel: str, command: str
) -> dict[str, Any]:
    return {
        "schema": SCHEMA,
        "shakerproc": __version__,
        "title": title,
        "command": command,
        "counts": counts(runs),
        "verdict": trend_sentence(runs, channel),
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
