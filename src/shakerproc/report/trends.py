"""Trends over tests as figures, and the section on changes since an earlier campaign."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final, final

import numpy as np

from shakerproc.campaign.earlier import Change, Earlier, changes
from shakerproc.campaign.trend import Trend, TrendPoint
from shakerproc.numerals import numeral
from shakerproc.report.figures import style, to_svg
from shakerproc.report.figures.figure import Axis, Curve, Plot
from shakerproc.report.figures.to_png import LEFT, save
from shakerproc.report.figures.units import ShownUnits
from shakerproc.report.page.sections import PageFigure, ReportSection, filled
from shakerproc.report.runs.in_units import (
    STILL,
    content_of_summary,
    frequency_axis,
    logarithmic_axis,
    outside,
    run_in,
)
from shakerproc.runs.levels import density_unit
from shakerproc.runs.summary import PeakSummary, RunSummary
from shakerproc.runs.tables import quantity_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

STYLES: Final = 6
"""How many colours with marks of their own there are."""

MARKERS: Final = ("o", "s", "^", "D", "v", "P")

COLUMNS: Final = (
    "test", "channel", "mode", "peak before [Hz]", "now [Hz]", "change", "ζ before [%]",
    "now [%]", "height [dB]", "level [dB]",
)  # fmt: skip

_EARLIER_STYLE: Final = style.CONTROL_STYLES[1]


@final
@dataclass(frozen=True, slots=True)
class _Series:
    """Facts that distinguish a series from the others of its trend, and its runs."""

    name: str
    facts: frozenset[str]
    runs: frozenset[str]

    def likeness(self, other: "_Series") -> tuple[float, int]:
        """Return the share of facts that both have, then how many runs both have."""
        both = len(self.facts & other.facts) / len(self.facts | other.facts)
        return both, len(self.runs & other.runs)


def series_styles(trends: Sequence[Trend]) -> list[Mapping[str, int]]:
    """Return the number of colour and mark of every series, trend by trend.

    A series has the style of the most alike series of an earlier trend: by the facts of its
    name that not all series of its trend share, then by its runs. Those without one have styles
    that no trend has yet, then any that their trend has not.
    """
    seen: list[tuple[int, _Series]] = []
    rows: list[Mapping[str, int]] = []
    for trend in trends:
        series = list(_series(trend))
        styles = _earlier_styles(series, seen)
        fresh = set(range(STYLES)) - {style for style, _ in seen}
        for one in series:
            if one.name not in styles:
                free = [s for s in (*fresh, *range(STYLES)) if s not in styles.values()]
                styles[one.name] = free[0] if free else len(styles) % STYLES
        seen += [(styles[one.name], one) for one in series]
        rows.append(styles)
    return rows


def _series(trend: Trend) -> Iterator[_Series]:
    facts = {name: frozenset(name.split(", ")) for name in trend.series}
    shared = frozenset.intersection(*facts.values()) if len(facts) > 1 else frozenset()
    for name, points in trend.series.items():
        runs = frozenset(point.test for point in points)
        yield _Series(name, (facts[name] - shared) or facts[name], runs)


def _earlier_styles(
    series: Sequence[_Series], seen: Sequence[tuple[int, _Series]]
) -> dict[str, int]:
    """Return the styles that series keep of earlier trends, the most alike first."""
    pairs = [(one.likeness(other), one.name, s) for one in series for s, other in seen]
    kept: dict[str, int] = {}
    for likeness, name, number in sorted(pairs, key=lambda pair: pair[0], reverse=True):
        if any(likeness) and name not in kept and number not in kept.values():
            kept[name] = number
    return kept


def draw_trends(trends: Sequence[Trend], folder: Path) -> list[Path]:
    """Draw trends, in which the same thing has the same colour; return the files."""
    return [
        save(_figure(trend, styles), folder / f"{trend.name}.png")
        for trend, styles in zip(trends, series_styles(trends), strict=True)
    ]


def trend_figure(trend: Trend, others: Sequence[Trend] = ()) -> "Figure":
    """Return the figure of a trend, its colours as where it stands among others."""
    known = list(others) if trend in others else [trend]
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


def earlier_section(
    runs: Sequence[RunSummary], earlier: Earlier, units: ShownUnits
) -> ReportSection:
    """Return the tests of both campaigns side by side: a table of modes, curves overlaid."""
    moved = changes(runs, earlier.runs)
    before = {run.test: run for run in earlier.runs if run.status == "done"}
    pairs = [(run, before[run.test]) for run in runs if run.status == "done"
             and run.test in before]  # fmt: skip
    paragraphs = [_opening(earlier, moved.rows, len(pairs))]
    for tests, whose in ((moved.only_now, "this campaign"), (moved.only_before, "the earlier")):
        if tests:
            paragraphs.append(f"Only in {whose}: {', '.join(tests)}.")
    other = [now.test for now, then in pairs if quantity_of(now) != quantity_of(then)]
    if other:
        text = ", ".join(other)
        paragraphs.append(f"Not compared, with a control in one campaign only: {text}.")
    rows = [_cells(row) for row in moved.rows]
    table = filled("Every mode before and now.", COLUMNS, rows)
    drawn = [_overlaid(run_in(now, units), run_in(then, units)) for now, then in pairs]
    return ReportSection(
        "Against an earlier campaign",
        "earlier",
        paragraphs,
        (table,) if rows else (),
        [drawing for drawing in drawn if drawing is not None],
    )


def _opening(earlier: Earlier, rows: Sequence[Change], n_tests: int) -> str:
    shifts = [(abs(row.shift_hz), row) for row in rows if row.shift_hz is not None]
    said = f"Beside {earlier.title} ({earlier.folder}): {n_tests} tests in both."
    clear = [one for one in shifts if one[0] > one[1].bin_hz]
    if not shifts:
        return said
    if not clear:
        return f"{said} No peak moved by more than a bin."
    _, row = max(clear, key=lambda one: one[0] / (one[1].now or one[1].before).frequency_hz)  # type: ignore[union-attr]
    assert row.before is not None  # noqa: S101 - a shift has both
    assert row.now is not None  # noqa: S101
    return (
        f"{said} {len(clear)} of {len(shifts)} peaks moved by more than a bin, most that of "
        f"{row.channel} in test {row.test}: from {numeral(row.before.frequency_hz, 4)} to "
        f"{numeral(row.now.frequency_hz, 4)} Hz ({_share(row):+.1f} %)."
    )


def _share(row: Change) -> float:
    assert row.before is not None  # noqa: S101 - asked by the callers
    return 100.0 * (row.shift_hz or 0.0) / row.before.frequency_hz


def _cells(row: Change) -> list[str]:
    change = "new" if row.before is None else "gone"
    if row.shift_hz is not None:
        beyond = abs(row.shift_hz) > row.bin_hz
        change = f"{_share(row):+.2f} %{'' if beyond else ', within a bin'}"
    return [
        row.test, row.channel, str(row.mode), _hz(row.before), _hz(row.now), change,
        _damping(row.before), _damping(row.now), _db(row.height_db), _db(row.level_db),
    ]  # fmt: skip


def _hz(peak: PeakSummary | None) -> str:
    return "" if peak is None else f"{peak.frequency_hz:.1f}"


def _damping(peak: PeakSummary | None) -> str:
    """Return a damping ratio with half its 95 % interval [%]."""
    if peak is None or peak.damping_ratio is None:
        return ""
    half = ""
    if peak.damping_low is not None and peak.damping_high is not None:
        half = f" ± {numeral(50.0 * (peak.damping_high - peak.damping_low), 2)}"
    return f"{numeral(100.0 * peak.damping_ratio)}{half}"


def _db(value: float | None) -> str:
    return "" if value is None else f"{value:+.1f}"


def _unit(unit: str, run: RunSummary, kind: str) -> str:
    """Return the unit of a density, or of a response over the controls."""
    over = next((c.unit for c in run.channels if c.role == "control"), unit)
    if kind == "psd":
        return density_unit(unit)
    return "-" if unit == over else f"{unit}/{over}"


def _overlaid(now: RunSummary, before: RunSummary) -> PageFigure | None:
    """Return response functions of a test, or densities, now and before."""
    kind, quantity = ("gain", "|H1|") if quantity_of(now) == "|H1|" else ("psd", "PSD")
    content = content_of_summary(now)
    then = {curve.channel: curve for curve in content_of_summary(before).of(kind)}
    units = [content.unit_of(c.channel) for c in content.of(kind) if c.channel in then]
    if not units:
        return None
    curves = [c for c in content.of(kind, units[0]) if c.channel in then]
    lines = [line for line in content.lines(kind, units[0]) if line.label in then]
    grey = [
        Curve(
            f"{c.channel}, earlier",
            then[c.channel].x,
            then[c.channel].y,
            _EARLIER_STYLE,
            thin=True,
        )
        for c in curves
    ]
    axis, unit = frequency_axis(curves), _unit(units[0], now, kind)
    return PageFigure(
        f"Test {now.test}.",
        f"{quantity} now in colour, earlier thin and grey.",
        to_svg.plot(
            Plot(
                [*grey, *lines],
                axis,
                logarithmic_axis(f"{quantity} [{unit}]", [*lines, *grey], 5),
                spans=outside(now, axis),
            ),
            most=STILL,
            title=f"{quantity} of test {now.test}, now and earlier",
        ),
    )
