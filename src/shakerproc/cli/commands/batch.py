"""``shakerproc batch``."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from shakerproc.cli import messages, options, output
from shakerproc.cli.commands import EVIDENCE, MACHINES, TRENDS

if TYPE_CHECKING:
    from shakerproc.campaign.batch import CampaignResult
    from shakerproc.report.page.sections import ReportSection
    from shakerproc.testlog import TestLog
    from shakerproc.workflows.campaign import TrendWish

LONGEST_S = 7 * 86400.0
"""A week."""

LARGEST_MB = 1e8
"""100 TB."""


@options.grouped
def batch(
    testlog: options.LogArgument,
    out: output.OutOption = None,
    workers: Annotated[
        int | None,
        typer.Option(
            help="Processes at a time.",
            min=1,
            show_default="processors",
            rich_help_panel=MACHINES,
        ),
    ] = None,
    time_limit_s: Annotated[
        float,
        typer.Option(
            "--time-limit",
            help="Longest time for one test [s].",
            min=0.1,
            max=LONGEST_S,
            callback=options.positive,
            rich_help_panel=MACHINES,
        ),
    ] = 600.0,
    memory_limit_mb: Annotated[
        float,
        typer.Option(
            "--memory-limit",
            help="Most memory for one test [MB].",
            min=100.0,
            max=LARGEST_MB,
            callback=options.positive,
            rich_help_panel=MACHINES,
        ),
    ] = 4000.0,
    scheduler: options.SchedulerOption = None,
    recordings: options.RecordingsOption = None,
    trend: Annotated[
        list[str] | None,
        typer.Option(
            metavar="COLUMN",
            help="A further trend of the peak frequency against this column.",
            rich_help_panel=TRENDS,
        ),
    ] = None,
    by: Annotated[
        str,
        typer.Option(
            metavar="COLUMNS",
            help="Columns whose values make its series, separated by commas.",
            rich_help_panel=TRENDS,
        ),
    ] = "",
    channel: Annotated[
        str | None,
        typer.Option(
            help="Channel of the trends.",
            show_default="the largest response",
            rich_help_panel=TRENDS,
        ),
    ] = None,
    *,
    averaging: options.AveragingOptions,
    written: options.ProductOptions,
    units: options.UnitsOption = None,
    against: Annotated[
        Path | None,
        typer.Option(
            metavar="EARLIER",
            help="Results of an earlier batch: the report sets both campaigns side by side.",
            exists=True,
            file_okay=False,
            rich_help_panel=EVIDENCE,
        ),
    ] = None,
    model: Annotated[
        Path | None,
        typer.Option(
            help="Compare this model with the tests and diagnose it, as part of the report.",
            metavar="MODEL",
            exists=True,
            dir_okay=False,
            rich_help_panel=EVIDENCE,
        ),
    ] = None,
    modal: Annotated[
        bool,
        typer.Option(
            "--modal",
            help="Find the modes of the tests too; results in the folder modal.",
            rich_help_panel=EVIDENCE,
        ),
    ] = False,
    pdf: options.PdfOption = False,
    accept_changed: Annotated[
        bool,
        typer.Option(
            "--accept-changed",
            help="Accept recordings that changed since they were first read.",
        ),
    ] = False,
    json: output.JsonOption = None,
) -> None:
    """Process every test of a log: tables, trends and a report.

    Called again after a stop, it goes on where it was.
    """
    from shakerproc.campaign.earlier import read_earlier
    from shakerproc.campaign.jobs import Products
    from shakerproc.campaign.result_folder import locked
    from shakerproc.cli.batch_output import tell, work_through_log
    from shakerproc.report.page.page import tried_header
    from shakerproc.testlog import read_testlog
    from shakerproc.workflows.arguments import Machines
    from shakerproc.workflows.campaign import TrendWish, units_of, write_up
    from shakerproc.workflows.processing_options import with_averaging

    options.exclusive(
        "--workers", *(["--scheduler"] if workers is not None and scheduler is not None else [])
    )
    log = read_testlog(testlog)
    log.recorded()
    output.say_planned_tests(log)
    _check_trends(log, trend or [], _words(by))
    _check_channel(log, channel)
    with options.usage():
        averaged = tuple(with_averaging(test, vars(averaging)) for test in log.tests)
        shown = units_of(log, units)
    log = replace(log, tests=averaged)
    products = Products(written.figures, options.exports_of(written.export), written.thesis)
    root = testlog.parent / "results" if out is None else out
    wish = TrendWish(
        channel,
        tuple(trend or ()),
        _words(by),
        written.figures,
        output.command(),
        tried_header(log),
        units=shown,
        earlier=None if against is None else read_earlier(against),
        thesis=written.thesis,
    )
    with locked(root):
        campaign = work_through_log(
            log,
            root,
            products,
            Machines(workers, time_limit_s, memory_limit_mb * 1e6, scheduler, recordings),
            accept_changed=accept_changed,
        )
        document = write_up(log.title, campaign, root, wish)
        if modal or model is not None:
            further = _modes(log, root, figures=written.figures) if modal else []
            document = _with_more(
                model, log, campaign, root, wish, recordings=recordings, further=further
            )
    output.write_json(document, json)
    tell(campaign, document, root)
    output.print_if(pdf, root / "report.html")
    _end(campaign, None if model is not None else testlog)


def _end(campaign: "CampaignResult", to_compare: Path | None) -> None:
    """Print the next step for a log without a comparison; end with the status."""
    states = {run.status for run in campaign.runs}
    if to_compare is not None and "done" in states:
        messages.after_batch(to_compare)
    if "failed" in states:
        output.finish(1)


def _modes(log: "TestLog", root: Path, *, figures: bool) -> "list[ReportSection]":
    """Return the section of the modes, which are found, written and told."""
    from shakerproc.cli.batch_output import modes_of_batch
    from shakerproc.report.modal.sections import section_of_modes

    return [section_of_modes(modes_of_batch(log, root, figures=figures))]


def _with_more(
    model: Path | None,
    log: "TestLog",
    campaign: "CampaignResult",
    root: Path,
    wish: "TrendWish",
    *,
    recordings: str | None,
    further: "Sequence[ReportSection]",
) -> dict[str, Any]:
    """Write the campaign up once more, with a model's comparison and diagnosis, or modes."""
    from shakerproc.campaign.jobs import at_hand
    from shakerproc.diagnosis.headline import headline
    from shakerproc.workflows.campaign import write_up
    from shakerproc.workflows.evidence import NONE, held_against

    evidence = NONE
    if model is not None:
        with (
            output.progress("model", 8 + 2 * len(log.tests)) as advance,
            at_hand(log, recordings) as seen,
        ):
            evidence = held_against(
                model, seen, log.path, campaign.runs, tell=advance, warn=output.warning
            )
    diagnosis = evidence.diagnosis
    verdict = (
        f"{headline(diagnosis, log.active)} {diagnosis.sentence}".strip() if diagnosis else ""
    )
    return write_up(
        log.title, campaign, root, wish, evidence=evidence, verdict=verdict, further=further
    )


def _check_trends(log: "TestLog", trend: Sequence[str], by: Sequence[str]) -> None:
    """Refuse further trends of columns that the log does not have, before any work.

    Raises
    ------
    typer.BadParameter
        If a column is unknown, or series are asked for without a trend.
    """
    from shakerproc.campaign.trends import column_of
    from shakerproc.testlog import facts_of

    if by and not trend:
        raise typer.BadParameter("goes with --trend", param_hint="--by")
    known = list(dict.fromkeys(name for test in log.tests for name in facts_of(test)))
    for option, names in (("--trend", trend), ("--by", by)):
        for name in names:
            with options.refused(option):
                column_of(name, known)


def _check_channel(log: "TestLog", channel: str | None) -> None:
    """Refuse a channel of the trends that no test has, as far as the log tells before any work.

    Raises
    ------
    typer.BadParameter
        If there is none.
    """
    from shakerproc.campaign.trends import chosen_channel

    used = [use for test in log.active for use in test.channels if use.role != "ignore"]
    names = list(dict.fromkeys(use.name or str(use.key) for use in used))
    by_file = any(use.name is None and isinstance(use.key, int) for use in used)
    if channel is None or by_file or not all(test.channels for test in log.active):
        return  # only the files know the names
    if names and not any(channel in name for name in names):
        with options.refused("--channel"):
            chosen_channel(channel, names)


def _words(text: str) -> tuple[str, ...]:
    return tuple(word.strip() for word in text.split(",") if word.strip())
