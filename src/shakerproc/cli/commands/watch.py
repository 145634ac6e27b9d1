"""``shakerproc watch``."""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from shakerproc.cli import options, output

if TYPE_CHECKING:
    from collections.abc import Callable

    from shakerproc.recordings import Sampling
    from shakerproc.testlog import TestLog


@options.grouped
def watch(
    folder: Annotated[
        Path,
        typer.Argument(
            metavar="FOLDER",
            help="Where recordings arrive, also in folders below.",
            exists=True,
            file_okay=False,
        ),
    ],
    log: Annotated[
        Path | None,
        typer.Option(
            metavar="TESTLOG",
            help="The tests and their options; without it FOLDER/testlog.yaml, to which each "
            "new recording adds a draft of a test.",
            exists=True,
            dir_okay=False,
        ),
    ] = None,
    out: output.OutOption = None,
    settle_s: Annotated[
        float,
        typer.Option(
            "--settle",
            help="A recording is finished when its size and time stand still for so long [s].",
            callback=options.not_negative,
        ),
    ] = 3.0,
    every_s: Annotated[
        float,
        typer.Option(
            "--every",
            help="Time between two checks of the folder [s].",
            callback=options.positive,
            max=3600.0,
        ),
    ] = 1.0,
    idle_s: Annotated[
        float | None,
        typer.Option(
            "--idle",
            help="End when nothing has changed for so long [s].",
            show_default="never",
            callback=options.positive,
        ),
    ] = None,
    workers: Annotated[
        int | None, typer.Option(help="Processes at a time.", min=1, show_default="processors")
    ] = None,
    channel: Annotated[
        str | None,
        typer.Option(help="Channel of the trends.", show_default="largest response"),
    ] = None,
    model: Annotated[
        Path | None,
        typer.Option(
            metavar="MODEL",
            help="Forecast the planned tests of the log with this model (YAML) after each run.",
            show_default="none",
            exists=True,
            dir_okay=False,
        ),
    ] = None,
    *,
    drawn: options.FileOptions,
    times: options.TimeOptions,
    json: output.JsonOption = None,
) -> None:
    """Process each recording of a folder as soon as it is finished.

    The report follows. Results are those of `batch`; after Ctrl-C or a crash the same command
    goes on. A recording that grows or changes later is processed again. The page in a browser
    reloads itself while the folder is watched. No port is opened.

    With --model, what was predicted of the run and what came is told, then the next test.
    """
    from shakerproc.campaign.jobs import Products
    from shakerproc.campaign.result_folder import locked
    from shakerproc.workflows.arguments import Machines
    from shakerproc.workflows.campaign import TrendWish
    from shakerproc.workflows.watching import Pace, Watch

    said = times.sampling()
    if log is not None and options.named_in(said):
        raise typer.BadParameter("goes without --log", param_hint=options.named_in(said))
    root = (folder if log is None else log.parent) / "results" if out is None else out
    if folder.resolve().is_relative_to(root.resolve()):
        raise typer.BadParameter(
            "results may not lie around the recordings; name a folder beside or below FOLDER",
            param_hint="--out",
        )
    watched = Watch(
        folder,
        root,
        _logs(folder, log, said),
        products=Products(drawn.figures, options.exports_of(drawn.export)),
        machines=Machines(workers),
        wish=TrendWish(channel, figures=drawn.figures, command=output.command()),
        tell=output.data,
        after=None if model is None else partial(_forecast, model, root / "forecast"),
    )
    with locked(root):
        output.message(f"watching {folder}; Ctrl-C ends it. Report: {root / 'report.html'}")
        try:
            watched.run(Pace(settle_s, every_s, idle_s))
        except KeyboardInterrupt as stopped:
            raise KeyboardInterrupt(output.GO_ON) from stopped
        finally:
            document = watched.last()
    counts = document.get("counts", {})
    output.write_json(document, json)
    text = ", ".join(f"{n} {kind}" for kind, n in counts.items() if n)
    output.data(text or "nothing processed")
    if counts.get("failed"):
        output.finish(1)


def _forecast(model: Path, folder: Path, log: "TestLog") -> None:
    """Forecast the planned tests of a log, and compare the last forecast with its test."""
    from shakerproc.cli.commands.forecast import print_step
    from shakerproc.errors import ShakerprocError
    from shakerproc.model_files import read_model
    from shakerproc.workflows.forecast import earlier_document, forecast_log, write_forecast

    if not log.planned:
        return
    try:
        forecast = forecast_log(read_model(model), log, earlier=earlier_document(folder))
    except ShakerprocError as error:
        output.message(f"no forecast: {error}")
        return
    folder.mkdir(parents=True, exist_ok=True)
    write_forecast(folder, forecast, output.command(), [], figures=False)
    output.data(f"forecast: {forecast.sentence}")
    if forecast.found.step is not None:
        print_step(forecast.found.step)


def _logs(folder: Path, log: Path | None, said: "Sampling") -> "Callable[..., TestLog | None]":
    from shakerproc.workflows.watching import DraftedLog, GivenLog, WatchedLog

    if log is None:
        return DraftedLog(folder, said, output.warning)
    given = WatchedLog(log, output.warning)
    given.read()
    return GivenLog(given, folder, output.warning)
