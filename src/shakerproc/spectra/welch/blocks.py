"""Samples in blocks: in memory order; mean, spread, extremes, shape and ends of the range."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.errors import SpectrumError

SLICE = 2**16
"""Samples of a slice: a few of them fit the cache."""


def in_order(blocks: Iterable[FloatArray] | FloatArray) -> Iterator[FloatArray]:
    """Yield (n_channels, n) blocks of float64 in row order, copied only where they are not.

    They may be in any unit.

    Raises
    ------
    ValueError
        If a block is not two-dimensional.
    """
    for block in (blocks,) if isinstance(blocks, np.ndarray) else blocks:
        if block.ndim != 2 or not block.shape[0]:
            raise ValueError(f"a block must be (n_channels, n) samples, not {block.shape}")
        if block.flags.c_contiguous and block.dtype == np.float64:
            yield block
            continue
        for start in range(0, block.shape[1], SLICE):
            yield np.ascontiguousarray(block[:, start : start + SLICE], dtype=np.float64)


@final
@dataclass(frozen=True, slots=True, eq=False)
class Statistics:
    """Descriptive statistics of each channel, (n_channels,) arrays.

    Attributes
    ----------
    n_samples : int
        Number of samples.
    mean, rms, standard_deviation, minimum, maximum : (n_channels,) arrays
        In the unit of the samples; the standard deviation divides by n, as the thesis does.
    crest_factor : (n_channels,) array
        Largest magnitude over rms [-]; not a number where all samples are 0.
    kurtosis : (n_channels,) array
        Fourth central moment over the squared variance, 3 for a normal distribution [-]; not
        a number where the samples do not vary.
    """

    n_samples: int
    mean: FloatArray
    rms: FloatArray
    standard_deviation: FloatArray
    minimum: FloatArray
    maximum: FloatArray
    crest_factor: FloatArray
    kurtosis: FloatArray


def statistics(blocks: Iterable[FloatArray] | FloatArray) -> Statistics:
    """Return the descriptive statistics of each channel.

    Parameters
    ----------
    blocks : iterable of (n_channels, n) arrays, or one (n_channels, n_samples) array
        The samples, in blocks of any size [unit of the channel].

    Returns
    -------
    Statistics
        One value a channel.

    Raises
    ------
    SpectrumError
        If there is no sample.

    References
    ----------
    .. [1] P. Pébay, "Formulas for robust, one-pass parallel computation of covariances and
       arbitrary-order statistical moments", Sandia SAND2008-6212, 2008.
    .. [2] THESIS, section 3.10.
    """
    total: _Moments | None = None
    for block in in_order(blocks):
        for start in range(0, block.shape[1], SLICE):
            part = _moments(block, start, min(start + SLICE, block.shape[1]))
            total = part if total is None else _merged(total, part)
    if total is None:
        raise SpectrumError("there is no sample to describe")
    variance = total.second / total.count
    rms = np.sqrt(variance + total.mean**2)
    peak = np.maximum(np.abs(total.minimum), np.abs(total.maximum))
    fourth = total.fourth / total.count
    return Statistics(
        n_samples=total.count,
        mean=total.mean,
        rms=rms,
        standard_deviation=np.sqrt(variance),
        minimum=total.minimum,
        maximum=total.maximum,
        crest_factor=_quotient(peak, rms),
        kurtosis=_quotient(fourth, variance**2),
    )


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Moments:
    """Sums of powers of the distance from the mean, (n_channels,) arrays."""

    count: int
    mean: FloatArray
    second: FloatArray
    third: FloatArray
    fourth: FloatArray
    minimum: FloatArray
    maximum: FloatArray


def _moments(block: FloatArray, start: int, stop: int) -> _Moments:
    """Return the moments of the samples start to stop of a block."""
    rows = [_moments_of_row(row[start:stop]) for row in block]
    return _Moments(stop - start, *np.array(rows).T)


def _moments_of_row(samples: FloatArray) -> tuple[float, ...]:
    """Return the mean, the sums of three powers of the distance from it, and the extremes."""
    mean = samples.mean()
    distance = samples - mean
    square = distance * distance
    # sums in pairs: products of BLAS depend in the last digit on where in memory samples lie
    powers = (square.sum(), (square * distance).sum(), (square * square).sum())
    return (mean, *powers, samples.min(), samples.max())


def _merged(a: _Moments, b: _Moments) -> _Moments:
    """Return the moments of two parts together."""
    n = a.count + b.count
    step = b.mean - a.mean
    both = a.count * b.count / n
    third = a.third + b.third + step**3 * both * (a.count - b.count) / n
    third += 3.0 * step * (a.count * b.second - b.count * a.second) / n
    fourth = a.fourth + b.fourth + 4.0 * step * (a.count * b.third - b.count * a.third) / n
    fourth += step**4 * both * (a.count**2 - a.count * b.count + b.count**2) / n**2
    fourth += 6.0 * (step / n) ** 2 * (a.count**2 * b.second + b.count**2 * a.second)
    return _Moments(
        n,
        a.mean + step * b.count / n,
        a.second + b.second + step**2 * both,
        third,
        fourth,
        np.minimum(a.minimum, b.minimum),
        np.maximum(a.maximum, b.maximum),
    )


def _quotient(above: FloatArray, below: FloatArray) -> FloatArray:
    """Return the quotient, not a number where there is nothing below."""
    result = np.full(above.shape, np.nan)
    np.divide(above, below, out=result, where=below > 0.0)
    return result


FEWEST: Final = 3
"""Samples exactly at the largest value of a channel that make it the end of its range."""

PILE: Final = 3.0
"""How many times as many samples as at the next value there must be: a quantised sine has
2.4 times as many at its crest [-]."""

RESTING: Final = 0.5
"""Share of samples from which on the extreme is where the channel rests [-]."""


def range_ends(blocks: Iterable[FloatArray]) -> FloatArray:
    """Return the ends of the ranges at which samples of a recording pile up.

    Parameters
    ----------
    blocks : iterable of (n_channels, n) arrays
        The samples in order [unit of the channel].

    Returns
    -------
    (2, n_channels) array
        Low and high end of each channel; not a number where its samples do not reach one.
    """
    counts: list[list[dict[float, int]]] = []
    n_samples = 0
    for block in blocks:
        n_samples += block.shape[1]
        counts = counts or [[{} for _ in block] for _ in range(2)]
        for side, samples in ((0, -block), (1, block)):
            for known, row in zip(counts[side], samples, strict=True):
                _count_highest(known, row)
    sides = [[_end(known, n_samples) for known in side] for side in counts]
    return np.array([[-low for low in sides[0]], sides[1]])


def _count_highest(known: dict[float, int], row: FloatArray) -> None:
    """Count the samples at the highest two values, with those that are known already."""
    top = float(row.max())
    below = row[row < top]
    values = [top, float(below.max())] if below.size else [top]
    for value in values:
        known[value] = known.get(value, 0) + int(np.count_nonzero(row == value))
    for value in sorted(known)[:-2]:
        del known[value]


def _end(known: dict[float, int], n_samples: int) -> float:
    """Return the end of a range, not a number where samples do not pile up there."""
    top = max(known)
    count, below = known[top], known[min(known)] if len(known) > 1 else 1
    piled = count >= max(FEWEST, PILE * below) and count < RESTING * n_samples
    return top if piled and top != 0.0 else float("nan")
