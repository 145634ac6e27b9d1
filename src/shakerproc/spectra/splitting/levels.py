"""Where the level of a vibration changes, and whether it stays the same between changes."""

from itertools import pairwise
from typing import Final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import FloatArray

MOST: Final = 2000
"""Stretches at most among which changes are sought."""

DEAR: Final = 3.0
"""What a change costs, over the logarithm of the number of stretches, for every number that it
adds [-]: on noise the best change of a channel gains less than 2."""

GROUPS: Final = 20
"""Mean squares that the test for a trend takes from a part [-]."""

CHANCE: Final = 0.01
"""Share of steady parts that are said to have a trend [-]."""


def changes(level: FloatArray, step: float) -> list[int]:
    r"""Return where the level changes: the first stretch of every part, and the end.

    Optimal partitioning: of all ways to cut the stretches the one with the least

    .. math:: \sum_{parts} \sum_{c,k} (x_{ck} - \bar x_c)^2 / \sigma_c^2 + \text{costs}

    where the scatter comes from the differences of neighbours. Parts whose levels differ by
    less than `step` are one.

    Parameters
    ----------
    level : (n_channels, n_stretches) array
        Levels [dB].
    step : float
        Difference between two parts at least, in one channel [dB].

    Returns
    -------
    list of int
        From 0 to the number of stretches.

    References
    ----------
    .. [1] B. Jackson et al., "An algorithm for optimal partitioning of data on an interval",
       IEEE Signal Processing Letters 12, 105-108, 2005.
    """
    n = level.shape[1]
    if n < 2:
        return [0, n]
    scaled = level / _scatter(level)[:, np.newaxis]
    return _merged(level, _partitioned(scaled), step)


def _scatter(level: FloatArray) -> FloatArray:
    """Return the standard deviation of each channel beside changes, (n_channels,) [dB]."""
    difference = np.abs(np.diff(level, axis=1))
    usual = np.median(difference, axis=1) / (0.6745 * np.sqrt(2.0))
    return np.asarray(np.maximum(usual, 1e-3), dtype=np.float64)


def _partitioned(scaled: FloatArray) -> list[int]:
    """Return the ends of the parts that together cost least."""
    channels, n = scaled.shape
    sums = np.concatenate([np.zeros((channels, 1)), np.cumsum(scaled, axis=1)], axis=1)
    squares = np.concatenate([[0.0], np.cumsum(np.sum(scaled**2, axis=0))])
    price = DEAR * (channels + 1) * np.log(n)
    best, before = np.full(n + 1, -price), np.zeros(n + 1, dtype=np.int64)
    for end in range(1, n + 1):
        starts = np.arange(end)
        within = np.sum((sums[:, end : end + 1] - sums[:, :end]) ** 2, axis=0)
        cost = best[:end] + squares[end] - squares[:end] - within / (end - starts) + price
        before[end] = int(np.argmin(cost))
        best[end] = cost[before[end]]
    ends = [n]
    while ends[-1] > 0:
        ends.append(int(before[ends[-1]]))
    return ends[::-1]


def _merged(level: FloatArray, ends: list[int], step: float) -> list[int]:
    """Return the ends without those between parts that hardly differ, the closest first."""
    found = list(ends)
    while len(found) > 2:
        mean = [level[:, a:b].mean(axis=1) for a, b in pairwise(found)]
        apart = [np.abs(b - a).max() for a, b in pairwise(mean)]
        least = int(np.argmin(apart))
        if apart[least] >= step:
            break
        del found[least + 1]
    return found


def arrangements(values: FloatArray) -> int:
    """Return the number of reverse arrangements: pairs of which the earlier is larger.

    Parameters
    ----------
    values : (n,) array
        One after the other [any unit].
    """
    later = np.triu(values[:, np.newaxis] > values[np.newaxis, :], k=1)
    return int(np.count_nonzero(later))


def has_trend(mean_square: FloatArray, known: NDArray[np.bool_]) -> bool:
    """Return whether the level of a part rises or falls by more than chance.

    By reverse arrangements of `GROUPS` mean squares, from the front and from the back, so that
    equal ones speak for neither; a part with fewer cells has none.

    Parameters
    ----------
    mean_square : (n_channels, n_cells) array
        Of the part [unit²].
    known : (n_cells,) array
        Which cells count.

    References
    ----------
    .. [1] J. S. Bendat and A. G. Piersol, Random Data, 4th ed., Wiley, 2010, section 4.5.2 and
       table A.6.
    """
    kept = mean_square[:, known]
    if kept.shape[1] < GROUPS:
        return False
    edges = np.arange(GROUPS) * kept.shape[1] // GROUPS
    sizes = np.diff(np.append(edges, kept.shape[1]))
    means = np.add.reduceat(kept, edges, axis=1) / sizes
    spread = np.sqrt(GROUPS * (2 * GROUPS + 5) * (GROUPS - 1) / 72.0)
    far = float(scipy.special.ndtri(1.0 - 0.5 * CHANCE / len(means))) * spread
    return any(abs(arrangements(row) - arrangements(row[::-1])) > 2.0 * far for row in means)
