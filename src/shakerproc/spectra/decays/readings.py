"""Frequency, damping and amplitude of a stretch of a decay: least squares, or crossings.

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
from shakerproc.spectra.decays.lines import DecayEnvelope, Oscillation

LEAST_SAMPLES: Final = 8
"""Independent values of an envelope in a stretch at least [-]: six parameters of sixteen."""

MOST_STEPS: Final = 8
"""Steps of Gauss and Newton; from the parabolas they converge in three to five [-]."""

FINE: Final = 32
"""Samples of a period between which a straight line places a crossing to 10^-4 of a period, and
a parabola a peak to 10^-5 of its height [-]."""

PARAMETERS: Final = 3
"""Those of a parabola [-]."""

LEAST_INDEPENDENT: Final = PARAMETERS + 3.0
"""Independent values that a stretch has at least [-]: Student's law of three degrees of freedom
has an interval of 3.2 standard deviations, not 12.7 as of one."""


@final
@dataclass(frozen=True, slots=True)
class DecayReading:
    """Frequency and damping of a mode over a stretch of its decay; limits are those of 95 %.

    Attributes
    ----------
    time : float
        At which they hold, from the start of the decay [s].
    amplitude : float
        Of the motion then [unit of the channel].
    frequency : float
        Natural frequency, the distance of the pole from 0 [Hz].
    frequency_error : float
        Half the width of its interval [Hz].
    damping : float
        Ratio [-].
    damping_error : float
        Half the width of its interval [-].
    noise : float
        Rms of what the fit leaves, over the amplitude [-].
    """

    time: float
    amplitude: float
    frequency: float
    frequency_error: float
    damping: float
    damping_error: float
    noise: float


def reading_of(
    pole: complex, errors: tuple[float, float], time: float, amplitude: float, noise: float
) -> DecayReading:
    r"""Return the reading of a pole :math:`-\sigma + i \omega_d`.

    Parameters
    ----------
    pole : complex
        Real and imaginary part [rad/s].
    errors : (float, float)
        Half the widths of their intervals [rad/s].
    time, amplitude, noise : float
        As in `DecayReading` [s, unit of the motion].
    """
    tau = 6.283185307179586
    size = abs(pole)
    return DecayReading(
        time=time,
        amplitude=amplitude,
        frequency=size / tau,
        frequency_error=errors[1] / tau,
        damping=-pole.real / size,
        damping_error=errors[0] / size,
        noise=noise,
    )


def within_stretch(rate: float, bend: float) -> float:
    r"""Return the slope that a change within a stretch may add at its middle [rad/s].

    A parabola leaves the cubic part :math:`a_3 t^3`, which adds :math:`3/5\, a_3 T^2` to the
    slope of a stretch from -T to T. Where the slope changes as amplitude to the power n, and
    amplitude as :math:`e^{-\sigma t}`, that is :math:`n/5\, \sigma q T^2` with the square part
    q; n is taken for 2, which is that of a cubic spring.

    Parameters
    ----------
    rate : float
        Of the decay, :math:`\sigma` [1/s].
    bend : float
        Logarithm or phase that the square part makes at an end, :math:`q T^2` [rad].
    """
    return 0.4 * abs(rate * bend)


def weighted_middle(time: FloatArray, weights: FloatArray) -> float:
    """Return the mean of times with weights [s]."""
    return float(weights @ time / weights.sum())


def read_envelope(envelope: DecayEnvelope, start: float, stop: float) -> DecayReading | None:
    r"""Return frequency and damping of a stretch by least squares.

    .. math:: z(t) = e^{a + p t + q t^2}

    is fitted to the envelope, with complex :math:`a`, :math:`p` and :math:`q`, from parabolas
    through logarithm and phase on; time is that from the middle of the power. The pole is
    :math:`p`; :math:`q` takes up how frequency and damping change within the stretch. What is
    left is taken for white noise of that stretch; intervals are those of Student's law.

    Parameters
    ----------
    envelope : DecayEnvelope
        Of the mode.
    start, stop : float
        The stretch [s].

    Returns
    -------
    DecayReading or None
        None where it holds too few values.
    """
    inside = (envelope.time >= start) & (envelope.time <= stop)
    time, values = envelope.time[inside], envelope.values[inside]
    if time.size < LEAST_SAMPLES or not np.abs(values).min() > 0.0:
        return None
    weights = np.abs(values) ** 2
    middle = weighted_middle(time, weights)
    half_width = 0.5 * float(np.ptp(time))
    design = np.vander((time - middle) / half_width, 3, increasing=True)
    root = np.abs(values)
    target = np.log(np.abs(values)) + 1j * np.unwrap(np.angle(values))
    coefficients, *_ = np.linalg.lstsq(
        design * root[:, np.newaxis] + 0j, target * root, rcond=None
    )
    for _ in range(MOST_STEPS):
        wave = np.exp(design @ coefficients)
        step, *_ = np.linalg.lstsq(design * wave[:, np.newaxis], values - wave, rcond=None)
        if not np.isfinite(step).all() or np.abs(step).max() > 1.0:
            return None  # noise, not a decay
        coefficients = coefficients + step
    wave = np.exp(design @ coefficients)
    slopes = design * wave[:, np.newaxis]
    freedom = time.size - design.shape[1]
    power = float(np.sum(np.abs(values - wave) ** 2)) / freedom
    covariance = power * np.linalg.inv((slopes.conj().T @ slopes).real)
    # a complex value is two real ones, each with half of the power of the noise
    half = float(scipy.special.stdtrit(2 * freedom, 0.975) * np.sqrt(0.5 * covariance[1, 1]))
    amplitude, pole, bend = (
        float(np.exp(coefficients[0].real)),
        coefficients[1] / half_width,
        coefficients[2],
    )
    half /= half_width
    return reading_of(
        complex(pole) + 2j * np.pi * envelope.frequency,
        (
            half + within_stretch(pole.real, bend.real),
            half + within_stretch(pole.real, bend.imag),
        ),
        middle,
        amplitude,
        float(np.sqrt(power)) / amplitude,
    )


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


def read_chart(chart: Chart, start: float, stop: float) -> DecayReading | None:
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
    DecayReading or None
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
    coefficients, *_ = np.linalg.lstsq(turned, y * root, rcond=None)
    residual = (y - design @ coefficients) * root
    power = float(residual @ residual) / (x.size - PARAMETERS * related)
    error = np.sqrt(power * related * np.linalg.inv(turned.T @ turned)[1, 1])
    half = float(scipy.special.stdtrit(freedom, 0.975) * error)
    return _Parabola(
        float(coefficients[0]),
        float(coefficients[1]) / half_width,
        half / half_width,
        float(coefficients[2]),
        float(np.sqrt(power)),
    )
