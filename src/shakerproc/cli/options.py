"""Options that several commands share, and what they change in a test."""

from dataclasses import replace
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

if TYPE_CHECKING:
    from shakerproc.data import BadRows, Measurement
    from shakerproc.testlog import Test


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
    """Return what the JSON of a command says of its effects: the hash of their file."""
    if path is None:
        return {}
    from shakerproc.model_files.effect_files import effect_hashes

    return {"effects_sha256": effect_hashes()}


def window_of(value: str | None) -> str | None:
    """Return the name of a window.

    Raises
    ------
    typer.BadParameter
        If there is none of that name.
    """
    if value is None:
        return None
    from shakerproc.spectra.windows import COSINE_TERMS, PERIODIC

    if value.removeprefix(PERIODIC) not in COSINE_TERMS:
        raise typer.BadParameter(
            f"no window {value!r}; there are {', '.join(COSINE_TERMS)}, each also with "
            f"{PERIODIC.strip()} in front"
        )
    return value


def detrend_of(value: str | None) -> str | None:
    """Return what mean is removed.

    Raises
    ------
    typer.BadParameter
        If it is not known.
    """
    if value not in {None, "none", "mean", "segment mean"}:
        raise typer.BadParameter(f"{value!r} is not one of none, mean, segment mean")
    return value


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
    ),
]
SegmentOption: TypeAlias = Annotated[
    int | None,
    typer.Option(
        help="Samples of a Welch segment.", min=8, max=LONGEST_SEGMENT, show_default="1024"
    ),
]
OverlapOption: TypeAlias = Annotated[
    int | None,
    typer.Option(help="Samples shared with the next segment.", min=0, show_default="half"),
]
WindowOption: TypeAlias = Annotated[
    str | None,
    typer.Option(help="Window of the segments.", callback=window_of, show_default="hamming"),
]
DetrendOption: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="none|mean|segment mean",
        help="What mean is removed.",
        callback=detrend_of,
        show_default="none",
    ),
]
FiguresOption: TypeAlias = Annotated[bool, typer.Option(help="Draw figures as PNG files.")]
PdfOption: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--pdf", help="Print the report to report.pdf too, by a browser that is installed."
    ),
]
BadRowsOption: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--bad-rows",
        metavar="refuse|skip",
        help="What to do with lines of a text file that are no rows of numbers.",
        show_default="refuse",
    ),
]
StitchOption: TypeAlias = Annotated[
    bool,
    typer.Option("--stitch", help="Join the sweeps of one direction to one response."),
]
ThesisOption: TypeAlias = Annotated[
    bool,
    typer.Option("--thesis", help="Write the thesis' tables too, to the letter."),
]
SchedulerOption: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS",
        help="Work on the dask.distributed cluster of this scheduler, such as "
        "tcp://10.0.0.1:8786 (extra: cluster).",
        show_default="this machine",
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
    ),
]
ExportOption: TypeAlias = Annotated[
    str, typer.Option("--export", metavar="mat,uff,parquet", help="Further formats of spectra.")
]


def bad_rows_of(text: str | None) -> "BadRows":
    """Return what is done with rows that are no numbers.

    Raises
    ------
    typer.BadParameter
        If it is not known.
    """
    if text in {None, "refuse"}:
        return "refuse"
    if text == "skip":
        return "skip"
    raise typer.BadParameter(f"{text!r} is not refuse or skip", param_hint="--bad-rows")


def exports_of(text: str) -> tuple[str, ...]:
    """Return the formats that were asked for.

    Raises
    ------
    typer.BadParameter
        If one is not known.
    """
    from shakerproc.batch.exports import EXPORTS

    asked = tuple(
        dict.fromkeys(word.strip().lower() for word in text.split(",") if word.strip())
    )
    for name in asked:
        if name not in EXPORTS:
            raise typer.BadParameter(
                f"no format {name!r}; shakerproc writes {', '.join(EXPORTS)}",
                param_hint="--export",
            )
    return asked


def measurement_of(text: str | None) -> "Measurement | None":
    """Return which measurement was asked for.

    Raises
    ------
    typer.BadParameter
        If it is no number from 1, nor all.
    """
    if text is None or text == "all":
        return text  # type: ignore[return-value]
    if not text.isdecimal() or not 1 <= int(text) <= 10_000:
        raise typer.BadParameter(
            f"expected a number from 1, or all, got {text!r}", param_hint="--measurement"
        )
    return int(text)


def with_averaging(
    test: "Test",
    *,
    segment: int | None,
    overlap: int | None,
    window: str | None,
    detrend: str | None,
    stitch: bool = False,
) -> "Test":
    """Return a test with other averaging than its log says, its sweeps stitched on request.

    Raises
    ------
    typer.BadParameter
        If the values do not fit each other.
    """
    welch, processing = test.processing.welch, test.processing
    if segment is not None:
        welch = replace(welch, segment=segment, overlap=segment // 2, n_fft=None)
    if overlap is not None:
        welch = replace(welch, overlap=overlap)
    if not welch.overlap < welch.segment:
        raise typer.BadParameter(
            f"{welch.overlap} samples do not fit a segment of {welch.segment}",
            param_hint="--overlap",
        )
    if window is not None:
        welch = replace(welch, window=window)
    if detrend is not None:
        processing = replace(processing, detrend=detrend)  # type: ignore[arg-type]
    stitch = stitch or processing.stitch
    return replace(test, processing=replace(processing, welch=welch, stitch=stitch))
