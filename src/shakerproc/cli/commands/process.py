"""``shakerproc process``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

from shakerproc.cli import messages, options, output
from shakerproc.cli.commands import TEST
from shakerproc.numerals import numeral

if TYPE_CHECKING:
    from shakerproc.runs import RunSummary
    from shakerproc.runs.summary import ChannelSummary
    from shakerproc.testlog import Test
    from shakerproc.workflows.processing_options import Options


@options.grouped
def process(
    recording: options.RecordingArgument,
    log: Annotated[
        Path | None,
        typer.Option(
            metavar="TESTLOG",
            help="Test log that lists the recording.",
            exists=True,
            rich_help_panel=TEST,
        ),
    ] = None,
    test: Annotated[
        str | None,
        typer.Option(
            metavar="ID", help="Test of the log.", show_default="by file", rich_help_panel=TEST
        ),
    ] = None,
    *,
    said: options.ProcessingOptions,
    channels: options.ChannelOptions,
    written: options.ProductOptions,
    out: output.OutOption = None,
    json: output.JsonOption = None,
) -> None:
    """Process one recording: spectra, peaks, tables, figures.

    Without a log, channels in N, m and m/s are forces, displacements and velocities. Of the
    others, those with control in their names are controls, otherwise the first two, as in the
    thesis (of two channels the first; none where a force drives the test); all others are
    responses. Channels of other quantities are not used; the output names them.
    """
    from shakerproc.campaign.jobs import Products
    from shakerproc.campaign.result_folder import check_result_folder, folder_name
    from shakerproc.workflows.processing_options import described, unit_of
    from shakerproc.workflows.run import process_file

    with options.usage():
        named = unit_of(channels.unit, override=channels.override_unit)
    controls = _controls(channels.control, log)
    if test is not None and log is None:
        raise typer.BadParameter("goes with --log", param_hint="--test")
    chosen = _logged(log, test, recording) if log is not None else _unlogged(recording)
    with options.usage():
        chosen = described(chosen, cast("Options", vars(said)))
    folder = Path(folder_name(recording, chosen)) if out is None else out
    check_result_folder(folder, "process")
    products = Products(written.figures, options.exports_of(written.export), written.thesis)
    summary = process_file(
        recording,
        chosen,
        controls=controls,
        unit=named,
        out=folder,
        products=products,
        pictured=written.figures,
    ).summary
    _tell(summary)
    output.write_json(summary, json)
    _print(summary, folder)
    messages.after_processing(recording, log)


def _tell(summary: "RunSummary") -> None:
    """Write notes and flags to stderr."""
    for remark in summary.remarks:
        output.message(f"note: {remark}")
    for flag in summary.flags:
        where = f" ({flag.channel})" if flag.channel else ""
        output.warning(f"{flag.kind}{where}: {flag.message}")


def _unlogged(recording: Path) -> "Test":
    from shakerproc.testlog import Test

    return Test(id=recording.stem)


def _logged(log_path: Path, wanted: str | None, recording: Path) -> "Test":
    """Return the test of the log, found by its id or by its recording.

    Raises
    ------
    LogError
        If there is none.
    """
    from shakerproc.errors import LogError
    from shakerproc.testlog import read_testlog

    log = read_testlog(log_path)
    if wanted is not None:
        return log.find(wanted)
    resolved = recording.resolve()
    for test in log.tests:
        if test.recording is not None and test.recording.resolve() == resolved:
            return test
    whose = [f"test {t.id} ({t.recording})" for t in log.tests if recording.name in _files(t)]
    text = f", but a file of that name belongs to {' and '.join(whose[:3])}" if whose else ""
    raise LogError(
        f"{log_path}: no test has the recording {recording}{text}. Give the path of the test's "
        "recording, or name the test with --test."
    )


def _files(test: "Test") -> set[str]:
    """Return the names of the files of a test, with those that follow and those beside."""
    further = (one.recording for one in test.beside)
    return {Path(one).name for one in (test.recording, *test.continued, *further) if one}


def _controls(wanted: list[str] | None, log: Path | None) -> tuple[str, ...] | None:
    """Return the controls that were asked for: an empty tuple for none at all."""
    if not wanted:
        return None
    if log is not None:
        raise typer.BadParameter(
            "the log says which channels are controls", param_hint="--control"
        )
    return tuple(name for name in wanted if name.lower() != "none")


def _print(summary: "RunSummary", folder: Path) -> None:
    from shakerproc.report.figures.units import USUAL
    from shakerproc.report.runs.in_units import run_in
    from shakerproc.runs import tables

    summary = run_in(summary, USUAL)
    start, stop = summary.crop_s or (0.0, 0.0)
    level = ""
    if summary.measured_level is not None:
        level = f", level {numeral(summary.measured_level)} {summary.level_unit}"
    length = f"{numeral(summary.duration_s, 4)} s"
    if summary.incomplete:
        length = (
            f"INCOMPLETE, {numeral(summary.duration_s, 4)} of "
            f"{numeral(summary.promised_s, 4)} s"
        )
    output.data(
        f"{summary.recording}: {length} at {summary.sample_rate_hz:.6g} Hz, processed "
        f"{start:.2f} to {stop:.2f} s{level}"
    )
    output.print_table(
        ("channel", "role", "rms", "unit", "crest factor", "peak frequency [Hz]", "coherence"),
        [_channel_row(summary, channel) for channel in summary.channels],
        spare=("crest factor", "role"),
        elsewhere=f"{folder / 'peaks.csv'} and statistics.csv",
    )
    rows = tables.peak_rows(summary)
    if rows:
        output.data(f"resolved peaks of {tables.quantity_of(summary)}:")
        output.print_table(tables.COLUMNS, [row.cells for row in rows])
    swept = tables.swept_rows(summary)
    if swept:
        output.data("tallest points of the swept response, and what a slow sweep would show:")
        output.print_table(tables.SWEPT_COLUMNS, swept)
    if summary.spectrum is not None:
        output.data(
            f"bins {numeral(summary.spectrum.bin_width_hz, 4)} Hz apart, "
            f"{summary.spectrum.degrees_of_freedom:.0f} degrees of freedom"
        )
    remarks = (
        tables.unresolved(summary, rows),
        *tables.withheld(rows),
        tables.steady_withheld(summary),
    )
    for text in filter(None, remarks):
        output.data(text)
    _print_analyses(summary)
    output.message(f"results in {folder}")


def _print_analyses(summary: "RunSummary") -> None:
    """Print the rows and the sentences of every analysis that the log asks for."""
    from shakerproc.runs.tables import heading, shown_cell

    for one in summary.analyses:
        output.data(f"{one.title}:")
        if one.rows:
            names = list(one.rows[0])
            output.print_table(
                [heading(name) for name in names],
                [[shown_cell(name, row.get(name)) for name in names] for row in one.rows],
            )
        flags = {flag.message for flag in summary.flags}  # which are said already
        for text in (text for text in one.told if text not in flags):
            output.data(text)


def _channel_row(summary: "RunSummary", channel: "ChannelSummary") -> tuple[object, ...]:
    from shakerproc.campaign.trends import main_peak

    peak = None if channel.role == "control" else main_peak(summary, channel.name)
    return (
        channel.name,
        channel.role,
        channel.rms,
        channel.unit,
        channel.crest_factor,
        peak.frequency_hz if peak else None,
        channel.coherence,
    )
