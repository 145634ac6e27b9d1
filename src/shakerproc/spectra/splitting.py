"""A long record split into shocks and parts of steady vibration."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, Literal, TypeAlias, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import FloatArray

MOST_STRETCHES: Final = 2000
"""Stretches at most among which changes are sought."""

COST_OF_CHANGE: Final = 3.0
"""What a change costs, over the logarithm of the number of stretches, for every number that it
adds [-]: on noise the best change of a channel gains less than 2."""

TREND_GROUPS: Final = 20
"""Mean squares that the test for a trend takes from a part [-]."""

FALSE_TRENDS: Final = 0.01
"""Share of steady parts that are said to have a trend [-]."""

BACKGROUND_TIME: Final = 10.0
"""Time over which the median tells the vibration around a cell [s]: shocks fill less than half
of it, and a step of the level moves it at once."""

BACKGROUND_SIDES: Final = 0.5
"""Time to either side whose vibration counts as well [s]: the median of a cell beside a step of
the level is that of the quietest cells of the louder side.
"""

SHOCK_END: Final = 2.0
"""Rms of a cell, over the vibration around it, down to which a shock has not ended yet [-]."""

LEAST_QUIET: Final = 0.1
"""Quiet that two shocks have between them at least [s]; with less they are one."""

LEAST_PEAK: Final = 1e-3
"""Share of the largest peak of a channel, 60 dB below it, that is no shock in any case [-]."""

CELL: Final = 0.02
"""Length of a cell [s]."""

STRETCH: Final = 0.5
"""Length of the stretches among which changes of the level are sought, at least [s]."""

Kind: TypeAlias = Literal["shock", "stationary", "not stationary", "transient"]


@final
@dataclass(frozen=True, slots=True, eq=False)
class Cells:
    """Statistics of a record in cells of equal length; the last few samples may make none.

    Attributes
    ----------
    length : int
        Samples of a cell.
    sample_rate : float
        Samples per second [Hz].
    mean_square : (n_channels, n_cells) array
        Of the samples of a cell [unit²].
    peak : (n_channels, n_cells) array
        Largest magnitude in a cell [unit].
    """

    length: int
    sample_rate: float
    mean_square: FloatArray
    peak: FloatArray

    @property
    def seconds(self) -> float:
        """Length of a cell [s]."""
        return self.length / self.sample_rate

    @property
    def count(self) -> int:
        """Number of cells."""
        return int(self.peak.shape[1])


def cells_of(blocks: Iterable[FloatArray], sample_rate: float, length: int) -> Cells:
    """Return the cells of a record.

    Parameters
    ----------
    blocks : iterable of (n_channels, n) arrays
        The samples in order, without their means, in blocks of any size [unit].
    sample_rate : float
        Samples per second [Hz].
    length : int
        Samples of a cell.

    Returns
    -------
    Cells
        Of whole cells only.
    """
    squares, peaks = [], []
    rest: FloatArray | None = None
    for block in blocks:
        joined = block if rest is None else np.concatenate([rest, block], axis=1)
        whole = joined.shape[1] // length * length
        cut = joined[:, :whole].reshape(joined.shape[0], -1, length)
        squares.append(np.einsum("ijk,ijk->ij", cut, cut) / length)
        peaks.append(np.maximum(cut.max(axis=2), -cut.min(axis=2)) if whole else squares[-1])
        rest = joined[:, whole:].copy()
    return Cells(length, sample_rate, np.concatenate(squares, 1), np.concatenate(peaks, 1))


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
    # 0.6745 is the median of |x| of a standard normal x; a few changes do not move a median
    usual = np.median(difference, axis=1) / (0.6745 * np.sqrt(2.0))
    return np.asarray(np.maximum(usual, 1e-3), dtype=np.float64)


def _partitioned(scaled: FloatArray) -> list[int]:
    """Return the ends of the parts that together cost least."""
    channels, n = scaled.shape
    sums = np.concatenate([np.zeros((channels, 1)), np.cumsum(scaled, axis=1)], axis=1)
    squares = np.concatenate([[0.0], np.cumsum(np.sum(scaled**2, axis=0))])
    price = COST_OF_CHANGE * (channels + 1) * np.log(n)
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
    numbers = list(ends)
    while len(numbers) > 2:
        mean = [level[:, a:b].mean(axis=1) for a, b in pairwise(numbers)]
        distances = [np.abs(b - a).max() for a, b in pairwise(mean)]
        least = int(np.argmin(distances))
        if distances[least] >= step:
            break
        del numbers[least + 1]
    return numbers


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

    By reverse arrangements of `TREND_GROUPS` mean squares, from the front and from the back, so
    that equal ones speak for neither; a part with fewer cells has none.

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
    if kept.shape[1] < TREND_GROUPS:
        return False
    edges = np.arange(TREND_GROUPS) * kept.shape[1] // TREND_GROUPS
    sizes = np.diff(np.append(edges, kept.shape[1]))
    means = np.add.reduceat(kept, edges, axis=1) / sizes
    spread = np.sqrt(TREND_GROUPS * (2 * TREND_GROUPS + 5) * (TREND_GROUPS - 1) / 72.0)
    far = float(scipy.special.ndtri(1.0 - 0.5 * FALSE_TRENDS / len(means))) * spread
    return any(abs(arrangements(row) - arrangements(row[::-1])) > 2.0 * far for row in means)


@final
@dataclass(frozen=True, slots=True)
class ShockRule:
    """Criterion of a shock.

    Attributes
    ----------
    crest : float
        Peak of a shock at least, over the rms of the vibration around it [-].
    least : float
        Peak of a shock at least [unit].
    longest : float
        Duration of a shock at most [s].
    """

    crest: float
    least: float
    longest: float


def background(cells: Cells) -> FloatArray:
    """Return the rms of the vibration around each cell, (n_channels, n_cells) [unit].

    The median over `BACKGROUND_TIME`, which shocks do not move, the largest of those within
    `BACKGROUND_SIDES`.
    """
    size = min(round(BACKGROUND_TIME / cells.seconds) | 1, (2 * cells.count - 1) | 1)
    median = scipy.ndimage.median_filter(cells.mean_square, (1, size), mode="nearest")
    width = 2 * round(BACKGROUND_SIDES / cells.seconds) + 1
    widened = scipy.ndimage.maximum_filter(median, (1, width), mode="nearest")
    return np.sqrt(np.asarray(widened, dtype=np.float64))


def shocks_of(cells: Cells, rule: ShockRule) -> list[tuple[int, int]]:
    """Return the shocks of a record, first cell and the cell after the last.

    A shock begins and ends where no channel is more than `SHOCK_END` times the vibration around
    it, and holds a peak that is one by `rule`; a cell on either side belongs to it. What lasts
    longer than the rule allows is none.
    """
    around = background(cells)
    floor = LEAST_PEAK * cells.peak.max(axis=1, keepdims=True)
    high = cells.peak >= np.maximum(np.maximum(rule.crest * around, floor), rule.least)
    high &= cells.peak > 0.0
    rms = np.sqrt(cells.mean_square)
    beyond = (rms > np.maximum(SHOCK_END * around, 0.5 * floor)) | high
    peaks = high.any(axis=0)
    joined = _closed(beyond.any(axis=0), round(LEAST_QUIET / cells.seconds))
    most = max(1, round(rule.longest / cells.seconds))
    return [
        (max(first - 1, 0), min(stop + 1, cells.count))
        for first, stop in _runs(joined)
        if peaks[first:stop].any() and stop - first <= most
    ]


def _closed(mask: NDArray[np.bool_], gap: int) -> NDArray[np.bool_]:
    """Return a mask in which gaps of less than so many cells are filled."""
    closed = mask.copy()
    for first, stop in _runs(~mask):
        if stop - first < gap and first > 0 and stop < mask.size:
            closed[first:stop] = True
    return closed


def _runs(mask: NDArray[np.bool_]) -> Iterator[tuple[int, int]]:
    """Yield where a mask holds, first place and the place after the last."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    for first, stop in edges.reshape(-1, 2):
        yield int(first), int(stop)


@final
@dataclass(frozen=True, slots=True)
class RecordPart:
    """One part of a record.

    Attributes
    ----------
    kind : Kind
        A ``shock``; vibration that is ``stationary`` or ``not stationary`` (its level rises or
        falls); or a ``transient``, vibration that is too short to tell.
    first, stop : int
        First cell, and the cell after the last.
    """

    kind: Kind
    first: int
    stop: int


def split(cells: Cells, rule: ShockRule, *, shortest: float, step: float) -> list[RecordPart]:
    """Return the shocks and the parts of vibration of a record, in order of time.

    Shocks lie within parts of vibration, which are told without them.

    Parameters
    ----------
    cells : Cells
        The record.
    rule : ShockRule
        What is a shock.
    shortest : float
        Length of a stationary part at least [s].
    step : float
        By how much the level of two parts differs at least [dB].

    Returns
    -------
    list of RecordPart
        Vibration covers the whole record.
    """
    shocks = shocks_of(cells, rule)
    calm = np.ones(cells.count, dtype=np.bool_)
    for first, stop in shocks:
        calm[first:stop] = False
    ends = _ends(cells, calm, step)
    vibration = [
        RecordPart(_kind(cells, calm, first, stop, shortest), first, stop)
        for first, stop in pairwise(ends)
    ]
    record_parts = [*vibration, *(RecordPart("shock", first, stop) for first, stop in shocks)]
    return sorted(record_parts, key=lambda part: (part.first, -part.stop))


def _kind(
    cells: Cells, calm: NDArray[np.bool_], first: int, stop: int, shortest: float
) -> Kind:
    if (stop - first) * cells.seconds < shortest:
        return "transient"
    trend = has_trend(cells.mean_square[:, first:stop], calm[first:stop])
    return "not stationary" if trend else "stationary"


def _ends(cells: Cells, calm: NDArray[np.bool_], step: float) -> list[int]:
    """Return the cells at which the level changes, with both ends of the record."""
    least = round(STRETCH / cells.seconds)
    together = max(1, least, -(-cells.count // MOST_STRETCHES))
    starts = np.arange(0, max(1, cells.count - together + 1), together)
    number = np.add.reduceat(calm.astype(np.float64), starts)
    energy = np.add.reduceat(cells.mean_square * calm, starts, axis=1)
    known = number > 0.0
    level = _decibels(energy[:, known] / number[known])
    ends = changes(level, step)
    fine = _decibels(np.where(calm, cells.mean_square, np.nan))
    places = np.flatnonzero(known)
    inner = [_refined(fine, int(starts[places[end]]), together) for end in ends[1:-1]]
    return [0, *sorted(set(inner) - {0, cells.count}), cells.count]


def _decibels(mean_square: FloatArray) -> FloatArray:
    """Return levels [dB], no more than 200 below the largest of a channel."""
    largest = np.nanmax(mean_square, axis=1, keepdims=True)
    return 10.0 * np.log10(np.maximum(mean_square, 1e-20 * np.where(largest, largest, 1.0)))


def _refined(fine: FloatArray, place: int, together: int) -> int:
    """Return the cell near a change at which the levels of both sides scatter least."""
    first = max(0, place - together)
    seen = fine[:, first : place + together]
    known = np.isfinite(seen).all(axis=0)
    values, at = seen[:, known], first + np.flatnonzero(known)
    if at.size < 2:
        return place
    counts = np.arange(1, at.size)
    sums = np.cumsum(values, axis=1)
    left, right = sums[:, :-1], sums[:, -1:] - sums[:, :-1]
    gain = np.sum(left**2 / counts + right**2 / counts[::-1], axis=0)
    return int(at[int(np.argmax(gain)) + 1])
