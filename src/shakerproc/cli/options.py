"""Options that several commands share, and their changes to a test."""

from contextlib import contextmanager
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from shakerproc.cli.commands import MACHINES, READING, RESULTS, SPECTRA
from shakerproc.late import without_parquet, without_xlsx

if TYPE_CHECKING:
    from collections.abc import Iterator

    from shakerproc.data import BadRows, Measurement
    from shakerproc.recordings import Sampling


def positive(value: float | None) -> float | None:
    """Return the number of an option that must be above 0.

    Raises
    ------
    typer.BadParameter
        If it is not, or no number.
    """
    if value is not None and not 0.0 < value < inf:
        raise typer.BadParameter(f"must be a number above 0, not {value:g}")
    return value


def not_negative(value: float | None) -> float | None:
    """Return the number of an option that must be 0 or more.

    Raises
    ------
    typer.BadParameter
        If it is not, or no number.
    """
    if value is not None and not 0.0 <= value < inf:
        raise typer.BadParameter(f"must be a number of at least 0, not {value:g}")
    return value


def own_effects(path: Path | None) -> Path | None:
    """Make the effects of a Python file known, and those of no other file."""
    if path is not None:
        from shakerproc.model_files.effect_files import load_effects

        load_effects(path)
    return path


def effects_of(path: Path | None) -> dict[str, dict[str, str]]:
    """Return the JSON entry of the user's effects: the hash of their file."""
    if path is None:
        return {}
    from shakerproc.model_files.effect_files import effect_hashes

    return {"effects_sha256": effect_hashes()}


@contextmanager
def usage(**places: str) -> "Iterator[None]":
    """Tell of an argument that cannot be used as of the option of that name.

    `places` are the names of those that are no options.

    Raises
    ------
    typer.BadParameter
        If there is one in the block.
    """
    from shakerproc.errors import ArgumentError

    try:
        yield
    except ArgumentError as error:
        from shakerproc.workflows.processing_options import option

        raise typer.BadParameter(
            error.says, param_hint=places.get(error.name, option(error.name))
        ) from error


def window_of(value: str | None) -> str | None:
    """Return the name of a window; see `option_values.window_of`."""
    if value is None:
        return None
    from shakerproc.workflows import processing_options

    with usage():
        return processing_options.window_of(value)


def detrend_of(value: str | None) -> str | None:
    """Return the option on the mean that is removed; see `option_values.detrend_of`."""
    if value is None:
        return None
    from shakerproc.workflows import processing_options

    with usage():
        return processing_options.detrend_of(value)


def exclusive(first: str, *others: str) -> None:
    """Refuse an option beside others that it contradicts.

    Raises
    ------
    typer.BadParameter
        If others are given, by their names.
    """
    if others:
        raise typer.BadParameter(
            f"contradicts {' and '.join(others)}; give one or the other", param_hint=first
        )


def check_order(model: Path, log: Path) -> None:
    """Refuse a model and a test log that are given in the wrong order.

    Raises
    ------
    typer.BadParameter
        If the first file is no model but a log, or the second no log but a model.
    """
    from shakerproc.documents import kind_of_file

    kinds = (kind_of_file(model), kind_of_file(log))
    if kinds == ("a test log", "a model"):
        raise typer.BadParameter(
            "the first file is a test log, the second a model: swap them", param_hint="MODEL"
        )
    if kinds[0] not in {"a model", ""}:
        raise typer.BadParameter(f"{model} is {kinds[0]}, not a model", param_hint="MODEL")
    if kinds[1] not in {"a test log", ""}:
        raise typer.BadParameter(f"{log} is {kinds[1]}, not a test log", param_hint="TESTLOG")


LONGEST_SEGMENT = 2**24
"""Samples of the longest segment: three channels of it take 400 MB."""

EffectsOption: TypeAlias = Annotated[
    Path | None,
    typer.Option(
        "--effects",
        metavar="FILE",
        help="Python file with effects of your own; it is run.",
        show_default="none",
        exists=True,
        dir_okay=False,
        is_eager=True,
        callback=own_effects,
    ),
]
LogArgument: TypeAlias = Annotated[
    Path,
    typer.Argument(metavar="TESTLOG", help="Test log (YAML).", exists=True, dir_okay=False),
]
LogOrFunctions: TypeAlias = Annotated[
    Path,
    typer.Argument(
        metavar="TESTLOG|FUNCTIONS",
        help="Test log (YAML), or measured response functions (.uff, .csv, .mat).",
        exists=True,
        dir_okay=False,
    ),
]
RecordingArgument: TypeAlias = Annotated[
    Path, typer.Argument(metavar="RECORDING", help="Recording of one run.", exists=True)
]
MeasurementOption: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--measurement",
        metavar="NUMBER|all",
        help="Which of several that follow each other in the same channels, from 1.",
        show_default="error",
        rich_help_panel=READING,
    ),
]
SegmentOption: TypeAlias = Annotated[
    int | None,
    typer.Option(
        help="Samples of a Welch segment.",
        min=8,
        max=LONGEST_SEGMENT,
        show_default="1024",
        rich_help_panel=SPECTRA,
    ),
]
OverlapOption: TypeAlias = Annotated[
    int | None,
    typer.Option(
        help="Samples shared with the next segment.",
        min=0,
        show_default="half",
        rich_help_panel=SPECTRA,
    ),
]
WindowOption: TypeAlias = Annotated[
    str | None,
    typer.Option(
        help="Window of the segments.",
        callback=window_of,
        show_default="hamming",
        rich_help_panel=SPECTRA,
    ),
]
DetrendOption: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="none|mean|segment mean",
        help="Which mean is removed before the spectra.",
        callback=detrend_of,
        show_default="none",
        rich_help_panel=SPECTRA,
    ),
]
FiguresOption: TypeAlias = Annotated[
    bool, typer.Option(help="Draw figures as PNG files.", rich_help_panel=RESULTS)
]
UnitsOption: TypeAlias = Annotated[
    str | None,
    typer.Option(
        help="Units of the report: SI, or a list such as g,in/s,mil.",
        show_default="as the log says",
        metavar="UNITS",
        rich_help_panel=RESULTS,
    ),
]
PdfOption: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--pdf",
        help="Print the report to report.pdf too, by a browser that is installed.",
        rich_help_panel=RESULTS,
    ),
]
SampleRateOption: TypeAlias = Annotated[
    float | None,
    typer.Option(
        "--sample-rate-hz",
        help="Sample rate, where the recording does not state it [Hz].",
        callback=positive,
        rich_help_panel=READING,
    ),
]
OverrideRateOption: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--override-rate",
        help="Use --sample-rate-hz although the recording states another.",
        rich_help_panel=READING,
    ),
]
TimeUnitOption: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--time-unit",
        metavar="s|ms|us|ns|min|h|d",
        help="Unit of times in the recording that state none.",
        show_default="by plausibility",
        rich_help_panel=READING,
    ),
]
ResampleOption: TypeAlias = Annotated[
    float | None,
    typer.Option(
        "--resample-hz",
        help="Interpolate every channel to even times at this rate [Hz].",
        callback=positive,
        rich_help_panel=READING,
    ),
]
IgnoreStartsOption: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--ignore-starts",
        help="Let all channels start together, whatever starts the recording states.",
        rich_help_panel=READING,
    ),
]
GroupOption: TypeAlias = Annotated[
    str | None,
    typer.Option(
        help="Group of a file of several.", show_default="all data", rich_help_panel=READING
    ),
]
BadRowsOption: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--bad-rows",
        metavar="refuse|skip",
        help="What to do with lines of a text file that are no rows of numbers.",
        show_default="refuse",
        rich_help_panel=READING,
    ),
]
StitchOption: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--stitch",
        help="Join the sweeps of one direction to one response.",
        rich_help_panel=SPECTRA,
    ),
]
UncertaintyOption: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--uncertainty",
        help="Give every level, peak and damping its uncertainty budget (k = 2).",
        rich_help_panel=RESULTS,
    ),
]
ThesisOption: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--thesis",
        help="Write the tables of the thesis too, as defined there; trends carry the numbers "
        "of its figures.",
        rich_help_panel=RESULTS,
    ),
]
SchedulerOption: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS",
        help="Work on the dask.distributed cluster of this scheduler, such as "
        "tcp://10.0.0.1:8786 (extra: cluster).",
        show_default="this machine",
        rich_help_panel=MACHINES,
    ),
]
RecordingsOption: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--recordings",
        metavar="FOLDER|URL",
        help="Where the workers find the log's recordings: a shared folder, or a URL that "
        "fsspec knows, such as s3://bucket/campaign.",
        show_default="the log's folder",
        rich_help_panel=MACHINES,
    ),
]
ExportOption: TypeAlias = Annotated[
    str,
    typer.Option(
        "--export",
        metavar="mat,uff,parquet,xlsx",
        help="Write the spectra in these formats too.",
        rich_help_panel=RESULTS,
    ),
]


def bad_rows_of(text: str | None) -> "BadRows":
    """Return the option on bad rows; see `option_values.bad_rows_of`."""
    from shakerproc.workflows import processing_options

    with usage():
        return processing_options.bad_rows_of(text)  # type: ignore[return-value]


def exports_of(text: str) -> tuple[str, ...]:
    """Return the formats that were asked for.

    Raises
    ------
    typer.BadParameter
        If one is not known, or needs what is not installed.
    """
    from shakerproc.campaign.exports import EXPORTS

    asked = tuple(
        dict.fromkeys(word.strip().lower() for word in text.split(",") if word.strip())
    )
    for name in asked:
        if name not in EXPORTS:
            raise typer.BadParameter(
                f"no format {name!r}; shakerproc writes {', '.join(EXPORTS)}",
                param_hint="--export",
            )
    for name, lacking in (("parquet", without_parquet), ("xlsx", without_xlsx)):
        if name in asked and (lacks := lacking()):
            raise typer.BadParameter(lacks, param_hint="--export")
    return asked


def sampling_of(
    sample_rate_hz: float | None,
    override_rate: bool,
    time_unit: str | None,
    resample_hz: float | None,
    ignore_starts: bool = False,
) -> "Sampling":
    """Return the option on the times; see `option_values.sampling_of`."""
    from shakerproc.workflows import processing_options

    with usage():
        return processing_options.sampling_of(
            sample_rate_hz,
            override_rate=override_rate,
            time_unit=time_unit,
            resample_hz=resample_hz,
            ignore_starts=ignore_starts,
        )


def named_in(said: "Sampling") -> str:
    """Return the first option that says something of the times; empty where none does."""
    given = {
        "--sample-rate-hz": said.rate, "--time-unit": said.unit,
        "--resample-hz": said.resample, "--ignore-starts": said.ignore_starts,
    }  # fmt: skip
    return next((name for name, value in given.items() if value), "")


def measurement_of(text: str | None) -> "Measurement | None":
    """Return which measurement was asked for; see `option_values.measurement_of`."""
    from shakerproc.workflows import processing_options

    with usage():
        return processing_options.measurement_of(text)  # type: ignore[return-value]
