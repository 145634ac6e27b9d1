"""Whether a periodic motion attracts: Floquet multipliers by the exact monodromy matrix."""

import numpy as np

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.simulation.harmonic_balance.balance import HarmonicBalance
from shakerproc.simulation.harmonic_balance.laws import HarmonicMotion
from shakerproc.simulation.harmonic_balance.system import Coupling
from shakerproc.simulation.kernels.harmonic_monodromy import propagate

GAUSS = 0.5 + np.array([-1.0, 1.0]) * np.sqrt(3.0) / 6.0


def monodromy(balance: HarmonicBalance, unknowns: FloatArray, omega: float) -> FloatArray:
    r"""Return the monodromy matrix: one period of a small disturbance of motion.

    Between switches of the laws the disturbance obeys a linear equation, with constant matrices
    where the laws are piecewise linear; there the propagator is a matrix exponential. Where the
    force jumps, the disturbance of the velocities jumps by
    :math:`-M^{-1} d \, \Delta F / (d^T \dot q) \; d^T \delta q`.

    Parameters
    ----------
    balance : HarmonicBalance
        The equations.
    unknowns : (n_unknowns,) array
        Coefficients of a solution [m].
    omega : float
        Its base rate [rad/s].

    Returns
    -------
    (2 n_dofs, 2 n_dofs) array
        Monodromy matrix, displacements first.

    References
    ----------
    .. [1] R. I. Leine and H. Nijmeijer, "Dynamics and Bifurcations of Non-Smooth Mechanical
       Systems", Springer, 2004, ch. 7.
    """
    moving = tuple(balance.motions(unknowns, omega))
    switches = [coupling.law.switches(motion) for coupling, motion in moving]
    edges = _edges(balance, moving, [angles for angles, _ in switches])
    early, late = _gauss_rates(balance, moving, edges)
    jumps = _jumps(balance, moving, switches, edges)
    n = balance.system.n_dofs
    scale = np.concatenate([np.ones(n), np.full(n, _rate_scale(early))])
    turn = scale / scale[:, None]
    found = propagate(np.diff(edges) / omega, early * turn, late * turn, jumps * turn)
    return np.asarray(found / turn)


def multipliers(monodromies: FloatArray) -> ComplexArray:
    """Return the Floquet multipliers, largest first, of (..., 2n, 2n) monodromy matrices.

    They have no unit [-].
    """
    values = np.linalg.eigvals(monodromies).astype(np.complex128)
    order = np.argsort(-np.abs(values), axis=-1)
    return np.asarray(np.take_along_axis(values, order, axis=-1))


def _edges(
    balance: HarmonicBalance,
    moving: tuple[tuple[Coupling, HarmonicMotion], ...],
    switches: list[FloatArray],
) -> FloatArray:
    """Return the angles between spans."""
    n_steps = 1
    if any(coupling.law.varies for coupling, _ in moving):
        n_steps = max(128, 8 * int(balance.harmonics[-1]))
    regular = np.linspace(0.0, 2.0 * np.pi, n_steps + 1)
    return np.unique(np.concatenate([regular, *switches]))


def _gauss_rates(
    balance: HarmonicBalance,
    moving: tuple[tuple[Coupling, HarmonicMotion], ...],
    edges: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return the matrices of the disturbance at the two Gauss points of each span."""
    if any(coupling.law.varies for coupling, _ in moving):
        early, late = (_rates(balance, moving, edges, share) for share in GAUSS)
        return early, late
    middle = _rates(balance, moving, edges, 0.5)
    return middle, middle


def _rates(
    balance: HarmonicBalance,
    moving: tuple[tuple[Coupling, HarmonicMotion], ...],
    edges: FloatArray,
    share: float,
) -> FloatArray:
    """Return the matrices of the disturbance within each span, (n_spans, 2n, 2n) array."""
    system, n = balance.system, balance.system.n_dofs
    angles = edges[:-1] + share * np.diff(edges)
    stiffness = np.broadcast_to(system.stiffness, (angles.size, n, n))
    damping = np.broadcast_to(system.damping, (angles.size, n, n))
    for coupling, motion in moving:
        by_displacement, by_velocity = coupling.law.tangent(*motion.at(angles))
        square = np.outer(coupling.direction, coupling.direction)
        stiffness = stiffness + by_displacement[:, None, None] * square
        damping = damping + by_velocity[:, None, None] * square
    rates = np.zeros((angles.size, 2 * n, 2 * n))
    rates[:, :n, n:] = np.eye(n)
    inverse = np.linalg.inv(system.mass)
    rates[:, n:, :n] = -inverse @ stiffness
    rates[:, n:, n:] = -inverse @ damping
    return rates


def _jumps(
    balance: HarmonicBalance,
    moving: tuple[tuple[Coupling, HarmonicMotion], ...],
    switches: list[tuple[FloatArray, FloatArray]],
    edges: FloatArray,
) -> FloatArray:
    """Return the jump of a disturbance at the end of each span, (n_spans, 2n, 2n) array."""
    n = balance.system.n_dofs
    jumps = np.zeros((edges.size - 1, 2 * n, 2 * n))
    jumps[:] = np.eye(2 * n)
    for (coupling, motion), (angles, forces) in zip(moving, switches, strict=True):
        if not forces.any():
            continue
        kick = np.linalg.solve(balance.system.mass, coupling.direction)
        shape = np.outer(kick, coupling.direction)
        shares = forces / motion.at(angles)[1]
        for edge, share in zip(np.searchsorted(edges, angles), shares, strict=True):
            jumps[edge - 1, n:, :n] -= share * shape
    return jumps


def _rate_scale(rates: FloatArray) -> float:
    """Return a rate that makes displacements and velocities of like size [rad/s]."""
    n = rates.shape[1] // 2
    return float(np.sqrt(max(np.max(np.abs(rates[:, n:, :n])), 1.0)))
