"""``shakerproc convert``."""

from pathlib import Path
from typing import Annotated

import typer

from shakerproc.cli import options, output


def convert(
    recording: options.RecordingArgument,
    out: Annotated[
        Path,
        typer.Argument(
            metavar="OUT",
            help="New file: .tdms, .csv, .mat, .uff, .parquet, .h5 or .mf4.",
            dir_okay=False,
        ),
    ],
    group: options.GroupOption = None,
    measurement: options.MeasurementOption = None,
    sample_rate_hz: options.SampleRateOption = None,
    override_rate: options.OverrideRateOption = False,
    time_unit: options.TimeUnitOption = None,
    resample_hz: options.ResampleOption = None,
    ignore_starts: options.IgnoreStartsOption = False,
    bad_rows: options.BadRowsOption = None,
) -> None:
    """Write a recording in another format, in the units that it has."""
    from shakerproc.recordings import WRITERS, FilePart, open_recording

    write = WRITERS.get(out.suffix.lower())
    if write is None:
        raise typer.BadParameter(
            f"no format {out.suffix or out.name!r}; shakerproc writes {', '.join(WRITERS)}",
            param_hint="OUT",
        )
    if out.exists() and out.samefile(recording):
        raise typer.BadParameter("this is the recording itself", param_hint="OUT")
    with open_recording(
        recording,
        part=FilePart(group, options.measurement_of(measurement)),
        sample_rate=options.sampling_of(
            sample_rate_hz, override_rate, time_unit, resample_hz, ignore_starts
        ),
        bad_rows=options.bad_rows_of(bad_rows),
    ) as opened:
        write(out, opened)
        for note in opened.notes:
            output.message(f"note: {note}")
        if opened.incomplete:
            output.warning(f"{recording.name} is incomplete, and so is {out.name}")
        output.message(
            f"{out}: {len(opened.channels)} channels, {opened.n_samples} samples at "
            f"{opened.sample_rate:.9g} Hz"
        )
