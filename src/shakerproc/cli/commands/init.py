"""``shakerproc init``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from shakerproc.cli import options, output

if TYPE_CHECKING:
    from shakerproc.recordings import Sampling


@options.grouped
def init(
    folder: Annotated[
        Path, typer.Argument(metavar="FOLDER", help="New or empty folder.", file_okay=False)
    ],
    recordings: Annotated[
        Path | None,
        typer.Option(
            metavar="RECORDINGS",
            help="Begin with your own: a folder below FOLDER, or FOLDER itself.",
            exists=True,
            file_okay=False,
        ),
    ] = None,
    *,
    times: options.TimeOptions,
) -> None:
    """Write a log, a model and small recordings to start from.

    `batch`, `compare` and `diagnose` run on them at once; both files are commented. With
    --recordings, a log and a model of your own: a line for each file, its channels, and marks
    where something has to be filled in.
    """
    said = times.sampling()
    if recordings is None and options.named_in(said):
        raise typer.BadParameter("goes with --recordings", param_hint=options.named_in(said))
    if recordings is None:
        _simulated(folder)
    else:
        _begin_campaign(folder, recordings, said)


def _begin_campaign(folder: Path, recordings: Path, said: "Sampling") -> None:
    from shakerproc.workflows.draft import begin, recordings_below

    with output.progress("looking into", len(recordings_below(recordings))) as advance:
        log, model = begin(folder, recordings, said, advance, output.warning)
    output.message(f"fill in what is marked ??? in {log}, then in {model}")
    for line in (f"shakerproc batch {log}", f"shakerproc compare {model} {log} --fit"):
        output.data(line)


def _simulated(folder: Path) -> None:
    from shakerproc.errors import LogError
    from shakerproc.workflows import draft

    if folder.is_dir() and any(folder.iterdir()):
        raise LogError(
            f"{folder}: the folder is not empty. Name a new one; nothing was written."
        )
    log, model = draft.write_example(folder)
    output.message("simulated recordings of a coupon whose joint has play, and a model without")
    for line in (
        f"shakerproc batch {log}",
        f"shakerproc compare {model} {log}",
        f"shakerproc diagnose {model} {log}",
    ):
        output.data(line)
