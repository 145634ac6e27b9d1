"""Result of a simulation, and the signals of the sensors of a model in it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models.model import BASE, Measures, Model, Sensor
from shakerproc.simulation.pieces import InterpolationError

SENSITIVE_GROWTH: Final = 1e4
"""Past it no measured input is known well enough to predict the motion in time [-]."""

CHAOTIC_GROWTH: Final = 1e8
"""A disturbance of 1e-10 that grows more than this becomes a hundredth of the motion [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class SimulatedResponse:
    """The response of a model, and how far it can be trusted.

    Attributes
    ----------
    sample_rate : float
        Samples per second [Hz].
    outputs : mapping of str to (n,) array
        What each sensor of the model records, by its name, faults and all, in SI units.
    excitation : (n,) array
        The input at the samples: acceleration of the base [m/s^2], force [N] or imposed
        displacement [m].
    masses : tuple of str
        What moves, in the order of the rows below: masses, attached and further modes, points
        of structures.
    displacement, velocity : (n_masses, n) array
        Motion relative to the base [m], [m/s].
    acceleration : (n_masses, n) array
        Absolute acceleration [m/s^2].
    states : (n_states, n) array
        Memory of the laws that have any, in the order of the elements.
    solver : str
        How it was computed.
    switchings : int
        Changes of branch: contacts made or lost, joints that stuck or slid.
    error : float
        Estimated error of displacement, as a share of the largest; truncation of the series,
        rounding and the interpolation of a sampled input, times the growth where that is
        known [-].
    growth : float, optional
        What a disturbance of 1e-10, of the start and of the input all along, made of the
        motion, as a multiple of 1e-10 of the largest; None where it was not asked for [-].
    notes : tuple of str
        What the reader should know, a sentence each.
    interpolation : InterpolationError, optional
        How far a sampled input may be from the band-limited signal through its samples.
    force : (n,) array, optional
        What imposes the displacement of a mass, where one is imposed [N].
    motion : (n_motions, n) array
        Displacements [m], velocities [m/s] and states as the model is carried by, in the order
        of `motions_of`; without rows where they were not kept.
    """

    sample_rate: float
    outputs: Mapping[str, FloatArray]
    excitation: FloatArray
    masses: tuple[str, ...]
    displacement: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    states: FloatArray
    solver: str
    switchings: int
    error: float
    growth: float | None
    notes: tuple[str, ...] = ()
    interpolation: InterpolationError | None = None
    force: FloatArray | None = None
    motion: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))

    @property
    def time(self) -> FloatArray:
        """Times of the samples, (n,) array [s]."""
        return np.arange(self.excitation.size) / self.sample_rate

    @property
    def sensitive(self) -> bool:
        """Whether the motion cannot be predicted in time from a measured input."""
        return self.growth is not None and self.growth > SENSITIVE_GROWTH

    @property
    def chaotic(self) -> bool:
        """Whether a disturbance grew so much that only statistics of the response hold.

        Growth in passing, as at the jump of a sweep or after the last contact, stays below:
        it costs digits, which `error` counts, but not the trajectory.
        """
        return self.growth is not None and self.growth > CHAOTIC_GROWTH

    def relative_displacement(self, first: str, second: str) -> FloatArray:
        """Return the displacement of the second place minus that of the first [m]."""
        return self._of(self.displacement, second) - self._of(self.displacement, first)

    def relative_velocity(self, first: str, second: str) -> FloatArray:
        """Return the velocity of the second place minus that of the first [m/s]."""
        return self._of(self.velocity, second) - self._of(self.velocity, first)

    def _of(self, rows: FloatArray, place: str) -> FloatArray:
        if place == BASE:
            return np.zeros(rows.shape[1])
        row: FloatArray = rows[self.masses.index(place)]
        return row


def read_sensors(
    model: Model, simulation: SimulatedResponse, pieces: FloatArray, stride: int
) -> SimulatedResponse:
    """Return the simulation with the signal of each sensor, its faults included.

    Parameters
    ----------
    pieces : (n_pieces, degree + 1) array
        The input over each part of a sample, of which there are `stride`; integrated twice
        from rest, it is the motion of the base where that is what is driven [m/s², N or m].
    """
    wanted = {sensor.measures for sensor in model.sensors.values()}
    base = _Base(simulation.excitation, model.excitation.moves_base, None, None)
    if base.driven and wanted & {"displacement", "velocity"}:
        velocity, displacement = integrated(pieces, stride, simulation.sample_rate)
        base = replace(base, velocity=velocity, displacement=displacement)
    outputs = {
        name: _recorded(sensor, simulation, base) for name, sensor in model.sensors.items()
    }
    return replace(simulation, outputs=MappingProxyType(outputs))


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Base:
    """Motion of the base; displacement and velocity only where they are needed."""

    excitation: FloatArray
    driven: bool
    velocity: FloatArray | None
    displacement: FloatArray | None

    def add(self, own: FloatArray | None, relative: FloatArray) -> FloatArray:
        return relative if own is None else relative + own


def _recorded(sensor: Sensor, simulation: SimulatedResponse, base: _Base) -> FloatArray:
    samples = _MEASURED[sensor.measures](sensor.at, simulation, base)
    for fault in sensor.faults:
        samples = fault.apply(samples, simulation.sample_rate)
    return samples


def _acceleration(at: str, simulation: SimulatedResponse, base: _Base) -> FloatArray:
    if at == BASE:
        return base.excitation if base.driven else np.zeros_like(base.excitation)
    row: FloatArray = simulation.acceleration[simulation.masses.index(at)]
    return row


def _displacement(at: str, simulation: SimulatedResponse, base: _Base) -> FloatArray:
    return base.add(base.displacement, simulation.relative_displacement(BASE, at))


def _velocity(at: str, simulation: SimulatedResponse, base: _Base) -> FloatArray:
    return base.add(base.velocity, simulation.relative_velocity(BASE, at))


def _relative_displacement(at: str, simulation: SimulatedResponse, base: _Base) -> FloatArray:  # noqa: ARG001
    return simulation.relative_displacement(BASE, at)


def _relative_velocity(at: str, simulation: SimulatedResponse, base: _Base) -> FloatArray:  # noqa: ARG001
    return simulation.relative_velocity(BASE, at)


def _force(at: str, simulation: SimulatedResponse, base: _Base) -> FloatArray:  # noqa: ARG001
    if simulation.force is None:
        raise ValueError("a force is measured where the displacement is imposed")
    return simulation.force


_MEASURED: Mapping[Measures, Callable[[str, SimulatedResponse, _Base], FloatArray]] = (
    MappingProxyType({
        "acceleration": _acceleration,
        "displacement": _displacement,
        "velocity": _velocity,
        "relative displacement": _relative_displacement,
        "relative velocity": _relative_velocity,
        "force": _force,
    })
)


def integrated(
    pieces: FloatArray, stride: int, sample_rate: float
) -> tuple[FloatArray, FloatArray]:
    """Return velocity and displacement of a base that starts at rest, at the samples.

    `pieces` are in [m/s²], `sample_rate` in [Hz].
    """
    step = 1.0 / (sample_rate * stride)
    k = np.arange(pieces.shape[1])
    velocity = step * np.concatenate(([0.0], np.cumsum(pieces @ (1.0 / (k + 1)))))
    by_acceleration = step**2 * (pieces @ (1.0 / ((k + 1) * (k + 2))))
    displacement = np.concatenate(([0.0], np.cumsum(step * velocity[:-1] + by_acceleration)))
    return velocity[::stride], displacement[::stride]
