"""Options that several commands share, and their changes to a test."""

from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import dataclass, fields, is_dataclass
from functools import wraps
from inspect import Parameter, Signature, signature
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, TypeAlias

import typer

from shakerproc.cli.commands import CROP, MACHINES, READING, RESULTS, SPECTRA, TEST
from shakerproc.late import without_parquet, without_xlsx

if TYPE_CHECKING:
    from collections.abc import Iterator

    from shakerproc.data import BadRows
    from shakerproc.recordings import FilePart, Sampling

KEYWORD_ONLY: Final = Parameter.KEYWORD_ONLY


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


@contextmanager
def refused(place: str) -> "Iterator[None]":
    """Tell of a value that cannot be used as of this option.

    Raises
    ------
    typer.BadParameter
        If it raises a ValueError or a LogError in the block.
    """
    from shakerproc.errors import LogError

    try:
        yield
    except (ValueError, LogError) as error:
        raise typer.BadParameter(str(error), param_hint=place) from error


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


def named_in(said: "Sampling") -> str:
    """Return the first option that says something of the times; empty where none does."""
    given = {
        "--sample-rate-hz": said.rate, "--time-unit": said.unit,
        "--resample-hz": said.resample, "--ignore-starts": said.ignore_starts,
    }  # fmt: skip
    return next((name for name, value in given.items() if value), "")


@dataclass(frozen=True, kw_only=True)
class TimeOptions:
    """Options on the times of a recording."""

    sample_rate_hz: Annotated[
        float | None,
        typer.Option(
            "--sample-rate-hz",
            help="Sample rate, where the recording does not state it [Hz].",
            callback=positive,
            rich_help_panel=READING,
        ),
    ] = None
    override_rate: Annotated[
        bool,
        typer.Option(
            "--override-rate",
            help="Use --sample-rate-hz although the recording states another.",
            rich_help_panel=READING,
        ),
    ] = False
    time_unit: Annotated[
        str | None,
        typer.Option(
            "--time-unit",
            metavar="s|ms|us|ns|min|h|d",
            help="Unit of times in the recording that state none.",
            show_default="by plausibility",
            rich_help_panel=READING,
        ),
    ] = None
    resample_hz: Annotated[
        float | None,
        typer.Option(
            "--resample-hz",
            help="Interpolate every channel to even times at this rate [Hz].",
            callback=positive,
            rich_help_panel=READING,
        ),
    ] = None
    ignore_starts: Annotated[
        bool,
        typer.Option(
            "--ignore-starts",
            help="Let all channels start together, whatever starts the recording states.",
            rich_help_panel=READING,
        ),
    ] = False

    def sampling(self) -> "Sampling":
        """Return the options as a reader takes them."""
        from shakerproc.workflows import processing_options

        with usage():
            return processing_options.sampling_of(
                self.sample_rate_hz,
                override_rate=self.override_rate,
                time_unit=self.time_unit,
                resample_hz=self.resample_hz,
                ignore_starts=self.ignore_starts,
            )


@dataclass(frozen=True, kw_only=True)
class ReadingOptions(TimeOptions):
    """Options on how a recording is read."""

    bad_rows: Annotated[
        str | None,
        typer.Option(
            "--bad-rows",
            metavar="refuse|skip",
            help="What to do with lines of a text file that are no rows of numbers.",
            show_default="refuse",
            rich_help_panel=READING,
        ),
    ] = None
    group: Annotated[
        str | None,
        typer.Option(
            help="Group of a file of several.", show_default="all data", rich_help_panel=READING
        ),
    ] = None
    measurement: Annotated[
        str | None,
        typer.Option(
            "--measurement",
            metavar="NUMBER|all",
            help="Which of several that follow each other in the same channels, from 1.",
            show_default="error",
            rich_help_panel=READING,
        ),
    ] = None

    def part(self) -> "FilePart":
        """Return the group and the measurement that are read."""
        from shakerproc.recordings import FilePart
        from shakerproc.workflows import processing_options

        with usage():
            chosen = processing_options.measurement_of(self.measurement)
        return FilePart(self.group, chosen)  # type: ignore[arg-type]

    def rows(self) -> "BadRows":
        """Return whether rows that are no numbers are refused or skipped."""
        from shakerproc.workflows import processing_options

        with usage():
            return processing_options.bad_rows_of(self.bad_rows)  # type: ignore[return-value]


@dataclass(frozen=True, kw_only=True)
class AveragingOptions:
    """Options on how spectra are averaged."""

    segment: Annotated[
        int | None,
        typer.Option(
            help="Samples of a Welch segment.",
            min=8,
            max=LONGEST_SEGMENT,
            show_default="1024",
            rich_help_panel=SPECTRA,
        ),
    ] = None
    overlap: Annotated[
        int | None,
        typer.Option(
            help="Samples shared with the next segment.",
            min=0,
            show_default="half",
            rich_help_panel=SPECTRA,
        ),
    ] = None
    window: Annotated[
        str | None,
        typer.Option(
            help="Window of the segments.",
            callback=window_of,
            show_default="hamming",
            rich_help_panel=SPECTRA,
        ),
    ] = None
    detrend: Annotated[
        str | None,
        typer.Option(
            metavar="none|mean|segment mean",
            help="Which mean is removed before the spectra.",
            callback=detrend_of,
            show_default="none",
            rich_help_panel=SPECTRA,
        ),
    ] = None
    stitch: Annotated[
        bool,
        typer.Option(
            "--stitch",
            help="Join the sweeps of one direction to one response.",
            rich_help_panel=SPECTRA,
        ),
    ] = False
    uncertainty: Annotated[
        bool,
        typer.Option(
            "--uncertainty",
            help="Give every level, peak and damping its uncertainty budget (k = 2).",
            rich_help_panel=RESULTS,
        ),
    ] = False


@dataclass(frozen=True, kw_only=True)
class TestOptions:
    """Options on a test beside its log: how it was shaken, and the part that is used."""

    excitation: Annotated[
        str | None,
        typer.Option(
            metavar="KIND",
            help="sine sweep, random, sine, shock, hammer, free decay or measured.",
            rich_help_panel=TEST,
        ),
    ] = None
    level: Annotated[
        str | None,
        typer.Option(
            metavar="LEVEL",
            help='Demanded level, such as "0.5 g", "1e-3 g^2/Hz".',
            rich_help_panel=TEST,
        ),
    ] = None
    from_hz: Annotated[
        float | None,
        typer.Option(
            help="Excited band, low end, or the frequency of a sine [Hz].",
            callback=positive,
            rich_help_panel=TEST,
        ),
    ] = None
    to_hz: Annotated[
        float | None,
        typer.Option(
            help="Excited band, high end [Hz].", callback=positive, rich_help_panel=TEST
        ),
    ] = None
    notch_hz: Annotated[
        float | None,
        typer.Option(
            help="Remove this tone and compare with the original [Hz].",
            callback=positive,
            rich_help_panel=TEST,
        ),
    ] = None
    crop_channel: Annotated[
        str | None,
        typer.Option(
            help="Control channel to crop by.", show_default="control 2", rich_help_panel=CROP
        ),
    ] = None
    crop_threshold: Annotated[
        str | None,
        typer.Option(
            help="The run lies between the first and the last sample at this level.",
            show_default="0.45 g",
            rich_help_panel=CROP,
        ),
    ] = None
    crop_absolute: Annotated[
        bool,
        typer.Option(
            "--crop-absolute",
            help="Compare magnitudes with the threshold.",
            rich_help_panel=CROP,
        ),
    ] = False
    crop_hold_s: Annotated[
        float | None,
        typer.Option(
            help="How long the threshold must hold [s].",
            callback=not_negative,
            show_default="0",
            rich_help_panel=CROP,
        ),
    ] = None
    skip_s: Annotated[
        float | None,
        typer.Option(
            help="Ignore this time at the start, to the nearest sample [s].",
            callback=not_negative,
            show_default="0",
            rich_help_panel=CROP,
        ),
    ] = None
    no_crop: Annotated[
        bool, typer.Option("--no-crop", help="Use the whole recording.", rich_help_panel=CROP)
    ] = False


@dataclass(frozen=True, kw_only=True)
class ProcessingOptions(AveragingOptions, ReadingOptions, TestOptions):
    """All options of `processing_options.Options`, in the order of the help."""


@dataclass(frozen=True, kw_only=True)
class ChannelOptions:
    """Options on the channels of a recording without a log."""

    control: Annotated[
        list[str] | None,
        typer.Option(
            metavar="CHANNEL",
            help="Control channel, name or number, or none; all others are responses. May be "
            "repeated.",
            show_default="by name, or the first two",
            rich_help_panel=TEST,
        ),
    ] = None
    unit: Annotated[
        str | None,
        typer.Option(
            help="Unit of channels that have none, such as g.",
            show_default="error",
            rich_help_panel=TEST,
        ),
    ] = None
    override_unit: Annotated[
        bool,
        typer.Option(
            "--override-unit",
            help="Use --unit although the file states another.",
            rich_help_panel=TEST,
        ),
    ] = False


@dataclass(frozen=True, kw_only=True)
class FileOptions:
    """Options on the files beside the tables."""

    export: Annotated[
        str,
        typer.Option(
            "--export",
            metavar="mat,uff,parquet,xlsx",
            help="Write the spectra in these formats too.",
            rich_help_panel=RESULTS,
        ),
    ] = ""
    figures: FiguresOption = True


@dataclass(frozen=True, kw_only=True)
class ProductOptions(FileOptions):
    """Options on the files beside the tables, those of the thesis included."""

    thesis: Annotated[
        bool,
        typer.Option(
            "--thesis",
            help="Write the tables of the thesis too, as defined there; trends carry the "
            "numbers of its figures.",
            rich_help_panel=RESULTS,
        ),
    ] = False


def grouped(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command of which each field of a group is an option of its own.

    A group is a parameter whose type is one of the dataclasses above.
    """
    given = signature(command).parameters.values()
    groups: dict[str, type[Any]] = {
        one.name: one.annotation
        for one in given
        if isinstance(one.annotation, type) and is_dataclass(one.annotation)
    }
    options: list[Parameter] = []
    for one in given:
        options += [
            Parameter(each.name, KEYWORD_ONLY, default=each.default, annotation=each.type)
            for each in fields(groups[one.name])
        ] if one.name in groups else [one.replace(kind=KEYWORD_ONLY)]  # fmt: skip

    @wraps(command)
    def run(**values: Any) -> None:
        made = {
            name: kind(**{each.name: values.pop(each.name) for each in fields(kind)})
            for name, kind in groups.items()
        }
        command(**values, **made)

    run.__signature__ = Signature(options)  # type: ignore[attr-defined]
    run.__annotations__ = {one.name: one.annotation for one in options}
    return run
