"""Trends as drawings of points."""

from collections.abc import Mapping, Sequence

import numpy as np

from shakerproc.campaign.trend import Trend
from shakerproc.report.figures import to_svg
from shakerproc.report.page.drawing import Drawing
from shakerproc.report.trends.styles import series_styles


def drawings(trends: Sequence[Trend]) -> list[Drawing]:
    """Return trends as drawings, in which the same thing has the same colour."""
    return [
        _drawing(trend, styles)
        for trend, styles in zip(trends, series_styles(trends), strict=True)
    ]


def _drawing(trend: Trend, styles: Mapping[str, int]) -> Drawing:
    """Return a trend as a drawing: a line of points for each series."""
    places, x_axis, names = positions(trend)
    frequencies = [
        p.frequency_hz + side * p.bin_width_hz
        for points in trend.series.values()
        for p in points
        for side in ((-0.5, 0.5) if np.isfinite(p.bin_width_hz) else (0.0,))
    ]
    margin = 0.12 * max(max(frequencies) - min(frequencies), 0.1 * max(frequencies))
    y_axis = to_svg.Axis(
        trend.quantity, max(0.0, min(frequencies) - margin), max(frequencies) + margin
    )
    curves: list[to_svg.Curve] = []
    for name, points in trend.series.items():
        x = np.array(places[name])
        y = np.array([p.frequency_hz for p in points])
        if trend.connected(name):
            curves.append(to_svg.Curve("", x, y, styles[name], thin=True))
        curves.append(
            to_svg.Curve(
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
    return Drawing(
        trend.title,
        caption,
        to_svg.plot(
            to_svg.Plot(curves, x_axis, y_axis, names=names), title=trend.title, height=260
        ),
    )


def positions(trend: Trend) -> tuple[dict[str, list[float]], to_svg.Axis, dict[float, str]]:
    """Return where the points of each series stand, the axis, and the names of categories."""
    if trend.numeric:
        places = {name: [float(p.x) for p in points] for name, points in trend.series.items()}
        everything = [x for row in places.values() for x in row]
        margin = 0.08 * (max(everything) - min(everything))
        return (
            places,
            to_svg.Axis(trend.x_label, min(everything) - margin, max(everything) + margin),
            {},
        )
    categories = sorted({str(p.x) for points in trend.series.values() for p in points})
    n_series = len(trend.series)
    places = {
        name: [categories.index(str(p.x)) + 0.5 * ((i + 0.5) / n_series - 0.5) for p in points]
        for i, (name, points) in enumerate(trend.series.items())
    }
    axis = to_svg.Axis(trend.x_label, -0.5, len(categories) - 0.5)
    return places, axis, {float(i): name for i, name in enumerate(categories)}
