"""Starts of springs between two places to rest, whose linear part pushes away from between."""

from dataclasses import replace

import numpy as np

from shakerproc.diagnosis.hypotheses.wells import wells_of
from shakerproc.diagnosis.screening.laws import Law
from shakerproc.diagnosis.screening.shared import Screening, linear_parts
from shakerproc.diagnosis.screening.start import Start


def with_wells(screening: Screening, law: Law, start: Start) -> tuple[Start, ...]:
    """Return starts of a law in a joint whose stiffness in the file is that of a well.

    A regression sees nothing of it (see `wells_of`). Only of laws of which nothing but the
    size is free.

    Parameters
    ----------
    screening : Screening
        The linear model and its motion.
    law, start : Law, Start
        The law, and what a regression says of it.
    """
    identification = law.identification
    if tuple(identification.scaled) != tuple(identification.free):
        return ()
    nearby = linear_parts(screening.model, law.between)[0]
    motion = screening.motions.across(law.between)
    largest = max(float(np.max(np.abs(one.displacement))) for one in motion)
    i = screening.joints.index(law.between)
    found = []
    for size, stiffness in wells_of(law.effect, nearby, largest):
        change = np.zeros(len(screening.joints))
        change[i] = stiffness / nearby - 1.0
        found.append(
            replace(
                start,
                values=law.scaled(size),
                stiffness=tuple(map(float, change)),
                damping=(0.0,) * change.size,
                kept=True,
            )
        )
    return tuple(found)
