"""Laws with a memory: sampled along the motion, differentiated by differences."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.simulation.harmonic_balance import fourier
from shakerproc.simulation.harmonic_balance.laws.base import (
    AbstractLaw,
    HarmonicMotion,
    LawBalance,
)


@final
@dataclass(frozen=True, eq=False)
class HystereticLaw(AbstractLaw):
    """A force with a memory, followed twice around the period from rest at displacement 0.

    Its derivative is taken by differences, one for each coefficient.

    Attributes
    ----------
    force_along : function
        Displacements [m], velocities [m/s] and samples per second [Hz] to forces [N].
    stiffness : float
        Stiffness before slip, to begin a search from [N/m].
    rounds : int
        Periods after which the memory is taken as periodic.
    """

    force_along: Callable[[FloatArray, FloatArray, float], FloatArray]
    stiffness: float
    rounds: int = 2

    def balance(self, motion: HarmonicMotion) -> LawBalance:
        real = fourier.real_of_complex(motion.coefficients, motion.harmonics)
        n_samples = self.n_samples(motion)
        table = fourier.sample_table(motion.harmonics, n_samples)
        base = table @ real
        size = float(np.max(np.abs(base[:n_samples]))) or 1.0
        numbers = np.repeat(motion.harmonics, np.where(motion.harmonics == 0, 1, 2))
        steps = 1e-6 * size / np.maximum(1.0, numbers)
        moved = np.vstack([base, base + (table * steps).T])
        forces = np.array([self._around(row, motion.omega) for row in moved])
        spectra = fourier.coefficients_of_values(forces, motion.harmonics)
        found = np.array([fourier.real_of_complex(row, motion.harmonics) for row in spectra])
        jacobian = np.ascontiguousarray((found[1:] - found[0]).T / steps)
        return LawBalance(found[0], jacobian, self._by_omega(base, motion, found[0]))

    def switches(self, motion: HarmonicMotion) -> tuple[FloatArray, FloatArray]:
        return np.empty(0), np.empty(0)

    def tangent(
        self, displacement: FloatArray, velocity: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        raise NotImplementedError("a law with memory has no tangent at a state")

    @property
    def varies(self) -> bool:
        return True

    @property
    def reference_stiffness(self) -> float:
        return self.stiffness

    @property
    def remembers(self) -> bool:
        return True

    @property
    def odd(self) -> bool:
        return True

    @staticmethod
    def n_samples(motion: HarmonicMotion) -> int:
        """Return how many samples one period takes."""
        return max(512, 16 * int(motion.harmonics[-1]))

    def _around(self, samples: FloatArray, omega: float) -> FloatArray:
        """Return the force over one period of (2 n_samples,) displacements and slopes [N]."""
        displacement, slope = np.split(samples, 2)
        ramp = displacement[0] * np.linspace(0.0, 1.0, 9)[:-1]
        rate = displacement.size * omega / (2.0 * np.pi)
        along = np.concatenate([ramp, *[displacement] * self.rounds])
        velocity = np.concatenate([0.0 * ramp, *[omega * slope] * self.rounds])
        return self.force_along(along, velocity, rate)[-displacement.size :]

    def _by_omega(
        self, samples: FloatArray, motion: HarmonicMotion, force: FloatArray
    ) -> FloatArray | None:
        """Return how the force depends on the pace, by a difference; None where it does not."""
        step = 1e-6 * motion.omega
        faster = fourier.coefficients_of_values(
            self._around(samples, motion.omega + step), motion.harmonics
        )
        change = fourier.real_of_complex(faster, motion.harmonics) - force
        return change / step if np.any(change) else None
