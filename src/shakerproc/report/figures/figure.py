"""A figure as data: `to_svg` draws it for the page, `to_png` for files."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from shakerproc.data import FloatArray

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
    """Two axes and what is drawn between them.

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
        found = {item.spread for item in self.items if isinstance(item, Curve) and item.spread}
        return found.pop() if len(found) == 1 else None


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
