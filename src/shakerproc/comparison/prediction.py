"""What the model says each sensor should have measured."""

from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.comparison.free_bodies import mean_force
from shakerproc.comparison.free_run_error import Scored, in_band
from shakerproc.comparison.measured import Measured
from shakerproc.comparison.windows import (
    RUN_IN_PERIODS,
    Windows,
    horizon_of,
    period_of_response,
    run_windows,
    windows_of,
)
from shakerproc.data import FloatArray
from shakerproc.errors import SimulationError
from shakerproc.models import Model
from shakerproc.models.effects.base import AbstractEffect
from shakerproc.simulation import Input, Runs, SimulatedResponse, free_runs, simulate
from shakerproc.simulation.inputs import prepare_like, prepare_measured

LINEAR: Final = frozenset({"spring", "damper"})
"""Effects in whose company a disturbance dies out."""

TOLERANCE: Final = 1e-9
"""Of a simulation that is compared with a measurement, as a share of the motion [-]."""

DRAWS: Final = 8
"""How often noise of the input is drawn: a contact that is just missed counts once in a while,
and single draws of it differ by a factor of three [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Prediction:
    """A test and its simulation.

    Attributes
    ----------
    measured : Measured
        The test.
    simulation : SimulatedResponse
        The motion of the model under the measured input, from rest.
    scored : Scored
        The samples of which the free-run error is taken.
    moved : (n_draws, n_sensors, n) array
        By how much the simulated samples move under as much noise again as the input holds,
        drawn afresh each time [unit of the sensor].
    response, predicted : (n_sensors, n) array
        What the sensors measured and what the model says, n the judged samples, within the
        compared band [unit of the sensor].
    input : (n,) array
        The input within the compared band [m/s^2 or N].
    windows : Windows, optional
        Where the motion cannot be predicted as a whole.
    """

    measured: Measured
    simulation: SimulatedResponse
    scored: Scored
    moved: FloatArray
    response: FloatArray
    predicted: FloatArray
    input: FloatArray
    windows: Windows | None = None

    @property
    def residual(self) -> FloatArray:
        """What was measured less what is predicted, (n_sensors, n) array.

        Of windows, where the motion is predicted in windows.
        """
        if self.windows is None:
            return self.response - self.predicted
        inside = np.any(self.scored.simulated != 0.0, axis=0)
        left = np.where(inside, self.scored.measured - self.scored.simulated, 0.0)
        part = slice(self.measured.start, self.measured.stop)
        return within(left, self.measured)[:, part]

    @property
    def predictable(self) -> bool:
        """Whether the motion is predictable for the whole test."""
        return self.windows is None

    @property
    def horizon_s(self) -> float | None:
        """Length of the windows, where the motion is predicted in windows [s]."""
        if self.windows is None:
            return None
        return self.windows.n_samples / self.measured.sample_rate


def predict(model: Model, measured: Measured, *, windows: Windows | None = None) -> Prediction:
    """Return the response of the model to the input of a test.

    Parameters
    ----------
    model : Model
        What is shaken.
    measured : Measured
        The test.
    windows : Windows, optional
        Windows of another model of the same test, so that both are scored alike; by default
        those in which the motion of this one is predictable.

    Raises
    ------
    SimulationError
        If the motion runs away; the message opens with the run.
    """
    given = _given(model, measured)
    try:
        simulation = simulate(model, given, growth=not _is_stable(model), tolerance=TOLERANCE)
    except SimulationError as error:
        raise SimulationError(f"{measured.run}: {error}") from error
    if windows is None and simulation.sensitive:
        windows = _windows(model, measured, given, simulation)
    scored, moved = _scored(model, measured, given, windows, _sizes(simulation))
    part = slice(measured.start, measured.stop)
    outputs = np.array([simulation.outputs[name] for name in measured.sensors])
    return Prediction(
        measured=measured,
        simulation=_only_sensed(simulation, model),
        scored=scored,
        moved=moved,
        response=within(measured.responses, measured)[:, part],
        predicted=within(outputs, measured)[:, part],
        input=within(measured.input, measured)[part],
        windows=windows,
    )


def _given(model: Model, measured: Measured) -> Input:
    """Return the input of a model in a test."""
    imposed = model.excitation.imposed
    return prepare_measured(_drive(model, measured), measured.sample_rate, imposed=imposed)


def _drive(model: Model, measured: Measured) -> FloatArray:
    return measured.input + mean_force(model, measured)


def free_run(model: Model, measured: Measured) -> Scored:
    """Return a test simulated from rest as a whole, however a disturbance may grow.

    Raises
    ------
    SimulationError
        If the motion runs away; the message opens with the run.
    """
    given = _given(model, measured)
    simulated, failed = _from_rest(model, given)
    if failed:
        raise SimulationError(f"{measured.run}: the motion of {model.title} runs away.")
    return _of_whole(measured, simulated)


def _of_whole(measured: Measured, simulated: FloatArray) -> Scored:
    counted = np.zeros(simulated.shape[1], bool)
    counted[measured.start : measured.stop] = True
    return Scored(
        measured.responses, simulated, measured.sample_rate, measured.error_band, counted
    )


def _from_rest(model: Model, given: Input) -> tuple[FloatArray, bool]:
    """Return what the sensors record, at the samples, and whether the motion ran away."""
    whole = np.array([(0, 0, given.n_samples)])
    found = free_runs(model, Runs((given,), whole))
    return at_samples(model, found.outputs[0]), bool(found.failed[0])


def _scored(
    model: Model,
    measured: Measured,
    given: Input,
    windows: Windows | None,
    sizes: FloatArray,
) -> tuple[Scored, FloatArray]:
    """Return the scored samples, and how the simulated ones move under noise of the input."""
    noisy = _noisy(model, measured, given)
    if windows is None:
        simulated, _ = _from_rest(model, given)
        runs = [_from_rest(model, one) for one in noisy]
        moved = [
            np.zeros_like(other) if failed else other - simulated for other, failed in runs
        ]
        return _of_whole(measured, simulated), np.array(moved)
    means = as_means(model, measured.responses)
    simulated, *others = (
        at_samples(model, run_windows(model, one, means, windows, sizes))
        for one in (given, noisy[0])
    )
    scored = replace(
        _of_whole(measured, simulated), counted=windows.counted(simulated.shape[1])
    )
    return scored, np.array(others) - simulated


def _noisy(model: Model, measured: Measured, given: Input) -> list[Input]:
    """Return the input of a test with as much noise again, drawn afresh each time.

    A stable linear model moves alike under every draw, so one of them will do.
    """
    generator = np.random.default_rng(0)
    count = 1 if _is_stable(model) else DRAWS
    n, rate = measured.input.size, measured.sample_rate
    draws = [measured.noise.drawn(n, rate, generator) for _ in range(count)]
    drive = _drive(model, measured)
    return [prepare_like(drive + draw, given) for draw in draws]


def _sizes(simulation: SimulatedResponse) -> FloatArray:
    """Return the usual size of every motion, in the order of `motions_of` [SI]."""
    sizes: FloatArray = np.sqrt(np.mean(simulation.motion**2, axis=1))
    return sizes


def _is_stable(model: Model) -> bool:
    """Return whether a model is linear and passive: a disturbance dies out whatever drives."""
    effects = [element.effect for element in model.elements]
    return all(
        type(effect).kind in LINEAR and all(value > 0.0 for value in _numbers(effect))
        for effect in effects
    )


def _numbers(effect: AbstractEffect) -> list[float]:
    values = [getattr(effect, name) for name in effect.parameters]
    return [value for value in values if value is not None]


def _only_sensed(simulation: SimulatedResponse, model: Model) -> SimulatedResponse:
    """Return a simulation without the motion of masses on which no sensor sits."""
    seen = {sensor.at for sensor in model.sensors.values()}
    kept = [i for i, mass in enumerate(simulation.masses) if mass in seen]
    return replace(
        simulation,
        masses=tuple(simulation.masses[i] for i in kept),
        displacement=simulation.displacement[kept],
        velocity=simulation.velocity[kept],
        acceleration=simulation.acceleration[kept],
        motion=np.zeros((0, 0)),
    )


def _windows(
    model: Model, measured: Measured, given: Input, simulation: SimulatedResponse
) -> Windows:
    """Return the windows in which the motion of a model is predictable."""
    horizon = horizon_of(model, given, simulation.motion, measured.start)
    period = period_of_response(
        measured.responses[:, measured.start : measured.stop], measured.sample_rate,
        measured.excited,
    )  # fmt: skip
    run_in = round(RUN_IN_PERIODS * period * measured.sample_rate)
    return windows_of(measured.start, measured.stop, horizon, run_in)


def at_samples(model: Model, outputs: FloatArray) -> FloatArray:
    r"""Return accelerations at the samples from means over the interval to the next.

    A mean does not alias where the acceleration jumps. Of a band-limited signal it is
    :math:`\mathrm{sinc}(f / f_s)\, e^{i \pi f / f_s}` times its spectrum, which is undone
    here, so that what was measured is left as it is. Rows of other quantities are returned
    unchanged.

    Parameters
    ----------
    model : Model
        Says what each sensor measures.
    outputs : (n_sensors, n) array
        What `free_runs` returns [SI].
    """
    return _boxed(model, outputs, -1)


def as_means(model: Model, samples: FloatArray) -> FloatArray:
    """Return what `at_samples` undoes: accelerations as means over the next interval [SI]."""
    return _boxed(model, samples, 1)


def _boxed(model: Model, rows: FloatArray, power: int) -> FloatArray:
    n = rows.shape[1]
    length = scipy.fft.next_fast_len(n + 2048, real=True)
    share = scipy.fft.rfftfreq(length, 1.0)
    box = (np.sinc(share) * np.exp(1j * np.pi * share)) ** power
    found = rows.copy()
    for i, sensor in enumerate(model.sensors.values()):
        if sensor.measures == "acceleration":
            found[i] = scipy.fft.irfft(scipy.fft.rfft(rows[i], length) * box, length)[:n]
    return found


def within(samples: FloatArray, measured: Measured) -> FloatArray:
    """Return samples within the compared band, along the last axis, an array like them.

    `samples` may be in any unit.
    """
    return in_band(samples, measured.sample_rate, measured.band)
