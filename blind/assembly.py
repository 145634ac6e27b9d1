"""What the truth integrates: structure, hidden effects and the nuisances that move."""

from typing import Any

import numpy as np

from blind import laws
from blind.nuisances import Nuisances
from blind.ranges import Hidden
from blind.structures import Structure
from blind.truth import Motion, Truth

NOTHING = Nuisances()


def assemble(
    structure: Structure,
    at: int,
    hidden: list[Hidden],
    drawn: Nuisances = NOTHING,
    test: int = 0,
) -> tuple[Truth, list[list[int]]]:
    """Return what to integrate, and the elements that belong to each hidden effect."""
    masses = list(structure.masses)
    joints = [(j.first, j.second, j.stiffness, j.damping) for j in structure.joints]
    elements: list[Any] = []
    where = structure.joints[at]
    columns = []
    for effect in hidden:
        first = len(elements)
        for code, parameters, thresholds in effect.parts:
            elements.append((code, where.first, where.second, parameters, thresholds))
        if effect.attached:
            mass, k, c = effect.attached
            masses.append(mass)
            elements.append((laws.SPRING, where.second, len(masses) - 1, (k,), ()))
            elements.append((laws.DAMPER, where.second, len(masses) - 1, (c,), ()))
        columns.append(list(range(first, len(elements))))
    if drawn.drift:
        for j in structure.joints:
            values = (j.stiffness, *drawn.drift[test])
            elements.append((laws.DRIFT, j.first, j.second, values, ()))
    if drawn.second_mode:
        joints.append(_second_mode(structure, drawn.second_mode, masses))
    rest = sum(effect.start for effect in hidden)
    start = tuple(rest if i >= where.second else 0.0 for i in range(len(masses)))
    truth = Truth(tuple(masses), tuple(joints), tuple(elements), structure.force_on, start)
    return truth, columns


def _second_mode(
    structure: Structure, numbers: tuple[float, float, float], masses: list[float]
) -> tuple[int, int, float, float]:
    """Hang a share of the last mass on a spring of its own; what is weighed stays the same."""
    share, factor, ratio = numbers
    last, first = len(structure.masses) - 1, structure.joints[0]
    omega = factor * float(np.sqrt(first.stiffness / structure.masses[0]))
    mass = share * masses[last]
    masses[last] -= mass
    masses.append(mass)
    return last, len(masses) - 1, mass * omega**2, 2.0 * ratio * mass * omega


def exercised(
    structure: Structure, at: int, motion: Motion, columns: list[list[int]]
) -> list[float]:
    """Return what no linear refit makes of each hidden force, as a share of the response."""
    mass = structure.masses[structure.joints[at].second]
    forces = [motion.force[:, indices].sum(axis=1) / mass for indices in columns]
    joint = structure.joints[at]
    z, w = (
        x[:, joint.second] - (x[:, joint.first] if joint.first >= 0 else 0.0)
        for x in (motion.displacement, motion.velocity)
    )
    fine = motion.acceleration[
        :: motion.acceleration.shape[0] // z.size, structure.joints[at].second
    ]
    out = []
    for i, force in enumerate(forces):
        beside = np.array([z, w, *(f for j, f in enumerate(forces) if j != i)])
        size = np.sqrt(np.mean(beside**2, axis=1, keepdims=True))
        beside /= np.where(size > 0.0, size, 1.0)
        left = force - np.linalg.lstsq(beside.T, force, rcond=None)[0] @ beside
        out.append(float(np.sqrt(np.mean(left**2) / np.mean(fine**2))))
    return out


def shows(shares: list[float], noise: float) -> bool:
    """Whether each hidden force is more than 3 % of the response and three times the noise."""
    return all(share > max(0.03, 3.0 * noise) for share in shares)
