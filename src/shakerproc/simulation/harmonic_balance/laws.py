"""Force laws in harmonic coefficients: one interface, four ways to get force and derivative."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Final, TypeAlias, final

import numpy as np

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.simulation.harmonic_balance import fourier
from shakerproc.simulation.kernels import harmonic as contact
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


_PERIODIC: Final = 1e-9
"""Difference of two rounds of a force that repeats itself, over its largest value [-]."""


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


@final
@dataclass(frozen=True, eq=False)
class HystereticLaw(AbstractLaw):
    r"""A force with a memory, followed around the period from rest at displacement 0.

    Two rounds are enough where both end with the same force. Else what the start has left fades
    by the same factor in every round, and that is summed up:

    .. math:: F = F_n + \frac{\lambda}{1 - \lambda} d_n, \quad d_n = F_n - F_{n-1}, \quad
        \lambda = \frac{d_n \cdot d_{n-1}}{d_{n-1} \cdot d_{n-1}}

    exact of a relaxation, such as that of a Maxwell element; of other laws after as many rounds
    as two such sums need to agree. The derivative is taken by differences, one for each
    coefficient.

    Attributes
    ----------
    force_along : function
        Displacements [m], velocities [m/s] and samples per second [Hz] to forces [N].
    stiffness : float
        Stiffness before slip, to begin a search from [N/m].
    """

    force_along: Callable[[FloatArray, FloatArray, float], FloatArray]
    stiffness: float

    def balance(self, motion: HarmonicMotion) -> LawBalance:
        real = fourier.real_of_complex(motion.coefficients, motion.harmonics)
        n_samples = self.n_samples(motion)
        table = fourier.sample_table(motion.harmonics, n_samples)
        base = table @ real
        size = float(np.max(np.abs(base[:n_samples]))) or 1.0
        numbers = np.repeat(motion.harmonics, np.where(motion.harmonics == 0, 1, 2))
        steps = 1e-6 * size / np.maximum(1.0, numbers)
        moved = np.vstack([base, base + (table * steps).T])
        rounds = self._rounds(base, motion.omega)
        forces = np.array([self._around(row, motion.omega, rounds) for row in moved])
        spectra = fourier.coefficients_of_values(forces, motion.harmonics)
        spectrum_rows = np.array([
            fourier.real_of_complex(row, motion.harmonics) for row in spectra
        ])
        jacobian = np.ascontiguousarray((spectrum_rows[1:] - spectrum_rows[0]).T / steps)
        return LawBalance(
            spectrum_rows[0], jacobian, self._by_omega(base, motion, spectrum_rows[0], rounds)
        )

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

    def _rounds(self, samples: FloatArray, omega: float) -> int:
        """Return after how many rounds of (2 n_samples,) samples the force is periodic."""
        loops = self._loops(samples, omega, 2)
        close = _PERIODIC * float(np.max(np.abs(loops)))
        if abs(loops[1, -1] - loops[0, -1]) <= close:
            return 2
        for rounds in (4, 8, 16, 32):
            loops = self._loops(samples, omega, rounds)
            if np.max(np.abs(_periodic(loops) - _periodic(loops[:-1]))) <= close:
                return rounds
        return 64

    def _loops(self, samples: FloatArray, omega: float, rounds: int) -> FloatArray:
        """Return the force of each round, (rounds, n_samples) array [N]."""
        displacement, slope = np.split(samples, 2)
        ramp = displacement[0] * np.linspace(0.0, 1.0, 9)[:-1]
        rate = displacement.size * omega / (2.0 * np.pi)
        along = np.concatenate([ramp, *[displacement] * rounds])
        velocity = np.concatenate([0.0 * ramp, *[omega * slope] * rounds])
        return self.force_along(along, velocity, rate)[ramp.size :].reshape(rounds, -1)

    def _around(self, samples: FloatArray, omega: float, rounds: int) -> FloatArray:
        """Return the force over one period of (2 n_samples,) displacements and slopes [N]."""
        return _periodic(self._loops(samples, omega, rounds))

    def _by_omega(
        self, samples: FloatArray, motion: HarmonicMotion, force: FloatArray, rounds: int
    ) -> FloatArray | None:
        """Return how the force depends on the pace, by a difference; None where it does not."""
        step = 1e-6 * motion.omega
        faster = fourier.coefficients_of_values(
            self._around(samples, motion.omega + step, rounds), motion.harmonics
        )
        change = fourier.real_of_complex(faster, motion.harmonics) - force
        return change / step if np.any(change) else None


def _periodic(loops: FloatArray) -> FloatArray:
    """Return the force of a round after all others, by the last three [N]; see `HystereticLaw`.

    The last where there are two, or where what is left does not fade.
    """
    last: FloatArray = loops[-1]
    if len(loops) < 3:
        return last
    before, after = loops[-2] - loops[-3], last - loops[-2]
    size = float(before @ before)
    fading = float(after @ before) / size if size > 0.0 else 1.0
    if abs(fading) < 1.0:
        last = last + after * fading / (1.0 - fading)
    return last
