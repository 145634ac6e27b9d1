"""The modes that fit a peak and what is beside it, and what chance made of them."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.spectra.peaks.chance import Chance, plain_chance, smearing_of, steady_chance
from shakerproc.spectra.peaks.finding import IndexArray
from shakerproc.spectra.peaks.mode_fit import (
    Kind,
    ModesFit,
    ModeShape,
    best_ratio,
    fit_modes,
)
from shakerproc.spectra.peaks.peak_bins import MOST_MODES, PeakData, clearance_of
from shakerproc.spectra.welch.cross import CrossSpectra
from shakerproc.spectra.welch.windows import (
    AbstractCorrelation,
    DecayCorrelation,
    correlation_of,
)

FIRST_RATIOS: Final = np.geomspace(2e-4, 0.3, 13)
"""Damping ratios tried before the search [-]."""

UNSTEADY: Final = 3.0
"""Standard deviations by which fewer segments light a bin than random vibration lights."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class FittedModes:
    """The modes that fit a peak (the first) and what is beside it, and what chance made."""

    shape: ModeShape
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
        """Squared misfit over what chance makes of it [-]."""
        left = float(np.trace(self.covariance)) - self.followed
        return self.fit.squares / max(left, 1e-3 * self.fit.residual.size)

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
    shape = ModeShape(data.kind, bins, kernel, spectra.n_fft, spectra.sample_rate)
    frequency = spectra.frequency[list(starts)]
    near = bins[np.abs(bins - starts[0]) <= clearance_of(starts)]
    alone = replace(shape, bins=near)
    first = best_ratio(
        alone, data.values[near], data.errors[near], float(frequency[0]), FIRST_RATIOS
    )
    ratio = first * frequency[0] / frequency
    fit = fit_modes(shape, data.values[bins], data.errors[bins], frequency, ratio)
    found = _settled(spectra, data, shape, fit)
    while found.scale > 1.0 and found.fit.frequency.size < MOST_MODES:
        more = _one_more(spectra, data, shape, found, maxima)
        if more is None:
            break
        found = more
    return found


def _kernel(spectra: CrossSpectra) -> AbstractCorrelation:
    """Return the correlation of the averaging, which multiplies the decay of a mode."""
    if spectra.decay_rate is not None:
        return DecayCorrelation(spectra.decay_rate / spectra.sample_rate)
    return correlation_of(spectra.window_name, spectra.window)


def _settled(
    spectra: CrossSpectra, data: PeakData, shape: ModeShape, fit: ModesFit
) -> FittedModes:
    """Return modes fitted again with the errors that they themselves imply."""
    chance = _chance(spectra, data, shape.bins, fit)
    errors = chance.errors
    values = data.values[shape.bins] - chance.bias
    again = fit_modes(shape, values, errors, fit.frequency, fit.ratio)
    return FittedModes(shape, again, chance, _weighted(chance, errors, data.kind), errors)


def _one_more(
    spectra: CrossSpectra,
    data: PeakData,
    shape: ModeShape,
    found: FittedModes,
    maxima: IndexArray,
) -> FittedModes | None:
    """Return a reading with one more mode if the information criterion falls, else None."""
    values = data.values[shape.bins] - found.chance.bias
    trials = []
    for place in _candidates(shape.bins, found, maxima):
        frequency = float(spectra.frequency[place])
        ratio = spectra.bin_width / frequency
        trial = fit_modes(
            shape,
            values,
            found.errors,
            np.append(found.fit.frequency, frequency),
            np.append(found.fit.ratio, ratio),
        )
        if trial.converged:
            trials.append(trial)
    if not trials:
        return None
    best = min(trials, key=lambda trial: trial.squares)
    more = FittedModes(shape, best, found.chance, found.covariance, found.errors)
    gained = (found.fit.squares - best.squares) / max(1.0, more.scale)
    if gained <= 2.0 * (more.followed - found.followed):
        return None
    settled = _settled(spectra, data, shape, best)
    return settled if settled.fit.converged else None


def _candidates(bins: IndexArray, found: FittedModes, maxima: IndexArray) -> Iterator[int]:
    """Yield where another mode may be: at the largest misfit, at the peaks beside the bins."""
    missed = np.sum(found.fit.residual.reshape(-1, bins.size) ** 2, axis=0)
    yield int(bins[int(np.argmax(missed))])
    below, above = maxima[maxima < bins[0]], maxima[maxima > bins[-1]]
    if below.size:
        yield int(below.max())
    if above.size:
        yield int(above.min())


def _chance(spectra: CrossSpectra, data: PeakData, bins: IndexArray, fit: ModesFit) -> Chance:
    """Return the errors of the values: by theory where the excitation was steady and random."""
    smearing = smearing_of(spectra)
    wanted = 0.5 * spectra.n_segments * (1.0 - UNSTEADY / np.sqrt(spectra.effective_averages))
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
