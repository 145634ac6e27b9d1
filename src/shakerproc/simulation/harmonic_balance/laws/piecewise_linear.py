"""Straight lines between breakpoints: gaps, stops, the literal jump of eq. 3.14."""

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
class PiecewiseLinearLaw(AbstractLaw):
    """A force made of straight lines, with or without jumps between them.

    Attributes
    ----------
    breakpoints : (n,) array
        Displacements at which the law changes, in rising order [m].
    slopes : (n + 1,) array
        Stiffness on each stretch [N/m].
    intercepts : (n + 1,) array
        Force that each straight line has at displacement 0 [N].
    """

    breakpoints: FloatArray
    slopes: FloatArray
    intercepts: FloatArray

    def balance(self, motion: HarmonicMotion) -> LawBalance:
        law = (self.breakpoints, self.slopes, self.intercepts)
        force, jacobian = contact.piecewise_linear_balance(
            motion.coefficients, motion.harmonics, motion.samples, law
        )
        if self._jumps:
            jacobian = jacobian + self._jump_jacobian(motion)
        return LawBalance(force, jacobian)

    def switches(self, motion: HarmonicMotion) -> tuple[FloatArray, FloatArray]:
        angles, segments = motion.stretches(self.breakpoints)
        if not self._jumps:
            return angles, np.zeros_like(angles)
        rising = np.diff(segments)
        steps = self._steps[np.minimum(segments[:-1], segments[1:])]
        return angles, rising * steps

    def tangent(
        self, displacement: FloatArray, velocity: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        segments = np.searchsorted(self.breakpoints, displacement)
        return self.slopes[segments], 0.0 * velocity

    @property
    def varies(self) -> bool:
        return False

    @property
    def reference_stiffness(self) -> float:
        return float(np.max(self.slopes))

    @property
    def remembers(self) -> bool:
        return False

    @property
    def odd(self) -> bool:
        return bool(
            np.array_equal(self.breakpoints, -self.breakpoints[::-1])
            and np.array_equal(self.slopes, self.slopes[::-1])
            and np.array_equal(self.intercepts, -self.intercepts[::-1])
        )

    @property
    def _scale(self) -> float:
        return float(np.max(np.abs(self.intercepts), initial=0.0))

    @cached_property
    def _steps(self) -> FloatArray:
        """By how much the force jumps at each breakpoint as the displacement rises [N]."""
        steps = np.diff(self.slopes) * self.breakpoints + np.diff(self.intercepts)
        steps[np.abs(steps) <= 1e-12 * self._scale] = 0.0
        return np.asarray(steps)

    @cached_property
    def _jumps(self) -> bool:
        return bool(np.any(self._steps))

    def _jump_jacobian(self, motion: HarmonicMotion) -> FloatArray:
        angles, jumps = self.switches(motion)
        _, velocity = motion.at(angles)
        return fourier.impulses(angles, jumps * motion.omega / velocity, motion.harmonics)
