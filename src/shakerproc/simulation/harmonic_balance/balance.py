"""The equations of motion in harmonic coefficients, with their derivatives."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.simulation.harmonic_balance import fourier
from shakerproc.simulation.harmonic_balance.laws import HarmonicMotion
from shakerproc.simulation.harmonic_balance.system import Coupling, PeriodicSystem
from shakerproc.simulation.kernels.harmonic import Harmonics

PUSH = 10.0
"""How hard the velocity pushes dry friction to its limit, over the system's impedance [-]."""


@final
@dataclass(frozen=True, eq=False)
class Residual:
    """How far coefficients are from a solution, and which way it lies.

    Attributes
    ----------
    force : (n_unknowns,) array
        What is left of the equations of motion [N].
    jacobian : (n_unknowns, n_unknowns) array
        Derivative by the coefficients [N/m].
    by_omega : (n_unknowns,) array
        Derivative by the rate of the base harmonic [N s].
    """

    force: FloatArray
    jacobian: FloatArray
    by_omega: FloatArray


@final
@dataclass(frozen=True, eq=False)
class HarmonicBalance:
    """The balance of a system over chosen harmonics.

    Attributes
    ----------
    system : PeriodicSystem
        What moves.
    harmonics : (n_harmonics,) array
        Harmonics of the base rate, in rising order.
    order : int
        Which harmonic of the base rate the load is: above 1 for subharmonic motion.
    """

    system: PeriodicSystem
    harmonics: Harmonics
    order: int = 1

    @property
    def n_real(self) -> int:
        """Real coefficients of one degree of freedom."""
        return fourier.n_real(self.harmonics)

    @property
    def n_unknowns(self) -> int:
        """Real coefficients of all degrees of freedom."""
        return self.system.n_dofs * self.n_real

    @cached_property
    def load(self) -> FloatArray:
        """Coefficients of the load, (n_unknowns,) array [N]."""
        coefficients = np.zeros((self.system.n_dofs, self.harmonics.size), np.complex128)
        coefficients[:, self.harmonics == self.order] = self.system.load[:, None]
        return self.real(coefficients)

    @cached_property
    def numbers(self) -> FloatArray:
        """Number of the harmonic of each unknown, (n_unknowns,) array."""
        one = np.repeat(self.harmonics, np.where(self.harmonics == 0, 1, 2))
        return np.tile(one, self.system.n_dofs).astype(np.float64)

    @cached_property
    def _linear(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Matrices that multiply 1, omega and -omega squared."""
        unit = np.eye(self.n_real)
        rate = fourier.rate_of_rows(unit, self.harmonics)
        system = self.system
        return (
            np.asarray(np.kron(system.stiffness, unit), np.float64),
            np.asarray(np.kron(system.damping, rate), np.float64),
            np.asarray(np.kron(system.mass, -rate @ rate), np.float64),
        )

    @cached_property
    def _momentum(self) -> FloatArray:
        """Matrix from the unknowns to the momenta at a rate of 1 [kg]."""
        rate = fourier.rate_of_rows(np.eye(self.n_real), self.harmonics)
        return np.asarray(np.kron(self.system.mass, rate), np.float64)

    def real(self, coefficients: ComplexArray) -> FloatArray:
        """Return (n_dofs, n_harmonics) complex coefficients as the vector of unknowns.

        Both are in [m].
        """
        return np.concatenate([
            fourier.real_of_complex(row, self.harmonics) for row in coefficients
        ])

    def coefficients(self, unknowns: FloatArray) -> ComplexArray:
        """Return the unknowns as (n_dofs, n_harmonics) complex coefficients.

        Both are in [m].
        """
        rows = unknowns.reshape(self.system.n_dofs, self.n_real)
        return np.array([fourier.complex_of_real(row, self.harmonics) for row in rows])

    def motions(
        self, unknowns: FloatArray, omega: float
    ) -> Iterator[tuple[Coupling, HarmonicMotion]]:
        """Yield every coupling with the motion along it.

        `unknowns` are in [m], `omega` in [rad/s].
        """
        rows = unknowns.reshape(self.system.n_dofs, self.n_real)
        for coupling in self.system.couplings:
            along = fourier.complex_of_real(coupling.direction @ rows, self.harmonics)
            yield coupling, HarmonicMotion(along, self.harmonics, omega)

    def linear_matrix(self, omega: float) -> FloatArray:
        """Return the dynamic stiffness without the couplings [N/m]."""
        stiffness, damping, mass = self._linear
        return stiffness + omega * damping - omega**2 * mass

    def residual(self, unknowns: FloatArray, omega: float, growth: float = 0.0) -> Residual:
        """Return the residual of the equations of motion.

        Parameters
        ----------
        unknowns : (n_unknowns,) array
            Coefficients of the displacements [m].
        omega : float
            Base rate [rad/s].
        growth : float
            Negative damping in proportion to the masses [1/s].
        """
        _, damping, mass = self._linear
        jacobian = self.linear_matrix(omega)
        if growth != 0.0:
            damping = damping - growth * self._momentum
            jacobian -= omega * growth * self._momentum
        force = jacobian @ unknowns - self.load
        by_omega = damping @ unknowns - 2.0 * omega * (mass @ unknowns)
        for i, (coupling, motion) in enumerate(self.motions(unknowns, omega)):
            balanced = coupling.law.balance(motion)
            force += np.outer(coupling.direction, balanced.force).ravel()
            self._add(jacobian, i, balanced.jacobian)
            if balanced.by_omega is not None:
                by_omega += np.outer(coupling.direction, balanced.by_omega).ravel()
        smooth = Residual(force, jacobian, by_omega)
        return self._with_friction(smooth, unknowns, omega) if self.system.frictions else smooth

    def reference_matrix(self, omega: float) -> FloatArray:
        """Return the dynamic stiffness with every coupling a linear spring [N/m]."""
        matrix = self.linear_matrix(omega)
        for i, coupling in enumerate(self.system.couplings):
            self._add(matrix, i, coupling.law.reference_stiffness * np.eye(self.n_real))
        return matrix

    @cached_property
    def _joints(self) -> tuple[FloatArray, FloatArray, FloatArray, float]:
        """Data of the joints for dry friction.

        Matrices from all unknowns to the forces that the joints are asked for and to their
        velocities at a rate of 1, back from the forces of the joints, and the push of the
        velocity: an impedance of the system [N s/m].
        """
        directions = np.array([joint.direction for joint in self.system.frictions])
        unit = np.eye(self.n_real)
        rate = fourier.rate_of_rows(unit, self.harmonics)
        stiffness = self.system.stiffness + sum(
            coupling.law.reference_stiffness * np.outer(coupling.direction, coupling.direction)
            for coupling in self.system.couplings
        )
        reduced = 1.0 / np.diag(directions @ np.linalg.solve(self.system.mass, directions.T))
        fastest = np.max(np.linalg.eigvals(np.linalg.solve(self.system.mass, stiffness)).real)
        return (
            np.asarray(np.kron(np.linalg.pinv(directions.T), unit), np.float64),
            np.asarray(np.kron(directions, rate), np.float64),
            np.asarray(np.kron(directions.T, unit), np.float64),
            float(PUSH * np.max(reduced) * np.sqrt(max(fastest, 1.0))),
        )

    def _with_friction(self, smooth: Residual, unknowns: FloatArray, omega: float) -> Residual:
        """Return a residual with the dry friction that the rest of it asks for."""
        asked, rate, back, push = self._joints
        velocity = omega * (rate @ unknowns)
        wish = -asked @ smooth.force + push * velocity
        wish_by = -asked @ smooth.jacobian + push * omega * rate
        wish_by_omega = -asked @ smooth.by_omega + push * (rate @ unknowns)
        force, by, by_omega = np.empty_like(wish), np.empty_like(wish_by), np.empty_like(wish)
        rows = unknowns.reshape(self.system.n_dofs, self.n_real)
        for i, joint in enumerate(self.system.frictions):
            part = slice(i * self.n_real, (i + 1) * self.n_real)
            along = fourier.complex_of_real(joint.direction @ rows, self.harmonics)
            limited = joint.law.limited(
                fourier.complex_of_real(wish[part], self.harmonics),
                HarmonicMotion(along, self.harmonics, omega),
            )
            force[part] = limited.force
            by[part] = (
                limited.by_wish @ wish_by[part] + omega * limited.by_velocity @ rate[part]
            )
            by_omega[part] = limited.by_wish @ wish_by_omega[part] + limited.by_velocity @ (
                rate[part] @ unknowns
            )
        return Residual(
            smooth.force + back @ force,
            smooth.jacobian + back @ by,
            smooth.by_omega + back @ by_omega,
        )

    @cached_property
    def _blocks(self) -> tuple[tuple[tuple[slice, slice, float], ...], ...]:
        """Rows, columns and factor of each block that a coupling adds to."""
        size = self.n_real
        spans = [slice(i * size, (i + 1) * size) for i in range(self.system.n_dofs)]
        return tuple(
            tuple(
                (spans[i], spans[j], float(coupling.direction[i] * coupling.direction[j]))
                for i in np.flatnonzero(coupling.direction)
                for j in np.flatnonzero(coupling.direction)
            )
            for coupling in self.system.couplings
        )

    def _add(self, matrix: FloatArray, coupling: int, block: FloatArray) -> None:
        """Add a block along a coupling to a matrix of all degrees of freedom, in place."""
        for rows, columns, factor in self._blocks[coupling]:
            matrix[rows, columns] += block if factor == 1.0 else factor * block
