"""Mean accelerations of motions that jump, without what folds back from above half the rate.

The mean over a sample lets through much of what jumps hold above half the sample rate, and that
folds back. Displacement and velocity at the samples together tell a motion up to the whole
rate, so that what folds back from below it can be taken away [1]_.

References
----------
.. [1] A. Papoulis, "Generalized sampling expansion", IEEE Transactions on Circuits and Systems
   24 (11), 652-654, 1977.
"""

from functools import cache
from typing import Final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import FloatArray
from shakerproc.models.effects.base import AbstractEffect, AbstractMemorylessEffect, Switch
from shakerproc.models.model import Model

HALF: Final = 12
"""Samples on each side of the middle of an interval that tell its second differences [-]."""

REACH: Final = 15
"""Samples on each side that tell what folds back [-]."""

EDGE: Final = HALF + REACH + 1
"""Samples at both ends of a run that keep their plain means [-]."""

_BAND: Final = 0.8 * np.pi  # up to which the filter is right, in radians a sample
_NEAR: Final = 1e-9  # beside a switch, as a share of where it is


def has_jumps(model: Model) -> bool:
    """Return whether a force of a model jumps where its law switches."""
    return any(_jumps(element.effect) for element in model.elements)


def is_smooth(model: Model) -> bool:
    """Return whether no law of a model changes its formula or remembers where it turned."""
    return all(
        isinstance(element.effect, AbstractMemorylessEffect) and not element.effect.switches()
        for element in model.elements
    )


def _jumps(effect: AbstractEffect) -> bool:
    if not isinstance(effect, AbstractMemorylessEffect):
        return False
    return any(_jumps_at(effect, switch) for switch in effect.switches())


def _jumps_at(effect: AbstractMemorylessEffect, switch: Switch) -> bool:
    """Return whether forces on the two sides of a switch stay apart as they are approached.

    At 1 m/s, or at rest.
    """
    near = np.array([-_NEAR, _NEAR, -1e3 * _NEAR, 1e3 * _NEAR])
    near = switch.at + near * max(abs(switch.at), 1e3 * _NEAR)
    if switch.variable == "velocity":
        forces = effect.force_at(np.zeros(4), near)
    else:
        forces = effect.force_at(near, np.ones(4))
    close, farther = np.abs(forces[1::2] - forces[::2])
    return bool(close > 0.5 * farther)


def mean_accelerations(
    displacement: FloatArray, velocity: FloatArray, sample_rate: float
) -> FloatArray:
    """Return mean accelerations over the interval after each sample, (n - 1,) array [m/s^2].

    Up to 0.4 of the rate nothing folds back from between half the rate and the whole rate;
    `EDGE` samples at both ends keep their plain means.

    Parameters
    ----------
    displacement, velocity : (n,) array
        At the samples [m], [m/s].
    sample_rate : float
        Samples per second [Hz].
    """
    plain = np.diff(velocity) * sample_rate
    if plain.size <= 2 * EDGE:
        return plain
    second = np.diff(displacement, 2) * sample_rate**2
    halfway, fold = _filters()
    smooth = np.zeros(plain.size)  # means of what the second differences tell
    inner = slice(HALF, plain.size - HALF)
    smooth[inner] = np.convolve(second, halfway, "valid")
    apart = np.zeros(plain.size)
    apart[inner] = smooth[inner] - plain[inner]
    taken = scipy.ndimage.convolve1d(apart, fold, mode="constant")
    plain[EDGE:-EDGE] += taken[EDGE:-EDGE]
    return plain


@cache
def _filters() -> tuple[FloatArray, FloatArray]:
    """Return coefficients of both filters, (2 HALF,) and (2 REACH + 1,) array [-].

    The first makes means over an interval of second differences around it. These hold another
    share of what folds back than the means do: 1 - f / rate of what both differ by at each
    frequency f, which the second filter adds, leaves none.
    """
    turn = np.linspace(1e-6, _BAND, 512)
    cosines = 2.0 * np.cos(np.outer(turn, np.arange(HALF) + 0.5))
    wanted = 0.5 * turn / np.sin(0.5 * turn)
    half = np.linalg.lstsq(cosines, wanted, rcond=None)[0]
    n = np.arange(-REACH, REACH + 1)
    odd = n % 2 == 1
    fold = np.where(odd, 1.0 / (np.pi * np.where(odd, n, 1)) ** 2, 0.0)
    fold[REACH] = 0.75
    return np.concatenate([half[::-1], half]), fold
