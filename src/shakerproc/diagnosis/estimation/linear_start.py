"""Where the linear fit starts: a factor on all stiffnesses, delays and signs of the sensors."""

from collections.abc import Sequence
from typing import Final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.linear_parameters import LinearParameters
from shakerproc.diagnosis.estimation.linear_problem import LinearTest

_SCAN: Final = tuple(np.linspace(-0.6, 0.6, 49))  # of the logarithm of all stiffnesses
_LATEST: Final = 0.02  # largest delay that is sought [s]
_PER_PERIOD: Final = 8.0  # delays that are tried in a period of the highest frequency
_MUCH_LESS: Final = 0.5  # share of what is left that a large delay may leave


def scanned(tests: Sequence[LinearTest], parameters: LinearParameters) -> FloatArray:
    """Return the best common factor on all stiffnesses, and delays where they explain most.

    A resonance that is off, or a channel that is late by more than a part of a period, has no
    slopes that lead there.
    """
    stiff = np.array([c.unit == "N/m" for c in parameters.coordinates])
    late = np.array([c.unit == "s" for c in parameters.coordinates])
    plain = [np.where(stiff, factor, 0.0) for factor in _SCAN]
    shifted = []
    for values in plain:
        moved = values.copy()
        moved[late] = _delays(tests, parameters, values)
        shifted.append(moved)
    best, other = (
        min((float(_left(tests, parameters, v, 1.0).sum()), i) for i, v in enumerate(own))
        for own in (plain, shifted)
    )
    return shifted[other[1]] if other[0] < _MUCH_LESS * best[0] else plain[best[1]]


def signs_of(tests: Sequence[LinearTest], parameters: LinearParameters) -> FloatArray:
    """Return -1 for each sensor that is the wrong way round, else 1, (n_sensors,) array.

    It is where the linear model then leaves much less, whatever its stiffness and however
    late the sensor may be.
    """
    stiff = np.array([c.unit == "N/m" for c in parameters.coordinates])
    late = np.array([c.unit == "s" for c in parameters.coordinates])
    right, wrong = [], []
    for factor in _SCAN:
        values = np.where(stiff, factor, 0.0)
        right.append(_left(tests, parameters, values, 1.0))
        wrong.append(_left(tests, parameters, values, -1.0))
        values[late] = _delays(tests, parameters, values)
        right.append(_left(tests, parameters, values, 1.0))
    turned = np.min(wrong, axis=0) < _MUCH_LESS * np.min(right, axis=0)
    return np.where(turned, -1.0, 1.0)


def _left(
    tests: Sequence[LinearTest], parameters: LinearParameters, values: FloatArray, sign: float
) -> FloatArray:
    """Return what is left, large residuals counted by their logarithm, (n_sensors,) [-]."""
    total = np.zeros(len(parameters.model.sensors))
    for test in tests:
        left = test.whitened(sign * test.test.responses - test.simulated(parameters, values))
        total += np.sum(np.log1p(np.abs(left) ** 2 / test.density), axis=1)
    return total


def _delays(
    tests: Sequence[LinearTest], parameters: LinearParameters, values: FloatArray
) -> FloatArray:
    """Return the delay at which each sensor is most like its simulation, (n_sensors,) [s]."""
    steps = 1.0 / (_PER_PERIOD * max(float(test.bins[-1]) for test in tests))
    delays = np.arange(-_LATEST, _LATEST + steps, steps)
    alike = np.zeros((len(parameters.model.sensors), delays.size))
    for test in tests:
        rows = (test.simulated(parameters, values), test.test.responses)
        simulated, measured = (test.whitened(row) for row in rows)
        step = float(test.bins[1] - test.bins[0])
        size = scipy.fft.next_fast_len(round(_PER_PERIOD * test.bins[-1] / step), real=True)
        product = np.zeros((len(alike), size // 2 + 1), complex)
        first = round(float(test.bins[0]) / step)
        product[:, first : first + test.bins.size] = np.conj(simulated) * measured
        found = scipy.fft.irfft(product, size)
        alike += found[:, np.round(delays * step * size).astype(int) % size]
    return np.asarray(delays[np.argmax(alike, axis=1)])
