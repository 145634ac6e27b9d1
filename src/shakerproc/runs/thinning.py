"""Fewer points of a curve that look the same."""

import numpy as np

from shakerproc.data import FloatArray


def thinned(x: FloatArray, y: FloatArray, most: int) -> tuple[FloatArray, FloatArray]:
    """Return a curve with at most so many points, in order.

    Of a function of `x` the extremes of each slice; of a line that goes back and forth, as a
    circle does, points at equal distances along it. A line that is broken stays so: of the
    values that are none, one in each slice or gap is kept.

    Parameters
    ----------
    x, y : (n,) arrays
        Points [any unit]; `y` not a number breaks the line.
    most : int
        How many are kept, beside the gaps of a line that goes back and forth.
    """
    if x.size <= most:
        return x, y
    steps = np.diff(x[np.isfinite(x)])
    loops = np.any(steps > 0.0) and np.any(steps < 0.0)
    kept = _along(x, y, most) if loops else _extremes(y, most)
    return x[kept], y[kept]


def _extremes(y: FloatArray, most: int) -> list[int]:
    finite = np.isfinite(y)
    each = 2 if finite.all() else 3
    kept: list[int] = []
    for part in np.array_split(np.arange(y.size), most // each):
        good, gaps = part[finite[part]], part[~finite[part]]
        chosen = {int(gap) for gap in gaps[:1]}
        if good.size:
            chosen |= {int(good[np.argmin(y[good])]), int(good[np.argmax(y[good])])}
        kept.extend(sorted(chosen))
    return kept


def _along(x: FloatArray, y: FloatArray, most: int) -> list[int]:
    finite = np.isfinite(x) & np.isfinite(y)
    places = np.flatnonzero(finite)
    if not places.size:
        return [0]
    wide, high = (float(np.ptp(row[places])) or 1.0 for row in (x, y))
    way = np.hypot(np.diff(x[places]) / wide, np.diff(y[places]) / high)
    length = np.concatenate([[0.0], np.cumsum(way)])
    wanted = np.searchsorted(length, np.linspace(0.0, length[-1], most))
    gaps = np.flatnonzero(~finite & np.concatenate([[True], finite[:-1]]))
    return sorted({*places[np.minimum(wanted, places.size - 1)].tolist(), *gaps.tolist()})
