"""Prediction of a model for each sensor of a test."""

from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from shakerproc.comparison.free_run_error import Scored, in_band
from shakerproc.comparison.measured import Measured
from shakerproc.comparison.own import (
    TOLERANCE,
    Own,
    as_means,
    at_samples,
    own_of,
    run,
    scored_whole,
)
from shakerproc.comparison.windows import (
    RUN_IN_PERIODS,
    EvenWindows,
    horizon_of,
    period_of_response,
    run_windows,
    windows_of,
)
from shakerproc.data import FloatArray
from shakerproc.errors import SimulationError
from shakerproc.models import Model
from shakerproc.models.effects.base import AbstractEffect
from shakerproc.simulation import Input, SimulatedResponse, motions_of, simulate
from shakerproc.simulation.inputs import prepare_like

LINEAR: Final = frozenset({"spring", "damper"})
"""Effects in whose company a disturbance dies out."""

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
        The motion of the model under the measured input.
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
    windows : EvenWindows, optional
        Where the motion cannot be predicted as a whole.
    """

    measured: Measured
    simulation: SimulatedResponse
    scored: Scored
    moved: FloatArray
    response: FloatArray
    predicted: FloatArray
    input: FloatArray
    own: Own
    windows: EvenWindows | None = None

    @property
    def residual(self) -> FloatArray:
        """Measured less predicted signals, (n_sensors, n) array.

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


def predict(
    model: Model, measured: Measured, *, windows: EvenWindows | None = None
) -> Prediction:
    """Return the response of the model to the input of a test.

    Parameters
    ----------
    model : Model
        What is shaken.
    measured : Measured
        The test.
    windows : EvenWindows, optional
        Windows of another model of the same test, so that both are scored alike; by default
        those in which the motion of this one is predictable.

    Raises
    ------
    SimulationError
        If the motion runs away; the message opens with the run.
    """
    model = model.under(measured.conditions)
    own, given = own_of(model, measured)
    try:
        simulation = simulate(
            model, given, start=_start(model, own), growth=not _is_stable(model),
            tolerance=TOLERANCE, solver="quick",
        )  # fmt: skip
    except SimulationError as error:
        raise SimulationError(f"{measured.run}: {error}") from error
    if windows is None and simulation.sensitive:
        windows = _windows(model, measured, given, simulation)
    scored, moved = _scored(
        model, measured, own, given, windows=windows, sizes=_sizes(simulation)
    )
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
        own=own,
        windows=windows,
    )


def _start(model: Model, own: Own) -> dict[str, tuple[float, float]] | None:
    """Return the start of a test as `simulate` takes it; None is rest [m], [m/s]."""
    if own.start is None:
        return None
    names = [name[2:] for name in motions_of(model) if name.startswith("x ")]
    n = len(names)
    return {
        name: (float(x), float(v))
        for name, x, v in zip(names, own.start[:n], own.start[n : 2 * n], strict=True)
    }


def free_run(model: Model, measured: Measured, own: Own, given: Input) -> Scored:
    """Return a test simulated as a whole, however a disturbance may grow.

    `own` and `given` are the numbers of the test and its input with them (see `own_of`) [SI].

    Raises
    ------
    SimulationError
        If the motion runs away; the message opens with the run.
    """
    simulated, failed = run(model.under(measured.conditions), given, own)
    if failed:
        raise SimulationError(f"{measured.run}: the motion of {model.title} runs away.")
    return scored_whole(measured, simulated)


def _scored(
    model: Model,
    measured: Measured,
    own: Own,
    given: Input,
    *,
    windows: EvenWindows | None,
    sizes: FloatArray,
) -> tuple[Scored, FloatArray]:
    """Return the scored samples, and how the simulated ones move under noise of the input."""
    noisy = _noisy(model, measured, own, given)
    if windows is None:
        simulated, _ = run(model, given, own)
        runs = [run(model, one, own) for one in noisy]
        moved = [
            np.zeros_like(other) if failed else other - simulated for other, failed in runs
        ]
        return scored_whole(measured, simulated), np.array(moved)
    means = as_means(model, measured.responses)
    simulated, *others = (
        at_samples(model, run_windows(model, one, means, windows, sizes))
        for one in (given, noisy[0])
    )
    scored = replace(
        scored_whole(measured, simulated), counted=windows.counted(simulated.shape[1])
    )
    return scored, np.array(others) - simulated


def _noisy(model: Model, measured: Measured, own: Own, given: Input) -> list[Input]:
    """Return the input of a test with as much noise again, drawn afresh each time.

    A stable linear model moves alike under every draw, so one of them will do.
    """
    generator = np.random.default_rng(0)
    count = 1 if _is_stable(model) else DRAWS
    n, rate = measured.input.size, measured.sample_rate
    draws = [measured.noise.drawn(n, rate, generator) for _ in range(count)]
    return [prepare_like(measured.input + own.constant + draw, given) for draw in draws]


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
) -> EvenWindows:
    """Return the windows in which the motion of a model is predictable."""
    horizon = horizon_of(model, given, simulation.motion, measured.start)
    period = period_of_response(
        measured.responses[:, measured.start : measured.stop], measured.sample_rate,
        measured.excited,
    )  # fmt: skip
    run_in = round(RUN_IN_PERIODS * period * measured.sample_rate)
    return windows_of(measured.start, measured.stop, horizon, run_in)


def within(samples: FloatArray, measured: Measured) -> FloatArray:
    """Return samples within the compared band, along the last axis, an array like them.

    `samples` may be in any unit.
    """
    return in_band(samples, measured.sample_rate, measured.band)
