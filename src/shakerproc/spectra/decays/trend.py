"""Whether frequency and damping of a decay change with its amplitude, and as which power."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import FloatArray
from shakerproc.spectra.decays.reading import Reading

LEAST: Final = 5
"""Readings that a trend needs at least [-]: three beyond a straight line."""

SHARED: Final = 2.0
"""How much the variance of a slope grows as each reading shares half its stretch with the one
before [-]: as if every other reading were left out."""

SURE: Final = 0.99
"""Probability of an interval of a slope, and that chance shows no trend [-]: of a hundred
decays of a linear structure one does."""


@final
@dataclass(frozen=True, slots=True)
class Slope:
    """How values go with the logarithm of amplitude.

    Attributes
    ----------
    value : float
        Slope of a straight line.
    error : float
        Half the width of its interval of probability `SURE`; a curved law makes it wide.
    sure : bool
        Whether the values change by more than their own intervals allow, straight or not.
    """

    value: float
    error: float
    sure: bool


@final
@dataclass(frozen=True, slots=True)
class Trend:
    """How a mode depends on its amplitude.

    Attributes
    ----------
    frequency : Slope
        Relative change of the frequency for each factor e of the amplitude [-].
    damping : Slope
        Exponent p where the damping ratio goes as amplitude to the power p [-].
    """

    frequency: Slope
    damping: Slope


def trend_of(readings: Sequence[Reading]) -> Trend | None:
    """Return how a mode depends on its amplitude; None where too few readings tell.

    Parameters
    ----------
    readings : sequence of Reading
        Of one method along the decay, each sharing half of its stretch with the one before.
    """
    used = [one for one in readings if one.damping > 0.0]
    if len(used) < LEAST:
        return None
    amplitude = np.log([one.amplitude for one in used])
    frequency = np.array([one.frequency for one in used])
    damping = np.array([one.damping for one in used])
    return Trend(
        _slope(
            amplitude,
            frequency / frequency.mean(),
            np.array([one.frequency_error for one in used]) / frequency.mean(),
        ),
        _slope(
            amplitude,
            np.log(damping),
            np.array([one.damping_error for one in used]) / damping,
        ),
    )


def _slope(x: FloatArray, y: FloatArray, errors: FloatArray) -> Slope:
    """Return the slope of values weighted by their errors.

    The scatter about the line makes these larger, never smaller: a curve is no straight line.
    """
    scale = errors / 1.96  # half of a 95 % interval to a standard deviation
    weights = scale**-2
    centre = float(weights @ x / weights.sum())
    spread = float(weights @ (x - centre) ** 2)
    level = float(weights @ y / weights.sum())
    slope = float(weights @ ((x - centre) * y)) / spread
    freedom = x.size - 2
    scatter = float(weights @ (y - level - slope * (x - centre)) ** 2) / freedom
    half = float(scipy.special.stdtrit(freedom, 0.5 + 0.5 * SURE))
    changes = float(weights @ (y - level) ** 2) / SHARED
    chance = float(scipy.special.chdtri(x.size - 1, 1.0 - SURE))
    return Slope(
        slope, half * float(np.sqrt(SHARED * max(scatter, 1.0) / spread)), changes > chance
    )
