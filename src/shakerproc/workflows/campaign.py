"""Every test of a log processed: `shakerproc batch`, and its results."""

from collections.abc import Collection, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import partial
from os import cpu_count
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack, final

from shakerproc import __version__, files
from shakerproc.campaign import tables, trends
from shakerproc.campaign.batch import (
    UNTOLD,
    BatchListener,
    CampaignResult,
    Execution,
    run_batch,
)
from shakerproc.campaign.earlier import Earlier, change_columns, changes, read_earlier
from shakerproc.campaign.jobs import Products, RemoteExecutor, RemoteHashes, relative_recording
from shakerproc.campaign.result_folder import check_result_folder, locked, settle
from shakerproc.campaign.tables import write_tables
from shakerproc.campaign.trend import Trend
from shakerproc.campaign.trends import trend_sentence
from shakerproc.errors import ArgumentError, ShakerprocError
from shakerproc.report.figures.units import USUAL, ShownUnits
from shakerproc.report.page.page import Report, Watched, tried_header, write_report
from shakerproc.report.page.sections import HeaderView, ReportSection
from shakerproc.report.runs.in_units import trend_in
from shakerproc.report.trends import draw_trends, earlier_section
from shakerproc.runs import RunSummary
from shakerproc.testlog import ChosenUnits, Test, TestLog, chosen_units, facts_of
from shakerproc.workflows.arguments import (
    AnyPath,
    Machines,
    choice_of,
    list_of,
    log_of,
    path_of,
    switch_of,
    text_of,
    whole_of,
)
from shakerproc.workflows.evidence import (
    NONE,
    SCHEMA,
    Evidence,
    document,
    methods_of,
    sections_of,
)
from shakerproc.workflows.processing_options import Options, described
from shakerproc.workflows.run import process_file
from shakerproc.workflows.shown import Shown, frame, html
from shakerproc.workflows.worker import prepare, work_through

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame


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
    """Write everything that concerns the whole campaign; return the content of report.json.

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
    trends = trends_of(runs, wish)
    channel, shown_trends, missing = trends.channel, trends.found, trends.missing
    write_tables(runs, shown_trends, channel, root)
    if wish.figures:
        draw_trends([trend_in(one, USUAL) for one in shown_trends], root / "trends")
    units, sections = ShownUnits(wish.units), [*further, *sections_of(root, evidence)]
    if wish.earlier is not None:
        rows = changes(runs, wish.earlier.runs).rows
        files.write_csv(root / "against.csv", change_columns(rows))
        sections.insert(0, earlier_section(runs, wish.earlier, units))
    report = Report(
        title,
        runs,
        shown_trends,
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
    content = {
        **_document(title, runs, shown_trends, channel, wish.command),
        **document(evidence),
    }
    if verdict:
        content["verdict"] = verdict
    files.write_json(root / "report.json", content)
    return content


def _document(
    title: str,
    runs: Sequence[RunSummary],
    shown_trends: Sequence[Trend],
    channel: str,
    command: str,
) -> dict[str, Any]:
    return {
        "schema": SCHEMA,
        "shakerproc": __version__,
        "title": title,
        "command": command,
        "counts": counts(runs),
        "verdict": trend_sentence(runs, channel),
        "trend_channel": channel,
        "trends": shown_trends,
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


def run_log(
    log: TestLog,
    root: Path,
    products: Products,
    machines: Machines,
    *,
    accept_changed: bool = False,
    only: Collection[int | str] | None = None,
    progress: BatchListener = UNTOLD,
) -> CampaignResult:
    """Return how every test of a log went, its results in a folder; see `run_batch`."""
    executor = machines.executor(prepare if products.figures else None)
    hashes = None
    if machines.recordings is not None:
        hashes = RemoteHashes(machines.executor(), machines.recordings)
    if machines.scheduler is not None or machines.recordings is not None:
        executor = RemoteExecutor(executor, machines.source(log))
    return run_batch(
        log,
        root,
        products,
        Execution(work_through, executor, hashes),
        accept_changed=accept_changed,
        only=only,
        progress=progress,
    )


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class ShownCampaign(Shown):
    """Every test of a log processed.

    Attributes
    ----------
    title : str
        Title of the log.
    runs : tuple of RunSummary
        Every test in order, failed (``.status``, ``.error``) and discarded ones included.
    wish : TrendWish
        Channel and columns of the trends.
    folder : Path, optional
        Where tables, figures and report.html are, if they were asked for.
    """

    title: str
    runs: tuple[RunSummary, ...]
    wish: TrendWish
    folder: Path | None = None

    def to_pandas(self) -> "DataFrame":
        """Return a row for each test, as runs.csv: its line of the log, status, levels."""
        return frame(tables.run_columns(self.runs))

    @property
    def peaks(self) -> "DataFrame":
        """Peaks of every channel of every test, as peaks.csv."""
        return frame(tables.peak_columns(self.runs))

    @property
    def statistics(self) -> "DataFrame":
        """Rms, extremes and crest factors, as statistics.csv."""
        return frame(tables.statistics_columns(self.runs))

    @property
    def trends(self) -> dict[str, Trend]:
        """Peak frequency against the quantities varied in the log, by the names of trends."""
        return {trend.name: trend for trend in trends_of(self.runs, self.wish).found}

    @property
    def sentence(self) -> str:
        """The trends in words; empty where there is none."""
        return trend_sentence(self.runs, trends_of(self.runs, self.wish).channel)

    def plot(self, trend: str = "") -> "Figure":
        """Return the figure of a trend.

        Parameters
        ----------
        trend : str
            One of `trends`; by default the first.

        Raises
        ------
        ArgumentError
            If there is no such trend, or none at all.
        """
        from shakerproc.report.trends import trend_figure

        known = self.trends
        if not known:
            raise ArgumentError("trend", "no quantity of the log takes two values in its tests")
        chosen = choice_of("trend", trend, known, "a trend")
        return trend_figure(known[chosen], tuple(known.values()))

    def _repr_html_(self) -> str:
        failed = [f"test {r.test} failed: {r.error}" for r in self.runs if r.status == "failed"]
        table = self.to_pandas().dropna(axis="columns", how="all")
        return html(self.title, [self.sentence, *failed], table.iloc[:, :10])


def batch(
    log: TestLog,
    out: AnyPath | None = None,
    *,
    channel: str | None = None,
    trend: Sequence[str] = (),
    by: Sequence[str] = (),
    figures: bool = True,
    units: str | None = None,
    against: AnyPath | None = None,
    workers: int | None = None,
    **options: Unpack[Options],
) -> ShownCampaign:
    """Return every test of a log processed, with trends over the tests.

    A test whose recording cannot be used is in the result as failed, with the reason; the
    others are processed all the same.

    Parameters
    ----------
    log : TestLog
        What `read_log` returned.
    out : path, optional
        Folder to write tables, figures and the report into, in processes of their own and
        resumable, as the command does; without it nothing is written, and the tests are worked
        through in threads of this process.
    channel : str, optional
        Channel of the trends; by default the one with the largest response.
    trend, by : sequence of str
        Further trends of the peak frequency: columns along the axis, and columns that make
        the series.
    figures : bool
        Whether to draw files, where `out` is given.
    units : str, optional
        Of the report, such as ``"SI"`` or ``"g, in/s, mil"``; by default those of the log.
    against : path, optional
        Folder of an earlier campaign's results, to set this one beside in the report.
    workers : int, optional
        Tests at a time; by default one for each processor.
    **options
        Of every test, before what its log says; see `Options`.

    Raises
    ------
    ArgumentError
        If an argument cannot be used.
    LogError
        If no test has a recording that may be used, or a trend is asked for of a column that
        the log does not have.
    LockedError
        If another shakerproc works in the folder.
    """
    known = log_of(log)
    known.recorded()
    wish = _wish_of(channel, trend, by, figures=figures)
    n_workers = None if workers is None else whole_of("workers", workers, 1)
    known = replace(known, tests=tuple(described(test, options) for test in known.tests))
    if out is None:
        _check_no_report(units=units, against=against)
        campaign = ShownCampaign(known.title, _in_threads(known, n_workers), wish)
        trends_of(campaign.runs, wish)  # a column or channel that is not there is told at once
        return campaign
    command = f"shakerproc.batch(read_log({known.path.name!r}), out={str(out)!r})"
    header, chosen = tried_header(known), units_of(known, units)
    wish = replace(wish, command=command, header=header, units=chosen)
    if against is not None:
        earlier = read_earlier(path_of("against", against, "a folder"))
        wish = replace(wish, earlier=earlier)
    root = path_of("out", out, "a folder")
    check_result_folder(root, "batch")
    with locked(root):
        done = run_log(known, root, Products(wish.figures), Machines(n_workers))
        write_up(known.title, done, root, wish)
    return ShownCampaign(known.title, done.runs, wish, root)


def _wish_of(channel: object, trend: object, by: object, *, figures: object) -> TrendWish:
    """Return the wishes for the trends.

    Raises
    ------
    ArgumentError
        If an argument cannot be used.
    """
    along, series = _columns_of("trend", trend), _columns_of("by", by)
    if series and not along:
        raise ArgumentError("by", "goes with --trend")
    named = None if channel is None else text_of("channel", channel, "the name of a channel")
    return TrendWish(named, along, series, figures=switch_of("figures", figures))


def _columns_of(name: str, given: object) -> tuple[str, ...]:
    columns = list_of(name, given, "columns")
    return tuple(text_of(name, one, "the name of a column") for one in columns)


def _check_no_report(**given: object) -> None:
    """Pass a campaign without a folder, of whose report nothing is said.

    Raises
    ------
    ArgumentError
        If something is.
    """
    for name, value in given.items():
        if value is not None:
            raise ArgumentError(name, "is of the report, which needs a folder: give out=")


def _in_threads(log: TestLog, workers: int | None) -> tuple[RunSummary, ...]:
    """Return every test of a log processed in memory."""
    with ThreadPoolExecutor(workers or cpu_count() or 1) as pool:
        return tuple(pool.map(partial(_summary, log), log.tests))


def _summary(log: TestLog, test: Test) -> RunSummary:
    name = "" if test.recording is None else test.recording.name
    if test.discarded:
        return RunSummary(str(test.id), "discarded", facts_of(test), name)
    try:
        summary = process_file(test.require_recording(), test, pictured=False).summary
        return replace(summary, recording=relative_recording(log, test))
    except ShakerprocError as error:
        return RunSummary(str(test.id), "failed", facts_of(test), name, error=str(error))
