"""Residuals of the linear fit, whitened, in the frequency domain, and their least squares."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.diagnosis.data import PreparedTest
from shakerproc.diagnosis.data.controls import spectra_of
from shakerproc.diagnosis.estimation.linear_parameters import LinearParameters
from shakerproc.diagnosis.estimation.linear_response import poles_of, sensor_responses
from shakerproc.models import Model
from shakerproc.spectra import psd

HIGHEST: Final = 0.4
"""Highest frequency of the fit over the sample rate: above it, the recorder's anti-alias
filter may fall off, and be another than that of the simulation [-]."""

RELATIVE: Final = 1e-3
"""Least noise over the response at a frequency: what sensors are linear to [-]."""

NOISE_KNOWN: Final = 1.5
"""What is left counts as systematic from so many times the noise on, as power: densities from
short rests are known to half of them [-]."""

_NEGLIGIBLE: Final = 1e-12  # of the largest density
_DECAYS: Final = 8.0  # time constants of the slowest motion behind the samples
_TAPER: Final = 0.05  # share of the judged samples in each flank of the window
_ROUNDS: Final = 20  # of least squares
_STIFFEST: Final = 1e8  # damping of a step that is as good as none
_DONE: Final = 1e-6  # relative fall of chi-square in a round
_PER_OCTAVE: Final = 3  # bands in which what the model leaves is smoothed


@final
@dataclass(frozen=True, slots=True, eq=False)
class LinearTest:
    """One test, prepared for the linear fit.

    Attributes
    ----------
    test : PreparedTest
        The test.
    controls : (n_controls, n_frequencies) complex array
        Spectra of the padded controls.
    frequency : (n_frequencies,) array
        Of the padded spectra [Hz].
    apart : (n_sensors, n) array
        What nonlinear laws and sensor faults that the model already has add to its linear
        response [unit of the sensor].
    bins : (n_bins,) array
        Frequencies of the residual within the band [Hz].
    inside : slice
        Those bins among all of the judged part.
    window : (n_judged,) array
        Taper of the judged part [-].
    noise : (n_sensors, n_bins) array
        Density of the noise of responses and input [unit^2/Hz].
    density : (n_sensors, n_bins) array
        Of noise and of what is not coherent with the input [unit^2/Hz].
    """

    test: PreparedTest
    controls: ComplexArray
    frequency: FloatArray
    apart: FloatArray
    bins: FloatArray
    inside: slice
    window: FloatArray
    noise: FloatArray
    density: FloatArray

    @property
    def length(self) -> int:
        """Samples of the padded signals."""
        return 2 * (self.frequency.size - 1)

    def simulated(self, parameters: LinearParameters, values: FloatArray) -> FloatArray:
        """Return the signals of the sensors, (n_sensors, n) array."""
        response = self.response(parameters, values, self.frequency)
        chain = parameters.chain_at(values)
        spectrum = response * chain.responses(self.frequency)
        spectrum = spectrum * (chain.weights @ self.controls)
        spectrum[:, 0] = 0.0
        found = scipy.fft.irfft(spectrum, self.length)[:, : self.test.n_samples]
        return np.asarray(found + chain.gains[:, np.newaxis] * self.apart)

    def response(
        self, parameters: LinearParameters, values: FloatArray, frequency: FloatArray
    ) -> ComplexArray:
        """Return the response function of every sensor at [Hz] (see `sensor_responses`)."""
        model = parameters.model_at(values).under(self.test.conditions)
        alone = sensor_responses(model, frequency)
        beside = (mode.responses(model, frequency) for mode in parameters.driven(values))
        return np.asarray(sum(beside, start=alone))

    def residual(self, parameters: LinearParameters, values: FloatArray) -> ComplexArray:
        """Return the spectrum of measured less simulated over its noise, (n_sensors, n_bins).

        Its real and imaginary parts have variance 1 where nothing but noise is left.
        """
        left = self.test.responses - self.simulated(parameters, values)
        return self.whitened(left) / np.sqrt(self.density)

    def whitened(self, rows: FloatArray) -> ComplexArray:
        """Return spectra whose real and imaginary parts have the density as variance."""
        judged = rows[:, self.test.start : self.test.stop] * self.window
        scale = 0.5 * np.sqrt(self.test.sample_rate * np.sum(self.window**2))
        spectrum = scipy.fft.rfft(judged, _fast(judged.shape[1]), axis=1)[:, self.inside]
        return np.asarray(spectrum / scale)


def prepared(model: Model, test: PreparedTest, apart: FloatArray) -> LinearTest:
    """Return a test for the linear fit of a model."""
    model, rate = model.under(test.conditions), test.sample_rate
    rest = int(min(_DECAYS * poles_of(model).decay * rate, test.n_samples))
    length = scipy.fft.next_fast_len(test.n_samples + rest + 1, real=True)
    length += length % 2
    frequency = scipy.fft.rfftfreq(length, 1.0 / rate)
    frequency[0] = frequency[1]
    window = scipy.signal.windows.tukey(test.stop - test.start, 2.0 * _TAPER)
    every = scipy.fft.rfftfreq(_fast(window.size), 1.0 / rate)
    low, high = test.arrays.band
    first, last = np.searchsorted(every, (low, min(high, HIGHEST * rate)))
    controls = test.arrays.controls - test.arrays.controls.mean(axis=1, keepdims=True)
    bins = every[first:last]
    noise = _noise(model, test, bins)
    return LinearTest(
        test=test,
        controls=scipy.fft.rfft(controls, length),
        frequency=frequency,
        apart=apart,
        bins=bins,
        inside=slice(int(first), int(last)),
        window=np.asarray(window),
        noise=noise,
        density=_density(test, noise, bins, _incoherent(test, test.responses, bins)),
    )


def _fast(size: int) -> int:
    """Return a length from which on a transform is quick: a few zeros behind the samples."""
    return int(scipy.fft.next_fast_len(size, real=True))


def refined(test: LinearTest, parameters: LinearParameters, values: FloatArray) -> LinearTest:
    """Return a test whose incoherent part is that of what the model leaves.

    A resonance narrower than the bins of a coherence leaks into what is taken for incoherent;
    what a linear model leaves has no such resonance.
    """
    left = test.test.responses - test.simulated(parameters, values)
    lost = _incoherent(test.test, left, test.bins)
    return replace(test, density=_density(test.test, test.noise, test.bins, lost))


def _density(
    test: PreparedTest, noise: FloatArray, bins: FloatArray, incoherent: FloatArray
) -> FloatArray:
    """Return the density that no linear model explains: noise, and incoherent response."""
    whole = spectra_of(test, test.responses)
    response = np.array([np.interp(bins, whole.frequency, row) for row in psd(whole)])
    found: FloatArray = np.maximum(noise, incoherent) + RELATIVE**2 * response
    return np.maximum(found, float(np.max(found)) * _NEGLIGIBLE or 1e-300)


def _noise(model: Model, test: PreparedTest, bins: FloatArray) -> FloatArray:
    """Return the noise of responses and input, the latter through the model."""
    noise = test.noise_density
    passed = np.abs(sensor_responses(model, bins)) ** 2 * noise.input_at(bins)
    return np.asarray(noise.responses_at(bins) + passed)


def _incoherent(test: PreparedTest, rows: FloatArray, bins: FloatArray) -> FloatArray:
    """Return the density of rows that is not coherent with the input of a test."""
    cross = spectra_of(test, np.concatenate([test.input[np.newaxis], rows]))
    power = psd(cross)
    coherent = np.abs(cross.matrix[0, 1:]) ** 2 / np.maximum(power[0], np.finfo(float).tiny)
    alone = np.maximum(0.0, power[1:] - coherent)
    return np.array([np.interp(bins, cross.frequency, row) for row in alone])


@final
@dataclass(frozen=True, slots=True, eq=False)
class LinearSolution:
    """Least squares of the linear fit.

    Attributes
    ----------
    values : (n,) array
        The unknowns.
    chi_square : float
        Of the data, without the priors [-].
    covariance : (n, n) array
        Of the unknowns, priors included.
    """

    values: FloatArray
    chi_square: float
    covariance: FloatArray


def solve(
    tests: Sequence[LinearTest],
    parameters: LinearParameters,
    start: FloatArray,
    more: Sequence[FloatArray],
    free: NDArray[np.bool_] | None = None,
) -> LinearSolution:
    """Return the unknowns of least squares, from a start (Levenberg-Marquardt).

    Parameters
    ----------
    more : sequence of (n_sensors, n_bins) array
        Densities that are added to those of the tests, relative to them [-].
    free : (n,) array of bool, optional
        Which unknowns move; by default all.
    """
    share = [1.0 / np.sqrt(1.0 + extra) for extra in more]
    moving = np.flatnonzero(np.ones(start.size, bool) if free is None else free)

    def residuals(values: FloatArray) -> FloatArray:
        found = [
            (part * test.residual(parameters, values)).ravel()
            for test, part in zip(tests, share, strict=True)
        ]
        both = np.concatenate(found)
        return np.concatenate([both.real, both.imag, values / parameters.spreads])

    def slopes_at(values: FloatArray, left: FloatArray) -> FloatArray:
        steps = np.diag([c.step for c in parameters.coordinates])[moving]
        columns = [(residuals(values + step) - left) / np.max(step) for step in steps]
        return np.column_stack(columns) if columns else np.zeros((left.size, 0))

    values, left = start, residuals(start)
    slopes, damping = slopes_at(values, left), 1e-3
    largest = 3.0 * parameters.spreads[moving]
    for _ in range(_ROUNDS):
        before = float(left @ left)
        while damping < _STIFFEST:
            move = _damped(slopes, left, damping)
            trial = values.copy()
            trial[moving] -= np.clip(move, -largest, largest)
            found = residuals(trial)
            if float(found @ found) <= before:
                values, left, damping = trial, found, max(1e-9, 0.1 * damping)
                break
            damping *= 10.0
        if before - float(left @ left) <= _DONE * before:
            break
        slopes = slopes_at(values, left)
    n = parameters.spreads.size
    covariance = np.zeros((n, n))
    covariance[np.ix_(moving, moving)] = np.linalg.pinv(slopes.T @ slopes)
    return LinearSolution(values, float(left[:-n] @ left[:-n]), covariance)


def _damped(slopes: FloatArray, left: FloatArray, damping: float) -> FloatArray:
    """Return the step of Levenberg and Marquardt, to be subtracted."""
    normal = slopes.T @ slopes
    scaled = normal + damping * np.diag(np.diag(normal))
    return np.asarray(np.linalg.solve(scaled, slopes.T @ left))


def misfit(test: LinearTest, parameters: LinearParameters, values: FloatArray) -> FloatArray:
    """Return the residual beyond noise over it, smoothed, (n_sensors, n_bins) array [-].

    The median of a third octave over that of an exponential distribution, so that a narrow mode
    does not count.
    """
    power = 0.5 * np.abs(test.residual(parameters, values)) ** 2
    band = np.floor(_PER_OCTAVE * np.log2(test.bins / test.bins[0])).astype(int)
    found = np.zeros_like(power)
    for k in range(band.max() + 1):
        inside = band == k
        if inside.any():
            middle = np.median(power[:, inside], axis=1, keepdims=True) / np.log(2.0)
            found[:, inside] = np.where(middle > NOISE_KNOWN, middle - 1.0, 0.0)
    return found
