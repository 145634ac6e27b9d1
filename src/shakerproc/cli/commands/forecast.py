"""``shakerproc forecast``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from shakerproc.cli import options, output

if TYPE_CHECKING:
    from shakerproc.forecasts import TestForecast
    from shakerproc.forecasts.model_error import LastStep
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
    notch: Annotated[
        bool, typer.Option("--notch", help="Plan the least notches that keep every limit.")
    ] = False,
    probability: Annotated[
        float | None,
        typer.Option(
            help="With which notches keep each limit [-].",
            min=0.5,
            max=0.999,
            show_default="0.95",
        ),
    ] = None,
    edges_db_per_octave: Annotated[
        float | None,
        typer.Option(
            help="Steepest edge of a notch.", min=1.0, max=1000.0, show_default="24.0"
        ),
    ] = None,
    seed: Annotated[int, typer.Option(help="Seed of all that is drawn.", min=0)] = 0,
    figures: options.FiguresOption = True,
    pdf: options.PdfOption = False,
    out: output.OutOption = None,
    effects: options.EffectsOption = None,
    json: output.JsonOption = None,
) -> None:
    """Predict planned tests, with 90 % bands and limits.

    Numbers of the model are fitted to the tests that were run, then drawn from their
    covariance, with calibration and phases. Each level that was run is forecast from those
    below it: how far the model missed them widens the bands. The first line is go or no-go.
    --notch writes the profile with the least taken away that keeps every limit.
    """
    from shakerproc.campaign.result_folder import check_result_folder
    from shakerproc.cli.messages import announce
    from shakerproc.forecasts.notch_plan import NotchWish
    from shakerproc.model_files import read_model
    from shakerproc.recordings import read_hashed
    from shakerproc.testlog import read_testlog
    from shakerproc.workflows.evidence import inputs_of
    from shakerproc.workflows.forecast import earlier_document, forecast_log, write_forecast

    if not notch and (probability is not None or edges_db_per_octave is not None):
        raise typer.BadParameter(
            "--probability and --edges-db-per-octave are for notches; give --notch, too"
        )
    options.check_order(model, testlog)
    announce()
    folder = Path(f"{model.stem}_forecast") if out is None else out
    check_result_folder(folder, "forecast")
    log, log_hash = read_hashed(read_testlog, testlog)
    known, model_hash = read_hashed(read_model, model)
    once = output.Once()
    wish = NotchWish.asked(probability, edges_db_per_octave) if notch else None
    steps = 2 * len(log.tests) + (14 if notch else 4) * max(1, len(log.planned))
    with output.progress("forecast", steps) as advance, options.usage(level="--level"):
        result = forecast_log(
            known,
            log,
            level=level,
            wish=wish,
            earlier=earlier_document(folder),
            seed=seed,
            say=advance,
            warn=once.warning,
        )
    documents = [("model", model, model_hash), ("test log", testlog, log_hash)]
    measured = [run.measured for run in result.found.evidence.runs]
    with output.results(folder, "forecast"):
        inputs = inputs_of(documents, measured)
        page = write_forecast(folder, result, output.command(), inputs, figures=figures)
    output.write_json({**result.as_json(), **options.effects_of(effects)}, json)
    _print(result, folder)
    for note in result.found.notes:
        once.warning(note)
    output.message(f"results in {folder}, report: {page}")
    output.print_if(pdf, page)


def _print(result: "Forecast", folder: Path) -> None:
    from shakerproc.forecasts import sentences

    output.data(result.sentence)
    if result.found.step is not None:
        print_step(result.found.step)
    for one in result.found.tests:
        output.print_table(
            ("of", "quantity", "value", "low", "high", "linear", "unit"),
            _rows(one),
            title=f"Test {one.planned.test.id}, 90 % bands",
            elsewhere=str(folder / "forecast.csv"),
        )
        for text in sentences(one):
            output.data(text)


def print_step(step: "LastStep") -> None:
    """Print the forecast of the highest level that was run, beside its measurement.

    `step` is that level, `json` where JSON goes.
    """
    from shakerproc.forecasts.document import as_shown

    output.data(step.sentence)
    band = step.told_before
    names = ("predicted", *(("low", "high") if band else ()), "measured", "unit", "error [dB]")
    rows = []
    for one in step.values:
        cells = (one.predicted, *((one.low, one.high) if band else ()), one.measured)
        unit, values = as_shown(one.unit, *cells)
        what = one.what.replace("_hz", "").replace("_", " ")
        rows.append((one.response, what, *values, unit, f"{one.error_db:+.2f}"))
    title = f"Test {step.test}, predicted and measured"
    output.print_table(("of", "quantity", *names), rows, title=title)


def _rows(one: "TestForecast") -> list[tuple[object, ...]]:
    from shakerproc.forecasts.document import as_shown, owner

    rows: list[tuple[object, ...]] = []
    for q, spread in one.spreads.items():
        unit, values = as_shown(q.unit, spread.value, *spread.band, one.linear.get(q))
        rows.append((owner(q), q.what.replace("_hz", "").replace("_", " "), *values, unit))
    return rows
