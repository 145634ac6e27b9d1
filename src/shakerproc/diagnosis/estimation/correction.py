"""Tests corrected by what is unusual of the chain of measurement: gains, delays, weights."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.comparison.measured import UNCALIBRATED
from shakerproc.comparison.own import at_samples
from shakerproc.data import FloatArray
from shakerproc.diagnosis.data import PreparedTest
from shakerproc.diagnosis.data.sensor_faults import Hum, hum_in
from shakerproc.diagnosis.estimation.columns import DELAY_SPREAD
from shakerproc.diagnosis.estimation.linear import (
    LINEAR_ENOUGH,
    UNUSUAL,
    fit_linear,
    signs_and_delays,
)
from shakerproc.diagnosis.estimation.linear_model import MUCH_LESS, LinearModel
from shakerproc.diagnosis.hypotheses.hypothesis import FARTHEST
from shakerproc.models import Model
from shakerproc.simulation import Runs, free_runs
from shakerproc.simulation.inputs import prepare_measured


def applied_gain(linear: LinearModel) -> FloatArray:
    """Return the gain by which each response was divided, (n_sensors,) array [-]."""
    gains = linear.chain.gains
    return np.where(np.abs(gains - 1.0) > UNUSUAL * UNCALIBRATED, gains, 1.0)


def applied_delay(linear: LinearModel) -> FloatArray:
    """Return the delay by which each response was advanced, (n_sensors,) array [s]."""
    delays = linear.chain.delays
    return np.where(np.abs(delays) > UNUSUAL * DELAY_SPREAD, delays, 0.0)


def is_unusual(linear: LinearModel) -> bool:
    """Return whether a number of the chain of measurement is not what its prior expects."""
    return bool(linear.unusual)


def explains(linear: LinearModel) -> bool:
    """Return whether the linear model leaves little of every test, whatever it may be.

    It is that of the file, with stiffness and damping that may still be meant.
    """
    meant = all(abs(number.value) <= np.log(FARTHEST) for number in linear.own)
    return meant and max(linear.left.values()) < LINEAR_ENOUGH


def corrected(tests: Sequence[PreparedTest], linear: LinearModel) -> tuple[PreparedTest, ...]:
    """Return tests as they would be without what is unusual of their chain of measurement.

    What is usual stays, to be estimated with the physics: a strong effect passes for a small
    gain or delay as long as it is not known.
    """
    gain, delay = applied_gain(linear), applied_delay(linear)
    out = []
    for test in tests:
        responses = test.responses / gain[:, None]
        if np.any(delay):
            responses = advanced(responses, delay, test.sample_rate)
        out.append(replace(test, input=linear.input_of(test), responses=responses))
    return tuple(out)


def turned_and_late(
    model: Model, tests: Sequence[PreparedTest]
) -> tuple[FloatArray, FloatArray]:
    """Return the sign of each sensor [-] and its delay [s] where that is large.

    A sensor is late if the model with all its linear numbers fitted leaves half of the power
    then that it leaves of the samples as they are: damping that is off passes for a delay of
    a short test, too. What is left of a delay is small, and fitted along the slope in time.

    Parameters
    ----------
    model : Model
        The prior.
    tests : sequence of PreparedTest
        As recorded.
    """
    signs, late = signs_and_delays(model, tests)
    if np.any(late):
        in_time = fit_linear(model, turned(tests, signs, late))
        as_recorded = fit_linear(model, turned(tests, signs, np.zeros_like(late)))
        told = _power_left(in_time) < MUCH_LESS * _power_left(as_recorded)
        late = np.where(late != 0.0, told * (late + in_time.chain.delays), 0.0)
    return signs, late


def _power_left(linear: LinearModel) -> float:
    """Return the mean square of what a linear model leaves of each test [-]."""
    return float(np.mean(np.square(list(linear.left.values()))))


def turned(
    tests: Sequence[PreparedTest], signs: FloatArray, delay: FloatArray
) -> tuple[PreparedTest, ...]:
    """Return tests whose sensors are the right way round and in time.

    Parameters
    ----------
    tests : sequence of PreparedTest
        As recorded.
    signs : (n_sensors,) array
        -1 for those that are to be turned, else 1.
    delay : (n_sensors,) array
        By which each is late [s].
    """
    out = []
    for test in tests:
        rows = test.responses * signs[:, None]
        if np.any(delay):
            rows = advanced(rows, delay, test.sample_rate)
        out.append(replace(test, responses=rows))
    return tuple(out)


def residuals_of(linear: LinearModel, tests: Sequence[PreparedTest]) -> list[FloatArray]:
    """Return the residuals of the linear model in every test, (n_sensors, n) arrays."""
    out = []
    for test in tests:
        whole = np.array([(0, 0, test.n_samples)])
        given = prepare_measured(linear.input_of(test), test.sample_rate, imposed=False)
        found = free_runs(linear.model.under(test.conditions), Runs((given,), whole))
        outputs = at_samples(linear.model, found.outputs[0])
        out.append(test.responses - linear.recorded(outputs, test.sample_rate))
    return out


def without_driven(
    tests: Sequence[PreparedTest], linear: LinearModel
) -> tuple[PreparedTest, ...]:
    """Return tests without what further modes add that the drive alone excites.

    At every level it is the same: what a joint does excites them little.
    """
    if not linear.driven:
        return tuple(tests)
    return tuple(
        replace(test, responses=test.responses - linear.answers(test)) for test in tests
    )


def without_hum(
    tests: Sequence[PreparedTest], residuals: Sequence[FloatArray], hums: Sequence[Hum]
) -> tuple[PreparedTest, ...]:
    """Return tests without the hum of their sensors, told from what the linear model leaves."""
    out = []
    for test, left in zip(tests, residuals, strict=True):
        responses = test.responses.copy()
        for hum in hums:
            responses[hum.sensor] -= hum_in(left[hum.sensor], test.sample_rate, hum.frequency)
        out.append(replace(test, responses=responses))
    return tuple(out)


def advanced(rows: FloatArray, delay: FloatArray, sample_rate: float) -> FloatArray:
    """Return rows moved to earlier times, each by its own delay [s], by their spectra."""
    n = rows.shape[1]
    length = scipy.fft.next_fast_len(2 * n, real=True)
    frequency = scipy.fft.rfftfreq(length, 1.0 / sample_rate)
    turn = np.exp(2j * np.pi * frequency * delay[:, None])
    moved: FloatArray = scipy.fft.irfft(scipy.fft.rfft(rows, length) * turn, length)[:, :n]
    return moved
