"""Lines and areas clipped to the axes: cut where they cross their ends."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray

ROUNDING: Final = 1e-9
"""How far beyond the end of an axis a value still lies on it, as a share of the axis [-]."""


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
