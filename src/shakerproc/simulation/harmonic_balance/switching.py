"""From one branch to another: lost symmetry, doubled periods, subharmonic motion."""

from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.simulation.harmonic_balance.backbone import Backbone, backbone
from shakerproc.simulation.harmonic_balance.balance import HarmonicBalance
from shakerproc.simulation.harmonic_balance.branch import (
    Branch,
    BranchMark,
    branch_of_trace,
    joined,
    samples_of_branch,
)
from shakerproc.simulation.harmonic_balance.continuation import StepSizes, correct, follow
from shakerproc.simulation.harmonic_balance.curves import (
    CLOSED,
    ForcedCurve,
    end_of_trace,
    limits,
    newton,
)
from shakerproc.simulation.harmonic_balance.response import (
    Response,
    balance_of_system,
    follow_branch,
)

STARTS = (0.03, 0.1, 0.01)
"""Share of the new harmonics to begin a new branch with [-]."""

FREQUENCIES, PHASES = 10, 8
"""How many frequencies and phases are tried."""

STEPS: Final = StepSizes(most=600)
"""How a branch that leaves another is followed."""


def branch_off(branch: Branch, mark: BranchMark, band: tuple[float, float]) -> Branch | None:
    """Return the branch that leaves another at a mark.

    Where the period doubles, the new branch has half the base rate; where the symmetry of an
    odd system is lost, it has even harmonics. Its mirror image is not followed.

    Parameters
    ----------
    branch : Branch
        The known branch.
    mark : BranchMark
        A period doubling or branch point on it.
    band : tuple of float
        Frequencies of the excitation [Hz].

    Returns
    -------
    Branch or None
        From the mark until it leaves the band or joins the known branch again; None where the
        new branch has no harmonics of its own, or is not found.
    """
    factor = 2 if mark.kind == "period doubling" else 1
    old = branch.balance
    highest = int(old.harmonics[-1]) * factor
    balance = HarmonicBalance(old.system, np.arange(highest + 1), old.order * factor)
    new = ~np.isin(balance.numbers, old.harmonics * factor)
    if not new.any():
        return None
    curve = ForcedCurve(balance)
    for index in (mark.index, mark.index - 1):
        point = _embedded(branch, index, balance)
        weights = curve.weights(point)
        direction = _direction(curve, point, new)
        for share in STARTS:
            guess = point + share * direction / weights
            corrected = correct(curve, guess, direction, weights, 1e-9)
            if corrected is not None and _share(curve, corrected[0], new) > 0.3 * share:
                towards = direction / weights
                return _follow(curve, (corrected[0], towards), new, band)
    return None


def branches_off(branch: Branch, band: tuple[float, float]) -> tuple[Branch, ...]:
    """Return every branch that leaves another, each once.

    Parameters
    ----------
    branch : Branch
        The known branch, its marks sharpened.
    band : tuple of float
        Frequencies of the excitation [Hz].
    """
    branches: list[Branch] = []
    for mark in branch.marks:
        other = None if mark.kind == "fold" else branch_off(branch, mark, band)
        if other is not None and not any(_same_branch(known, other) for known in branches):
            branches.append(other)
    return tuple(branches)


def _same_branch(known: Branch, other: Branch) -> bool:
    """Return whether two branches are one, or each other's mirror image."""
    ends = [(np.min(found.frequency), np.max(found.frequency)) for found in (known, other)]
    same_order = known.balance.order == other.balance.order
    return same_order and bool(np.allclose(ends[0], ends[1], rtol=1e-2))


def _embedded(branch: Branch, index: int, balance: HarmonicBalance) -> FloatArray:
    """Return a point of a branch in the harmonics of another balance."""
    factor = balance.order // branch.balance.order
    old = branch.balance.coefficients(branch.unknowns[index])
    new = np.zeros((old.shape[0], balance.harmonics.size), np.complex128)
    new[:, np.isin(balance.harmonics, branch.balance.harmonics * factor)] = old
    rate = 2.0 * np.pi * branch.frequency[index] / balance.order
    return np.append(balance.real(new), rate)


def _direction(curve: ForcedCurve, point: FloatArray, new: NDArray[np.bool_]) -> FloatArray:
    """Return the direction in the new harmonics that costs the least force, of length 1."""
    _, derivative = curve.evaluate(point)
    scaled = (derivative / curve.weights(point))[:, :-1]
    _, _, right = np.linalg.svd(scaled[np.ix_(new, new)])
    direction = np.zeros(point.size)
    direction[:-1][new] = right[-1]
    return direction


def _share(curve: ForcedCurve, point: FloatArray, new: NDArray[np.bool_]) -> float:
    """Return the share of the new harmonics in a motion [-]."""
    return float(np.linalg.norm((point * curve.weights(point))[:-1][new]))


def _follow(
    curve: ForcedCurve,
    start: tuple[FloatArray, FloatArray],
    new: NDArray[np.bool_],
    band: tuple[float, float],
) -> Branch:
    """Return the branch from a point in a direction until its own harmonics fade."""
    least = 0.5 * _share(curve, start[0], new)
    usual = limits(curve, start[0], band)

    def stop(before: FloatArray, point: FloatArray) -> str:
        faded = _share(curve, point, new) < least or before[:-1][new] @ point[:-1][new] < 0.0
        return "joined the branch that it came from" if faded else usual(before, point)

    trace = follow(curve, *start, stop, STEPS)
    trace, ended = end_of_trace(curve, trace, band)
    return branch_of_trace(curve.balance, curve, trace, ended)


def subharmonic_branches(
    response: Response, order: int, *, harmonics: int = 15
) -> tuple[Branch, ...]:
    """Return the branches of motions that repeat every so many periods of the excitation.

    Such a branch lies around the backbone at the excitation's frequency over the order. It is
    sought from free motions of that frequency, at several phases.

    Parameters
    ----------
    response : Response
        Model, level and band.
    order : int
        Periods of the excitation after which the motion repeats, 2 or more.
    harmonics : int
        Highest harmonic of the excitation that is carried.

    Returns
    -------
    tuple of Branch
        Each once; empty where no such motion was found.

    Raises
    ------
    ValueError
        If `order` is below 2.
    """
    if order < 2:
        raise ValueError(f"order must be at least 2, not {order}")
    balance = balance_of_system(response.branches[0].balance.system, harmonics, order)
    largest = max(float(np.max(np.abs(samples_of_branch(b, 256)))) for b in response.branches)
    free = backbone(response.model, (1e-3 * largest, 2.0 * largest), harmonics=harmonics)
    branches: list[Branch] = []
    for guess, omega in _guesses(balance, free, response.band):
        frequency = omega * order / (2.0 * np.pi)
        covered = [b for b in branches if np.ptp(np.sign(b.frequency - frequency)) > 0.0]
        solution = None if covered else newton(balance, guess, omega, most=12)
        if solution is not None and _subharmonic_share(balance, solution) > 0.05:
            branches.append(_both_ways(balance, np.append(solution, omega), response.band))
    return tuple(branches)


def _subharmonic_share(balance: HarmonicBalance, unknowns: FloatArray) -> float:
    """Return the share of the harmonics that are none of the excitation's [-]."""
    subharmonic = balance.numbers % balance.order != 0
    return float(np.linalg.norm(unknowns[subharmonic]) / np.linalg.norm(unknowns))


def _both_ways(
    balance: HarmonicBalance, start: FloatArray, band: tuple[float, float]
) -> Branch:
    towards = np.zeros(start.size)
    towards[-1] = 1.0
    onwards = follow_branch(balance, start, towards, band, STEPS)
    if CLOSED in onwards.ended:
        return onwards
    return joined(follow_branch(balance, start, -towards, band, STEPS), onwards)


def _guesses(
    balance: HarmonicBalance, free: Backbone, band: tuple[float, float]
) -> Iterator[tuple[FloatArray, float]]:
    """Yield free motions and base rates at which to look."""
    for frequency in np.geomspace(*band, FREQUENCIES + 2)[1:-1] / balance.order:
        above = free.frequency >= frequency
        for i in np.flatnonzero(above[1:] != above[:-1]):
            omega = 2.0 * np.pi * frequency
            forced = np.linalg.lstsq(balance.reference_matrix(omega), balance.load)[0]
            for phase in np.arange(PHASES) * (2.0 * np.pi / PHASES):
                yield forced + _free_motion_in(balance, free, int(i), float(phase)), omega


def _free_motion_in(
    balance: HarmonicBalance, free: Backbone, point: int, phase: float
) -> FloatArray:
    old: ComplexArray = free.balance.coefficients(free.unknowns[point])
    turned = old * np.exp(1j * phase * free.balance.harmonics)
    new = np.zeros((old.shape[0], balance.harmonics.size), np.complex128)
    common, into, out_of = np.intersect1d(
        balance.harmonics, free.balance.harmonics, return_indices=True
    )
    del common
    new[:, into] = turned[:, out_of]
    return balance.real(new)
