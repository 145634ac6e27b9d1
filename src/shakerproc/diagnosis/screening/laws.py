"""Forces of effects along the measured motion of a joint."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.data import JointMotion, Test
from shakerproc.diagnosis.screening.stretches import Stretch
from shakerproc.diagnosis.screening.transfer import Joint
from shakerproc.errors import ModelError
from shakerproc.models import Element, Model
from shakerproc.models.conditions import share_of
from shakerproc.models.coordinates import resolved
from shakerproc.models.effects import EFFECTS, AbstractEffect
from shakerproc.models.effects.base import AbstractMemorylessEffect
from shakerproc.models.identification import Identification, Values


@final
@dataclass(frozen=True, slots=True, eq=False)
class Law:
    """An effect at a start, in a joint.

    Attributes
    ----------
    kind : str
        Key of the effect.
    between : (str, str)
        The joint.
    identification : Identification
        Of the effect there.
    values : mapping
        Its coordinates and fixed values.
    effect : AbstractEffect
        The effect with these numbers, and those of its surroundings.
    """

    kind: str
    between: Joint
    identification: Identification
    values: Values
    effect: AbstractEffect

    @property
    def words(self) -> tuple[str, ...]:
        """Words for a variant of the effect."""
        return tuple(v for v in self.values.values() if isinstance(v, str))

    @property
    def one_sign(self) -> bool:
        """Whether its force may not be turned round: a scaled coordinate must be above 0."""
        free = self.identification.free
        names = self.identification.scaled
        return any(free[name].transform == "logarithm" for name in names)

    @property
    def slides(self) -> bool:
        """Whether it is dry friction: its force turns round with the velocity, at a jump."""
        if not isinstance(self.effect, AbstractMemorylessEffect):
            return False
        if not any(s.variable == "velocity" and s.at == 0.0 for s in self.effect.switches()):
            return False
        slow, fast = self.effect.force_at(np.zeros(2), np.array([1e-9, 1.0]))
        return bool(abs(slow) > 1e-6 * abs(fast))

    @property
    def sticks(self) -> bool:
        """Whether its force at rest is not told by the motion, or depends on the past.

        A regression on the measured motion is blind to such a force while the joint rests.
        """
        return self.slides or not isinstance(self.effect, AbstractMemorylessEffect)

    @property
    def constant(self) -> bool:
        """Whether its force is the same wherever the joint is and however it moves.

        It shifts where the joint rests, of which a regression on the measured motion, which
        has no mean, sees nothing.
        """
        if not isinstance(self.effect, AbstractMemorylessEffect):
            return False
        places = np.linspace(-1.0, 1.0, 5)
        force = self.effect.force_at(*np.meshgrid(places, places))
        return bool(np.ptp(force) == 0.0)

    @property
    def shape(self) -> tuple[object, ...]:
        """Remaining values once the force is scaled; all of a constant force."""
        if self.constant:
            return (self.kind, self.between, *self.values.items())
        names = self.identification.scaled
        unit = abs(float(self.values[names[0]])) if names else 1.0
        sizes = {name: round(float(self.values[name]) / unit, 9) for name in names}
        if not self.one_sign:
            sizes = {name: abs(size) for name, size in sizes.items()}
        return (self.kind, self.between, *({**self.values, **sizes}).items())

    def scaled(self, amplitude: float) -> Values:
        """Return the values that make the force this many times as large, within bounds."""
        free = self.identification.free
        changed = {
            name: _kept(float(self.values[name]) * amplitude, free[name].low, free[name].high)
            for name in self.identification.scaled
        }
        return {**self.values, **changed}

    def force(self, motion: JointMotion, stretch: Stretch, test: Test) -> FloatArray:
        """Return its force along a stretch of a test, under the conditions of the test [N].

        A law with memory begins a block before; one that knows the time, with the test.
        """
        force = force_along(self.effect, motion, stretch, test.sample_rate)
        return share_of(self.identification.scaled_by, test.conditions) * force


def force_along(
    effect: AbstractEffect, motion: JointMotion, stretch: Stretch, sample_rate: float
) -> FloatArray:
    """Return the force of an effect along a stretch of a test (see `Law.force`) [N]."""
    first = stretch.start
    if not isinstance(effect, AbstractMemorylessEffect):
        knows_time = _knows_time(effect, motion, sample_rate)
        first = 0 if knows_time else max(0, first - stretch.block)
    part = slice(first, stretch.stop)
    with np.errstate(all="ignore"):
        along = effect.force_along(
            motion.displacement[part], motion.velocity[part], sample_rate
        )
    return np.asarray(along[stretch.start - first :], float)


def _knows_time(effect: AbstractEffect, motion: JointMotion, sample_rate: float) -> bool:
    """Return whether the force changes while the joint rests away from its zero."""
    still = np.full(2, motion.displacement[np.argmax(motion.displacement[::16]) * 16] or 1.0)
    force = effect.force_along(still, 0.0 * still, sample_rate)
    return bool(force[0] != force[1])


def _kept(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)


def laws_of(
    model: Model, joint: Joint, identifications: Mapping[str, Identification]
) -> tuple[Law, ...]:
    """Return every start of every effect in a joint that the model can have there."""
    every = (
        law_at(model, joint, kind, identification, values)
        for kind, identification in identifications.items()
        for values in identification.starts
    )
    return tuple(law for law in every if law is not None)


def law_at(
    model: Model, joint: Joint, kind: str, identification: Identification, values: Values
) -> Law | None:
    """Return an effect in a joint, or None where the model cannot have it."""
    effect = _effect(model, joint, kind, identification, values)
    return None if effect is None else Law(kind, joint, identification, values, effect)


def with_values(model: Model, law: Law, values: Values) -> Law | None:
    """Return a law with other coordinates, or None where the model cannot have it."""
    return law_at(model, law.between, law.kind, law.identification, values)


def _effect(
    model: Model, joint: Joint, kind: str, identification: Identification, values: Values
) -> AbstractEffect | None:
    """Return an effect in its place, or None where it cannot stand there."""
    try:
        effect = EFFECTS[kind].of_numbers(identification.numbers(values))
        element = Element(effect, joint, identification.scaled_by)
        return resolved(replace(model, elements=(*model.elements, element)))[-1].effect
    except (ValueError, ModelError):
        return None


def one_of_each_shape(laws: Sequence[Law]) -> tuple[Law, ...]:
    """Return laws that differ by more than the size of their force."""
    return tuple({law.shape: law for law in reversed(laws)}.values())[::-1]
