"""A figure as data, which `to_svg` and `to_png` draw; its numbers for the script of a page."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np
from markupsafe import Markup

from shakerproc.data import FloatArray
from shakerproc.report.figures.style import COLOURS

HALF_TURN: Final = 180.0
"""Degrees."""


@dataclass(frozen=True, slots=True)
class Axis:
    """One axis of a plot.

    Attributes
    ----------
    label : str
        Quantity and unit.
    low, high : float
        Ends, in the unit of the label.
    logarithmic : bool
        Whether steps are powers of ten.
    degrees : bool
        Whether steps are right angles.
    """

    label: str
    low: float
    high: float
    logarithmic: bool = False
    degrees: bool = False

    def share(self, values: FloatArray) -> FloatArray:
        """Return where values lie on the axis, from 0 at the low end to 1 at the high end.

        What lies beyond an end is below 0 or above 1; what has no place on a logarithmic axis
        is not a number.

        `values` are in the unit of the axis.
        """
        low, high = self.low, self.high
        if self.logarithmic:
            values = np.log10(np.where(values > 0.0, values, np.nan))
            low, high = math.log10(low), math.log10(high)
        return np.asarray((values - low) / (high - low), dtype=float)


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """One line of a plot.

    Attributes
    ----------
    label : str
        Name in the legend.
    x, y : (n,) array
        Points, in the units of the axes; NaN breaks the line.
    style : int
        Which colour and dash; the same channel has the same one everywhere.
    points : bool
        Whether to draw a mark at each point, and the line thin.
    hollow : sequence of bool
        Which of the marks are hollow.
    bars : sequence of float
        How far an error bar reaches from each of the marks, up and down, in the unit of y.
    thin : bool
        Whether the line is a limit and no result.
    wide : bool
        Whether the line is broad, so that others can be seen to lie on it.
    dots : bool
        Whether each point is a dot and there is no line.
    spread : (float, float), optional
        The 95 % bounds of every value, as multiples of it.
    """

    label: str
    x: FloatArray
    y: FloatArray
    style: int
    points: bool = False
    hollow: Sequence[bool] = ()
    bars: Sequence[float] = ()
    thin: bool = False
    wide: bool = False
    dots: bool = False
    spread: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Filling:
    """An area between two lines, such as the envelope of a time series."""

    label: str
    x: FloatArray
    low: FloatArray
    high: FloatArray
    style: int


def unwrapped(item: Curve | Filling, y_axis: Axis) -> Curve | Filling:
    """Return a line of angles, broken where it goes on at the other end of the circle.

    A step of more than half a turn is such a jump: its line would be no measurement.
    """
    return item if isinstance(item, Filling) else unwrapped_line(item, y_axis)


def unwrapped_line(item: Curve, y_axis: Axis) -> Curve:
    """Return a curve as `unwrapped` has it."""
    if not y_axis.degrees or item.points or item.dots:
        return item
    with np.errstate(invalid="ignore"):
        jumps = np.flatnonzero(np.abs(np.diff(item.y)) > HALF_TURN) + 1
    return replace(
        item, x=np.insert(item.x, jumps, item.x[jumps]), y=np.insert(item.y, jumps, np.nan)
    )


@dataclass(frozen=True, slots=True)
class Mark:
    """A vertical line with a word to it, such as a peak or the end of the crop."""

    x: float
    label: str


@dataclass(frozen=True, slots=True)
class Span:
    """A part of the horizontal axis that is shaded because it does not count."""

    low: float
    high: float


@dataclass(frozen=True, slots=True, eq=False)
class Image:
    """Values over a plane, in colours from little to much.

    Attributes
    ----------
    x, y : (n,), (m,) arrays
        Middles of columns and rows, in the units of the axes.
    values : (m, n) array
        What is shown.
    low, high : float
        Values of the first and the last colour.
    label : str
        Quantity and unit of the values.
    """

    x: FloatArray
    y: FloatArray
    values: FloatArray
    low: float
    high: float
    label: str


@dataclass(frozen=True, slots=True, eq=False)
class Plot:
    """Two axes and the curves between them.

    Attributes
    ----------
    items : sequence of Curve or Filling
        Lines and areas, in the order in which they are drawn and named.
    x, y : Axis
        The axes.
    marks : sequence of Mark
        Vertical lines with a word.
    spans : sequence of Span
        What is shaded.
    names : mapping
        What to write along the horizontal axis where its values are categories.
    title, caption : str
        What it is, and what to look for.
    kind : str
        Of the curves of a run, so that those of several can be overlaid.
    channel : str
        Whose it is alone, where others of the same stand above or below.
    image : Image, optional
        What lies behind.
    height : float
        Of the axes in a file [in].
    """

    items: Sequence[Curve | Filling]
    x: Axis
    y: Axis
    marks: Sequence[Mark] = ()
    spans: Sequence[Span] = ()
    names: Mapping[float, str] = field(default_factory=dict)
    title: str = ""
    caption: str = ""
    kind: str = ""
    channel: str = ""
    image: Image | None = None
    height: float = 2.4

    @property
    def spread(self) -> tuple[float, float] | None:
        """The 95 % bounds that its curves have in common, as multiples of a value."""
        spreads = {
            item.spread for item in self.items if isinstance(item, Curve) and item.spread
        }
        return spreads.pop() if len(spreads) == 1 else None


@dataclass(frozen=True, slots=True, eq=False)
class Figure:
    """Plots above each other.

    Attributes
    ----------
    name : str
        Of its file.
    plots : sequence of Plot
        From the top.
    note : str
        A line below the title of a file, around which no page explains it.
    together : bool
        Whether the page, too, has its plots above each other, under the title of the first.
    """

    name: str
    plots: Sequence[Plot]
    note: str = ""
    together: bool = False


_LETTERS: Final = np.frombuffer(
    b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_", dtype=np.uint8
)
"""Digits to base 64."""

PLACES: Final = (3, 2)
"""Digits of a value along x and y: steps of 4 millionths and of a quarter per thousand of the
range of the figure's values; where the axis is logarithmic, of the range of the logarithms."""

EVEN: Final = 2e-2
"""How far places may lie off even steps to be told as such, in steps [-]."""


def payload(plot: Plot) -> Markup:
    """Return an element without content whose value holds the numbers of a figure.

    Nothing, where a line goes back and forth along x.
    """
    x_axis, y_axis, marks, spans = plot.x, plot.y, plot.marks, plot.spans
    items = [unwrapped(item, y_axis) for item in plot.items]
    drawn = [one for item in items if (one := _placed(item, x_axis)).x.size]
    if any(_loops(item) for item in drawn):
        return Markup("")  # the script draws functions of x
    x_range = _range([item.x for item in drawn], logarithmic=x_axis.logarithmic)
    y_range = _range(
        [rows for item in drawn for rows in _rows(item)], logarithmic=y_axis.logarithmic
    )
    known: dict[bytes, int] = {}
    lines = []
    for i, item in enumerate(drawn):
        first = known.setdefault(item.x.tobytes(), i)
        places = first if first < i else _places(item.x, x_axis, x_range)
        values: list[Any] = [_text(row, y_axis, y_range, PLACES[1]) for row in _rows(item)]
        if isinstance(item, Curve) and any(item.hollow):
            values.append([j for j, empty in enumerate(item.hollow) if empty])
        if isinstance(item, Curve) and len(item.bars):
            values += [[]] * (2 - len(values)) + [[_rounded(bar) for bar in item.bars]]
        lines.append([item.label, item.style % len(COLOURS), _kind(item), places, *values])
    content: dict[str, Any] = {
        "x": [*_axis(x_axis), *_short(x_range)],
        "y": [*_axis(y_axis), *_short(y_range)],
        "c": lines,
    }
    if marks:
        content["m"] = [[_rounded(mark.x), mark.label] for mark in marks]
    if spans:
        content["s"] = [[_rounded(span.low), _rounded(span.high)] for span in spans]
    if plot.image is not None:
        content["i"] = [_rounded(plot.image.low), _rounded(plot.image.high), plot.image.label]
    if plot.spread and y_axis.logarithmic:
        content["e"] = _rounded(plot.spread[1] / plot.spread[0])
    text = json.dumps(content, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    return Markup("<data value='{}'></data>").format(quoted(text))


def _placed(item: Curve | Filling, axis: Axis) -> Curve | Filling:
    """Return an item of which every point has a place along x; where one has none, a break."""
    known = np.isfinite(axis.share(item.x))
    if known.all():
        return item
    at = np.maximum.accumulate(np.where(known, np.arange(item.x.size), -1))
    begun = at >= 0
    x, known = item.x[at[begun]], known[begun]
    if isinstance(item, Filling):
        low, high = (np.where(known, row[begun], np.nan) for row in (item.low, item.high))
        return replace(item, x=x, low=low, high=high)
    hollow, bars = (
        tuple(np.asarray(row)[begun[: len(row)]]) for row in (item.hollow, item.bars)
    )
    y = np.where(known, item.y[begun], np.nan)
    return replace(item, x=x, y=y, hollow=hollow, bars=bars)


def _loops(item: Curve | Filling) -> bool:
    """Return whether a line goes back and forth."""
    if isinstance(item, Curve) and (item.points or item.dots):
        return False
    steps = np.diff(item.x)
    return bool(np.any(steps > 0.0) and np.any(steps < 0.0))


def quoted(text: str) -> Markup:
    """Return text for an attribute in single quotes; JSON is full of double ones."""
    safe = text.replace("&", "&amp;").replace("'", "&#39;")
    return Markup(safe.replace("<", "&lt;").replace(">", "&gt;"))  # noqa: S704 - escaped here


def _axis(axis: Axis) -> list[Any]:
    steps = 1 if axis.logarithmic else 2 if axis.degrees else 0
    return [axis.label, _rounded(axis.low), _rounded(axis.high), steps]


def _rounded(value: float) -> float:
    return float(f"{value:.6g}")


def _short(limits: tuple[float, float]) -> list[float]:
    """Return limits rounded as in the text, from which the page decodes them."""
    return [_rounded(value) for value in limits]


def _rows(item: Curve | Filling) -> list[FloatArray]:
    return [item.high, item.low] if isinstance(item, Filling) else [item.y]


def _kind(item: Curve | Filling) -> int:
    """Return 0 for a line, 1 thin, 2 broad, 3 marks, 4 dots, 5 an area."""
    if isinstance(item, Filling):
        return 5
    flags = (item.thin, item.wide, item.points, item.dots)
    return next((i for i, flag in enumerate(flags, 1) if flag), 0)


def _range(rows: Sequence[FloatArray], *, logarithmic: bool) -> tuple[float, float]:
    """Return the smallest and largest value, made to be told apart and rounded outwards."""
    values = np.concatenate([*rows, np.zeros(0)])
    values = values[np.isfinite(values) & ((values > 0.0) | (not logarithmic))]
    if not values.size:
        return 1.0, 2.0
    low, high = float(values.min()), float(values.max())
    if logarithmic:
        return _rounded(low * (1.0 - 1e-5)), _rounded(high * (1.0 + 2e-5))
    margin = 1e-5 * max(high - low, abs(high), abs(low), 1e-12)
    return _rounded(low - margin), _rounded(high + margin)


def _places(x: FloatArray, axis: Axis, limits: tuple[float, float]) -> str | list[float]:
    """Return where points lie: first and last and their number where they are even."""
    if x.size > 2 and not axis.logarithmic and np.isfinite(x).all():
        even = np.linspace(x[0], x[-1], x.size)
        step = abs(x[-1] - x[0]) / (x.size - 1)
        if step > 0.0 and np.max(np.abs(x - even)) < EVEN * step:
            return [_rounded(float(x[0])), _rounded(float(x[-1])), x.size]
    return _text(x, axis, limits, PLACES[0])


def _text(values: FloatArray, axis: Axis, limits: tuple[float, float], places: int) -> str:
    """Return values as letters; the largest number there is says that there is none."""
    low, high = limits
    top = 64**places - 1
    with np.errstate(divide="ignore", invalid="ignore"):
        if axis.logarithmic:
            values, low, high = np.log(np.maximum(values, 0.0)), np.log(low), np.log(high)
        share = (values - low) / (high - low)
    known = np.isfinite(share)
    steps = np.full(values.size, top, dtype=np.int64)
    steps[known] = np.rint(np.clip(share[known], 0.0, 1.0) * (top - 1)).astype(np.int64)
    digits = np.array([steps >> (6 * place) & 63 for place in reversed(range(places))])
    return str(_LETTERS[digits.T.ravel()].tobytes(), "ascii")
