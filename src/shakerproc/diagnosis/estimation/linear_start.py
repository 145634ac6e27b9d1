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
_PER_PERIOD: Final = 32.0  # delays that are tried in a period of the highest frequency
_MUCH_LESS: Final = 0.5  # share of what is left that a large delay may leave


def scanned(tests: Sequence[LinearTest], parameters: LinearParameters) -> FloatArray:
    """Return the best common factor on all stiffnesses: a resonance off has no slopes."""
    return min(
        _stiffened(parameters), key=lambda v: float(_left(tests, parameters, v, 1.0).sum())
    )


def wrong_way_and_late(
    tests: Sequence[LinearTest], parameters: LinearParameters
) -> tuple[FloatArray, FloatArray]:
    """Return the sign of each sensor and a large delay, each an (n_sensors,) array [-], [s].

    A sensor is turned or late where the linear model then leaves much less, whatever its
    stiffness; a channel that is late by a part of a period has no slopes that lead there.
    """
    late = np.array([c.unit == "s" for c in parameters.coordinates])
    right, wrong, shifted, delays = [], [], [], []
    for values in _stiffened(parameters):
        right.append(_left(tests, parameters, values, 1.0))
        wrong.append(_left(tests, parameters, values, -1.0))
        delays.append(_delays(tests, parameters, values))
        moved = values.copy()
        moved[late] = delays[-1]
        shifted.append(_left(tests, parameters, moved, 1.0))
    best = np.argmin(shifted, axis=0)
    least = np.min(shifted, axis=0)
    is_late = least < _MUCH_LESS * np.minimum(np.min(right, axis=0), np.min(wrong, axis=0))
    is_turned = np.min(wrong, axis=0) < _MUCH_LESS * np.minimum(np.min(right, axis=0), least)
    delay = np.array([delays[k][i] for i, k in enumerate(best)])
    return np.where(is_turned, -1.0, 1.0), np.where(is_late, delay, 0.0)


def _stiffened(parameters: LinearParameters) -> list[FloatArray]:
    stiff = np.array([c.unit == "N/m" for c in parameters.coordinates])
    return [np.where(stiff, factor, 0.0) for factor in _SCAN]


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
    return np.array([_top(delays, row) for row in alike])


def _top(places: FloatArray, row: FloatArray) -> float:
    """Return where the parabola through the largest value and its neighbours is largest."""
    k = int(np.clip(np.argmax(row), 1, row.size - 2))
    before, at, after = row[k - 1 : k + 2]
    bend = before - 2.0 * at + after
    shift = 0.5 * (before - after) / bend if bend < 0.0 else 0.0
    return float(places[k] + np.clip(shift, -1.0, 1.0) * (places[1] - places[0]))
