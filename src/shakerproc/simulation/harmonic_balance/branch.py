"""A branch of periodic motions: stability by the monodromy matrix, folds and branches."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final, Literal, TypeAlias, TypeVar, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.simulation.harmonic_balance import fourier
from shakerproc.simulation.harmonic_balance.balance import HarmonicBalance
from shakerproc.simulation.harmonic_balance.continuation import Trace, correct, refine
from shakerproc.simulation.harmonic_balance.curves import ForcedCurve
from shakerproc.simulation.harmonic_balance.laws import HarmonicMotion
from shakerproc.simulation.harmonic_balance.system import Coupling, PeriodicSystem
from shakerproc.simulation.kernels.harmonic import propagate

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
    product = propagate(np.diff(edges) / omega, early * turn, late * turn, jumps * turn)
    return np.asarray(product / turn)


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


Kind: TypeAlias = Literal["fold", "period doubling", "branch point", "quasi-periodic"]

Number = TypeVar("Number", bound=np.generic)

NEUTRAL = 1e-6
"""By how much a multiplier may exceed 1 and the motion still count as stable [-]."""

EVERYWHERE: Final = 401
"""Points over the band, evenly in the logarithm."""

ABOUT_A_POLE: Final = np.sinh(np.linspace(-3.0, 3.0, 13))
"""Points about each resonance, in its half-power half-widths."""


@final
@dataclass(frozen=True, slots=True)
class BranchMark:
    """A point at which the branch folds or stability changes.

    Attributes
    ----------
    index : int
        Point of the branch; a fold is a point of its own, the others lie just before theirs.
    kind : str
        What happens there.
    frequency : float
        Frequency of the excitation there [Hz]; interpolated where it is no fold.
    """

    index: int
    kind: Kind
    frequency: float


@final
@dataclass(frozen=True, eq=False)
class Branch:
    """Periodic motions against the frequency of the excitation, in order along the curve.

    Attributes
    ----------
    balance : HarmonicBalance
        The equations that they solve.
    frequency : (n_points,) array
        Frequency of the excitation [Hz].
    unknowns : (n_points, n_unknowns) array
        Coefficients of the displacements [m].
    multipliers : (n_points, 2 n_dofs) array
        Floquet multipliers, largest first; NaN with laws that have a memory.
    stable : (n_points,) array of bool
        Whether the motion attracts its neighbours; with a memory, whether it lies outside the
        folds.
    marks : tuple of BranchMark
        Folds and changes of stability, in order.
    ended : str
        Why the branch ends, for people.
    """

    balance: HarmonicBalance
    frequency: FloatArray
    unknowns: FloatArray
    multipliers: ComplexArray
    stable: NDArray[np.bool_]
    marks: tuple[BranchMark, ...]
    ended: str

    @property
    def folds(self) -> tuple[int, ...]:
        """Points at which the frequency turns back."""
        return tuple(mark.index for mark in self.marks if mark.kind == "fold")

    @cached_property
    def coefficients(self) -> ComplexArray:
        """Complex displacements, (n_points, n_dofs, n_harmonics) array [m]."""
        if not self.unknowns.size:
            shape = (0, self.balance.system.n_dofs, self.balance.harmonics.size)
            return np.zeros(shape, np.complex128)
        return np.array([self.balance.coefficients(row) for row in self.unknowns])


def branch_of_trace(
    balance: HarmonicBalance, curve: ForcedCurve, trace: Trace, ended: str
) -> Branch:
    """Return a followed curve with its folds as points, its stability and its marks."""
    points, folds = _with_folds(curve, trace)
    return _assessed(balance, points, folds, ended)


def _assessed(
    balance: HarmonicBalance, points: FloatArray, folds: list[int], ended: str
) -> Branch:
    rates = points[:, -1]
    system = balance.system
    if system.remembers or system.frictions:
        floquet_multipliers = np.full((rates.size, 2 * system.n_dofs), np.nan, np.complex128)
        turns = np.isin(np.arange(rates.size), folds)
        stable = np.cumsum(turns) % 2 == 0
    else:
        matrices = np.array([
            monodromy(balance, point[:-1], rate)
            for point, rate in zip(points, rates, strict=True)
        ])
        floquet_multipliers = multipliers(matrices)
        stable = np.abs(floquet_multipliers[:, 0]) <= 1.0 + NEUTRAL
    frequency = rates * balance.order / (2.0 * np.pi)
    return Branch(
        balance=balance,
        frequency=frequency,
        unknowns=points[:, :-1],
        multipliers=floquet_multipliers,
        stable=np.asarray(stable, np.bool_),
        marks=_marks(frequency, floquet_multipliers, folds),
        ended=ended,
    )


def joined(backwards: Branch, onwards: Branch) -> Branch:
    """Return the branch that runs backwards to a point and onwards from it as one."""
    last = backwards.frequency.size - 1
    marks = [
        replace(mark, index=last - mark.index + int(mark.kind != "fold"))
        for mark in reversed(backwards.marks)
    ]
    marks += [replace(mark, index=mark.index + last) for mark in onwards.marks]

    def both(before: NDArray[Number], after: NDArray[Number]) -> NDArray[Number]:
        return np.concatenate([before[::-1], after[1:]])

    return Branch(
        balance=onwards.balance,
        frequency=both(backwards.frequency, onwards.frequency),
        unknowns=both(backwards.unknowns, onwards.unknowns),
        multipliers=both(backwards.multipliers, onwards.multipliers),
        stable=both(backwards.stable, onwards.stable),
        marks=tuple(marks),
        ended=f"{onwards.ended}; backwards, {backwards.ended}",
    )


def sharpened(branch: Branch) -> Branch:
    """Return a branch with its changes of stability as points of their own, like the folds.

    They are found by bisection between the two points around them, to 1e-4 of that distance.
    """
    curve = ForcedCurve(branch.balance)
    rate = 2.0 * np.pi / branch.balance.order
    points = np.column_stack([branch.unknowns, rate * branch.frequency])
    inserted: list[FloatArray] = []
    places: list[int] = []
    for mark in branch.marks:
        if mark.kind != "fold":
            change = _change(curve, points[mark.index - 1], points[mark.index])
            inserted += [] if change is None else [change]
            places += [] if change is None else [mark.index]
    if not places:
        return branch
    folds = [int(i + np.sum(np.array(places) <= i)) for i in branch.folds]
    everything = np.insert(points, places, np.array(inserted), axis=0)
    return _assessed(branch.balance, everything, folds, branch.ended)


def samples_of_branch(branch: Branch, n_samples: int) -> FloatArray:
    """Return one period of every displacement, (n_points, n_dofs, n_samples) array [m]."""
    return fourier.values(branch.coefficients, branch.balance.harmonics, n_samples)


def _change(curve: ForcedCurve, before: FloatArray, after: FloatArray) -> FloatArray | None:
    """Return the point between two at which the number of multipliers outside 1 changes."""
    weights = curve.weights(before)
    chord = (after - before) * weights
    chord /= np.linalg.norm(chord)

    def outside(point: FloatArray) -> int:
        floquet_multipliers = multipliers(monodromy(curve.balance, point[:-1], point[-1]))
        return int(np.sum(np.abs(floquet_multipliers) > 1.0 + NEUTRAL))

    low, high, count = before, after, outside(before)
    for _ in range(14):
        middle = correct(curve, 0.5 * (low + high), chord, weights, 1e-9)
        if middle is None:
            return None
        if outside(middle[0]) == count:
            low = middle[0]
        else:
            high = middle[0]
    return high


def _with_folds(curve: ForcedCurve, trace: Trace) -> tuple[FloatArray, list[int]]:
    """Return the points with every fold in its place, and which they are."""
    points: list[FloatArray] = [trace.points[0]]
    folds: list[int] = []
    for i in range(1, len(trace.points)):
        before, after = trace.tangents[i - 1], trace.tangents[i]
        if before[-1] * after[-1] < 0.0:
            fold = refine(curve, trace.points[i - 1], trace.points[i], -1)
            if fold is not None:
                folds.append(len(points))
                points.append(fold)
        points.append(trace.points[i])
    return np.array(points), folds


def _marks(
    frequency: FloatArray, floquet_multipliers: ComplexArray, folds: list[int]
) -> tuple[BranchMark, ...]:
    """Return the folds, and the points after which other multipliers have left the circle."""
    marks = [BranchMark(index, "fold", float(frequency[index])) for index in folds]
    counts = np.sum(np.abs(floquet_multipliers) > 1.0 + NEUTRAL, axis=1)
    for i in np.flatnonzero(np.diff(counts)):
        near_fold = any(i <= fold <= i + 1 for fold in folds)
        kind, share = _crossing(floquet_multipliers[i], floquet_multipliers[i + 1])
        if not (near_fold and kind == "branch point"):
            between = frequency[i] + share * (frequency[i + 1] - frequency[i])
            marks.append(BranchMark(int(i) + 1, kind, float(between)))
    return tuple(sorted(marks, key=lambda mark: mark.index))


def _crossing(before: ComplexArray, after: ComplexArray) -> tuple[Kind, float]:
    """Return which way a multiplier crossed the unit circle, and where between two points."""
    limit = 1.0 + NEUTRAL
    counts = [int(np.sum(np.abs(found) > limit)) for found in (before, after)]
    place = min(counts)
    value = (before if counts[0] > counts[1] else after)[place]
    sizes = np.abs(before[place]), np.abs(after[place])
    share = float((1.0 - sizes[0]) / (sizes[1] - sizes[0]))
    if abs(value.imag) > 1e-9 * abs(value):
        return "quasi-periodic", share
    return ("period doubling" if value.real < 0.0 else "branch point"), share


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
    decays = np.exp(slowest_first[None, :] / frequency[:, None])
    return Branch(
        balance=balance,
        frequency=frequency,
        unknowns=unknowns,
        multipliers=decays,
        stable=np.abs(decays[:, 0]) <= 1.0 + NEUTRAL,
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
