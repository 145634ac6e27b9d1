"""Solutions of harmonic balance made exact by shooting, where dry friction asks for it."""

from dataclasses import replace

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models import Model
from shakerproc.simulation.harmonic_balance import fourier
from shakerproc.simulation.harmonic_balance.branch import NEUTRAL, Branch
from shakerproc.simulation.harmonic_balance.shooting import Orbit, periodic_orbit
from shakerproc.simulation.harmonic_balance.stability import multipliers

NEAR = 0.2
"""How far shooting may go from harmonic balance, over the size of the motion [-]."""


def polished(model: Model, level: float, branch: Branch) -> Branch:
    """Return a branch with every motion made exact and with its multipliers.

    A point whose orbit is not found near stays as harmonic balance has it.

    Parameters
    ----------
    model : Model
        What is shaken; its laws have no memory.
    level : float
        Amplitude of the excitation [m/s²] or [N].
    branch : Branch
        Its motions by harmonic balance.
    """
    unknowns, found = branch.unknowns.copy(), branch.multipliers.copy()
    stable = branch.stable.copy()
    for i in range(branch.frequency.size):
        orbit = _orbit(model, level, branch, i)
        if orbit is None:
            continue
        coefficients = fourier.coefficients_of_values(orbit.motion, branch.balance.harmonics)
        exact = branch.balance.real(coefficients)
        if np.linalg.norm(exact - unknowns[i]) < NEAR * np.linalg.norm(exact):
            unknowns[i] = exact
            found[i] = multipliers(orbit.monodromy)
            stable[i] = bool(np.abs(found[i, 0]) <= 1.0 + NEUTRAL)
    return replace(branch, unknowns=unknowns, multipliers=found, stable=stable)


def _orbit(model: Model, level: float, branch: Branch, point: int) -> Orbit | None:
    balance = branch.balance
    return periodic_orbit(
        model,
        level,
        float(branch.frequency[point]),
        state_of(branch, point),
        order=balance.order,
        n_samples=4 * int(balance.harmonics[-1]) // balance.order + 4,
    )


def state_of(branch: Branch, point: int) -> FloatArray:
    """Return displacements and velocities at time 0, (2 n_dofs,) array [m], [m/s].

    Parameters
    ----------
    branch : Branch
        Motions by harmonic balance.
    point : int
        Which of them.
    """
    balance = branch.balance
    omega = 2.0 * np.pi * branch.frequency[point] / balance.order
    start: list[FloatArray] = [
        np.array(fourier.value(row, balance.harmonics, 0.0)[:2])
        for row in balance.coefficients(branch.unknowns[point])
    ]
    states = np.array(start)
    return np.concatenate([states[:, 0], omega * states[:, 1]])
