"""Signals of the sensors of a model, from its motion."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models.model import BASE, Measures, Model, Sensor
from shakerproc.simulation.simulation import Simulation


def read_sensors(
    model: Model, simulation: Simulation, pieces: FloatArray, stride: int
) -> Simulation:
    """Return the simulation with what each sensor records, faults and all.

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


def _recorded(sensor: Sensor, simulation: Simulation, base: _Base) -> FloatArray:
    samples = _MEASURED[sensor.measures](sensor.at, simulation, base)
    for fault in sensor.faults:
        samples = fault.apply(samples, simulation.sample_rate)
    return samples


def _acceleration(at: str, simulation: Simulation, base: _Base) -> FloatArray:
    if at == BASE:
        return base.excitation if base.driven else np.zeros_like(base.excitation)
    row: FloatArray = simulation.acceleration[simulation.masses.index(at)]
    return row


def _displacement(at: str, simulation: Simulation, base: _Base) -> FloatArray:
    return base.add(base.displacement, simulation.relative_displacement(BASE, at))


def _velocity(at: str, simulation: Simulation, base: _Base) -> FloatArray:
    return base.add(base.velocity, simulation.relative_velocity(BASE, at))


def _relative_displacement(at: str, simulation: Simulation, base: _Base) -> FloatArray:  # noqa: ARG001
    return simulation.relative_displacement(BASE, at)


def _relative_velocity(at: str, simulation: Simulation, base: _Base) -> FloatArray:  # noqa: ARG001
    return simulation.relative_velocity(BASE, at)


def _force(at: str, simulation: Simulation, base: _Base) -> FloatArray:  # noqa: ARG001
    if simulation.force is None:
        raise ValueError("a force is measured where the displacement is imposed")
    return simulation.force


_MEASURED: Mapping[Measures, Callable[[str, Simulation, _Base], FloatArray]] = (
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
