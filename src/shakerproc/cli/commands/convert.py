"""``shakerproc convert``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from shakerproc.cli import options, output
from shakerproc.cli.commands import MODES

if TYPE_CHECKING:
    from shakerproc.workflows.mode_sets import ModeOptions

_RECORDING = (
    "group", "measurement", "sample_rate_hz", "override_rate", "time_unit", "resample_hz",
    "ignore_starts", "bad_rows",
)  # fmt: skip
_MODES = ("mass_unit", "length_unit", "damping_ratio", "direction", "at", "sensors")


@options.grouped
def convert(
    context: typer.Context,
    recording: Annotated[
        Path,
        typer.Argument(
            metavar="RECORDING|MODES", help="Recording of one run, or modes.", exists=True
        ),
    ],
    out: Annotated[
        Path,
        typer.Argument(
            metavar="OUT",
            help="New file: .tdms, .csv, .mat, .uff, .parquet, .h5 or .mf4; of modes .yaml, "
            ".csv, .uff, .unv, .pch or .frd.",
            dir_okay=False,
        ),
    ],
    reading: options.ReadingOptions,
    mass_unit: Annotated[
        str | None,
        typer.Option(
            help="For which shapes are normalised, of a file that does not say it: kg, t.",
            metavar="UNIT",
            rich_help_panel=MODES,
        ),
    ] = None,
    length_unit: Annotated[
        str | None,
        typer.Option(
            help="Of nodes in a file that does not say it: m, mm.",
            metavar="UNIT",
            rich_help_panel=MODES,
        ),
    ] = None,
    damping_ratio: Annotated[
        float | None,
        typer.Option(help="Of all modes [-].", min=0.0, max=1.0, rich_help_panel=MODES),
    ] = None,
    direction: Annotated[
        str | None,
        typer.Option(
            help="x, y or z: in which the base moves, and sensors measure where the log does "
            "not say it.",
            metavar="AXIS",
            rich_help_panel=MODES,
        ),
    ] = None,
    at: Annotated[
        list[str] | None,
        typer.Option(
            "--at",
            metavar="NAME=PLACE",
            help="A point and its node and direction, such as 'tip=301 z'; may be repeated. "
            "Without points all places are written.",
            rich_help_panel=MODES,
        ),
    ] = None,
    sensors: Annotated[
        Path | None,
        typer.Option(
            help="Its sensors are points: places of their names, or the nearest nodes.",
            metavar="TESTLOG",
            exists=True,
            dir_okay=False,
            rich_help_panel=MODES,
        ),
    ] = None,
) -> None:
    """Write a recording or modes in another format.

    A recording keeps its units; modes are written in SI.
    """
    from shakerproc.recordings import open_recording
    from shakerproc.workflows.mode_sets import ModeOptions, is_of_modes

    if out.exists() and out.samefile(recording):
        raise typer.BadParameter("this is the recording itself", param_hint="OUT")
    of_modes = is_of_modes(recording, out)
    _refuse(context, _RECORDING if of_modes else _MODES, "modes" if of_modes else "a recording")
    if of_modes:
        at = at or []
        given = ModeOptions(mass_unit, length_unit, damping_ratio, direction, at, sensors)
        _convert_modes(recording, out, given)
        return
    write = output.writer_of(out, modes=True)
    with open_recording(
        recording,
        part=reading.part(),
        sample_rate=reading.sampling(),
        bad_rows=reading.rows(),
    ) as opened:
        write(out, opened)
        output.tell_written(out, opened)


def _refuse(context: typer.Context, names: tuple[str, ...], of: str) -> None:
    """Refuse options of another kind of file.

    Raises
    ------
    typer.BadParameter
        If one is given.
    """
    from shakerproc.workflows.processing_options import option

    for name in names:
        value = context.params[name]
        if value is not None and value is not False and value not in ([], ()):  # 0 is given
            raise typer.BadParameter(
                f"does not belong to {of}; leave it out", param_hint=option(name)
            )


def _convert_modes(source: Path, out: Path, given: "ModeOptions") -> None:
    """Write modes in another format, and say where their points are."""
    from shakerproc.workflows.mode_sets import convert_modes

    with options.usage():
        converted = convert_modes(source, out, given)
    for note in converted.notes:
        output.message(f"note: {note}")
    output.message(f"{out}: {converted.modes} modes at {converted.places} places")
