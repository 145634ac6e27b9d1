"""What can be drawn: axes, lines, areas, marks, spans; how is told elsewhere."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shakerproc.data import FloatArray


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
    thin : bool
        Whether the line is a limit and no result.
    wide : bool
        Whether the line is broad, so that others can be seen to lie on it.
    dots : bool
        Whether each point is a dot and there is no line.
    """

    label: str
    x: FloatArray
    y: FloatArray
    style: int
    points: bool = False
    hollow: Sequence[bool] = ()
    thin: bool = False
    wide: bool = False
    dots: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Filling:
    """An area between two lines, such as the envelope of a time series."""

    label: str
    x: FloatArray
    low: FloatArray
    high: FloatArray
    style: int


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
