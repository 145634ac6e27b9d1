"""Where a motion whose mean was not measured lies: where the mean force of a joint is none.

Accelerations tell displacements but for their mean. A law that is not odd pushes that aside, by
a dead weight for one; and a law may have several places to rest at.
"""

from collections.abc import Sequence
from itertools import product
from typing import Final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.diagnosis.data import members_of, models_of
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.hypotheses.joints import Joint, joints_of
from shakerproc.models import Element, Model
from shakerproc.models.coordinates import coordinates_of
from shakerproc.models.effects import Damper, Spring
from shakerproc.models.effects.base import AbstractMemorylessEffect

PERIODS: Final = 10.0
"""Length before and after the beginning of a window over which forces are averaged, in periods
of the motion: the inertia, which they balance, then has no mean to a few per cent [-]."""

SAMPLES: Final = 100
"""Samples of such a stretch that are averaged: five of every period [-]."""

PLACES: Final = np.concatenate([
    -np.geomspace(30.0, 0.03, 20),
    [0.0],
    np.geomspace(0.03, 30.0, 20),
])
"""Means that are tried, over the rms of the motion: 1.4 from one to the next [-]."""

MOST: Final = 4
"""Combinations of resting places of all joints that are looked at, the nearest first [-]."""


def resting_places(
    data: DataSet, model: Model, table: NDArray[np.int64]
) -> tuple[FloatArray, ...]:
    """Return where coordinates may lie in each window, (n_places, n_coordinates) arrays [m].

    The place nearest to none comes first; (0, 0, ...) alone where the mean was measured, or
    every joint pushes back alike on both sides.

    Parameters
    ----------
    data : DataSet
        The tests.
    model : Model
        Says which forces act.
    table : (n_windows, 3) array of int
        Test, first sample, and number of samples.
    """
    found = [np.zeros((0, 0))] * len(table)
    for own, members in members_of(models_of(model, data.tests), table):
        for i, places in zip(members, _of_one_model(data, own, table[members]), strict=True):
            found[i] = places
    return tuple(found)


def _of_one_model(
    data: DataSet, model: Model, table: NDArray[np.int64]
) -> tuple[FloatArray, ...]:
    """Return the places of windows of tests in which the model is the same."""
    joints = _shifting(data, model)
    if not joints:
        return (np.zeros((1, model.n_coordinates)),) * len(table)
    spread = np.linalg.pinv(np.array([apart(model, joint) for joint in joints]))
    roots = [
        _roots(*_mean_force(model, joint, _stretches(data, joint, table))) for joint in joints
    ]
    return tuple(_combined(each) @ spread.T for each in zip(*roots, strict=True))


def may_shift(data: DataSet, model: Model) -> bool:
    """Return whether the mean of a displacement is neither measured nor none."""
    return bool(_shifting(data, model))


def _shifting(data: DataSet, model: Model) -> list[Joint]:
    """Return the joints that may rest elsewhere than at none, as far as nothing tells."""
    if any(sensor.measures == "displacement" for sensor in model.sensors.values()):
        return []
    return [joint for joint in joints_of(model) if _may_shift(data, model, joint)]


def _stretches(data: DataSet, joint: Joint, table: NDArray[np.int64]) -> FloatArray:
    """Return displacements of a joint around the beginning of each window, a row each [m]."""
    half = PERIODS * data.lengths.unit_s * data.tests[0].sample_rate
    rows = np.empty((len(table), SAMPLES))
    for i, motion in enumerate(data.across(joint)):
        own, z = table[:, 0] == i, motion.displacement
        first, last = table[own, 1] - half, table[own, 1] + half
        ends = np.maximum(first, 0.0), np.minimum(last, z.size - 1.0)
        rows[own] = z[np.linspace(*ends, SAMPLES, axis=-1).astype(int)]
    return rows


def _elements(model: Model, joint: Joint) -> list[Element]:
    return [one for one in model.elements if set(one.between) == set(joint)]


def _may_shift(data: DataSet, model: Model, joint: Joint) -> bool:
    """Return whether a joint may rest elsewhere than at none, all its laws without memory.

    Not if its force is as large on both sides and pushes away on neither.
    """
    effects = [one.effect for one in _elements(model, joint)]
    if not all(isinstance(effect, AbstractMemorylessEffect) for effect in effects):
        return False
    if all(isinstance(effect, (Spring, Damper)) for effect in effects):
        return False
    z = data.largest_across(joint) * PLACES[PLACES > 0.0]
    force, other = _static_force(model, joint, z), _static_force(model, joint, -z)
    return not np.allclose(force, -other, atol=0.0) or bool(np.any(force < 0.0))


def apart(model: Model, joint: Joint) -> FloatArray:
    """Return the motion of a joint by unit coordinates, (n_coordinates,) array [-]."""
    return coordinates_of(model, ()).across(joint)[: model.n_coordinates]


def _mean_force(model: Model, joint: Joint, z: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return means of a joint's displacement that are tried, and its mean force there.

    Without friction: of a joint at rest it tells nothing.

    Parameters
    ----------
    model : Model
        Says which forces act.
    joint : (str, str)
        Where.
    z : (n_windows, SAMPLES) array
        Displacement but for its mean [m].

    Returns
    -------
    (n_windows, n_places) array, (n_windows, n_places) array
        [m], [N].
    """
    places = PLACES * np.sqrt(np.mean(z**2, axis=1, keepdims=True))
    moved = places[:, :, np.newaxis] + z[:, np.newaxis]
    return places, _static_force(model, joint, moved).mean(axis=2)


def _static_force(model: Model, joint: Joint, z: FloatArray) -> FloatArray:
    """Return the force of all laws of a joint at rest, at displacements [N]."""
    force = np.zeros_like(z)
    for element in _elements(model, joint):
        sign, law = 1.0 if element.between == joint else -1.0, element.effect
        if isinstance(law, AbstractMemorylessEffect):
            force += sign * law.force_at(sign * z, np.zeros_like(z))
    return force


def _roots(places: FloatArray, force: FloatArray) -> list[list[float]]:
    """Return where the mean force of each window turns to pushing back, the nearest first."""
    out = []
    for row, own in zip(places, force, strict=True):
        i = np.flatnonzero((own[:-1] < 0.0) & (own[1:] >= 0.0))
        share = own[i] / (own[i] - own[i + 1])
        found = row[i] + share * (row[i + 1] - row[i])
        out.append(sorted(map(float, found), key=abs) or [0.0])
    return out


def _combined(roots: Sequence[Sequence[float]]) -> FloatArray:
    """Return combinations of the roots of all joints, the nearest first."""
    found = sorted(product(*roots), key=lambda one: sum(map(abs, one)))
    return np.array(found[:MOST])
