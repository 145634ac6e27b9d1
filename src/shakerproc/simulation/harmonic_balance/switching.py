"""From one branch to another: where symmetry is lost, and where the period doubles."""

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.simulation.harmonic_balance.balance import HarmonicBalance
from shakerproc.simulation.harmonic_balance.branch import Branch, BranchMark, branch_of_trace
from shakerproc.simulation.harmonic_balance.continuation import StepSizes, correct, follow
from shakerproc.simulation.harmonic_balance.curves import ForcedCurve
from shakerproc.simulation.harmonic_balance.ends import end_of_trace, limits

STARTS = (0.03, 0.1, 0.01)
"""Share of the new harmonics to begin a new branch with [-]."""


def branch_off(
    branch: Branch, mark: BranchMark, band: tuple[float, float], steps: StepSizes | None = None
) -> Branch | None:
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
    steps : StepSizes, optional
        How the curve is followed.

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
            found = correct(curve, guess, direction, weights, 1e-9)
            if found is not None and _share(curve, found[0], new) > 0.3 * share:
                towards = direction / weights
                return _follow(
                    curve, (found[0], towards), new, band, steps or StepSizes(most=600)
                )
    return None


def branches_off(
    branch: Branch, band: tuple[float, float], steps: StepSizes | None = None
) -> tuple[Branch, ...]:
    """Return every branch that leaves another, each once.

    Parameters
    ----------
    branch : Branch
        The known branch, its marks sharpened.
    band : tuple of float
        Frequencies of the excitation [Hz].
    steps : StepSizes, optional
        How the curves are followed.
    """
    found: list[Branch] = []
    for mark in branch.marks:
        other = None if mark.kind == "fold" else branch_off(branch, mark, band, steps)
        if other is not None and not any(_alike(known, other) for known in found):
            found.append(other)
    return tuple(found)


def _alike(known: Branch, other: Branch) -> bool:
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
    steps: StepSizes,
) -> Branch:
    """Return the branch from a point in a direction until its own harmonics fade."""
    least = 0.5 * _share(curve, start[0], new)
    usual = limits(curve, start[0], band)

    def stop(before: FloatArray, point: FloatArray) -> str:
        faded = _share(curve, point, new) < least or before[:-1][new] @ point[:-1][new] < 0.0
        return "joined the branch that it came from" if faded else usual(before, point)

    trace = follow(curve, *start, stop, steps)
    trace, ended = end_of_trace(curve, trace, band)
    return branch_of_trace(curve.balance, curve, trace, ended)
