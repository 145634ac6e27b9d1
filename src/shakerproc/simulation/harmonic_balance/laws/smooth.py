"""Laws with a derivative: sampled over the period (alternating frequency and time)."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.simulation.harmonic_balance import fourier
from shakerproc.simulation.harmonic_balance.laws.base import (
    AbstractLaw,
    HarmonicMotion,
    LawBalance,
)

State: TypeAlias = Callable[[FloatArray, FloatArray], FloatArray]
Tangent: TypeAlias = Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]


@final
@dataclass(frozen=True, eq=False)
class SmoothLaw(AbstractLaw):
    """A force with a derivative, sampled over the period (alternating frequency and time).

    Attributes
    ----------
    force : function
        Displacements [m] and velocities [m/s] to forces [N].
    slopes : function
        Displacements and velocities to stiffnesses [N/m] and dampings [N s/m].
    degree : int
        Degree of the force where it is a polynomial, else how sharp a polynomial it is like.
    is_odd : bool
        Whether the force changes sign with the motion.
    stiffness : float
        Stiffness to begin a search for a solution from [N/m].
    """

    force: State
    slopes: Tangent
    degree: int
    is_odd: bool
    stiffness: float

    def balance(self, motion: HarmonicMotion) -> LawBalance:
        highest = int(motion.harmonics[-1])
        n_samples = 2 ** int(np.ceil(np.log2((self.degree + 1) * highest + 1)))
        samples = motion.sampled(max(n_samples, 4 * highest + 2, 64))
        displacement, velocity = samples[0], motion.omega * samples[1]
        force = fourier.coefficients_of_values(
            self.force(displacement, velocity), motion.harmonics
        )
        stiffness, damping = self.slopes(displacement, velocity)
        jacobian = self._product(stiffness, motion)
        by_omega = None
        if np.any(damping):
            by_velocity = self._product(damping, motion)
            rate = fourier.rate_of_columns(by_velocity, motion.harmonics)
            jacobian += motion.omega * rate
            by_omega = rate @ fourier.real_of_complex(motion.coefficients, motion.harmonics)
        return LawBalance(fourier.real_of_complex(force, motion.harmonics), jacobian, by_omega)

    def switches(self, motion: HarmonicMotion) -> tuple[FloatArray, FloatArray]:
        return np.empty(0), np.empty(0)

    def tangent(
        self, displacement: FloatArray, velocity: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        return self.slopes(displacement, velocity)

    @property
    def varies(self) -> bool:
        return True

    @property
    def reference_stiffness(self) -> float:
        return self.stiffness

    @property
    def remembers(self) -> bool:
        return False

    @property
    def odd(self) -> bool:
        return self.is_odd

    def _product(self, factor: FloatArray, motion: HarmonicMotion) -> FloatArray:
        spectrum = np.fft.rfft(factor) / factor.size
        return fourier.multiplication(spectrum, motion.harmonics)
