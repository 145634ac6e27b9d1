"""Trends as figures: as PNG files and as SVG on the page."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from shakerproc.campaign.trend import Trend, TrendPoint
from shakerproc.report.figures import style, to_svg
from shakerproc.report.figures.figure import Axis, Curve, Plot
from shakerproc.report.figures.to_png import LEFT, save
from shakerproc.report.page.sections import PageFigure
from shakerproc.report.trends.styles import series_styles

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MARKERS: Final = ("o", "s", "^", "D", "v", "P")


def draw_trends(trends: Sequence[Trend], folder: Path) -> list[Path]:
    """Draw trends, in which the same thing has the same colour; return the files."""
    return [
        save(_figure(trend, styles), folder / f"{trend.name}.png")
        for trend, styles in zip(trends, series_styles(trends), strict=True)
    ]


def trend_figure(trend: Trend, beside: Sequence[Trend] = ()) -> "Figure":
    """Return the figure of a trend, its colours as where it stands among others."""
    known = list(beside) if trend in beside else [trend]
    return _figure(trend, series_styles(known)[known.index(trend)])


def _figure(trend: Trend, styles: Mapping[str, int]) -> "Figure":
    places, x_axis, names = positions(trend)
    with style.look():
        figure, (axis,) = style.figure(7.0, 4.0, left=LEFT)
        for name, points in trend.series.items():
            _draw_series(axis, places[name], points, styles[name], name)
            if trend.connected(name):
                y = [p.frequency_hz for p in points]
                axis.plot(places[name], y, lw=0.7, color=style.COLOURS[styles[name]])
        axis.set_xlim(x_axis.low, x_axis.high)
        if names:
            axis.set_xticks(list(names), list(names.values()))
        axis.set_xlabel(trend.x_label)
        axis.set_ylabel(trend.quantity)
        note = f"{trend.channel}; bars: {trend.bars}"
        if any(p.incomplete for points in trend.series.values() for p in points):
            note += "; hollow: incomplete recording"
        style.head(axis, trend.title.rstrip("."), note)
        style.legend(axis)
    return figure


def _draw_series(
    axis: "Axes", x: Sequence[float], points: Sequence[TrendPoint], number: int, name: str
) -> None:
    """Draw one series: a bar of one bin at each point, incomplete runs hollow."""
    y = [p.frequency_hz for p in points]
    half = [p.bin_width_hz / 2.0 for p in points]
    colour, marker = style.COLOURS[number], MARKERS[number]
    axis.errorbar(x, y, half, color=colour, fmt="none", elinewidth=0.8, capsize=2.0)
    axis.plot(x, y, marker=marker, ms=5.5, lw=0.0, color=colour, label=name)
    cut = [i for i, p in enumerate(points) if p.incomplete]
    axis.plot(
        [x[i] for i in cut],
        [y[i] for i in cut],
        marker=marker,
        ms=5.5,
        lw=0.0,
        mfc="white",
        mec=colour,
    )


def page_figures(trends: Sequence[Trend]) -> list[PageFigure]:
    """Return trends as figures of the page, each quantity in one colour throughout."""
    return [
        _page_figure(trend, styles)
        for trend, styles in zip(trends, series_styles(trends), strict=True)
    ]


def _page_figure(trend: Trend, styles: Mapping[str, int]) -> PageFigure:
    """Return a trend as a drawing: a line of points for each series."""
    places, x_axis, names = positions(trend)
    frequencies = [
        p.frequency_hz + side * p.bin_width_hz
        for points in trend.series.values()
        for p in points
        for side in ((-0.5, 0.5) if np.isfinite(p.bin_width_hz) else (0.0,))
    ]
    margin = 0.12 * max(max(frequencies) - min(frequencies), 0.1 * max(frequencies))
    y_axis = Axis(
        trend.quantity, max(0.0, min(frequencies) - margin), max(frequencies) + margin
    )
    curves: list[Curve] = []
    for name, points in trend.series.items():
        x = np.array(places[name])
        y = np.array([p.frequency_hz for p in points])
        if trend.connected(name):
            curves.append(Curve("", x, y, styles[name], thin=True))
        curves.append(
            Curve(
                name,
                x,
                y,
                styles[name],
                points=True,
                hollow=[p.incomplete for p in points],
                bars=[p.bin_width_hz / 2.0 for p in points],
            )
        )
    caption = f"{trend.caption} Bars: {trend.bars}."
    if any(p.incomplete for points in trend.series.values() for p in points):
        caption += " Hollow: incomplete recording."
    return PageFigure(
        trend.title,
        caption,
        to_svg.plot(Plot(curves, x_axis, y_axis, names=names), title=trend.title, height=260),
    )


def positions(trend: Trend) -> tuple[dict[str, list[float]], Axis, dict[float, str]]:
    """Return where the points of each series stand, the axis, and the names of categories."""
    if trend.numeric:
        places = {name: [float(p.x) for p in points] for name, points in trend.series.items()}
        everything = [x for row in places.values() for x in row]
        margin = 0.08 * (max(everything) - min(everything))
        return (
            places,
            Axis(trend.x_label, min(everything) - margin, max(everything) + margin),
            {},
        )
    categories = sorted({str(p.x) for points in trend.series.values() for p in points})
    n_series = len(trend.series)
    places = {
        name: [categories.index(str(p.x)) + 0.5 * ((i + 0.5) / n_series - 0.5) for p in points]
        for i, (name, points) in enumerate(trend.series.items())
    }
    axis = Axis(trend.x_label, -0.5, len(categories) - 0.5)
    return places, axis, {float(i): name for i, name in enumerate(categories)}
