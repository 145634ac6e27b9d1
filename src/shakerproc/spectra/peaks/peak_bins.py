"""Which bins around a peak are fitted, and which peaks are its neighbours."""

from dataclasses import dataclass
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.spectra.peaks.finding import IndexArray, local_maxima, resolved
from shakerproc.spectra.peaks.mode_fit import (
    Kind,
)

REACH_BINS: Final = 6
"""Bins to each side of a peak that are fitted at least."""

FURTHEST: Final = 64
"""Bins to each side of a peak that are fitted at most."""

LEAST_BINS: Final = 7
"""Bins below which six or eight unknowns are too many."""

SEEN: Final = 400
"""Bins to each side of a peak in which its neighbours are looked for."""

BENT: Final = 0.3
"""Bias in standard errors that is let stand [-]: it costs a 95 % interval 1 % of its coverage,
P(|z + 0.3| < 1.96) = 0.94."""

MOST_MODES: Final = 6
"""Modes that are fitted together at most."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class PeakData:
    """Data of a fit: values of every frequency and their standard errors."""

    kind: Kind
    values: ComplexArray | FloatArray
    errors: FloatArray
    lit_segments: FloatArray
    missing: FloatArray | None = None


def smoothing_of(power: FloatArray, data: PeakData, place: float) -> int:
    """Return over how many bins to average so that chance makes no peaks of its own.

    `power` may be in any unit, `place` counts bins [-].
    """
    centre = min(max(round(place), 2), power.size - 3)
    near = slice(centre - 2, centre + 3)
    kept = power[near] > 0.0
    if not kept.any():
        return 1
    error = np.median(data.errors[near][kept] / np.abs(data.values[near][kept]))
    error *= 2.0 if data.kind == "response" else 1.0
    return min(1 + 2 * round(8.0 * float(error) ** 2), 201)


def maxima_around(data: PeakData, usable: NDArray[np.bool_], place: float) -> IndexArray:
    """Return the peaks around a place that chance does not make. `place` counts bins [-]."""
    low = max(0, int(place) - SEEN)
    part = slice(low, int(place) + SEEN + 1)
    height = np.where(usable[part], np.abs(data.values[part]), np.nan)
    share = np.full(height.shape, np.nan)
    np.divide(data.errors[part], height, out=share, where=height > 0.0)
    return low + resolved(local_maxima(height), height, share)


def nearest_peak(maxima: IndexArray, power: FloatArray, place: float) -> int:
    """Return the peak nearest to a place, or the tallest bin there if there is none near.

    `power` may be in any unit, `place` counts bins [-].
    """
    near = maxima[np.abs(maxima - place) <= SEEN / 4]
    if near.size:
        return int(near[np.argmin(np.abs(near - place))])
    low = min(max(round(place) - 2, 1), power.size - 2)
    return low + int(np.argmax(power[low : low + 5]))


def bins_around(
    data: PeakData, usable: NDArray[np.bool_], maxima: IndexArray, peak: int, reach: float,
    *, width: float,
) -> tuple[IndexArray, tuple[int, ...]]:  # fmt: skip
    """Return the bins around a peak, those of neighbours that matter included, and these.

    `reach` and the half-power `width` count bins [-].
    """
    others = maxima[maxima != peak]
    others = others[
        (np.abs(others - peak) <= 2.0 * reach) | _bend(data, others, peak, reach, width)
    ]
    beyond = max(reach / 2.0, REACH_BINS / 2.0)
    low = min([peak - reach, *(others - beyond)])
    high = max([peak + reach, *(others + beyond)])
    number = np.arange(usable.size)
    bins = number[(number >= low) & (number <= high) & (np.abs(number - peak) <= 2 * FURTHEST)]
    broken = bins[~usable[bins]]
    if (broken < peak).any():
        bins = bins[bins > broken[broken < peak].max()]
    if (broken > peak).any():
        bins = bins[bins < broken[broken > peak].min()]
    inside = others[np.isin(others, bins)]
    nearest = inside[np.argsort(np.abs(inside - peak), kind="stable")][: MOST_MODES - 1]
    return bins, tuple(int(k) for k in nearest)


def _bend(
    data: PeakData, others: IndexArray, peak: int, reach: float, width: float
) -> NDArray[np.bool_]:
    r"""Return which neighbours a straight background under a peak misses by more than chance.

    A neighbour of height A and half-width h so many bins d away is
    :math:`A (h/d)^p` under the peak, p = 1 in a response function and 2 in a density. A
    straight line over r bins to each side misses of that, rms,
    :math:`2/\sqrt{45}\ p (p + 1)/2\ (r/d)^2`, which bends no parameter by more than that over
    the error, times the root of the number of bins (Cauchy and Schwarz), in standard errors.
    """
    power = 1 if data.kind == "response" else 2
    apart = np.abs(others - peak).astype(np.float64)
    under = np.abs(data.values[others]) * (0.5 * width / apart) ** power
    missed = 2.0 / np.sqrt(45.0) * power * (power + 1) / 2.0 * (reach / apart) ** 2 * under
    near = apart + max(reach / 2.0, REACH_BINS / 2.0) <= 2 * FURTHEST
    return np.asarray(near & (missed * np.sqrt(2.0 * reach) > BENT * data.errors[peak]))


def clearance_of(starts: tuple[int, ...]) -> float:
    """Return how many bins around the first of some peaks are nearer to it than to others."""
    nearest = min((abs(other - starts[0]) for other in starts[1:]), default=2 * FURTHEST)
    return max(nearest / 2.0, LEAST_BINS / 2.0)
