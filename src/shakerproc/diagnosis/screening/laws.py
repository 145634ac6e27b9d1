"""Forces of effects along the measured motion of a joint."""

from dataclasses import dataclass
from typing import final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.data import PreparedTest, RelativeMotion
from shakerproc.diagnosis.screening.stretches import Stretch
from shakerproc.diagnosis.screening.transfer import Joint
from shakerproc.models.conditions import share_of
from shakerproc.models.effects import AbstractEffect
from shakerproc.models.effects.base import AbstractMemorylessEffect
from shakerproc.models.identification import Identification, Values


@final
@dataclass(frozen=True, slots=True, eq=False)
class StartedLaw:
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
    def one_sign(self) -> bool:
        """Whether its force may not be turned round: a scaled coordinate must be above 0."""
        free = self.identification.free
        names = self.identification.scaled
        return any(free[name].transform == "logarithm" for name in names)

    def force(self, motion: RelativeMotion, stretch: Stretch, test: PreparedTest) -> FloatArray:
        """Return its force along a stretch of a test, under the conditions of the test [N].

        A law with memory begins a block before; one that knows the time, with the test.
        """
        force = force_along(self.effect, motion, stretch, test.sample_rate)
        return share_of(self.identification.scaled_by, test.conditions) * force


def force_along(
    effect: AbstractEffect, motion: RelativeMotion, stretch: Stretch, sample_rate: float
) -> FloatArray:
    """Return the force of an effect along a stretch of a test (see `StartedLaw.force`) [N]."""
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


def _knows_time(effect: AbstractEffect, motion: RelativeMotion, sample_rate: float) -> bool:
    """Return whether the force changes while the joint rests away from its zero."""
    still = np.full(2, motion.displacement[np.argmax(motion.displacement[::16]) * 16] or 1.0)
    force = effect.force_along(still, 0.0 * still, sample_rate)
    return bool(force[0] != force[1])
