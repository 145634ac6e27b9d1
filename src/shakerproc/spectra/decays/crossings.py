"""A stretch of a decay by its peaks and zero crossings, as one reads them off a chart.

References
----------
.. [1] M. Jin, W. Chen, M. R. W. Brake and H. Song, "Identification of instantaneous frequency
   and damping from transient decay data", J. Vib. Acoust. 142, 051111, 2020.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Final, NamedTuple, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import FloatArray
from shakerproc.spectra.decays.isolation import Oscillation
from shakerproc.spectra.decays.reading import (
    Reading,
    reading_of,
    weighted_middle,
    within_stretch,
)

FINE: Final = 32
"""Samples of a period between which a straight line places a crossing to 10^-4 of a period, and
a parabola a peak to 10^-5 of its height [-]."""

PARAMETERS: Final = 3
"""Those of a parabola [-]."""

LEAST_INDEPENDENT: Final = PARAMETERS + 3.0
"""Independent values that a stretch has at least [-]: Student's law of three degrees of freedom
has an interval of 3.2 standard deviations, not 12.7 as of one."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Chart:
    """Where a motion crosses zero and where it turns.

    Attributes
    ----------
    crossings : (n,) array
        Times of the zero crossings [s].
    peaks : (m,) array
        Times of the largest and smallest values between them [s].
    heights : (m,) array
        Their sizes [unit of the channel].
    independent : float
        Values of one kind in a second that noise leaves independent of each other [1/s].
    """

    crossings: FloatArray
    peaks: FloatArray
    heights: FloatArray
    independent: float


def chart_of(motion: Oscillation, frequency: float) -> Chart:
    """Return where a band-passed motion crosses zero and turns.

    Parameters
    ----------
    motion : Oscillation
        The mode.
    frequency : float
        About its frequency [Hz].
    """
    if motion.time.size < 2:
        nothing = np.zeros(0)
        return Chart(nothing, nothing, nothing, motion.bandwidth)
    step = float(motion.time[1] - motion.time[0])
    times = max(int(np.ceil(FINE * frequency * step)), 1)
    values = motion.values
    if times > 1:
        values = scipy.signal.resample_poly(values, times, 1)
    step /= times
    time = motion.time[0] + step * np.arange(values.size)
    positive = values > 0.0
    before = np.flatnonzero(positive[1:] != positive[:-1])
    a, b = values[before], values[before + 1]
    crossings = time[before] + step * a / (a - b)
    if before.size < 2:
        nothing = np.zeros(0)
        return Chart(crossings, nothing, nothing, motion.bandwidth)
    at = np.array([
        first + 1 + int(np.argmax(np.abs(values[first + 1 : last + 1])))
        for first, last in pairwise(before)
    ])
    at = np.clip(at, 1, values.size - 2)
    left, middle, right = (np.abs(values[at + k]) for k in (-1, 0, 1))
    bent = left - 2.0 * middle + right
    shift = np.where(bent < 0.0, 0.5 * (left - right) / np.where(bent < 0.0, bent, -1.0), 0.0)
    shift = np.clip(shift, -0.5, 0.5)
    return Chart(
        crossings,
        time[at] + step * shift,
        middle - 0.25 * (left - right) * shift,
        motion.bandwidth,
    )


def read_chart(chart: Chart, start: float, stop: float) -> Reading | None:
    """Return frequency and damping of a stretch from crossings and peaks.

    Parabolas through the number of the crossings and through the logarithm of the peaks over
    time, weighted by the square of the height; their slopes in the middle of the power.

    Parameters
    ----------
    chart : Chart
        Of the mode.
    start, stop : float
        The stretch [s].

    Returns
    -------
    Reading or None
        None where it holds too few peaks.
    """
    inside = (chart.peaks >= start) & (chart.peaks <= stop)
    time, heights = chart.peaks[inside], chart.heights[inside]
    if time.size < 4 or not heights.min() > 0.0:
        return None
    crossed = chart.crossings[(chart.crossings >= start) & (chart.crossings <= stop)]
    if crossed.size < 4:
        return None
    related = max((time.size - 1) / (time[-1] - time[0]) / chart.independent, 1.0)
    middle = weighted_middle(time, heights**2)
    decay = _parabola(time, np.log(heights), heights**2, middle, related)
    height = np.exp(np.interp(crossed, time, np.log(heights)))
    turns = _parabola(crossed, np.arange(crossed.size, dtype=float), height**2, middle, related)
    if decay is None or turns is None:
        return None
    rate = decay.slope
    return reading_of(
        complex(rate, np.pi * turns.slope),
        (
            decay.error + within_stretch(rate, decay.bend),
            np.pi * (turns.error + within_stretch(rate, turns.bend)),
        ),
        middle,
        float(np.exp(decay.value)),
        decay.scatter,
    )


class _Parabola(NamedTuple):
    """A parabola at the middle: value, slope and half its 95 % interval, square part, rms."""

    value: float
    slope: float
    error: float
    bend: float
    scatter: float


def _parabola(
    x: FloatArray, y: FloatArray, weights: FloatArray, middle: float, related: float
) -> _Parabola | None:
    """Return a weighted parabola; one value in `related` is independent, None if too few."""
    freedom = x.size / related - PARAMETERS
    if freedom < 1.0:
        return None
    half_width = 0.5 * float(np.ptp(x))
    design = np.vander((x - middle) / half_width, PARAMETERS, increasing=True)
    root = np.sqrt(weights / weights.mean())
    turned = design * root[:, np.newaxis]
    found, *_ = np.linalg.lstsq(turned, y * root, rcond=None)
    left = (y - design @ found) * root
    power = float(left @ left) / (x.size - PARAMETERS * related)
    error = np.sqrt(power * related * np.linalg.inv(turned.T @ turned)[1, 1])
    half = float(scipy.special.stdtrit(freedom, 0.975) * error)
    return _Parabola(
        float(found[0]),
        float(found[1]) / half_width,
        half / half_width,
        float(found[2]),
        float(np.sqrt(power)),
    )
