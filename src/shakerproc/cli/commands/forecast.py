"""``shakerproc forecast``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from shakerproc.cli import options, output
from shakerproc.workflows import folders

if TYPE_CHECKING:
    from shakerproc.forecasts import TestForecast
    from shakerproc.workflows.forecast import Forecast


def forecast(
    model: Annotated[
        Path, typer.Argument(metavar="MODEL", help="Model (YAML).", exists=True, dir_okay=False)
    ],
    testlog: options.LogArgument,
    level: Annotated[
        str | None,
        typer.Option(
            metavar="LEVEL",
            help='Level of the planned tests, or of the loudest run, such as "0.04 g^2/Hz".',
            show_default="as the log says",
        ),
    ] = None,
    seed: Annotated[int, typer.Option(help="Seed of all that is drawn.", min=0)] = 0,
    figures: options.FiguresOption = True,
    pdf: options.PdfOption = False,
    out: output.OutOption = None,
    own: options.EffectsOption = None,
    json: output.JsonOption = None,
) -> None:
    """Predict what the planned tests of a log will do, with 90 % bands and its limits.

    Numbers of the model are fitted to the tests that were run, then drawn from their
    covariance, with calibration and phases. Each level that was run is forecast from those
    below it: how far the model missed them widens the bands. The first line is go or no-go.
    """
    from shakerproc.cli.compiling import announce
    from shakerproc.model_files import read_model
    from shakerproc.recordings import read_hashed
    from shakerproc.testlog import read_testlog
    from shakerproc.workflows.evidence import inputs_of
    from shakerproc.workflows.forecast import forecast_log, write_forecast

    options.check_order(model, testlog)
    announce()
    folder = Path(f"{model.stem}_forecast") if out is None else out
    folders.own_folder(folder, "forecast")
    log, log_hash = read_hashed(read_testlog, testlog)
    known, model_hash = read_hashed(read_model, model)
    once = output.Once()
    steps = 2 * len(log.tests) + 4 * max(1, len(log.planned))
    with output.progress("forecast", steps) as advance, options.usage(level="--level"):
        found = forecast_log(known, log, level=level, seed=seed, say=advance, warn=once.warning)
    documents = [("model", model, model_hash), ("test log", testlog, log_hash)]
    measured = [run.measured for run in found.found.evidence.runs]
    with output.results(folder, "forecast"):
        inputs = inputs_of(documents, measured)
        page = write_forecast(folder, found, output.command(), inputs, figures=figures)
    output.write_json({**found.as_json(), **options.effects_of(own)}, json)
    _print(found, folder, json)
    for note in found.found.notes:
        once.warning(note)
    output.message(f"results in {folder}, report: {page}")
    output.print_if(pdf, page)


def _print(found: "Forecast", folder: Path, json: str | None) -> None:
    from shakerproc.forecasts import sentences

    output.data(found.sentence, json_target=json)
    for one in found.found.tests:
        output.print_table(
            ("of", "quantity", "value", "low", "high", "linear", "unit"),
            _rows(one),
            title=f"Test {one.planned.test.id}, 90 % bands",
            json_target=json,
            elsewhere=str(folder / "forecast.csv"),
        )
        for text in sentences(one):
            output.data(text, json_target=json)


def _rows(one: "TestForecast") -> list[tuple[object, ...]]:
    return [
        (
            f"{'' if q.whose == 'response' else q.whose} {q.name}".strip(),
            q.what.replace("_hz", "").replace("_", " "),
            spread.value,
            *spread.band,
            one.linear.get(q),
            q.unit,
        )
        for q, spread in one.spreads.items()
    ]
