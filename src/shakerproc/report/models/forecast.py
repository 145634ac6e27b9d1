"""A forecast as a page: limits, numbers with their bands, and predicted densities."""

from typing import Final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.forecasts import CampaignForecast, Quantity, TestForecast
from shakerproc.forecasts.document import (
    SHOWN,
    as_shown,
    departures,
    limit_text,
    of_notches,
    owner,
    percent,
)
from shakerproc.forecasts.levels import raised_level_text
from shakerproc.forecasts.model_error import LastStep
from shakerproc.forecasts.notches import PROFILE_UNITS, profile_of_test
from shakerproc.forecasts.quantities import UncertainQuantity
from shakerproc.numerals import numeral
from shakerproc.report.figures import to_svg
from shakerproc.report.figures.figure import Axis, Curve, Figure, Filling, Plot
from shakerproc.report.page.sections import PageFigure, ReportSection, ReportTable, filled
from shakerproc.report.runs.in_units import logarithmic_axis
from shakerproc.runs.levels import density_unit

PREDICTED: Final = 0
LINEAR: Final = 1
BAND_STYLE: Final = 5
MEASURED: Final = (6, 7, 2, 3, 4)
"""Styles of the curves: what is predicted, scaled, and measured from the highest level down."""

_WORDS: Final = {
    "rms": "rms", "peak": "largest", "peak_frequency_hz": "peak frequency",
    "displacement": "displacement", "force": "force", "velocity": "velocity",
    "acceleration": "acceleration",
}  # fmt: skip


def profile_figure(one: TestForecast) -> Figure | None:
    """Return the notched profile beside the planned one and that of force limiting."""
    plan = one.notch
    if plan is None or plan.notched is None or plan.notched.test.profile is None:
        return None
    test = one.planned.test
    planned = profile_of_test(test)
    unit, scale, _ = PROFILE_UNITS[planned.unit]
    low, high = one.planned.excited
    curves = []
    for label, profile, style in (
        ("planned", planned, LINEAR),
        ("force limiting", None if plan.by_force is None else plan.by_force.test.profile, 6),
        ("notched", plan.notched.test.profile, PREDICTED),
    ):
        if profile is not None:
            at, level = np.array(profile.frequency_hz), np.array(profile.level)
            curves.append(Curve(label, at, level / scale, style))
    what = "density" if planned.unit.endswith("/Hz") else "amplitude"
    plot = Plot(
        curves,
        Axis("frequency [Hz]", low, high, logarithmic=True),
        logarithmic_axis(f"{what} [{unit}]", curves, 6),
        title=f"Profile of test {test.id}",
        height=2.6,
    )
    return Figure(f"forecast_{test.id}_profile", [plot])


def density_figures(one: TestForecast, forecast: CampaignForecast) -> list[Figure]:
    """Return the predicted density of each response with its band, beside measured levels."""
    return [
        Figure(f"forecast_{one.planned.test.id}_{name}", [_plot(one, forecast, name)])
        for name in one.run.spectra
    ]


def _plot(one: TestForecast, forecast: CampaignForecast, name: str) -> Plot:
    rms = next(q for q in one.spreads if (q.whose, q.name, q.what) == ("response", name, "rms"))
    unit, factor = SHOWN.get(rms.unit, (rms.unit, 1.0)) if rms.unit != "m" else (rms.unit, 1.0)
    low, high = one.planned.excited
    kept = (one.made.frequency >= low) & (one.made.frequency <= high)
    frequency = one.made.frequency[kept]
    carried_on = np.median(one.spreads[rms].drawn / one.made.values[rms])  # from a level run
    drawn = one.made.densities[name][:, kept] * (carried_on / factor) ** 2
    under, over = _band(drawn, one.spreads[rms])
    predicted = Curve("predicted", frequency, np.median(drawn, axis=0), PREDICTED)
    curves = []
    for style, run in zip(MEASURED, reversed(forecast.evidence.runs), strict=False):
        spectrum = run.spectra[name]
        inside = (spectrum.frequency >= low) & (spectrum.frequency <= high)
        told = run.measured.test.level_text
        label = f"test {run.measured.name}, {told}" if told else f"test {run.measured.name}"
        curves.append(
            Curve(label, spectrum.frequency[inside], spectrum.values[inside] / factor**2, style)
        )
    scaled = one.run.spectra[name]
    inside = (scaled.frequency >= low) & (scaled.frequency <= high)
    ratio = (one.linear[rms] / one.run.values[rms]) ** 2
    linear = Curve(
        f"test {one.run.measured.name} scaled", scaled.frequency[inside],
        ratio * scaled.values[inside] / factor**2, LINEAR,
    )  # fmt: skip
    lines = [*curves, linear, predicted]
    return Plot(
        [Filling("90 % band", frequency, under, over, BAND_STYLE), *lines],
        Axis("frequency [Hz]", low, high, logarithmic=True),
        logarithmic_axis(f"density [{density_unit(unit)}]", lines, 6),
        title=f"{name}, test {one.planned.test.id}",
        height=3.4,
    )


def _band(drawn: FloatArray, rms: UncertainQuantity) -> tuple[FloatArray, FloatArray]:
    """Return the 90 % band of a density [unit^2/Hz]: that of the draws and of the model.

    What the model misses is taken to be as much at each frequency as it is of the whole.
    """
    low, high = rms.band
    inner = np.quantile(rms.drawn, [0.05, 0.95])
    under, over = np.quantile(drawn, [0.05, 0.95], axis=0)
    return under * (low / inner[0]) ** 2, over * (high / inner[1]) ** 2


def sections(forecast: CampaignForecast) -> list[ReportSection]:
    """Return the sections of the page: a planned test each, then the basis of the bands."""
    tests = [_section(one, forecast) for one in forecast.tests]
    step = [] if forecast.step is None else [_last_step(forecast.step)]
    return [*step, *tests, _rests_on(forecast)]


def _last_step(step: LastStep) -> ReportSection:
    """Return the prediction for the highest level that was run, beside the measurement."""
    rows = []
    for one in step.values:
        unit, values = as_shown(one.unit, one.predicted, one.low, one.high, one.measured)
        shown = ["" if value is None else numeral(value) for value in values]
        rows.append((one.response, _WORDS[one.what], *shown, unit, f"{one.error_db:+.2f} dB"))
    names = ("of", "quantity", "predicted", "low", "high", "measured", "unit", "error")
    table = filled("Predicted and measured.", names, rows)
    return ReportSection("The last step", "last-step", [step.sentence], [table])


def _section(one: TestForecast, forecast: CampaignForecast) -> ReportSection:
    test = one.planned.test
    verdict = {True: "Go", False: "No-go", None: "No limits in the log"}[one.go]
    figures = [
        PageFigure(
            f"{plot.title}.",
            "Predicted density with its 90 % band, over what was measured at the levels that "
            "were run, and the highest of them scaled with the level.",
            to_svg.plot(plot, title=f"Predicted density of {plot.title}", height=220),
        )
        for figure in density_figures(one, forecast)
        for plot in figure.plots
    ]
    profile = profile_figure(one)
    for plot in profile.plots if profile is not None else ():
        figures.insert(0, PageFigure(
            f"{plot.title}.",
            "The planned profile, and the one that takes the least away and keeps every limit.",
            to_svg.plot(plot, title=plot.title, height=220),
        ))  # fmt: skip
    text = f"{test.excitation}, {raised_level_text(test)}, {numeral(one.planned.duration, 4)} s"
    distance = (
        f"{numeral(one.distance_db)} dB above what was run" if one.distance_db > 0 else ""
    )
    return ReportSection(
        f"Test {test.id}: {verdict}",
        f"test-{test.id}",
        [
            ", ".join(filter(None, (text, distance))) + ".",
            *departures(one),
            *([] if one.notch is None else of_notches(one, one.notch)),
        ],
        [*_limits(one), _numbers(one)],
        figures,
    )


def _limits(one: TestForecast) -> list[ReportTable]:
    if not one.limits:
        return []
    rows = [
        (
            judged.name, limit_text(judged), _shown(one, judged.quantity),
            percent(judged.probability),
            "beyond 12 dB" if judged.level_db is None
            else raised_level_text(one.planned.test, judged.level_db),
        )
        for judged in one.limits
    ]  # fmt: skip
    names = ("limit", "value", "forecast, 90 % band", "exceeded with", "5 % at")
    return [ReportTable("Limits.", names, rows)]


def _shown(one: TestForecast, quantity: Quantity) -> str:
    unit, factor = SHOWN.get(quantity.unit, (quantity.unit, 1.0))
    spread = one.spreads[quantity]
    value, low, high = (numeral(v / factor) for v in (spread.value, *spread.band))
    return f"{value} ({low} to {high}) {unit}"


def _numbers(one: TestForecast) -> ReportTable:
    rows = []
    for quantity in one.spreads:
        unit, factor = SHOWN.get(quantity.unit, (quantity.unit, 1.0))
        linear = one.linear.get(quantity)
        rows.append((
            owner(quantity), _WORDS[quantity.what], _shown(one, quantity),
            "" if linear is None else f"{numeral(linear / factor)} {unit}",
        ))  # fmt: skip
    names = ("of", "quantity", "forecast, 90 % band", "linear scaling")
    return ReportTable(
        "Forecast; the largest value is that of the whole duration.", names, rows
    )


def _rests_on(forecast: CampaignForecast) -> ReportSection:
    """Return how far the model missed the levels that were run."""
    errors = forecast.evidence.errors
    rows = [
        (
            f"test {one.test}", one.quantity.name, _WORDS[one.quantity.what],
            f"{one.distance_db:+.1f} dB",
            numeral(one.predicted), numeral(one.measured), f"{one.error_db:+.2f} dB",
        )
        for one in errors
        if one.distance_db
    ]  # fmt: skip
    known = [one.of_model.error_db for one in errors if not one.distance_db]
    fitted = max(map(abs, known), default=0.0)
    names = ("test", "response", "quantity", "level", "predicted", "measured", "error")
    return ReportSection(
        "What the bands rest on",
        "rests-on",
        [
            "Each level that was run was forecast from those below it. How far the model "
            "missed them, over the distance in level, is how far it may miss the next one. "
            f"Levels that it was fitted to it meets within {numeral(fitted, 2)} dB.",
            *forecast.notes,
        ],
        [ReportTable("Levels that were run, from those below them, in SI units.", names, rows)],
    )
