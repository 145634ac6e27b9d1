"""Starts of springs between two places to rest, whose linear part pushes away from between."""

from dataclasses import replace
from typing import Final

import numpy as np

from shakerproc.diagnosis.screening.laws import Law
from shakerproc.diagnosis.screening.shared import Screening, linear_parts
from shakerproc.diagnosis.screening.start import Start
from shakerproc.models.effects.base import AbstractMemorylessEffect

WELLS: Final = np.geomspace(0.2, 1.5, 8)
"""Places to rest that are tried, over the largest displacement that was measured [-]."""


def with_wells(screening: Screening, law: Law, start: Start) -> tuple[Start, ...]:
    """Return starts of a law in a joint whose stiffness in the file is that of a well.

    The law's force is f(z), times a size. With a negative stiffness it holds the joint at z0
    and at -z0, and is as stiff there as the file says::

        stiffness z0 + size f(z0) = 0,    stiffness + size f'(z0) = stiffness of the file

    A regression sees nothing of it: accelerations do not tell in which well the joint is. Only
    laws of which nothing but the size is free, and that push back alike on both sides.

    Parameters
    ----------
    screening : Screening
        The linear model and its motion.
    law, start : Law, Start
        The law, and what a regression says of it.
    """
    identification, effect = law.identification, law.effect
    nearby = linear_parts(screening.model, law.between)[0]
    only_size = tuple(identification.scaled) == tuple(identification.free)
    if nearby <= 0.0 or not only_size or not isinstance(effect, AbstractMemorylessEffect):
        return ()
    motion = screening.motions.across(law.between)
    z = WELLS * max(float(np.max(np.abs(one.displacement))) for one in motion)
    force, other = effect.force_at(z, 0.0 * z), effect.force_at(-z, 0.0 * z)
    bend = effect.slopes(z, 0.0 * z)[0] - force / z
    if not np.allclose(force, -other, atol=0.0) or np.any(bend == 0.0):
        return ()
    i = screening.joints.index(law.between)
    found = []
    for size, stiffness in zip(nearby / bend, -nearby * force / (z * bend), strict=True):
        change = np.zeros(len(screening.joints))
        change[i] = stiffness / nearby - 1.0
        found.append(
            replace(
                start,
                values=law.scaled(float(size)),
                stiffness=tuple(map(float, change)),
                damping=(0.0,) * change.size,
                kept=True,
            )
        )
    return tuple(found)
