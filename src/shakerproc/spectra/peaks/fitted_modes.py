"""The modes that fit the bins around a peak, and the errors that chance makes."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.spectra.peaks.chance import Chance, plain_chance, smearing_of, steady_chance
from shakerproc.spectra.peaks.finding import IndexArray, local_maxima, resolved
from shakerproc.spectra.peaks.mode_fit import (
    Kind,
    ModesFit,
    SmearedModes,
    best_ratio,
    fit_modes,
)
from shakerproc.spectra.welch.cross import CrossSpectra
from shakerproc.spectra.welch.windows import (
    AbstractCorrelation,
    DecayCorrelation,
    correlation_of,
)

REACH_BINS: Final = 6
"""Bins to each side of a peak that are fitted at least."""

MOST_BINS: Final = 64
"""Bins to each side of a peak that are fitted at most."""

LEAST_BINS: Final = 7
"""Bins below which six or eight unknowns are too many."""

NEIGHBOUR_BINS: Final = 400
"""Bins to each side of a peak in which its neighbours are looked for."""

MOST_BIAS: Final = 0.3
"""Bias in standard errors that is let stand [-]: it costs a 95 % interval 1 % of its coverage,
P(|z + 0.3| < 1.96) = 0.94."""

MOST_MODES: Final = 6
"""Modes that are fitted together at most."""

FIRST_RATIOS: Final = np.geomspace(2e-4, 0.3, 13)
"""Damping ratios tried before the search [-]."""

UNSTEADY_DEVIATIONS: Final = 3.0
"""Standard deviations by which fewer segments light a bin than random vibration lights."""


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
    low = max(0, int(place) - NEIGHBOUR_BINS)
    part = slice(low, int(place) + NEIGHBOUR_BINS + 1)
    height = np.where(usable[part], np.abs(data.values[part]), np.nan)
    share = np.full(height.shape, np.nan)
    np.divide(data.errors[part], height, out=share, where=height > 0.0)
    return low + resolved(local_maxima(height), height, share)


def nearest_peak(maxima: IndexArray, power: FloatArray, place: float) -> int:
    """Return the peak nearest to a place, or the tallest bin there if there is none near.

    `power` may be in any unit, `place` counts bins [-].
    """
    near = maxima[np.abs(maxima - place) <= NEIGHBOUR_BINS / 4]
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
    bins = number[(number >= low) & (number <= high) & (np.abs(number - peak) <= 2 * MOST_BINS)]
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
    distances = np.abs(others - peak).astype(np.float64)
    under = np.abs(data.values[others]) * (0.5 * width / distances) ** power
    missed = 2.0 / np.sqrt(45.0) * power * (power + 1) / 2.0 * (reach / distances) ** 2 * under
    near = distances + max(reach / 2.0, REACH_BINS / 2.0) <= 2 * MOST_BINS
    return np.asarray(near & (missed * np.sqrt(2.0 * reach) > MOST_BIAS * data.errors[peak]))


def clearance_of(starts: tuple[int, ...]) -> float:
    """Return how many bins around the first of some peaks are nearer to it than to others."""
    nearest = min((abs(other - starts[0]) for other in starts[1:]), default=2 * MOST_BINS)
    return max(nearest / 2.0, LEAST_BINS / 2.0)


@final
@dataclass(frozen=True, slots=True, eq=False)
class FittedModes:
    """The modes that fit a peak (the first) and its neighbours, and the errors of chance."""

    shape: SmearedModes
    fit: ModesFit
    chance: Chance
    covariance: FloatArray  # of the weighted values
    errors: FloatArray

    @property
    def followed(self) -> float:
        """How much of the squared errors the fit follows: its penalty."""
        return float(np.sum(self.fit.basis * (self.covariance @ self.fit.basis)))

    @property
    def scale(self) -> float:
        """Squared misfit over its expectation by chance [-]."""
        expected = float(np.trace(self.covariance)) - self.followed
        return self.fit.squares / max(expected, 1e-3 * self.fit.residual.size)

    @property
    def spread(self) -> FloatArray:
        """Variances of the logarithms of frequencies and ratios, the misfit included."""
        slopes = self.fit.slopes
        inverse = np.linalg.pinv(slopes.T @ slopes) @ slopes.T
        return np.asarray(np.diag(inverse @ self.covariance @ inverse.T) * max(1.0, self.scale))


def fitted_modes(
    spectra: CrossSpectra,
    data: PeakData,
    bins: IndexArray,
    starts: tuple[int, ...],
    maxima: IndexArray,
) -> FittedModes:
    """Return the modes that fit these bins, as many as the data tell apart."""
    kernel = _kernel(spectra)
    shape = SmearedModes(data.kind, bins, kernel, spectra.n_fft, spectra.sample_rate)
    frequency = spectra.frequency[list(starts)]
    near = bins[np.abs(bins - starts[0]) <= clearance_of(starts)]
    alone = replace(shape, bins=near)
    first = best_ratio(
        alone, data.values[near], data.errors[near], float(frequency[0]), FIRST_RATIOS
    )
    ratio = first * frequency[0] / frequency
    fit = fit_modes(shape, data.values[bins], data.errors[bins], frequency, ratio)
    reading = _refitted(spectra, data, shape, fit)
    while reading.scale > 1.0 and reading.fit.frequency.size < MOST_MODES:
        more = _with_further_mode(spectra, data, shape, reading, maxima)
        if more is None:
            break
        reading = more
    return reading


def _kernel(spectra: CrossSpectra) -> AbstractCorrelation:
    """Return the correlation of the averaging, which multiplies the decay of a mode."""
    if spectra.decay_rate is not None:
        return DecayCorrelation(spectra.decay_rate / spectra.sample_rate)
    return correlation_of(spectra.window_name, spectra.window)


def _refitted(
    spectra: CrossSpectra, data: PeakData, shape: SmearedModes, fit: ModesFit
) -> FittedModes:
    """Return modes fitted again with the errors that they themselves imply."""
    chance = _chance(spectra, data, shape.bins, fit)
    errors = chance.errors
    values = data.values[shape.bins] - chance.bias
    again = fit_modes(shape, values, errors, fit.frequency, fit.ratio)
    return FittedModes(shape, again, chance, _weighted(chance, errors, data.kind), errors)


def _with_further_mode(
    spectra: CrossSpectra,
    data: PeakData,
    shape: SmearedModes,
    fitted: FittedModes,
    maxima: IndexArray,
) -> FittedModes | None:
    """Return a reading with one more mode if the information criterion falls, else None."""
    values = data.values[shape.bins] - fitted.chance.bias
    trials = []
    for place in _candidates(shape.bins, fitted, maxima):
        frequency = float(spectra.frequency[place])
        ratio = spectra.bin_width / frequency
        trial = fit_modes(
            shape,
            values,
            fitted.errors,
            np.append(fitted.fit.frequency, frequency),
            np.append(fitted.fit.ratio, ratio),
        )
        if trial.converged:
            trials.append(trial)
    if not trials:
        return None
    best = min(trials, key=lambda trial: trial.squares)
    more = FittedModes(shape, best, fitted.chance, fitted.covariance, fitted.errors)
    gained = (fitted.fit.squares - best.squares) / max(1.0, more.scale)
    if gained <= 2.0 * (more.followed - fitted.followed):
        return None
    refitted = _refitted(spectra, data, shape, best)
    return refitted if refitted.fit.converged else None


def _candidates(bins: IndexArray, fitted: FittedModes, maxima: IndexArray) -> Iterator[int]:
    """Yield where another mode may be: at the largest misfit, at the peaks beside the bins."""
    missed = np.sum(fitted.fit.residual.reshape(-1, bins.size) ** 2, axis=0)
    yield int(bins[int(np.argmax(missed))])
    below, above = maxima[maxima < bins[0]], maxima[maxima > bins[-1]]
    if below.size:
        yield int(below.max())
    if above.size:
        yield int(above.min())


def _chance(spectra: CrossSpectra, data: PeakData, bins: IndexArray, fit: ModesFit) -> Chance:
    """Return the errors of the values: by theory where the excitation was steady and random."""
    smearing = smearing_of(spectra)
    wanted = (
        0.5
        * spectra.n_segments
        * (1.0 - UNSTEADY_DEVIATIONS / np.sqrt(spectra.effective_averages))
    )
    transient = spectra.decay_rate is not None
    if transient or float(data.lit_segments[bins].mean()) < wanted:
        is_complex = data.kind == "response"
        return plain_chance(smearing, data.errors[bins], is_complex=is_complex)
    missing = None if data.missing is None else data.missing[bins]
    return steady_chance(smearing, data.kind, spectra.frequency[bins], fit, missing)


def _weighted(chance: Chance, errors: FloatArray, kind: Kind) -> FloatArray:
    """Return the covariance of values over their errors."""
    every = errors if kind == "density" else np.concatenate([errors, errors])
    return np.asarray(chance.covariance / (every * every[:, np.newaxis]))
