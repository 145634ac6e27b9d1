r"""The least that must be taken from a drive: notches, their edges and their breakpoints.

Of all reductions :math:`D(f)` of a drive that bring the mean squares of linear responses down
to what they may be, the one that takes away the least, in decibels times octaves, clips the
mean square that each octave gives, weighted by prices :math:`\lambda_q` of the limits:

.. math:: \min_D \int D \, d \ln f \quad \text{with} \quad
    \int P_q 10^{-D / 10} \, d \ln f \le T_q, \qquad
    D = \max\left(0,\; 10 \lg \sum_q \lambda_q P_q\right)

with :math:`P_q = f |H_q|^2 W` for a drive of density :math:`W`: where :math:`D > 0`, the
derivative :math:`1 - \lambda P 10^{-D / 10}` of the Lagrangian is 0. A sweep passes the
frequencies one after the other, so that its largest value is clipped where it exceeds.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray

HALVINGS: Final = 50
"""Halvings of the logarithm of a price: to rounding [-]."""

SWEEPS: Final = 20
"""How often the prices of several limits are found in turn [-]."""

DEEPEST: Final = 60.0
"""Reduction that is looked at: a controller has no more range [dB]."""

CLOSE: Final = 0.1
"""By how much breakpoints may miss a reduction: a tenth of what controllers keep to [dB]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Bound:
    """A limit of a mean square.

    Attributes
    ----------
    power : (n_bins,) array
        What each bin of the full drive gives to it [unit^2].
    allowed : float
        What the sum may be [unit^2].
    """

    power: FloatArray
    allowed: float


def reduction_of(
    octaves: FloatArray, bounds: Sequence[Bound], least: FloatArray, slope: float
) -> FloatArray:
    """Return the least reduction that keeps limits of mean squares, (n_bins,) array [dB].

    Parameters
    ----------
    octaves : (n_bins,) array
        Logarithm to base 2 of the frequency of each bin, evenly rising [-].
    bounds : sequence of Bound
        The limits.
    least : (n_bins,) array
        Reduction that is needed anyway [dB].
    slope : float
        Steepest edge [dB/oct].
    """
    prices = np.zeros(len(bounds))

    def reduced(prices: FloatArray) -> FloatArray:
        total = sum((p * b.power for p, b in zip(prices, bounds, strict=True)), start=0.0)
        clipped = 10.0 * np.log10(np.maximum(total, 1.0)) * np.ones_like(octaves)
        return with_edges(octaves, np.minimum(np.maximum(clipped, least), DEEPEST), slope)

    for _ in range(SWEEPS if len(bounds) > 1 else 1):
        for i, bound in enumerate(bounds):
            prices[i] = 0.0
            if _left(bound, reduced(prices)) <= bound.allowed:
                continue
            largest = float(np.max(bound.power))
            low, high = -np.log(largest), DEEPEST * np.log(10.0) / 10.0 - np.log(largest)
            for _ in range(HALVINGS):
                middle = 0.5 * (low + high)
                prices[i] = np.exp(middle)
                enough = _left(bound, reduced(prices)) <= bound.allowed
                low, high = (low, middle) if enough else (middle, high)
            prices[i] = np.exp(high)
    return reduced(prices)


def _left(bound: Bound, reduction: FloatArray) -> float:
    """Return what is left of a mean square [unit^2]."""
    return float(np.sum(bound.power * 10.0 ** (-reduction / 10.0)))


def with_edges(octaves: FloatArray, reduction: FloatArray, slope: float) -> FloatArray:
    """Return the least reduction above another one that is nowhere steeper, (n,) array [dB].

    Parameters
    ----------
    octaves : (n,) array
        Logarithm to base 2 of frequencies that rise [-].
    reduction : (n,) array
        What is taken away at least [dB].
    slope : float
        Steepest edge [dB/oct].
    """
    fall = slope * octaves
    rising = np.maximum.accumulate(reduction + fall) - fall
    falling = np.maximum.accumulate((reduction - fall)[::-1])[::-1] + fall
    return np.maximum(rising, falling)


def corners_of(octaves: FloatArray, reduction: FloatArray) -> list[int]:
    """Return the points between which a reduction is straight within 0.1 dB, both ends in.

    Parameters
    ----------
    octaves : (n,) array
        Logarithm to base 2 of the frequencies [-].
    reduction : (n,) array
        What is taken away [dB].

    References
    ----------
    .. [1] D. H. Douglas and T. K. Peucker, "Algorithms for the reduction of the number of
       points required to represent a digitized line", Cartographica 10, 112-122, 1973.
    """
    kept, parts = {0, octaves.size - 1}, [(0, octaves.size - 1)]
    while parts:
        first, last = parts.pop()
        between = np.arange(first + 1, last)
        if not between.size:
            continue
        line = np.interp(octaves[between], octaves[[first, last]], reduction[[first, last]])
        missed = np.abs(reduction[between] - line)
        at = int(between[np.argmax(missed)])
        if missed.max() > CLOSE:
            kept.add(at)
            parts += [(first, at), (at, last)]
    return sorted(kept)
