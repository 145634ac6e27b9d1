"""What the sensors of a model record in windows of a test."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models.model import BASE, Measures, Model
from shakerproc.simulate.assembly import System
from shakerproc.simulate.inputs import Input
from shakerproc.simulate.sensing import integrated


@final
@dataclass(frozen=True, slots=True, eq=False)
class BaseMotion:
    """How the base moves at the samples of a test, from rest at its first.

    Attributes
    ----------
    acceleration, velocity, displacement : (n,) array
        At the samples [m/s^2], [m/s], [m].
    mean : (n,) array
        Mean acceleration over the interval after each sample; the last is repeated [m/s^2].
    sample_rate : float
        Samples per second [Hz].
    """

    acceleration: FloatArray
    velocity: FloatArray
    displacement: FloatArray
    mean: FloatArray
    sample_rate: float

    def part(self, first: int, last: int) -> "BaseMotion":
        """Return the motion between two samples, both included."""
        rows = slice(first, last + 1)
        return BaseMotion(
            self.acceleration[rows], self.velocity[rows], self.displacement[rows],
            self.mean[rows], self.sample_rate,
        )  # fmt: skip


def base_motion(model: Model, given: Input) -> BaseMotion:
    """Return how the base of a model moves in a test; where a force drives it, not at all."""
    if model.excitation.on is not None:
        still = np.zeros(given.n_samples)
        return BaseMotion(still, still, still, still, given.sample_rate)
    k = np.arange(given.pieces.shape[1])
    velocity, displacement = integrated(given.pieces, given.stride, given.sample_rate)
    of_parts = given.pieces @ (1.0 / (k + 1))
    mean = of_parts.reshape(-1, given.stride).mean(axis=1)
    return BaseMotion(
        given.samples, velocity, displacement, np.append(mean, mean[-1]), given.sample_rate
    )


def sense(
    model: Model,
    system: System,
    motion: FloatArray,
    acceleration: FloatArray,
    base: BaseMotion,
    *,
    means: bool,
) -> FloatArray:
    """Return what every sensor records, (n_sensors, n) array [SI].

    Parameters
    ----------
    motion : (n, n_motions) array
        Displacements, velocities and states, relative to the base.
    acceleration : (n, n_masses) array
        Relative to the base [m/s^2].
    base : BaseMotion
        At the same samples.
    means : bool
        Whether accelerations are means over the interval after each sample.
    """
    n = len(system.names)
    if means:
        acceleration = np.diff(motion[:, n : 2 * n], axis=0) * base.sample_rate
        acceleration = np.concatenate((acceleration, acceleration[-1:]))
        base = BaseMotion(
            base.mean, base.velocity, base.displacement, base.mean, base.sample_rate
        )
    out = np.empty((len(model.sensors), len(motion)))
    for row, sensor in zip(out, model.sensors.values(), strict=True):
        quantity = _QUANTITY[sensor.measures]
        row[:] = quantity.of_base(base)
        if sensor.at != BASE:
            at = system.names.index(sensor.at)
            of_mass = (acceleration, motion, motion[:, n:])[quantity.source]
            np.add(row, of_mass[:, at], out=row)
        for fault in sensor.faults:
            row[:] = fault.apply(row, base.sample_rate)
    return out


@final
@dataclass(frozen=True, slots=True)
class _Quantity:
    """Where a measured quantity comes from: 0 acceleration, 1 displacement, 2 velocity."""

    source: int
    of_base: Callable[[BaseMotion], FloatArray | float]


_QUANTITY: Final[Mapping[Measures, _Quantity]] = MappingProxyType({
    "acceleration": _Quantity(0, lambda base: base.acceleration),
    "displacement": _Quantity(1, lambda base: base.displacement),
    "velocity": _Quantity(2, lambda base: base.velocity),
    "relative displacement": _Quantity(1, lambda _: 0.0),
    "relative velocity": _Quantity(2, lambda _: 0.0),
})
