"""Trends as figures in files."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from shakerproc.campaign.trend import Point, Trend
from shakerproc.report.figures import style
from shakerproc.report.figures.to_png import LEFT, save
from shakerproc.report.trends import trend_view
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
    places, x_axis, names = trend_view.positions(trend)
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
    axis: "Axes", x: Sequence[float], points: Sequence[Point], number: int, name: str
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
