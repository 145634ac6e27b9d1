"""Result of a simulation."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models.model import BASE
from shakerproc.simulation.interpolation import InterpolationError

SENSITIVE_GROWTH: Final = 1e4
"""Past it no measured input is known well enough to predict the motion in time [-]."""

CHAOTIC_GROWTH: Final = 1e8
"""A disturbance of 1e-10 that grows more than this becomes a hundredth of the motion [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Simulation:
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
