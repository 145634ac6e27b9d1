"""Curves as static SVG, written by hand so that a page of a hundred runs stays small."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.report.figures import axes, figure
from shakerproc.report.figures.axes import UNIT, Box, grid
from shakerproc.report.figures.figure import Axis, Curve, Filling, Mark, Plot, Span, unwrapped
from shakerproc.report.figures.style import COLOURS
from shakerproc.runs.panels import straightened, thinned

ROUNDING: Final = 1e-9
"""How far beyond the end of an axis a value still lies on it, as a share of the axis [-]."""

CAP: Final = 12
"""Half width of the ends of an error bar, in steps of a drawing."""

MARKERS: Final = (
    "m-14 0a14 14 0 1 0 28 0a14 14 0 1 0-28 0",
    "m-12-12h24v24h-24z",
    "m0-16l15 27h-30z",
    "m0-17l17 17-17 17-17-17z",
    "m0 16l15-27h-30z",
    "m-6-16h12v10h10v12h-10v10h-12v-10h-10v-12h10z",
    "m-18-6h36v12h-36z",
    "m-6-18h12v36h-12z",
)

_LEFT, _RIGHT, _TOP, _BOTTOM = 58, 18, 8, 34  # room for the labels [px]
_BARE: Final = 6
"""Room below an axis without label and numbers [px]."""


def line_inside(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the part of a line that lies inside, broken where it is outside.

    Where it crosses an end of an axis the line ends there, on the straight line between its
    points: nothing is drawn where the data are not.

    Parameters
    ----------
    x, y : (n,) array
        Places along the axes, 0 to 1 being inside [-].

    Returns
    -------
    (m,) array, (m,) array
        Places, not a number where the line is broken.
    """
    rows = _cut((x, y), (0, 1))
    outside = _outside(rows[0]) | _outside(rows[1])
    return _without(rows[0], outside), _without(rows[1], outside)


def points_inside(x: FloatArray, y: FloatArray) -> NDArray[np.bool_]:
    """Return which points are numbers and lie inside; arguments as of `line_inside`.

    Both are shares of their axes [-].
    """
    inside = np.isfinite(x) & np.isfinite(y) & ~_outside(x) & ~_outside(y)
    return np.asarray(inside, dtype=bool)


def area_inside(
    x: FloatArray, low: FloatArray, high: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the part of the area between two lines that lies inside.

    Parameters
    ----------
    x, low, high : (n,) array
        Places along the axes, 0 to 1 being inside [-].

    Returns
    -------
    (m,) array, (m,) array, (m,) array
        Places, not a number where nothing of the area is inside.
    """
    x, low, high = _cut((x, low, high), (0, 1, 2))
    outside = _outside(x) | (high < -ROUNDING) | (low > 1.0 + ROUNDING)
    return (
        _without(x, outside),
        _without(np.clip(low, 0.0, 1.0), outside),
        _without(np.clip(high, 0.0, 1.0), outside),
    )


def _outside(places: FloatArray) -> NDArray[np.bool_]:
    return np.asarray((places < -ROUNDING) | (places > 1.0 + ROUNDING), dtype=bool)


def _without(places: FloatArray, outside: NDArray[np.bool_]) -> FloatArray:
    return np.where(outside, np.nan, places)


def _cut(rows: Sequence[FloatArray], along: Sequence[int]) -> list[FloatArray]:
    """Return rows with a point more wherever one of some rows crosses an end of its axis."""
    cut = [np.asarray(row, dtype=float) for row in rows]
    for row in along:
        for end in (0.0, 1.0):
            off = cut[row] - end
            with np.errstate(invalid="ignore"):
                crossing = np.flatnonzero(np.sign(off[:-1]) * np.sign(off[1:]) < 0.0)
            share = off[crossing] / (off[crossing] - off[crossing + 1])
            places = [
                one[crossing] + share * (one[crossing + 1] - one[crossing]) for one in cut
            ]
            places[row] = np.full(crossing.size, end)
            cut = [
                np.insert(one, crossing + 1, place)
                for one, place in zip(cut, places, strict=True)
            ]
    return cut


def plot(
    content: Plot,
    *,
    title: str,
    width: int = 560,
    height: int = 230,
    keys: bool = True,
    most: int = 2000,
) -> Markup:
    """Return a figure: axes with ticks, lines, marks and a legend of its own.

    Without `keys` there is no legend, as where figures above each other share one; `most` is
    how many points of a line are drawn, the extremes among them. Beside the drawing stand its
    numbers for the script, which draws it anew for whoever looks closer. `title` is for who
    cannot see it.
    """
    x_axis, y_axis, names = content.x, content.y, content.names
    bottom = _BOTTOM if x_axis.label else _BARE
    box = Box(_LEFT, _TOP, width - _LEFT - _RIGHT, height - _TOP - bottom)
    numbers = Markup("") if names else figure.payload(content)
    parts = [
        Markup('<svg viewBox="0 0 {} {}" class="plot" role="img"><title>{}</title>').format(
            width * UNIT, height * UNIT, title
        ),
        *(_span(span, x_axis, box) for span in content.spans),
        grid(x_axis, y_axis, box, height, names),
        Markup("") if content.image is None else axes.picture(content.image, box),
        *(
            _drawn(unwrapped(_thinned(item, most), y_axis), x_axis, y_axis, box)
            for item in content.items
        ),
        *(_mark(mark, x_axis, box) for mark in content.marks),
        _spread_bar(content.spread, y_axis, box),
        Markup("</svg>"),
    ]
    drawn = Markup('<div class="draw">{}{}</div>').format(Markup("").join(parts), numbers)
    if content.image is not None:
        return drawn + axes.scale(content.image)
    return drawn + (legend(content.items) if keys else Markup(""))


def legend(items: Sequence[Curve | Filling]) -> Markup:
    """Return the names of the lines with a sample of each."""
    return Markup('<p class="legend">{}</p>').format(
        Markup(" ").join(
            Markup('<span><svg class="key">{}</svg> {}</span>').format(_key(item), item.label)
            for item in items
            if item.label
        )
    )


def _key(item: Curve | Filling) -> Markup:
    style = item.style % len(COLOURS)
    if isinstance(item, Filling):
        return Markup('<path class="f{}" d="M8 6h80v28h-80z"/>').format(style)
    if item.points:
        return Markup('<path class="p{}" d="M48 20{}"/>').format(style, marker(style))
    if item.dots:
        return Markup('<path class="d{}" d="M24 20h0M48 20h0M72 20h0"/>').format(style)
    return Markup('<path class="c{}{}" d="M0 20h96"/>').format(style, _weight(item))


def _weight(item: Curve) -> str:
    """Return the class of a line that is thinner or broader than others."""
    return " thin" if item.thin else " wide" if item.wide else ""


def marker(style: int) -> str:
    """Return the path of a mark, from its middle."""
    return MARKERS[style % len(MARKERS)]


def sparkline(x: FloatArray, y: FloatArray, x_axis: Axis, y_axis: Axis) -> Markup:
    """Return a thumbnail: one line without axes. `x` and `y` are in the units of their axes."""
    width, height = 120, 28
    box = Box(0, 1, width, height - 2)
    path = _path(*line_inside(x_axis.share(x), y_axis.share(y)), box)
    return Markup('<svg viewBox="0 0 {} {}" class="spark"><path d="{}"/></svg>').format(
        width * UNIT, height * UNIT, path
    )


def _steps(share_x: FloatArray, share_y: FloatArray, box: Box) -> tuple[FloatArray, FloatArray]:
    """Return points in steps of the drawing; rows that fall together are merged."""
    x = (box.left + share_x * box.width) * UNIT
    y = (box.top + (1.0 - share_y) * box.height) * UNIT
    return np.rint(x), np.rint(y)


def _path(share_x: FloatArray, share_y: FloatArray, box: Box) -> str:
    """Return the shortest path through points, in relative whole steps."""
    pieces = []
    for start, stop in _unbroken(np.isfinite(share_x) & np.isfinite(share_y)):
        x, y = straightened(*_steps(share_x[start:stop], share_y[start:stop], box))
        pieces.append(f"M{x[0]:.0f} {y[0]:.0f}")
        moves = zip(
            np.diff(x).astype(int).tolist(), np.diff(y).astype(int).tolist(), strict=True
        )
        body = "".join(f" {a}{b}" if b < 0 else f" {a} {b}" for a, b in moves if a or b)
        pieces.append(f"l{body.lstrip()}" if body else "h0")
    return "".join(pieces).replace(" -", "-")


def _dots(share_x: FloatArray, share_y: FloatArray, box: Box) -> str:
    """Return a dot at each point between the axes, in relative whole steps."""
    good = points_inside(share_x, share_y)
    if not good.any():
        return ""
    x, y = _steps(share_x[good], share_y[good], box)
    places = np.unique(np.array([x, y], dtype=int).T, axis=0)
    moves = np.diff(places, axis=0).tolist()
    body = "".join(f"m{a} {b}h0" for a, b in moves).replace(" -", "-")
    return f"M{places[0, 0]} {places[0, 1]}h0{body}"


def _unbroken(good: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]) -> list[tuple[int, int]]:
    """Return where runs of True start and stop."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], good, [False])).astype(int)))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


def _thinned(item: Curve | Filling, most: int) -> Curve | Filling:
    """Return a line with its extremes alone where it has more points than there is room."""
    if isinstance(item, Filling):
        return _coarser(item, max(1, -(-2 * item.x.size // most)))
    if item.points or item.dots or item.x.size <= most:
        return item
    x, y = thinned(item.x, item.y, most)
    return replace(item, x=x, y=y)


def _coarser(item: Filling, together: int) -> Filling:
    """Return an area of which so many neighbours are one, as far as they reach."""
    starts = np.arange(0, item.x.size, together)
    if not item.x.size or together == 1:
        return item
    counts = np.diff(np.append(starts, item.x.size))
    return replace(
        item,
        x=np.add.reduceat(item.x, starts) / counts,
        low=np.minimum.reduceat(item.low, starts),
        high=np.maximum.reduceat(item.high, starts),
    )


def _drawn(item: Curve | Filling, x_axis: Axis, y_axis: Axis, box: Box) -> Markup:
    x = x_axis.share(item.x)
    style = item.style % len(COLOURS)
    if isinstance(item, Filling):
        area = _area(x, y_axis.share(item.low), y_axis.share(item.high), box)
        return Markup('<path class="f{}" d="{}"/>').format(style, area)
    y = y_axis.share(item.y)
    if item.dots:
        return Markup('<path class="d{}" d="{}"/>').format(style, _dots(x, y, box))
    if not item.points:
        line = _path(*line_inside(x, y), box)
        return Markup('<path class="c{}{}" d="{}"/>').format(style, _weight(item), line)
    bars = _bars(item, x_axis, y_axis, box)
    hollow = np.zeros(x.size, dtype=bool)
    hollow[: len(item.hollow)] = item.hollow
    drawn = points_inside(x, y)
    solid, empty = (
        "".join(
            f"M{a:.0f} {b:.0f}{marker(style)}"
            for a, b in zip(*_steps(x[which], y[which], box), strict=True)
        )
        for which in (drawn & ~hollow, drawn & hollow)
    )
    return bars + Markup('<path class="p{0}" d="{1}"/><path class="h{0}" d="{2}"/>').format(
        style, solid, empty
    )


def _bars(item: Curve, x_axis: Axis, y_axis: Axis, box: Box) -> Markup:
    """Return the error bars of the marks of a curve."""
    if not len(item.bars):
        return Markup("")
    x, inside = x_axis.share(item.x), points_inside(x_axis.share(item.x), y_axis.share(item.y))
    half = np.asarray(item.bars, dtype=float)
    ends = (np.clip(y_axis.share(item.y + side * half), 0.0, 1.0) for side in (-1.0, 1.0))
    (left, low), (_, high) = (_steps(x[inside], end[inside], box) for end in ends)
    path = "".join(
        f"M{a - CAP:.0f} {b:.0f}h{2 * CAP}m{-CAP} 0V{c:.0f}m{-CAP} 0h{2 * CAP}"
        for a, b, c in zip(left, low, high, strict=True)
    )
    return Markup('<path class="bar c{}" d="{}"/>').format(item.style % len(COLOURS), path)


def _area(share_x: FloatArray, low: FloatArray, high: FloatArray, box: Box) -> str:
    """Return the path around the area between two lines, there and back."""
    x, low, high = area_inside(share_x, low, high)
    pieces = []
    for start, stop in _unbroken(np.isfinite(x) & np.isfinite(low) & np.isfinite(high)):
        part = slice(start, stop)
        there = np.concatenate((x[part], x[part][::-1]))
        back = np.concatenate((high[part], low[part][::-1]))
        pieces.append(f"{_path(there, back, box)}z")
    return "".join(pieces)


def _span(span: Span, axis: Axis, box: Box) -> Markup:
    low, high = np.clip(axis.share(np.array([span.low, span.high])), 0.0, 1.0)
    return Markup('<rect class="span" x="{:.0f}" y="{}" width="{:.0f}" height="{}"/>').format(
        (box.left + low * box.width) * UNIT,
        box.top * UNIT,
        (high - low) * box.width * UNIT,
        box.height * UNIT,
    )


def _spread_bar(spread: tuple[float, float] | None, axis: Axis, box: Box) -> Markup:
    """Return a bar as tall as the 95 % bounds of every value of a logarithmic axis."""
    if spread is None or not axis.logarithmic:
        return Markup("")
    tall = math.log10(spread[1] / spread[0]) / math.log10(axis.high / axis.low) * box.height
    x, y = (box.left + box.width - 10) * UNIT, (box.top + 8) * UNIT
    return Markup(
        '<path class="spread" d="M{0} {1}h24m-12 0v{2:.0f}m-12 0h24"/>'
        '<text class="end" x="{3}" y="{4:.0f}">95 %</text>'
    ).format(x - 12, y, tall * UNIT, x - 24, y + max(tall * UNIT / 2 + 14, 30))


def _mark(mark: Mark, axis: Axis, box: Box) -> Markup:
    share = axis.share(np.array([mark.x]))
    if not points_inside(share, share).all():
        return Markup("")
    x = (box.left + float(share[0]) * box.width) * UNIT
    side = "end" if x > (box.left + 0.8 * box.width) * UNIT else "start"
    return Markup(
        '<path class="mark" d="M{:.0f} {}v{}"/>'
        '<text class="marked {}" x="{:.0f}" y="{}">{}</text>'
    ).format(
        x,
        box.top * UNIT,
        box.height * UNIT,
        side,
        x + (-16 if side == "end" else 16),
        (box.top + 11) * UNIT,
        mark.label,
    )
