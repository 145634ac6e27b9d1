"""The modes of a free decay: lines of its spectrum, and each of them by itself.

Both filters that isolate a mode look ahead only, within the decay, so that neither smears what
was before it: what they make of a decaying sinusoid is the sinusoid again, times a constant,
from its first sample.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.errors import SpectrumError
from shakerproc.spectra.blows import LOUD, NORMAL
from shakerproc.spectra.responses import excited

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
    distance : float
        How far away the next other line, rest (0 Hz) or half the sample rate is [Hz].
    ratio : float
        Height of that line over its own, 1 at least [-].
    """

    frequency: float
    row: int
    distance: float
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
        (attenuation - 7.95) / (2.285 * 2.0 * np.pi * (STOP_EDGE - PASS_EDGE) * line.distance)
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
    cutoff = 0.5 * (STOP_EDGE + PASS_EDGE) * line.distance
    taps = scipy.signal.firwin(
        length, cutoff, window=("kaiser", scipy.signal.kaiser_beta(attenuation)), fs=sample_rate
    )
    step = max(round(np.sum(taps) ** 2 / np.sum(taps**2)), 1)
    frame = (step / sample_rate, line.frequency, PASS_EDGE * line.distance)
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
    half = line.distance * (REJECTION / line.ratio) ** (1.0 / ORDER)
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
    undisturbed = time < time[-1] - 4.0 * delay  # the filter began at the end of the record
    return Oscillation(time[undisturbed], values[undisturbed], bandwidth)


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
    departure = end[1:-1] - 0.5 * (end[:-2] + end[2:])
    # independent noise less the mean of two neighbours has 1 + 1/4 + 1/4 of its variance
    return min(median, RAYLEIGH * float(np.sqrt(np.mean(departure**2) / 1.5)))


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


DRIVE_FLOOR: Final = 0.05
"""Share of the largest input below which it drives no more [-]: what a hammer or a table rings
with after a pulse."""

LEAST_FREE_PART: Final = 0.05
"""Share of a run that its free part lasts at least [-]: less is the end of a test, no decay."""

LEAST_PROMINENCE: Final = 2.0
"""How far a line stands above the spectrum on both its sides, as a factor, 6 dB [-]: a
resonance that is no shoulder of another."""

ABOVE_NOISE: Final = 6.0
"""Multiples of the rms of a line of noise by which a line stands above both its sides at least
[-]: of 10^6 lines of white noise, whose magnitudes follow Rayleigh's law, none is as tall."""

LEAST_HEIGHT: Final = 1e-3
"""Share of the tallest line of its channel in the band below which a line is left out, 60 dB
[-]."""

MOST_SHIFT: Final = 0.3
"""Share of its frequency over which the lines of one mode may spread [-]: a gap or a cubic
spring shifts a mode as far in one decay."""

NOISE_TAIL: Final = 0.1
"""Share of a decay at its end that tells its noise, where nothing lies before it [-]."""


LET_GO: Final = 0.05
"""Share of the range of a motion by which it has left where it was held [-]."""


def free_start(samples: FloatArray, inputs: FloatArray) -> int:
    """Return the first sample of the free part of a run.

    Parameters
    ----------
    samples : (n_responses, n_samples) array
        The responses [unit of the channel].
    inputs : (n_inputs, n_samples) array
        Forces or controls, if any: the free part begins when the last of them is at rest.
        Without any it begins at the largest motion of all responses, or where they are let
        go after they were held there [unit of the channel].

    Raises
    ------
    SpectrumError
        If less than `LEAST_FREE_PART` of the run is left.
    """
    n_samples = samples.shape[1]
    if inputs.shape[0]:
        starts = [_at_rest(row) for row in inputs]
        why = "the input moves to its end"
    else:
        rest = samples - np.median(samples, axis=1, keepdims=True)
        power = np.mean(rest**2, axis=1, keepdims=True)
        shares = np.divide(rest**2, power, out=np.zeros_like(rest), where=power > 0.0)
        first = int(np.argmax(shares.sum(axis=0)))
        starts = [first + _held(rest[:, first:], power) + 1]
        why = "the largest motion is at its end, and no channel is an input"
    start = max(starts)
    if start > (1.0 - LEAST_FREE_PART) * n_samples:
        raise SpectrumError(
            f"no free part: {why}. Record until the motion has died away, give only the input "
            "the role force or control, or crop: {from: ..., to: ...}"
        )
    return start


def _held(rest: FloatArray, power: FloatArray) -> int:
    """Return how many samples responses are held at their largest motion; 0 if they are not.

    A sine takes 0.4 times as long to leave its crest by `LET_GO` of its range as from there
    to half of the range.
    """
    way = np.divide((rest - rest[:, :1]) ** 2, power, out=np.zeros_like(rest), where=power > 0)
    size = np.sqrt(way.sum(axis=0))
    gone, half = (int(np.argmax(size > share * size.max())) for share in (LET_GO, 0.5))
    return gone if gone > max(half - gone, 1) else 0


def _at_rest(row: FloatArray) -> int:
    """Return the sample after the last at which an input drives, the end if it never rests."""
    size = np.abs(row - np.median(row))
    noise = LOUD * NORMAL * float(np.median(size))
    largest = float(size.max())
    if largest <= noise:
        return row.size
    return int(np.flatnonzero(size > max(DRIVE_FLOOR * largest, noise))[-1]) + 1


def decay_lines(
    samples: FloatArray,
    sample_rate: float,
    band: tuple[float, float],
    *,
    noise: FloatArray | None = None,
    count: int | None = None,
) -> tuple[DecayLine, ...]:
    """Return the lines of a free decay, lowest first.

    Parameters
    ----------
    samples : (n_channels, n_samples) array
        The free decay, from its start [unit of the channel].
    sample_rate : float
        Samples per second [Hz].
    band : (float, float)
        Where they are looked for [Hz].
    noise : (n_channels,) array, optional
        Rms of the noise [unit of the channel]; by default that of the end of the decay.
    count : int, optional
        How many at most, the tallest over the noise; by default all.
    """
    n_samples = samples.shape[1]
    rest = samples - samples[:, -max(int(NOISE_TAIL * n_samples), 1) :].mean(
        axis=1, keepdims=True
    )
    if noise is None:
        noise = rest[:, -max(int(NOISE_TAIL * n_samples), 2) :].std(axis=1)
    taper = 0.5 + 0.5 * np.cos(np.pi * np.arange(n_samples) / n_samples)
    n_fft = 2 * scipy.fft.next_fast_len(n_samples)
    magnitude: FloatArray = np.abs(np.fft.rfft(rest * taper, n_fft))
    frequency = np.asarray(np.fft.rfftfreq(n_fft, 1.0 / sample_rate), dtype=np.float64)
    of_noise = noise[:, np.newaxis] * np.sqrt(np.sum(taper**2))
    over = magnitude / np.where(of_noise > 0.0, of_noise, magnitude.max() * 1e-12)
    score = over.max(axis=0)
    level = 20.0 * np.log10(np.maximum(score, 1e-300))
    places, _ = scipy.signal.find_peaks(level, prominence=20.0 * np.log10(LEAST_PROMINENCE))
    prominence, *_ = scipy.signal.peak_prominences(score, places)
    places = places[prominence > ABOVE_NOISE]
    alone = [
        _ModeLines(float(frequency[i]), 0.0, magnitude[:, i], over[:, i])
        for i in places.tolist()
    ]
    groups = _groups(rest, sample_rate, alone)
    tallest = np.where(excited(frequency, band), magnitude, 0.0).max(axis=1)
    kept = [
        one
        for one in groups
        if band[0] <= one.frequency <= band[1] and (one.heights > LEAST_HEIGHT * tallest).any()
    ]
    if count is not None:
        strongest = sorted(kept, key=lambda one: -float(one.over.max()))[:count]
        kept = sorted(strongest, key=lambda one: one.frequency)
    return tuple(_line(one, groups, 0.5 * sample_rate) for one in kept)


@final
@dataclass(frozen=True, slots=True, eq=False)
class _ModeLines:
    """Lines of one mode: several where its frequency shifts. Heights by channel, over noise."""

    frequency: float
    span: float
    heights: FloatArray
    over: FloatArray


def _groups(rest: FloatArray, sample_rate: float, alone: list[_ModeLines]) -> list[_ModeLines]:
    """Return the modes that lines make, lowest first.

    A mode whose frequency shifts while it decays has a spectrum of several lines, which one by
    one look like modes. They are one where their sum never grows: two modes beat.
    """
    mode_lines: list[_ModeLines] = []
    while alone:
        last = max(
            i for i, one in enumerate(alone)
            if one.frequency - alone[0].frequency <= MOST_SHIFT * alone[0].frequency
        )  # fmt: skip
        while last > 0:
            joined = _joined(alone[: last + 1])
            row = int(np.argmax(joined.over))
            line = _line(joined, [*mode_lines, joined, *alone[last + 1 :]], 0.5 * sample_rate)
            if joined.span <= 2.0 * PASS_EDGE * line.distance and never_grows(
                rest[row], sample_rate, line
            ):
                break
            last -= 1
        mode_lines.append(_joined(alone[: last + 1]))
        alone = alone[last + 1 :]
    return mode_lines


def _joined(lines: Sequence[_ModeLines]) -> _ModeLines:
    low, high = lines[0].frequency, lines[-1].frequency
    return _ModeLines(
        0.5 * (low + high),
        high - low,
        np.max([one.heights for one in lines], axis=0),
        np.max([one.over for one in lines], axis=0),
    )


def _line(lines: _ModeLines, groups: Sequence[_ModeLines], highest: float) -> DecayLine:
    """Return a mode among all others; their own width is no part of the distance."""
    row = int(np.argmax(lines.over))
    others = [(lines.frequency, 1.0), (highest - lines.frequency, 1.0)] + [
        (
            abs(one.frequency - lines.frequency) - 0.5 * one.span,
            float(one.heights[row] / lines.heights[row]),
        )
        for one in groups
        if one is not lines and one.heights[row] > LEAST_HEIGHT * lines.heights[row]
    ]
    distance_hz = min(distance for distance, _ in others)
    ratio = max(tall * distance_hz / distance for distance, tall in others)
    return DecayLine(lines.frequency, row, distance_hz, max(ratio, 1.0))
