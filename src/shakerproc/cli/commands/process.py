"""``shakerproc process``."""

from dataclasses import dataclass, replace
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from shakerproc.cli import options, output

if TYPE_CHECKING:
    from collections.abc import Mapping

    from shakerproc.batch.campaign import Products
    from shakerproc.runs import RunSummary, UnitOption
    from shakerproc.runs.summary import ChannelSummary
    from shakerproc.testlog import Test


def process(
    recording: options.RecordingArgument,
    log: Annotated[
        Path | None, typer.Option(metavar="TESTLOG", help="Test log that lists the recording.")
    ] = None,
    test: Annotated[
        str | None, typer.Option(metavar="ID", help="Test of the log.", show_default="by file")
    ] = None,
    excitation: Annotated[
        str | None, typer.Option(metavar="KIND", help="sine sweep, random, sine or shock.")
    ] = None,
    level: Annotated[
        str | None,
        typer.Option(metavar="LEVEL", help='Demanded, such as "0.5 g", "1e-3 g^2/Hz".'),
    ] = None,
    from_hz: Annotated[
        float | None,
        typer.Option(
            help="Excited band, low end, or the frequency of a sine [Hz].",
            callback=options.positive,
        ),
    ] = None,
    to_hz: Annotated[
        float | None,
        typer.Option(help="Excited band, high end [Hz].", callback=options.positive),
    ] = None,
    notch_hz: Annotated[
        float | None,
        typer.Option(
            help="Take this tone out for a second look [Hz].", callback=options.positive
        ),
    ] = None,
    crop_channel: Annotated[
        str | None, typer.Option(help="Control channel to crop by.", show_default="control 2")
    ] = None,
    crop_threshold: Annotated[
        str | None,
        typer.Option(help="Value between which the run lies.", show_default="0.45 g"),
    ] = None,
    crop_absolute: Annotated[
        bool, typer.Option("--crop-absolute", help="Compare magnitudes with the threshold.")
    ] = False,
    crop_hold_s: Annotated[
        float | None,
        typer.Option(
            help="How long the threshold must hold [s].",
            callback=options.not_negative,
            show_default="0",
        ),
    ] = None,
    skip_s: Annotated[
        float | None,
        typer.Option(
            help="Time at the start that is not looked at, to the nearest sample [s].",
            callback=options.not_negative,
            show_default="0",
        ),
    ] = None,
    control: Annotated[
        list[str] | None,
        typer.Option(
            metavar="CHANNEL",
            help="Control channel, name or number, or none; all others are responses. May be "
            "repeated.",
            show_default="by name, or the first two",
        ),
    ] = None,
    unit: Annotated[
        str | None,
        typer.Option(help="Unit of channels that say none, such as g.", show_default="error"),
    ] = None,
    override_unit: Annotated[
        bool, typer.Option("--override-unit", help="Take --unit where the file says another.")
    ] = False,
    no_crop: Annotated[
        bool, typer.Option("--no-crop", help="Use the whole recording.")
    ] = False,
    sample_rate_hz: Annotated[
        float | None,
        typer.Option(
            help="Where the recording does not say it [Hz].", callback=options.positive
        ),
    ] = None,
    bad_rows: options.BadRowsOption = None,
    group: Annotated[
        str | None, typer.Option(help="Group of a file of several.", show_default="all data")
    ] = None,
    measurement: options.MeasurementOption = None,
    segment: options.SegmentOption = None,
    overlap: options.OverlapOption = None,
    window: options.WindowOption = None,
    detrend: options.DetrendOption = None,
    export: options.ExportOption = "",
    stitch: options.StitchOption = False,
    thesis: options.ThesisOption = False,
    figures: options.FiguresOption = True,
    out: output.OutOption = None,
    json: output.JsonOption = None,
) -> None:
    """Process one recording: crop, spectra, peaks, tables and figures.

    Without a log, channels in N, m and m/s are forces, displacements and velocities. Of the
    others, those whose name speaks of control are controls, otherwise the first two, as in the
    thesis (of two channels the first; none where a force drives the test); all others are
    responses. What measures something else is not used, and named.
    """
    from shakerproc.batch.campaign import Products
    from shakerproc.batch.single import folder_name

    said = _unit(unit, override=override_unit)
    reading = Reading(_controls(control, log), said)
    if test is not None and log is None:
        raise typer.BadParameter("goes with --log", param_hint="--test")
    chosen = _logged(log, test, recording) if log is not None else _unlogged(recording)
    chosen = _with_excitation(chosen, excitation, level, from_hz, to_hz, notch_hz)
    crop = {
        "--crop-channel": crop_channel,
        "--crop-threshold": crop_threshold,
        "--crop-hold-s": crop_hold_s,
        "--skip-s": skip_s,
        "--crop-absolute": crop_absolute or None,
    }
    chosen = _with_crop(
        chosen, {k: v for k, v in crop.items() if v is not None}, no_crop=no_crop
    )
    chosen = options.with_averaging(
        chosen,
        segment=segment,
        overlap=overlap,
        window=window,
        detrend=detrend,
        stitch=stitch,
    )
    chosen = _with_reading(
        chosen,
        sample_rate=sample_rate_hz,
        bad_rows=None if bad_rows is None else options.bad_rows_of(bad_rows),
        measurement=options.measurement_of(measurement),
        group=group,
    )
    folder = Path(folder_name(recording, chosen)) if out is None else out
    output.own_folder(folder, "process")
    products = Products(figures, options.exports_of(export), thesis)
    summary = _worked_through(recording, chosen, reading, folder, products)
    output.write_json(summary, json)
    _print(summary, folder, json)


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
    raise LogError(
        f"{log_path}: no test has the recording {recording}. Name the test with --test."
    )


def _with_excitation(
    test: "Test",
    excitation: str | None,
    level: str | None,
    *frequencies: float | None,
) -> "Test":
    """Return a test with what the options say of its excitation."""
    from shakerproc.testlog.levels import level_of

    from_hz, to_hz, notch_hz = frequencies
    kind = excitation.replace("-", " ").lower() if excitation is not None else test.excitation
    if kind not in {None, "sine sweep", "random", "sine", "stepped sine", "shock"}:
        raise typer.BadParameter(
            f"{excitation!r} is not one of sine sweep, random, sine, stepped sine, shock",
            param_hint="--excitation",
        )
    test = replace(test, excitation=kind)  # type: ignore[arg-type]
    if level is not None:
        try:
            value, unit = level_of(level, kind)  # type: ignore[arg-type]
        except ValueError as error:
            raise typer.BadParameter(str(error), param_hint="--level") from error
        test = replace(test, level=value, level_unit=unit, level_text=level)
    elif excitation is not None and test.level_text:
        try:
            level_of(test.level_text, kind)  # type: ignore[arg-type]
        except ValueError as error:
            raise typer.BadParameter(
                f"the log's level {test.level_text} is none of a {kind} test; give --level too",
                param_hint="--excitation",
            ) from error
    if notch_hz is not None:
        test = replace(test, notch_hz=notch_hz)
    if kind == "sine":
        return test if from_hz is to_hz is None else _with_tone(test, from_hz, to_hz)
    return test if from_hz is to_hz is None else _with_band(test, from_hz, to_hz)


def _with_reading(test: "Test", **said: Any) -> "Test":
    """Return a test with what the options say of how its file is read; None says nothing."""
    given = {name: value for name, value in said.items() if value is not None}
    return replace(test, processing=replace(test.processing, **given))


def _with_tone(test: "Test", from_hz: float | None, to_hz: float | None) -> "Test":
    """Return a sine test at the frequency that the options say.

    Raises
    ------
    typer.BadParameter
        If they say a band.
    """
    if to_hz is not None:
        raise typer.BadParameter(
            "a sine has one frequency, which --from-hz says", param_hint="--to-hz"
        )
    return replace(test, frequency_hz=from_hz)


def _with_band(test: "Test", from_hz: float | None, to_hz: float | None) -> "Test":
    """Return a test with the excited band that the options, and the log, say.

    Raises
    ------
    typer.BadParameter
        If an end is missing, or the band does not rise.
    """
    band = test.processing.band or test.band or (None, None)
    low = band[0] if from_hz is None else from_hz
    high = band[1] if to_hz is None else to_hz
    if low is None or high is None:
        given, other = ("--from-hz", "--to-hz") if high is None else ("--to-hz", "--from-hz")
        raise typer.BadParameter(
            f"a band has two ends: give {other} too (the log says none)", param_hint=given
        )
    if not low < high:
        raise typer.BadParameter(
            f"the band from {low:g} to {high:g} Hz does not rise", param_hint="--from-hz"
        )
    processing = replace(test.processing, band=None)
    if (test.from_hz or 0.0) > (test.to_hz or inf):  # the log sweeps down, and so it stays
        low, high = high, low
    return replace(test, from_hz=low, to_hz=high, processing=processing)


def _with_crop(test: "Test", said: "Mapping[str, str | float]", *, no_crop: bool) -> "Test":
    """Return a test with what the options say of the crop, by their names.

    Raises
    ------
    typer.BadParameter
        If they contradict each other or the crop of the log, or hold no threshold.
    """
    from shakerproc.testlog import ThresholdCrop, threshold_of

    crop = test.processing.crop
    if no_crop:
        options.exclusive("--no-crop", *said)
        return replace(test, processing=replace(test.processing, crop=None))
    if not said:
        return test
    if not isinstance(crop, ThresholdCrop):
        if "--crop-threshold" not in said:
            has = "does not crop" if crop is None else "crops from one time to another"
            raise typer.BadParameter(
                f"goes with a threshold, and the log {has}; give --crop-threshold too",
                param_hint=next(iter(said)),
            )
        crop = ThresholdCrop()
    changed = {_CROP[name]: value for name, value in said.items()}
    if "--crop-threshold" in said:
        try:
            changed["threshold"] = threshold_of(said["--crop-threshold"])
        except ValueError as error:
            raise typer.BadParameter(str(error), param_hint="--crop-threshold") from error
    crop = replace(crop, **changed)  # type: ignore[arg-type]
    return replace(test, processing=replace(test.processing, crop=crop))


_CROP: "Final[Mapping[str, str]]" = {
    "--crop-channel": "channel",
    "--crop-threshold": "threshold",
    "--crop-hold-s": "hold",
    "--skip-s": "skip",
    "--crop-absolute": "absolute",
}
"""What each option changes in the crop by threshold."""


@dataclass(frozen=True, slots=True)
class Reading:
    """How a recording is to be read, beside what the log says."""

    controls: tuple[str, ...] | None
    unit: "UnitOption | None"


def _unit(unit: str | None, *, override: bool) -> "UnitOption | None":
    """Return what the options say of units.

    Raises
    ------
    typer.BadParameter
        If it is no unit of a channel, or there is none to override with.
    """
    from shakerproc.recordings.si import parse_unit
    from shakerproc.runs import UnitOption

    if unit is None:
        if override:
            raise typer.BadParameter("goes with --unit", param_hint="--override-unit")
        return None
    if parse_unit(unit) is None:
        raise typer.BadParameter(
            f"expected the unit of a channel such as g, m/s^2 or N, got {unit!r}",
            param_hint="--unit",
        )
    return UnitOption(unit, override)


def _controls(wanted: list[str] | None, log: Path | None) -> tuple[str, ...] | None:
    """Return the controls that were asked for: an empty tuple for none at all."""
    if not wanted:
        return None
    if log is not None:
        raise typer.BadParameter(
            "the log says which channels are controls", param_hint="--control"
        )
    return tuple(name for name in wanted if name.lower() != "none")


def _worked_through(
    path: Path, test: "Test", reading: Reading, folder: Path, products: "Products"
) -> "RunSummary":
    from dataclasses import asdict

    from shakerproc import files
    from shakerproc.batch.campaign import SUMMARY, input_of
    from shakerproc.batch.lock import locked
    from shakerproc.batch.single import check_folder, put_in_place
    from shakerproc.runs import open_path, process_recording, summary_of, tables, write_summary
    from shakerproc.testlog import facts_of
    from shakerproc.workflows.work import write_products

    with open_path(path, test, controls=reading.controls, unit=reading.unit) as opened:
        first = "" if opened.file is None else opened.file.first_sha256()
        check_folder(folder, first)  # before the work, and once nobody else can write there
        result = process_recording(opened, test)
        with locked(folder), files.staged(folder) as staged:
            check_folder(folder, first)
            write_products(result, opened, staged, products)
            digest = opened.sha256()
            summary = summary_of(result, str(test.id), facts_of(test), path.name, digest)
            files.write_csv(staged / "peaks.csv", tables.peak_columns([summary]))
            files.write_csv(staged / "statistics.csv", tables.statistics_columns([summary]))
            for kind in tables.kinds_of_analysis([summary]):
                columns = tables.analysis_columns([summary], kind)
                files.write_csv(staged / f"{kind}.csv", columns)
            write_summary(staged / SUMMARY, summary)
            put_in_place(folder, staged, digest, [input_of(test), asdict(products)])
    for remark in summary.remarks:
        output.message(f"note: {remark}")
    for flag in summary.flags:
        where = f" ({flag.channel})" if flag.channel else ""
        output.warning(f"{flag.kind}{where}: {flag.message}")
    return summary


def _print(summary: "RunSummary", folder: Path, json: str | None) -> None:
    from shakerproc.runs import peak_rows

    start, stop = summary.crop_s or (0.0, 0.0)
    level = ""
    if summary.measured_level is not None:
        level = f", level {summary.measured_level:.3g} {summary.level_unit}"
    length = f"{summary.duration_s:.4g} s"
    if summary.incomplete:
        length = f"INCOMPLETE, {summary.duration_s:.4g} of {summary.promised_s:.4g} s"
    output.data(
        f"{summary.recording}: {length} at {summary.sample_rate_hz:.6g} Hz, processed "
        f"{start:.2f} to {stop:.2f} s{level}",
        json_target=json,
    )
    output.print_table(
        ("channel", "role", "rms", "unit", "crest factor", "omega_e [Hz]", "coherence"),
        [_channel_row(summary, channel) for channel in summary.channels],
        json_target=json,
        spare=("crest factor", "role"),
        elsewhere=f"{folder / 'peaks.csv'} and statistics.csv",
    )
    rows = peak_rows.peak_rows(summary)
    if rows:
        output.data(f"resolved peaks of {peak_rows.quantity_of(summary)}:", json_target=json)
        output.print_table(peak_rows.COLUMNS, [row.cells for row in rows], json_target=json)
    swept = peak_rows.swept_rows(summary)
    if swept:
        output.data(
            "tallest points of the swept response, and what a slow sweep would show:",
            json_target=json,
        )
        output.print_table(peak_rows.SWEPT_COLUMNS, swept, json_target=json)
    if summary.spectrum is not None:
        output.data(
            f"bins {summary.spectrum.bin_width_hz:.4g} Hz apart, "
            f"{summary.spectrum.degrees_of_freedom:.0f} degrees of freedom",
            json_target=json,
        )
    remarks = (
        peak_rows.unresolved(summary, rows),
        *peak_rows.withheld(rows),
        peak_rows.steady_withheld(summary),
    )
    for text in filter(None, remarks):
        output.data(text, json_target=json)
    _print_analyses(summary, json)
    output.message(f"results in {folder}")


def _print_analyses(summary: "RunSummary", json: str | None) -> None:
    """Print the rows and the sentences of every analysis that the log asks for."""
    from shakerproc.runs.tables import heading, shown_cell

    for one in summary.analyses:
        output.data(f"{one.title}:", json_target=json)
        if one.rows:
            names = list(one.rows[0])
            output.print_table(
                [heading(name) for name in names],
                [[shown_cell(name, row.get(name)) for name in names] for row in one.rows],
                json_target=json,
            )
        for text in one.told:
            output.data(text, json_target=json)


def _channel_row(summary: "RunSummary", channel: "ChannelSummary") -> tuple[object, ...]:
    from shakerproc.runs.trends import omega_e

    peak = None if channel.role == "control" else omega_e(summary, channel.name)
    return (
        channel.name,
        channel.role,
        channel.rms,
        channel.unit,
        channel.crest_factor,
        peak.frequency_hz if peak else None,
        channel.coherence,
    )
