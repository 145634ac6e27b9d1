"""Local maxima: those that chance does not make, the tallest in a band, the thesis' rule."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import FloatArray

IndexArray: TypeAlias = NDArray[np.intp]

BY_CHANCE: Final = 0.05
"""Probability that chance alone makes a peak in a flat spectrum of this many bins [-]."""


def saddles(level: FloatArray, peaks: IndexArray) -> IndexArray:
    """Return the higher of the two saddles between each maximum and taller ground.

    scipy.signal has them, but takes 0.4 s to load.

    Parameters
    ----------
    level : (n,) array
        Values without NaN [any unit].
    peaks : (m,) array of int
        Maxima among them.

    Returns
    -------
    (m,) array of int
        Where the saddles are; the left one of two that are as high.
    """
    last = level.size - 1
    left = np.array(_lowest_before(level.tolist()), dtype=np.intp)[peaks]
    right = last - np.array(_lowest_before(level[::-1].tolist()), dtype=np.intp)[last - peaks]
    return np.where(level[left] >= level[right], left, right)


def _lowest_before(level: Sequence[float]) -> list[int]:
    """Return where the lowest value lies from each one back to the next that is taller.

    The nearest of several that are as low. What is taller waits in a stack, each with the
    lowest value between it and the one below it.
    """
    lowest: list[int] = []
    waiting: list[tuple[float, int]] = []
    for place, height in enumerate(level):
        low = place
        while waiting and waiting[-1][0] <= height:
            _, beside = waiting.pop()
            if level[beside] < level[low]:
                low = beside
        waiting.append((height, low))
        lowest.append(low)
    return lowest


@final
@dataclass(frozen=True, slots=True)
class Peak:
    """One local maximum of a spectrum.

    Attributes
    ----------
    index : int
        Which bin.
    bin_frequency : float
        Middle of the bin [Hz].
    frequency : float
        Frequency of the parabola through the logarithms of three bins [Hz].
    value : float
        Value in the bin [unit of the values].
    """

    index: int
    bin_frequency: float
    frequency: float
    value: float


def local_maxima(values: FloatArray) -> IndexArray:
    """Return the indices of local maxima, of a flat top its first, as MATLAB's findpeaks.

    The first and the last value are no maxima; nothing is next to a value that is not a
    number.

    `values` may be in any unit.
    """
    if values.size < 3:
        return np.zeros(0, dtype=np.intp)
    keep = np.concatenate([[True], values[1:] != values[:-1]])
    where = np.flatnonzero(keep)
    level = values[where]
    inner = (level[1:-1] > level[:-2]) & (level[1:-1] > level[2:])
    return where[1:-1][inner]


def separated(indices: IndexArray, values: FloatArray, distance: float) -> IndexArray:
    """Return the maxima that no taller one lies near, tallest first.

    Parameters
    ----------
    indices : (n,) array of int
        Candidates.
    values : (n_values,) array
        The spectrum that they are maxima of [any unit].
    distance : float
        Bins within which only the tallest is kept, the limit included; of equal ones the
        first [-].

    Returns
    -------
    (m,) array of int
        What is kept, tallest first.
    """
    remaining = indices[np.argsort(-values[indices], kind="stable")]
    kept = []
    while remaining.size:
        kept.append(remaining[0])
        remaining = remaining[np.abs(remaining - remaining[0]) > distance]
    return np.array(kept, dtype=np.intp)


def resolved(indices: IndexArray, values: FloatArray, errors: FloatArray) -> IndexArray:
    r"""Return the maxima that chance does not make.

    The logarithm of a maximum exceeds that of the higher of the two saddles between it and
    taller ground by more than both may be off at once,

    .. math:: \ln y_p - \ln y_s > z (\varepsilon_p + \varepsilon_s)

    with the normal quantile :math:`z` of which all bins together are on the safe side with a
    probability of 95 %.

    Parameters
    ----------
    indices : (n,) array of int
        Local maxima.
    values : (n_values,) array
        The spectrum that they are maxima of, positive; what is not a number is masked
        [any unit].
    errors : (n_values,) array
        Random error of each value, as a share of it [-].

    Returns
    -------
    (m,) array of int
        Those of the maxima that stand out; one at the edge of what is not masked shows one
        flank only and does not count.
    """
    known = np.flatnonzero(np.isfinite(values) & (values > 0.0) & ~np.isnan(errors))
    level = np.log(values[known])
    maxima = np.intersect1d(np.searchsorted(known, indices), local_maxima(level))
    saddle = saddles(level, maxima)
    prominence = level[maxima] - level[saddle]
    z = scipy.special.ndtri(1.0 - BY_CHANCE / (2.0 * max(1, known.size)))
    sure = errors[known]
    return np.asarray(known[maxima[prominence > z * (sure[maxima] + sure[saddle])]])


def find_peaks(
    frequency: FloatArray,
    values: FloatArray,
    band: tuple[float, float],
    *,
    distance: float = 0.0,
    height: float = 0.0,
    count: int | None = None,
    errors: FloatArray | None = None,
) -> tuple[Peak, ...]:
    """Return the tallest peaks in a band, tallest first.

    Parameters
    ----------
    frequency : (n_frequencies,) array
        Equally spaced frequencies [Hz].
    values : (n_frequencies,) array
        Positive values, linear; what is not a number is masked [any unit].
    band : (float, float)
        Lowest and highest frequency of a peak [Hz].
    distance : float
        Frequency within which only the tallest peak counts [Hz].
    height : float
        Peaks lower than this or equal to it do not count [unit of the values].
    count : int, optional
        How many at most; by default all.
    errors : (n_frequencies,) array, optional
        Random error of each value, as a share of it [-]: peaks that chance may make do not
        count (see `resolved`).

    Returns
    -------
    tuple of Peak
        Peaks, tallest first; empty where there is none.

    Raises
    ------
    ValueError
        If the arrays or the band do not fit.
    """
    if frequency.shape != values.shape or frequency.ndim != 1:
        raise ValueError(f"{frequency.shape} frequencies for {values.shape} values")
    if not band[0] < band[1]:
        raise ValueError(f"the band must rise, not run from {band[0]:g} to {band[1]:g} Hz")
    inside = (frequency >= band[0]) & (frequency <= band[1])
    indices = local_maxima(values)
    indices = indices[inside[indices] & (values[indices] > height)]
    width = frequency[1] - frequency[0] if frequency.size > 1 else 1.0
    if errors is not None:
        indices = resolved(indices, np.where(inside, values, np.nan), errors)
    tallest = separated(indices, values, distance / width)[:count]
    return tuple(_peak(int(k), frequency, values) for k in tallest)


def thesis_peaks(values: FloatArray, share: float, height: float = -np.inf) -> IndexArray:
    """Return the indices that the thesis' findpeaks call gives, by location.

    Parameters
    ----------
    values : (n_frequencies,) array
        PSD (as its logarithm) or PSD ratio from 0 to half the sample rate [any unit].
    share : float
        MinPeakDistance as a share of the lower half of the values [-].
    height : float
        MinPeakHeight [unit of the values].

    Returns
    -------
    (n,) array of int
        Indices of the peaks, from 0, in the order of frequency.

    References
    ----------
    .. [1] THESIS, appendix C, "Finding peaks".
    """
    lower_half = values[: int(np.floor(values.size / 2 + 0.5))]
    indices = local_maxima(lower_half)
    indices = indices[lower_half[indices] > height]
    return np.sort(separated(indices, lower_half, share * lower_half.size))


def _peak(k: int, frequency: FloatArray, values: FloatArray) -> Peak:
    """Return the peak in bin k, its frequency from a parabola through the logarithms."""
    near = values[k - 1 : k + 2]
    shift = 0.0
    if (near > 0.0).all():
        left, middle, right = np.log(near)
        shift = 0.5 * (left - right) / (left - 2.0 * middle + right)
    width = frequency[k] - frequency[k - 1]
    return Peak(k, float(frequency[k]), float(frequency[k] + shift * width), float(values[k]))
