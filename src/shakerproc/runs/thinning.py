"""Fewer points of a curve that look the same."""

from typing import Final

import numpy as np

from shakerproc.data import FloatArray

OFF: Final = 2.0
"""How far off a straight line a point may lie that is left out [steps of a drawing]."""


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


def straightened(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return a line without the points that lie within `OFF` of a straight line along x or y.

    Each point that is kept begins a stretch, which lasts as long as one straight line from it
    leaves no point further off than that, along y; where x goes back or stands, it ends.

    Parameters
    ----------
    x, y : (n,) arrays
        Finite points in steps of a drawing [-].
    """
    across, up = x.tolist(), y.tolist()
    kept, anchor = [0], 0
    least, most = -np.inf, np.inf
    for i in range(1, len(across)):
        run = across[i] - across[anchor]
        slope = (up[i] - up[anchor]) / run if run > 0.0 else np.nan
        if i > anchor + 1 and not (least <= slope <= most and across[i] > across[i - 1]):
            anchor = i - 1
            kept.append(anchor)
            least, most = -np.inf, np.inf
            run = across[i] - across[anchor]
        if run > 0.0:
            least = max(least, (up[i] - up[anchor] - OFF) / run)
            most = min(most, (up[i] - up[anchor] + OFF) / run)
        else:
            least, most = np.inf, -np.inf  # upright, or back: the next point begins anew
    if len(across) > 1:
        kept.append(len(across) - 1)
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
