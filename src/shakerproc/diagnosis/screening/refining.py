"""The motion that a force completes which the model lacks."""

from dataclasses import replace
from typing import Final

import numpy as np

from shakerproc.diagnosis.data import RelativeMotion
from shakerproc.diagnosis.screening.completing import Lacking, completed
from shakerproc.diagnosis.screening.laws import StartedLaw
from shakerproc.diagnosis.screening.motion import Motions
from shakerproc.diagnosis.screening.regression import Gains
from shakerproc.diagnosis.screening.shared import Screening
from shakerproc.diagnosis.screening.stretches import Stretch

_SHIFT: Final = 0.01
"""Displacement for the slope of a force, as a share of the largest [-]."""


def completed_by(
    screening: Screening, law: StartedLaw, first: Motions, share: float
) -> Screening:
    """Return the screening around the motion that a share [-] of an effect completes."""
    equations = screening.equations
    gains = screening.gains([law])
    rate = equations.tests[0].sample_rate
    lacking = [
        _lacking(screening, law, gains, _longer(stretch)) for stretch in equations.stretches
    ]
    motions = completed(equations.linear, screening.motions, first, lacking, rate, share=share)
    return screening.with_motions(motions)


def _longer(stretch: Stretch) -> Stretch:
    """Return a stretch with a block before it, where there is one."""
    if stretch.start < stretch.block:
        return stretch
    return replace(stretch, start=stretch.start - stretch.block, n_blocks=stretch.n_blocks + 1)


def _lacking(screening: Screening, law: StartedLaw, gains: Gains, stretch: Stretch) -> Lacking:
    """Return the force on the masses along a stretch that is not in the model."""
    linear, part = screening.equations.linear, slice(stretch.start, stretch.stop)
    absolute = law.effect.absolute
    direction = linear.direction(law.between, second_only=absolute)
    motion = screening.motions.across(law.between, absolute=absolute)[stretch.test]
    amplitude = float(gains.amplitude[0])
    test = screening.equations.tests[stretch.test]
    own = law.force(motion, stretch, test)
    total = -amplitude * np.outer(direction, own)
    for joint, k, c in zip(screening.joints, *screening.changes(gains.common[0]), strict=True):
        across = screening.motions.across(joint)[stretch.test]
        force = k * across.displacement[part] + c * across.velocity[part]
        total -= np.outer(linear.direction(joint), force)
    shift = _SHIFT * float(np.max(np.abs(motion.displacement[part])))
    if absolute or shift == 0.0:
        return Lacking(stretch, total, direction, 0.0)
    shifted = RelativeMotion(motion.displacement + shift, motion.velocity)
    rise = stretch.folded(law.force(shifted, stretch, test) - own).mean(axis=-1) / shift
    return Lacking(stretch, total, direction, max(0.0, amplitude * float(np.max(rise))))
