"""Subharmonic motion on branches of its own: it repeats every second, third, ... period."""

from collections.abc import Iterator

import numpy as np

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.simulation.harmonic_balance.backbone import Backbone, backbone
from shakerproc.simulation.harmonic_balance.balance import HarmonicBalance
from shakerproc.simulation.harmonic_balance.branch import Branch, joined, samples_of_branch
from shakerproc.simulation.harmonic_balance.continuation import StepSizes
from shakerproc.simulation.harmonic_balance.ends import CLOSED
from shakerproc.simulation.harmonic_balance.response import (
    Response,
    balance_of_system,
    follow_branch,
)
from shakerproc.simulation.harmonic_balance.solve import newton

FREQUENCIES, PHASES = 10, 8
"""How many frequencies and phases are tried."""


def subharmonic_branches(
    response: Response, order: int, *, harmonics: int = 15, steps: StepSizes | None = None
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
    steps : StepSizes, optional
        How the curve is followed.

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
    chosen = steps or StepSizes(most=600)
    branches: list[Branch] = []
    for guess, omega in _guesses(balance, free, response.band):
        frequency = omega * order / (2.0 * np.pi)
        covered = [b for b in branches if np.ptp(np.sign(b.frequency - frequency)) > 0.0]
        found = None if covered else newton(balance, guess, omega, most=12)
        if found is not None and _own_share(balance, found) > 0.05:
            branches.append(_both_ways(balance, np.append(found, omega), response.band, chosen))
    return tuple(branches)


def _own_share(balance: HarmonicBalance, unknowns: FloatArray) -> float:
    """Return the share of the harmonics that are none of the excitation's [-]."""
    own = balance.numbers % balance.order != 0
    return float(np.linalg.norm(unknowns[own]) / np.linalg.norm(unknowns))


def _both_ways(
    balance: HarmonicBalance, start: FloatArray, band: tuple[float, float], steps: StepSizes
) -> Branch:
    towards = np.zeros(start.size)
    towards[-1] = 1.0
    onwards = follow_branch(balance, start, towards, band, steps)
    if CLOSED in onwards.ended:
        return onwards
    return joined(follow_branch(balance, start, -towards, band, steps), onwards)


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
                yield forced + _embedded(balance, free, int(i), float(phase)), omega


def _embedded(balance: HarmonicBalance, free: Backbone, point: int, phase: float) -> FloatArray:
    old: ComplexArray = free.balance.coefficients(free.unknowns[point])
    turned = old * np.exp(1j * phase * free.balance.harmonics)
    new = np.zeros((old.shape[0], balance.harmonics.size), np.complex128)
    common, into, out_of = np.intersect1d(
        balance.harmonics, free.balance.harmonics, return_indices=True
    )
    del common
    new[:, into] = turned[:, out_of]
    return balance.real(new)
