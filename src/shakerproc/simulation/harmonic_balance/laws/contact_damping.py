"""Damping that acts only in contact."""

from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.simulation.harmonic_balance import fourier
from shakerproc.simulation.harmonic_balance.laws.base import (
    AbstractLaw,
    HarmonicMotion,
    LawBalance,
)
from shakerproc.simulation.kernels import harmonic as contact


@final
@dataclass(frozen=True, eq=False)
class ContactDampingLaw(AbstractLaw):
    """A viscous force whose coefficient depends on the stretch that the displacement is in.

    The force is the rate of a piecewise-linear function, so it is integrated as exactly.

    Attributes
    ----------
    breakpoints : (n,) array
        Displacements at which the damping changes, in rising order [m].
    damping : (n + 1,) array
        Damping on each stretch [N s/m].
    """

    breakpoints: FloatArray
    damping: FloatArray

    def balance(self, motion: HarmonicMotion) -> LawBalance:
        impulse, by_displacement = contact.piecewise_linear_balance(
            motion.coefficients,
            motion.harmonics,
            motion.samples,
            (self.breakpoints, self.damping, self._intercepts),
        )
        rate = fourier.rate_of_rows(
            np.column_stack([impulse, by_displacement]), motion.harmonics
        )
        return LawBalance(motion.omega * rate[:, 0], motion.omega * rate[:, 1:], rate[:, 0])

    def switches(self, motion: HarmonicMotion) -> tuple[FloatArray, FloatArray]:
        angles, segments = motion.stretches(self.breakpoints)
        _, velocity = motion.at(angles)
        return angles, np.diff(self.damping[segments]) * velocity

    def tangent(
        self, displacement: FloatArray, velocity: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        segments = np.searchsorted(self.breakpoints, displacement)
        return np.zeros_like(displacement), self.damping[segments]

    @property
    def varies(self) -> bool:
        return False

    @property
    def reference_stiffness(self) -> float:
        return 0.0

    @property
    def remembers(self) -> bool:
        return False

    @property
    def odd(self) -> bool:
        return bool(
            np.array_equal(self.breakpoints, -self.breakpoints[::-1])
            and np.array_equal(self.damping, self.damping[::-1])
        )

    @cached_property
    def _intercepts(self) -> FloatArray:
        steps = -np.diff(self.damping) * self.breakpoints
        intercepts = np.concatenate([[0.0], np.cumsum(steps)])
        return np.asarray(intercepts - intercepts[intercepts.size // 2])
