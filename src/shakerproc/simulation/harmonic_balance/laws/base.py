"""Interface of a law: a force along one relative displacement, in harmonic coefficients."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.simulation.harmonic_balance import fourier
from shakerproc.simulation.kernels.harmonic import Harmonics, Segments, stretches


@final
@dataclass(frozen=True)
class HarmonicMotion:
    """A periodic relative displacement.

    Attributes
    ----------
    coefficients : (n_harmonics,) array
        Complex coefficients of the displacement [m].
    harmonics : (n_harmonics,) array
        Number of each harmonic.
    omega : float
        Rate of the angle [rad/s].
    """

    coefficients: ComplexArray
    harmonics: Harmonics
    omega: float

    @cached_property
    def samples(self) -> FloatArray:
        """Displacement and its derivative by the angle, (2, n_samples) array [m]."""
        return self.sampled(max(32, 8 * int(self.harmonics[-1])))

    def sampled(self, n_samples: int) -> FloatArray:
        """Return displacement and derivative by the angle, (2, n_samples) array [m]."""
        table = fourier.sample_table(self.harmonics, n_samples)
        real = fourier.real_of_complex(self.coefficients, self.harmonics)
        return np.asarray((table @ real).reshape(2, n_samples))

    def stretches(self, breakpoints: FloatArray) -> tuple[FloatArray, Segments]:
        """Return where breakpoints [m] are crossed [rad], and the stretches between."""
        return stretches(self.coefficients, self.harmonics, self.samples, breakpoints)

    def at(self, angles: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return displacement [m] and velocity [m/s] at angles, two (n,) arrays."""
        return fourier.values_at(self.coefficients, self.harmonics, self.omega, angles)


@final
@dataclass(frozen=True)
class LawBalance:
    """The coefficients of a force, in the real form.

    Attributes
    ----------
    force : (n_real,) array
        Coefficients [N].
    jacobian : (n_real, n_real) array
        Derivative by the coefficients of the displacement [N/m].
    by_omega : (n_real,) array or None
        Derivative by the rate of the angle [N s]; None where it is 0.
    """

    force: FloatArray
    jacobian: FloatArray
    by_omega: FloatArray | None = None


class AbstractLaw(ABC):
    """A force that depends on one relative displacement and velocity."""

    @abstractmethod
    def balance(self, motion: HarmonicMotion) -> LawBalance:
        """Return the coefficients of the force during a motion."""

    @abstractmethod
    def switches(self, motion: HarmonicMotion) -> tuple[FloatArray, FloatArray]:
        """Return where stiffness or damping jump [rad], and the jump of the force there [N]."""

    @abstractmethod
    def tangent(
        self, displacement: FloatArray, velocity: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return stiffness [N/m] and damping [N s/m] at states away from the switches."""

    @property
    @abstractmethod
    def varies(self) -> bool:
        """Whether stiffness or damping vary between the switches."""

    @property
    @abstractmethod
    def reference_stiffness(self) -> float:
        """Stiffness to begin a search for a solution from [N/m]."""

    @property
    @abstractmethod
    def remembers(self) -> bool:
        """Whether the force depends on the motion before."""

    @property
    @abstractmethod
    def odd(self) -> bool:
        """Whether the force changes sign with the motion."""
