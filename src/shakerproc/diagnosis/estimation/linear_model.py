"""The linear model of tests: its numbers, and what it leaves."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.diagnosis.data import PreparedTest
from shakerproc.diagnosis.estimation.linear_parameters import Chain, LinearParameters
from shakerproc.diagnosis.estimation.linear_problem import LinearTest
from shakerproc.diagnosis.estimation.linear_response import DrivenMode
from shakerproc.models import Mode, Model


@final
@dataclass(frozen=True, slots=True)
class LinearNumber:
    """One number of the linear model.

    Attributes
    ----------
    name : str
        For people.
    unit : str
        SI unit of what it stands for.
    value, low, high : float
        Logarithm of a factor on the prior, or the number itself for delays and weights, with
        its 95 % interval.
    deviations : float
        Of the prior, by which it is off [-].
    """

    name: str
    unit: str
    value: float
    low: float
    high: float
    deviations: float


@final
@dataclass(frozen=True, slots=True, eq=False)
class LinearModel:
    """Linear model on top of which effects are judged.

    Attributes
    ----------
    model : Model
        With fitted stiffness and damping, and further modes.
    chain : Chain
        Gains, delays, weights of the controls.
    own : tuple of LinearNumber
        Stiffness and damping of the model's elements, with their intervals.
    numbers : tuple of LinearNumber
        Every unknown of the fit with its interval.
    left : mapping of str to float
        For each test the rms that the linear model leaves, over that measured, in its band [-].
    unusual : tuple of LinearNumber
        Numbers of the chain of measurement that their priors do not expect.
    driven : tuple of DrivenMode
        Further modes that the drive alone excites; the model has none of them.
    """

    model: Model
    chain: Chain
    own: tuple[LinearNumber, ...]
    numbers: tuple[LinearNumber, ...]
    left: dict[str, float]
    unusual: tuple[LinearNumber, ...]
    driven: tuple[DrivenMode, ...] = ()

    def answers(self, test: PreparedTest) -> FloatArray:
        """Return what the driven modes add to the responses of a test, an array like them."""
        n, rate = test.n_samples, test.sample_rate
        slowest = min(mode.damping_ratio * mode.frequency for mode in self.driven)
        length = scipy.fft.next_fast_len(n + int(min(rate / slowest, n)), real=True)
        frequency = scipy.fft.rfftfreq(length, 1.0 / rate)[1:]
        rows = sum(mode.responses(self.model, frequency) for mode in self.driven)
        spectrum = rows * self.chain.responses(frequency)
        spectrum = spectrum * scipy.fft.rfft(self.input_of(test), length)[1:]
        return np.asarray(scipy.fft.irfft(np.pad(spectrum, ((0, 0), (1, 0))), length)[:, :n])

    def with_mode(self, mode: Mode) -> "LinearModel":
        """Return the linear model with one more mode that was found since."""
        return replace(self, model=replace(self.model, modes=(*self.model.modes, mode)))

    def input_of(self, test: PreparedTest) -> FloatArray:
        """Return the excitation of the model in a test: its controls, weighted, (n,) array."""
        mean = test.arrays.controls.mean(axis=1, keepdims=True)
        return np.asarray(self.chain.weights @ (test.arrays.controls - mean))

    def recorded(self, outputs: FloatArray, sample_rate: float) -> FloatArray:
        """Return simulated signals after the chain of measurement, an array like them.

        Parameters
        ----------
        outputs : (n_sensors, n) array
            At the samples [SI].
        sample_rate : float
            Samples per second [Hz].
        """
        n = outputs.shape[1]
        frequency = np.asarray(np.fft.rfftfreq(2 * n, 1.0 / sample_rate), np.float64)
        spectrum = np.asarray(np.fft.rfft(outputs, 2 * n) * self.chain.responses(frequency))
        return np.asarray(np.fft.irfft(spectrum, 2 * n)[:, :n])


_SCAN: Final = tuple(np.linspace(-0.6, 0.6, 49))  # of the logarithm of all stiffnesses
_LATEST: Final = 0.02  # largest delay that is sought [s]
_PER_PERIOD: Final = 32.0  # delays that are tried in a period of the highest frequency
MUCH_LESS: Final = 0.5
"""Share of what is left without it that a sign or a large delay may leave [-]."""


def scanned(tests: Sequence[LinearTest], parameters: LinearParameters) -> FloatArray:
    """Return the best common factor on all stiffnesses: a resonance off has no slopes."""
    measured = [test.whitened(test.test.responses) for test in tests]
    tried = _stiffened(parameters)
    left = [
        _left(tests, measured, _simulated(tests, parameters, values)).sum() for values in tried
    ]
    return tried[int(np.argmin(left))]


def wrong_way_and_late(
    tests: Sequence[LinearTest], parameters: LinearParameters
) -> tuple[FloatArray, FloatArray]:
    """Return the sign of each sensor and a large delay, each an (n_sensors,) array [-], [s].

    A sensor is turned or late where the linear model then leaves much less, whatever its
    stiffness; a channel that is late by a part of a period has no slopes that lead there.
    """
    measured = [test.whitened(test.test.responses) for test in tests]
    turned = [-rows for rows in measured]
    right, wrong, shifted, delays = [], [], [], []
    for values in _stiffened(parameters):
        simulated = _simulated(tests, parameters, values)
        delay = _delays(tests, measured, simulated)
        late = [
            rows * np.exp(-2j * np.pi * test.bins * delay[:, None])
            for test, rows in zip(tests, simulated, strict=True)
        ]
        right.append(_left(tests, measured, simulated))
        wrong.append(_left(tests, turned, simulated))
        shifted.append(_left(tests, measured, late))
        delays.append(delay)
    best = np.argmin(shifted, axis=0)
    least = np.min(shifted, axis=0)
    is_late = least < MUCH_LESS * np.minimum(np.min(right, axis=0), np.min(wrong, axis=0))
    is_turned = np.min(wrong, axis=0) < MUCH_LESS * np.minimum(np.min(right, axis=0), least)
    found = np.array([delays[k][i] for i, k in enumerate(best)])
    return np.where(is_turned, -1.0, 1.0), np.where(is_late, found, 0.0)


def _stiffened(parameters: LinearParameters) -> list[FloatArray]:
    stiff = np.array([c.unit == "N/m" for c in parameters.coordinates])
    return [np.where(stiff, factor, 0.0) for factor in _SCAN]


def _simulated(
    tests: Sequence[LinearTest], parameters: LinearParameters, values: FloatArray
) -> list[ComplexArray]:
    """Return the whitened spectra of what the sensors show in each test."""
    return [test.whitened(test.simulated(parameters, values)) for test in tests]


def _left(
    tests: Sequence[LinearTest],
    measured: Sequence[ComplexArray],
    simulated: Sequence[ComplexArray],
) -> FloatArray:
    """Return the residual, large ones counted by their logarithm, (n_sensors,) [-]."""
    each = [
        np.sum(np.log1p(np.abs(one - other) ** 2 / test.density), axis=1)
        for test, one, other in zip(tests, measured, simulated, strict=True)
    ]
    return np.asarray(np.sum(each, axis=0))


def _delays(
    tests: Sequence[LinearTest],
    measured: Sequence[ComplexArray],
    simulated: Sequence[ComplexArray],
) -> FloatArray:
    """Return the delay at which each sensor is most like its simulation, (n_sensors,) [s].

    Frequencies that no delay sought tells apart count as one.
    """
    highest = max(float(test.bins[-1]) for test in tests)
    apart = 1.0 / (_PER_PERIOD * _LATEST)
    size = scipy.fft.next_fast_len(round(_PER_PERIOD * highest / apart), real=True)
    product = np.zeros((len(measured[0]), size // 2 + 1), complex)
    for test, one, other in zip(tests, measured, simulated, strict=True):
        place = np.round(test.bins / apart).astype(int)
        firsts = np.flatnonzero(np.diff(place, prepend=-1))
        product[:, place[firsts]] += np.add.reduceat(np.conj(other) * one, firsts, axis=1)
    alike = scipy.fft.irfft(product, size)
    step = 1.0 / (apart * size)
    delays = np.asarray(step * np.arange(-int(_LATEST / step), int(_LATEST / step) + 1.0))
    rows = alike[:, np.round(delays / step).astype(int) % size]
    return np.array([_top(delays, np.asarray(row)) for row in rows])


def _top(places: FloatArray, row: FloatArray) -> float:
    """Return where the parabola through the largest value and its neighbours is largest."""
    k = int(np.clip(np.argmax(row), 1, row.size - 2))
    before, at, after = row[k - 1 : k + 2]
    bend = before - 2.0 * at + after
    shift = 0.5 * (before - after) / bend if bend < 0.0 else 0.0
    return float(places[k] + np.clip(shift, -1.0, 1.0) * (places[1] - places[0]))
