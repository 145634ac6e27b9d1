"""One mode of a free decay by itself: at rest in its own frame, or band-passed.

Both filters look ahead only, within the decay, so that neither smears what was before it: what
they make of a decaying sinusoid is the sinusoid again, times a constant, from its first sample.
"""

from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import ComplexArray, FloatArray

REJECTION: Final = 1e-3
"""What a filter leaves of the nearest other line, over the mode itself [-]."""

STOP_EDGE: Final = 0.8
"""Where a filter has reached that, over the distance to the nearest other line [-]."""

PASS_EDGE: Final = 0.15
"""Where it begins to fall, over that distance [-]: modes shift on their way."""

MOST_RISE: Final = 1.05
"""How far the amplitude of one mode may rise, as a factor [-]: the filters ripple by 0.1 %, and
noise is looked at where it makes less."""

LEAST_OVER_NOISE: Final = 30.0
"""Amplitude over that at the end of the record above which it is looked at [-]."""

RAYLEIGH: Final = 1.8
"""Median of the amplitude of noise over its standard deviation, by Rayleigh's law [-]."""

NOISE_VALUES: Final = 8
"""Values at the end of a record that tell its noise by how rough they are, at least [-]."""

ORDER: Final = 6
"""Poles of the band-pass on either side of a mode [-]."""


@final
@dataclass(frozen=True, slots=True)
class DecayLine:
    """A mode of a decay as its spectrum shows it.

    Attributes
    ----------
    frequency : float
        Of the line [Hz].
    row : int
        Channel in which it stands out of the noise most.
    apart : float
        How far away the next other line, rest (0 Hz) or half the sample rate is [Hz].
    ratio : float
        Height of that line over its own, 1 at least [-].
    """

    frequency: float
    row: int
    apart: float
    ratio: float


@final
@dataclass(frozen=True, slots=True, eq=False)
class DecayEnvelope:
    """A mode in a frame that turns with its frequency.

    Attributes
    ----------
    time : (n,) array
        Middle of the filter, from the start of the decay, as far apart as values are
        independent of each other [s].
    values : (n,) complex array
        Amplitude and phase [unit of the channel].
    step : float
        From value to value [s].
    frequency : float
        Of the frame [Hz].
    reach : float
        How far from that the filter passes all [Hz].
    """

    time: FloatArray
    values: ComplexArray
    step: float
    frequency: float
    reach: float


@final
@dataclass(frozen=True, slots=True, eq=False)
class Oscillation:
    """A mode, band-passed.

    Attributes
    ----------
    time : (n,) array
        From the start of the decay, the delay of the filter taken into account [s].
    values : (n,) array
        The motion [unit of the channel].
    bandwidth : float
        Of a band that passes as much white noise [Hz].
    """

    time: FloatArray
    values: FloatArray
    bandwidth: float


def filter_length(line: DecayLine) -> float:
    """Return how long a filter is that isolates a line [s]."""
    attenuation = -20.0 * np.log10(REJECTION / line.ratio)
    # Kaiser's law for the length of a low-pass, over the width of its transition
    return float(
        (attenuation - 7.95) / (2.285 * 2.0 * np.pi * (STOP_EDGE - PASS_EDGE) * line.apart)
    )


def envelope_of(samples: FloatArray, sample_rate: float, line: DecayLine) -> DecayEnvelope:
    """Return a mode in its own frame, by a finite low-pass after its phase is turned back.

    Parameters
    ----------
    samples : (n_samples,) array
        The free decay without offset [unit of the channel].
    sample_rate : float
        Samples per second [Hz].
    line : DecayLine
        The mode.

    Returns
    -------
    Envelope
        Without values where the decay is shorter than the filter.
    """
    attenuation = -20.0 * np.log10(REJECTION / line.ratio)
    length = 2 * round(0.5 * filter_length(line) * sample_rate) + 1
    cutoff = 0.5 * (STOP_EDGE + PASS_EDGE) * line.apart
    taps = scipy.signal.firwin(
        length, cutoff, window=("kaiser", scipy.signal.kaiser_beta(attenuation)), fs=sample_rate
    )
    step = max(round(np.sum(taps) ** 2 / np.sum(taps**2)), 1)
    frame = (step / sample_rate, line.frequency, PASS_EDGE * line.apart)
    if samples.size < length:
        return DecayEnvelope(np.zeros(0), np.zeros(0, complex), *frame)
    turned = samples * np.exp(
        -2j * np.pi * line.frequency / sample_rate * np.arange(samples.size)
    )
    values = scipy.signal.oaconvolve(turned, taps, mode="valid")[::step]
    time = (0.5 * (length - 1) + step * np.arange(values.size)) / sample_rate
    return DecayEnvelope(np.asarray(time, float), np.asarray(2.0 * values, complex), *frame)


def oscillation_of(samples: FloatArray, sample_rate: float, line: DecayLine) -> Oscillation:
    """Return a mode, band-passed by a Butterworth filter that runs backwards in time.

    Parameters
    ----------
    samples : (n_samples,) array
        The free decay without offset [unit of the channel].
    sample_rate : float
        Samples per second [Hz].
    line : DecayLine
        The mode.
    """
    half = line.apart * (REJECTION / line.ratio) ** (1.0 / ORDER)
    edges = [line.frequency - half, min(line.frequency + half, 0.499 * sample_rate)]
    sections = scipy.signal.butter(ORDER, edges, "bandpass", fs=sample_rate, output="sos")
    near = line.frequency + half * np.array([-0.01, 0.0, 0.01])
    frequency, gain = scipy.signal.sosfreqz(sections, np.linspace(0.0, 0.5, 2**15), fs=1.0)
    bandwidth = sample_rate * float(np.sum(np.abs(gain) ** 2) * (frequency[1] - frequency[0]))
    _, at = scipy.signal.sosfreqz(sections, near, fs=sample_rate)
    delay = -float(np.diff(np.unwrap(np.angle(at)))[[0, 1]].mean()) / (
        2.0 * np.pi * float(near[1] - near[0])
    )
    values = scipy.signal.sosfilt(sections, samples[::-1])[::-1] / abs(at[1])
    time = np.arange(samples.size) / sample_rate + delay
    settled = time < time[-1] - 4.0 * delay  # the filter began at the end of the record
    return Oscillation(time[settled], values[settled], bandwidth)


def largest_rise(amplitude: FloatArray) -> float:
    """Return the largest amplitude after a smaller one, over that; 1 of a mere decay [-].

    Parameters
    ----------
    amplitude : (n,) array
        Of a mode against time [unit of the channel]; what is before the largest does not count.
    """
    if not amplitude.size:
        return 1.0
    from_top = amplitude[int(np.argmax(amplitude)) :]
    return float(np.max(from_top / np.minimum.accumulate(from_top)))


def _rest(amplitude: FloatArray) -> float:
    """Return the amplitude of the noise at the end, also where a mode still rings there.

    Noise departs from the mean of its neighbours, a mode that decays hardly does.
    """
    end = amplitude[-max(amplitude.size // 10, min(amplitude.size, NOISE_VALUES)) :]
    median = float(np.median(end))
    if end.size < NOISE_VALUES:
        return median
    apart = end[1:-1] - 0.5 * (end[:-2] + end[2:])
    return min(median, RAYLEIGH * float(np.sqrt(np.mean(apart**2) / 1.5)))


def never_grows(samples: FloatArray, sample_rate: float, line: DecayLine) -> bool:
    """Return whether the signal around a line only decays, as one mode does and two do not.

    Parameters
    ----------
    samples : (n_samples,) array
        The free decay without offset [unit of the channel].
    sample_rate : float
        Samples per second [Hz].
    line : DecayLine
        The line.
    """
    amplitude = np.abs(envelope_of(samples, sample_rate, line).values)
    if not amplitude.size:
        return False
    clear = np.flatnonzero(amplitude > LEAST_OVER_NOISE * _rest(amplitude))
    return clear.size > 2 and largest_rise(amplitude[: int(clear[-1]) + 1]) < MOST_RISE
