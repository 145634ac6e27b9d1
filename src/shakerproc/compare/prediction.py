"""What the model says each sensor should have measured."""

from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.compare.measured import Measured
from shakerproc.data import ComplexArray, FloatArray
from shakerproc.errors import SimulationError
from shakerproc.models import Model
from shakerproc.models.effects.base import AbstractEffect
from shakerproc.simulate import Simulation, simulate

LINEAR: Final = frozenset({"spring", "damper"})
"""Effects whose response functions tell what becomes of noise."""
DRAWS: Final = 4
"""How often a model that is not linear is simulated with fresh noise."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Prediction:
    """A test and its simulation, both within the compared band.

    Attributes
    ----------
    measured : Measured
        The test.
    simulation : Simulation
        The motion of the model under the measured input.
    response, predicted : (n_sensors, n) array
        What the sensors measured and what the model says, n the judged samples, within the
        band [unit of the sensor].
    input : (n,) array
        The input within the band [m/s^2 or N].
    scatter : (n_sensors, n * DRAWS) array, optional
        By how much the prediction moves under as much noise again as the controls hold at
        rest, where the model is not linear: several draws of it, one after the other [unit of
        the sensor].
    """

    measured: Measured
    simulation: Simulation
    response: FloatArray
    predicted: FloatArray
    input: FloatArray
    scatter: FloatArray | None = None

    @property
    def residual(self) -> FloatArray:
        """What was measured less what is predicted, (n_sensors, n) array."""
        return self.response - self.predicted

    @property
    def predictable(self) -> bool:
        """Whether the motion can be compared in time, not only in statistics."""
        return not self.simulation.sensitive


def predict(model: Model, measured: Measured, *, growth: bool = True) -> Prediction:
    """Return the response of the model to the input of a test.

    Parameters
    ----------
    model : Model
        What is shaken.
    measured : Measured
        The test.
    growth : bool
        Whether to see how a disturbance grows, so that chaos is told; in a model of springs and
        dampers it dies out.

    Raises
    ------
    SimulationError
        If the motion runs away; the message opens with the run.
    """
    wanted = growth and not _is_stable(model)
    try:
        simulation = simulate(model, measured.input, measured.sample_rate, growth=wanted)
    except SimulationError as error:
        raise SimulationError(f"{measured.run}: {error}") from error
    part = slice(measured.start, measured.stop)
    outputs = np.array([simulation.outputs[name] for name in measured.sensors])
    scatter = None
    if growth and not simulation.sensitive:
        noisy = _under_noise(model, measured)
        if noisy:
            moved = [within(one - outputs, measured)[:, part] for one in noisy]
            scatter = np.concatenate(moved, axis=1)
    return Prediction(
        measured=measured,
        simulation=_only_sensed(simulation, model),
        response=within(measured.responses, measured)[:, part],
        predicted=within(outputs, measured)[:, part],
        input=within(measured.input, measured)[part],
        scatter=scatter,
    )


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


def _only_sensed(simulation: Simulation, model: Model) -> Simulation:
    """Return a simulation without the motion of masses on which no sensor sits."""
    seen = {sensor.at for sensor in model.sensors.values()} | {simulation.masses[0]}
    kept = [i for i, mass in enumerate(simulation.masses) if mass in seen]
    return replace(
        simulation,
        masses=tuple(simulation.masses[i] for i in kept),
        displacement=simulation.displacement[kept],
        velocity=simulation.velocity[kept],
        acceleration=simulation.acceleration[kept],
    )


def _under_noise(model: Model, measured: Measured) -> list[FloatArray]:
    """Return the sensors of a model that is not linear, under controls with fresh noise.

    What a contact makes of the controls' noise no response function tells, and one draw of it
    may do little: a contact just missed counts once in a while.
    """
    kinds = {type(element.effect).kind for element in model.elements}
    if measured.quiet is None or kinds <= LINEAR:
        return []
    sigma = float(np.std(np.mean(measured.quiet.controls, axis=0)))
    generator = np.random.default_rng(0)
    out = []
    for _ in range(DRAWS):
        noise = generator.normal(scale=sigma, size=measured.input.size)
        try:
            moved = simulate(model, measured.input + noise, measured.sample_rate, growth=False)
        except SimulationError:
            continue
        out.append(np.array([moved.outputs[name] for name in measured.sensors]))
    return out


def within(samples: FloatArray, measured: Measured) -> FloatArray:
    """Return samples within the compared band, along the last axis, an array like them."""
    n = samples.shape[-1]
    length = scipy.fft.next_fast_len(n + 2048, real=True)
    spectrum: ComplexArray = scipy.fft.rfft(samples, length)
    spectrum *= edges(scipy.fft.rfftfreq(length, 1.0 / measured.sample_rate), measured.band)
    kept: FloatArray = scipy.fft.irfft(spectrum, length)[..., :n]
    return kept


def edges(frequency: FloatArray, band: tuple[float, float]) -> FloatArray:
    """Return 1 within a band and 0 outside, with cosine flanks of a tenth of its limits.

    Parameters
    ----------
    frequency : (n_frequencies,) array
        Frequencies [Hz].
    band : (float, float)
        Limits, in the middle of the flanks [Hz].

    Returns
    -------
    (n_frequencies,) array
        Gain [-].
    """
    low, high = band
    rise = np.clip((frequency / low - 0.9) / 0.2, 0.0, 1.0)
    fall = np.clip((frequency / high - 0.9) / 0.2, 0.0, 1.0)
    gain: FloatArray = 0.25 * (1.0 - np.cos(np.pi * rise)) * (1.0 + np.cos(np.pi * fall))
    return gain
