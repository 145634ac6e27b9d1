"""The joints of a model, how they move, and what each effect says of its own identification."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final, TypeAlias

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.data import PreparedTest, RelativeMotion
from shakerproc.models import BASE, Model, Scale
from shakerproc.models.coordinates import mobility, resolved
from shakerproc.models.effects import EFFECTS, AbstractEffect, Spring
from shakerproc.models.effects.base import AbstractMemorylessEffect
from shakerproc.models.identification import Identification, JointScales
from shakerproc.models.laws import Law

Joint: TypeAlias = tuple[str, str]

Known: TypeAlias = Mapping[Joint, Mapping[str, Identification]]
"""What each effect says of each joint."""


def joints_of(model: Model) -> tuple[Joint, ...]:
    """Return the pairs of places between which the model has elements, each once."""
    found: dict[frozenset[str], Joint] = {}
    for element in model.elements:
        found.setdefault(frozenset(element.between), (element.between[0], element.between[1]))
    return tuple(found.values())


def linear_parts(model: Model, joint: Joint) -> tuple[float, float]:
    """Return the stiffness [N/m] and damping [N s/m] of what is linear in a joint."""
    rows = [e.effect.rows() for e in resolved(model) if set(e.between) == set(joint)]
    linear = [row.values for own in rows for row in own if row.law is Law.LINEAR]
    return sum(v[0] for v in linear), sum(v[1] for v in linear)


def scales_of(
    model: Model, tests: Sequence[PreparedTest], joint: Joint, motions: Sequence[RelativeMotion]
) -> JointScales:
    """Return how a joint moves in the tests, and the force that it carries."""
    springs = [
        e.effect.stiffness for e in model.elements
        if isinstance(e.effect, Spring) and set(e.between) == set(joint)
    ]  # fmt: skip
    inverse = mobility(model, joint)
    mass = 1.0 / inverse if inverse else max(model.masses.values())
    displacement = max(_peak(motion.displacement) for motion in motions)
    velocity = max(_peak(motion.velocity) for motion in motions)
    stiffness = max(sum(springs), 0.0)
    told = max(carried_force(model, tests, joint), stiffness * displacement)
    return JointScales(
        displacement=displacement,
        velocity=velocity,
        force=told or max(mass * velocity**2 / displacement, 1e-12),  # its inertia
        stiffness=stiffness,
        mass=mass,
        duration=max(test.n_samples / test.sample_rate for test in tests),
        band=math.inf if model.excitation.imposed else max(test.band[1] for test in tests),
    )


def _peak(samples: FloatArray) -> float:
    return max(float(np.max(np.abs(samples))), 1e-15)


def carried_force(model: Model, tests: Sequence[PreparedTest], joint: Joint) -> float:
    """Return the largest force that a joint carries, as sensors tell it [N].

    Mass times acceleration of the mass that hangs on it, or the force that imposes its motion;
    where no sensor measures either, the force that drives one of its sides.
    """
    on = next((place for place in reversed(joint) if place != BASE), None)
    mass = 0.0 if on is None else 1.0 / mobility(model, (BASE, on))
    found = [0.0]
    for test in tests:
        for sensor, row in zip(model.sensors.values(), test.responses, strict=True):
            if sensor.measures == "acceleration" and sensor.at in joint:
                found.append(mass * _peak(row))
            elif sensor.measures == "force" and sensor.at in joint:
                found.append(_peak(row))
    if not any(found) and model.excitation.on in joint and not model.excitation.imposed:
        found = [_peak(test.input) for test in tests]
    return max(found)


def identifications(
    at: JointScales, scaled_by: Scale | None = None
) -> Mapping[str, Identification]:
    """Return the identification of each effect in a joint that moves like this, by kind.

    Where a condition scales them, `at` holds at that of the scale.
    """
    known = {kind: effect.identification(at) for kind, effect in EFFECTS.items()}
    return {
        kind: one if scaled_by is None else replace(one, scaled_by=scaled_by)
        for kind, one in known.items()
        if one is not None
    }


def has_limit(known: Known, richer: tuple[str, Joint], simpler: tuple[str, Joint]) -> bool:
    """Return whether an effect has another one, in the same joint, as a limit."""
    kind, joint = richer
    other, there = simpler
    return joint == there and any(
        one.limit and one.kind == other for one in known[joint][kind].contains
    )


PLACES: Final = np.geomspace(0.2, 1.5, 8)
"""Places to rest that are tried, over the largest displacement that was measured [-]."""


def wells_of(
    effect: AbstractEffect, nearby: float, largest: float
) -> tuple[tuple[float, float], ...]:
    """Return sizes of a law and linear stiffnesses that hold a joint beside its middle.

    The law's force is f(z), times a size. With a negative stiffness it holds the joint at z0
    and at -z0, and is as stiff there as it is known to be nearby::

        stiffness z0 + size f(z0) = 0,    stiffness + size f'(z0) = nearby

    Accelerations do not tell in which well the joint is.

    Parameters
    ----------
    effect : AbstractEffect
        The law; none are returned of one that does not push back alike on both sides.
    nearby : float
        Stiffness that the joint has where it rests [N/m].
    largest : float
        Largest displacement that was measured [m].

    Returns
    -------
    tuple of (float, float)
        Size over that of the law [-], and stiffness [N/m].
    """
    if nearby <= 0.0 or not isinstance(effect, AbstractMemorylessEffect):
        return ()
    z = PLACES * largest
    force, other = effect.force_at(z, 0.0 * z), effect.force_at(-z, 0.0 * z)
    bend = effect.slopes(z, 0.0 * z)[0] - force / z
    if not np.allclose(force, -other, atol=0.0) or np.any(bend == 0.0):
        return ()
    sizes, stiffnesses = nearby / bend, -nearby * force / (z * bend)
    return tuple((float(s), float(k)) for s, k in zip(sizes, stiffnesses, strict=True))
