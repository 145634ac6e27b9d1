"""The response of a linear model: no curve to follow, solved closely where it bends."""

from typing import Final

import numpy as np

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.simulation.harmonic_balance.balance import HarmonicBalance
from shakerproc.simulation.harmonic_balance.branch import NEUTRAL, Branch
from shakerproc.simulation.harmonic_balance.system import PeriodicSystem

EVERYWHERE: Final = 401
"""Points over the band, evenly in the logarithm."""

ABOUT_A_POLE: Final = np.sinh(np.linspace(-3.0, 3.0, 13))
"""Points about each resonance, in its half-power half-widths."""


def is_linear(system: PeriodicSystem) -> bool:
    """Return whether a system answers a sine with one sine, in proportion."""
    return not system.couplings and not system.frictions


def linear_branch(balance: HarmonicBalance, band: tuple[float, float]) -> Branch:
    """Return the response of a linear system over a band.

    Parameters
    ----------
    balance : HarmonicBalance
        The equations, for one harmonic.
    band : tuple of float
        Frequencies of the excitation [Hz].
    """
    system = balance.system
    rates = _poles(system)
    frequency = _grid(rates, band)
    unknowns = np.array([_solved(balance, 2.0 * np.pi * hertz) for hertz in frequency])
    slowest_first = rates[np.argsort(-rates.real)]
    found = np.exp(slowest_first[None, :] / frequency[:, None])
    return Branch(
        balance=balance,
        frequency=frequency,
        unknowns=unknowns,
        multipliers=found,
        stable=np.abs(found[:, 0]) <= 1.0 + NEUTRAL,
        marks=(),
        ended=f"reached {band[1]:.6g} Hz, an end of the band",
    )


def _poles(system: PeriodicSystem) -> ComplexArray:
    """Return the eigenvalues of the equations of motion, (2 n_dofs,) array [rad/s]."""
    n = system.n_dofs
    matrix = np.zeros((2 * n, 2 * n))
    matrix[:n, n:] = np.eye(n)
    matrix[n:, :n] = -np.linalg.solve(system.mass, system.stiffness)
    matrix[n:, n:] = -np.linalg.solve(system.mass, system.damping)
    return np.linalg.eigvals(matrix).astype(np.complex128)


def _grid(rates: ComplexArray, band: tuple[float, float]) -> FloatArray:
    """Return frequencies over the band, close where the response has peaks, (n,) array [Hz]."""
    swinging = rates[rates.imag > 0.0] / (2.0 * np.pi)
    width = np.maximum(-swinging.real, 1e-6 * swinging.imag)
    offsets = ABOUT_A_POLE + 1e-3 * (
        -swinging.real[:, None] < width[:, None]
    )  # never on a pole
    near = (swinging.imag[:, None] + width[:, None] * offsets).ravel()
    inside = near[(near > band[0]) & (near < band[1])]
    return np.unique(np.concatenate((np.geomspace(*band, EVERYWHERE), inside, band)))


def _solved(balance: HarmonicBalance, omega: float) -> FloatArray:
    """Return the solution at a rate [rad/s]."""
    system = balance.system
    matrix = system.stiffness - omega**2 * system.mass + 1j * omega * system.damping
    one = np.linalg.solve(matrix, system.load.astype(np.complex128))
    coefficients = np.zeros((system.n_dofs, balance.harmonics.size), np.complex128)
    coefficients[:, balance.harmonics == balance.order] = one[:, None]
    return balance.real(coefficients)
