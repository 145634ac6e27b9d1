"""Springs between two places to rest, whose linear part pushes away from between."""

from typing import Final

import numpy as np

from shakerproc.models.effects import AbstractEffect
from shakerproc.models.effects.base import AbstractMemorylessEffect

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
