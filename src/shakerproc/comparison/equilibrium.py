"""Which joint forces follow from the accelerations of the masses that have a sensor."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models import Model
from shakerproc.models.effects.attached_mode import AttachedMode
from shakerproc.numerals import numeral

_NONE: Final = 1e-9
"""Share of a unit force below which rounding alone is left [-]."""


@final
@dataclass(frozen=True, slots=True)
class Joint:
    """One joint, and how its force follows from equilibrium.

    Attributes
    ----------
    between : (str, str)
        The two places, in the direction in which the joint is first written.
    weights : mapping of str to float, optional
        Factor of inertia less external force of each mass, whose sum is the force in the
        joint [-]; None where the sensors leave it open.
    why : str
        Why it is open; empty where it is not.
    """

    between: tuple[str, str]
    weights: Mapping[str, float] | None
    why: str = ""


def joints_of(model: Model, sensed: Collection[str]) -> tuple[Joint, ...]:
    r"""Return every joint of a model with the weights that tell its force.

    .. math:: m_i \ddot x_i - f_i = \sum_e S_{ie} q_e, \qquad
        q_e = \sum_i w_i (m_i \ddot x_i - f_i) \quad\text{where}\quad S^T w = \mathbf 1_e

    with a row of :math:`S` for every mass that has a sensor, and a column for every joint and
    every further mode: a joint's force is told where no other force has its part in the sum.

    Parameters
    ----------
    model : Model
        Its masses, joints and modes; no stiffness and no damping plays a part.
    sensed : collection of str
        Places whose acceleration is measured.
    """
    pairs = pairs_of(model)
    forces, names = _incidence(model, pairs)
    here = [i for i, mass in enumerate(model.masses) if mass in sensed]
    told, told_by_all = _solved(forces[here]), _solved(forces)
    told_alone = _solved(forces[:, : len(pairs)])
    masses = list(model.masses)
    found = []
    for k, between in enumerate(pairs):
        by_sensed = told[k]
        if by_sensed is not None:
            weights = {masses[i]: float(w) for i, w in zip(here, by_sensed, strict=True) if w}
            found.append(Joint(between, weights))
            continue
        by_all = told_by_all[k]
        if by_all is not None:
            lacking = [m for m, w in zip(masses, by_all, strict=True) if w and m not in sensed]
            why = f"no sensor on {' and '.join(lacking)}, which it moves"
        elif not np.any(forces[:, k]):
            why = "points of structures: elastic forces act on them besides"
        elif told_alone[k] is not None:
            why = f"only its sum with the force of {' and '.join(names)} is told"
        else:
            why = f"only sums with the forces {_loop(forces, k, pairs)} are told: a loop"
        found.append(Joint(between, None, why))
    return tuple(found)


def pairs_of(model: Model) -> tuple[tuple[str, str], ...]:
    """Return the places of every joint once, in the direction in which it is first written."""
    pairs: dict[frozenset[str], tuple[str, str]] = {}
    for element in model.elements:
        if not isinstance(element.effect, AttachedMode):
            pairs.setdefault(frozenset(element.between), element.between)
    return tuple(pairs.values())


def _incidence(model: Model, pairs: Sequence[tuple[str, str]]) -> tuple[FloatArray, list[str]]:
    """Return the acceleration of each mass under a unit of each force, and names of modes."""
    row = {mass: i for i, mass in enumerate(model.masses)}
    columns, names = [], []
    for first, second in pairs:
        column = np.zeros(len(row))
        for place, sign in ((first, 1.0), (second, -1.0)):
            if place in row:
                column[row[place]] += sign
        columns.append(column)
    for element in model.elements:
        place = element.between[1]
        if isinstance(element.effect, AttachedMode) and place in row:
            columns.append(-np.eye(len(row))[row[place]])
            names.append(f"the attached mode on {place}")
    for mode in model.modes:
        columns.append(np.array([mode.participation.get(mass, 0.0) for mass in row]))
        names.append(f"the mode of {numeral(mode.frequency, 4)} Hz")
    return np.reshape(columns, (len(columns), len(row))).T, names


def _solved(forces: FloatArray) -> list[FloatArray | None]:
    """Return for each column the weights of the rows that leave it alone, or None."""
    weights: FloatArray = np.asarray(np.linalg.pinv(forces.T), float)
    left = forces.T @ weights - np.eye(forces.shape[1])
    weights[np.abs(weights) < _NONE] = 0.0
    return [
        weights[:, k] if np.max(np.abs(left[:, k]), initial=0.0) < _NONE else None
        for k in range(forces.shape[1])
    ]


def _loop(forces: FloatArray, k: int, pairs: Sequence[tuple[str, str]]) -> str:
    """Return the joints that share a loop with one of them."""
    alone = forces[:, : len(pairs)]
    open_ = np.eye(len(pairs)) - np.linalg.pinv(alone) @ alone
    others = [" - ".join(p) for j, p in enumerate(pairs) if j != k and abs(open_[k, j]) > _NONE]
    return f"between {' and '.join(others)}"
