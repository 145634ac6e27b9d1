"""Density against time and frequency, and the strongest line in it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, TypeAlias, final

import numpy as np

from shakerproc import checks
from shakerproc.data import FloatArray
from shakerproc.errors import SpectrumError
from shakerproc.spectra.welch.windows import window_samples

SampleReader: TypeAlias = Callable[[int, int], FloatArray]
"""Samples start to stop of every channel, an (n_channels, stop - start) array."""

CHUNK: Final = 2**16
"""Samples of every channel read at a time."""

KEPT: Final = 2**22
"""Samples of the control up to which it is read once and kept, 32 MiB."""

SHORTEST: Final = 64
"""Samples of the shortest frame."""

PERIODS: Final = 8
"""Periods in a frame at the lower end of its octave."""

QUIET: Final = 0.01
"""Share of the largest amplitude of a line below which it is not followed [-]."""

GRID: Final = 20_000
"""Places at most where the ridge is taken."""

REVERSAL: Final = 0.2
"""Octaves back after which a sweep has turned."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Ridge:
    """Frequency and amplitude of the strongest line against time.

    Attributes
    ----------
    position : (n,) array
        Samples from the start.
    frequency : (n,) array
        Frequency of the strongest line [Hz].
    amplitude : (n,) array
        Its amplitude, roughly [unit of the samples].
    """

    position: FloatArray
    frequency: FloatArray
    amplitude: FloatArray


def reader_of(samples: FloatArray) -> tuple[SampleReader, int]:
    """Return a reader of samples in memory and how many there are.

    `samples` may be in any unit.
    """
    return (lambda start, stop: samples[:, start:stop]), int(samples.shape[1])


def mean_control(read: SampleReader, n_samples: int, controls: Sequence[int]) -> SampleReader:
    """Return a reader of the mean of some channels, (1, n) arrays, kept if it is small."""
    rows = list(controls)

    def mean(start: int, stop: int) -> FloatArray:
        return np.asarray(read(start, stop)[rows].mean(axis=0, keepdims=True))

    if n_samples > KEPT:
        return mean
    starts = range(0, n_samples, CHUNK)
    parts = [mean(start, min(start + CHUNK, n_samples)) for start in starts]
    return reader_of(np.concatenate(parts, axis=1))[0]


def ridge_of(
    read: SampleReader, n_samples: int, sample_rate: float, band: tuple[float, float]
) -> Ridge:
    """Return the strongest line against time.

    Parameters
    ----------
    read : callable
        Gives (1, n) samples.
    n_samples : int
        How many samples there are.
    sample_rate : float
        Samples per second [Hz].
    band : (float, float)
        Frequencies between which the line lies [Hz].

    Returns
    -------
    Ridge
        At most 20000 places, equally spaced.

    Raises
    ------
    SpectrumError
        If there are fewer than 8 periods of the lowest frequency, or half the sample rate is
        below it.
    """
    lengths = _frame_lengths(n_samples, sample_rate, band)
    count = max(2, min(GRID, n_samples // (SHORTEST // 2)))
    position = np.linspace(0.0, n_samples - 1.0, count)
    frequency, amplitude = np.zeros(count), np.full(count, -1.0)
    for length in lengths:
        limits = _octave(length, lengths, sample_rate, band)
        if limits[1] <= limits[0]:
            continue
        centre, line, height = _lines(read, n_samples, length, limits)
        here = np.interp(position, centre, height)
        better = here > amplitude
        frequencies = np.exp(np.interp(position, centre, np.log(line))) * sample_rate / length
        frequency = np.where(better, frequencies, frequency)
        amplitude = np.maximum(amplitude, here)
    return Ridge(position, frequency, amplitude)


def monotone_sections(ridge: Ridge) -> list[tuple[int, int]]:
    """Return the parts of a ridge that only rise or only fall, as (first, last) places.

    Where the line is below a hundredth of its largest amplitude there is only noise to follow.
    """
    loud = ridge.amplitude > QUIET * ridge.amplitude.max()
    edges = np.flatnonzero(np.diff(np.concatenate([[False], loud, [False]])))
    return [
        (int(a + first), int(a + last))
        for a, b in edges.reshape(-1, 2)
        if b - a > 4
        for first, last in _monotone(np.log2(median_of_five(ridge.frequency[a:b])))
    ]


def _monotone(octaves: FloatArray) -> list[tuple[int, int]]:
    """Return the parts of a course that only rise or only fall."""
    turns, direction, extreme = [0], 0, 0
    for k in range(1, octaves.size):
        if direction == 0:
            if abs(octaves[k] - octaves[0]) > REVERSAL:
                direction, extreme = int(np.sign(octaves[k] - octaves[0])), k
        elif direction * (octaves[k] - octaves[extreme]) > 0.0:
            extreme = k
        elif direction * (octaves[extreme] - octaves[k]) > REVERSAL:
            turns.append(extreme)
            direction, extreme = -direction, k
    turns.append(octaves.size - 1)
    return [(a, b) for a, b in pairwise(turns) if b - a > 3]


def median_of_five(values: FloatArray) -> FloatArray:
    """Return the running median of five values, the ends repeated.

    `values` may be in any unit.
    """
    padded = np.pad(values, 2, mode="edge")
    return np.array(np.median(np.lib.stride_tricks.sliding_window_view(padded, 5), axis=1))


def _frame_lengths(n_samples: int, sample_rate: float, band: tuple[float, float]) -> list[int]:
    """Return the lengths of frames, doubling, of which each sees one octave.

    Raises
    ------
    SpectrumError
        If not even one frame fits.
    """
    if not 0.0 < band[0] < min(band[1], sample_rate / 2.0):
        raise SpectrumError(
            f"no tone from {band[0]:g} to {band[1]:g} Hz can be followed in samples at "
            f"{sample_rate:g} Hz"
        )
    lengths = [SHORTEST]
    while PERIODS * sample_rate / lengths[-1] > band[0] and 2 * lengths[-1] <= n_samples:
        lengths.append(2 * lengths[-1])
    if lengths[-1] > n_samples:
        raise SpectrumError(f"{n_samples} samples are too few to follow a tone in them")
    return lengths


def _octave(
    length: int, lengths: Sequence[int], sample_rate: float, band: tuple[float, float]
) -> tuple[int, int]:
    """Return the first and last bin in which a frame of this length looks for the line."""
    low = PERIODS if length < lengths[-1] else 2
    high = 2 * PERIODS + 1 if length > lengths[0] else length // 2 - 1
    width = sample_rate / length
    return max(low, int(band[0] / width)), min(high, int(np.ceil(band[1] / width)))


def _lines(
    read: SampleReader, n_samples: int, length: int, limits: tuple[int, int]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return middle [samples], bin (with fraction) and amplitude of each frame's line."""
    step = max(length // 2, n_samples // GRID)
    window = window_samples("periodic hann", length)
    starts = np.arange(0, n_samples - length + 1, step)
    lines, heights = np.empty(starts.size), np.empty(starts.size)
    per_read = max(1, CHUNK // step)
    for first in range(0, starts.size, per_read):
        part = slice(first, min(first + per_read, starts.size))
        samples = read(int(starts[part][0]), int(starts[part][-1]) + length)[0]
        frames = np.lib.stride_tricks.sliding_window_view(samples, length)[::step] * window
        power = np.abs(np.fft.rfft(frames)) ** 2
        lines[part], heights[part] = _strongest(power, limits)
    return np.array(starts + length / 2.0), lines, np.array(heights / length)


def _strongest(power: FloatArray, limits: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
    """Return bin (with fraction) and root of the power around each row's strongest bin."""
    peak = limits[0] + np.argmax(power[:, limits[0] : limits[1] + 1], axis=1)
    row = np.arange(power.shape[0])
    left, middle, right = (power[row, peak + shift] for shift in (-1, 0, 1))
    around = left + middle + right
    shift = np.zeros(row.size)
    np.divide(right - left, around, out=shift, where=around > 0.0)
    return peak + np.clip(shift, -0.5, 0.5), np.sqrt(around)


AT_ONCE: Final = 2**18
"""Samples of a channel transformed at once."""


def periodogram(samples: FloatArray, sample_rate: float) -> tuple[FloatArray, FloatArray]:
    r"""Return the one-sided periodogram of each channel.

    .. math:: S_k = \frac{2}{f_s N} \Big| \sum_n x_n e^{-2 \pi i k n / N} \Big|^2

    (not doubled at 0 and at half the sample rate).

    Parameters
    ----------
    samples : (n_channels, n_samples) array
        Samples of the crop [unit of the channel].
    sample_rate : float
        Samples per second [Hz].

    Returns
    -------
    (n_frequencies,) array
        Frequencies [Hz].
    (n_channels, n_frequencies) array
        Densities [unit²/Hz].
    """
    checks.positive("sample_rate", sample_rate, "Hz")
    n_samples = samples.shape[1]
    spectrum = np.array([np.abs(np.fft.rfft(row)) ** 2 for row in samples])
    spectrum /= sample_rate * n_samples
    spectrum[:, 1 : (n_samples + 1) // 2] *= 2.0
    return np.array(np.fft.rfftfreq(n_samples, 1.0 / sample_rate), dtype=np.float64), spectrum


@final
@dataclass(frozen=True, slots=True, eq=False)
class Spectrogram:
    """Density of each channel in stretches of time.

    Attributes
    ----------
    time : (n_times,) array
        Middle of each stretch, from the start of the samples [s].
    frequency : (n_frequencies,) array
        Middle of each bin [Hz].
    density : (n_channels, n_frequencies, n_times) array
        Mean density of the segments that start in the stretch [unit²/Hz].
    """

    time: FloatArray
    frequency: FloatArray
    density: FloatArray


def spectrogram(
    samples: FloatArray | SampleReader,
    sample_rate: float,
    *,
    n_samples: int | None = None,
    segment: int = 1024,
    overlap: int | None = None,
    window: str = "periodic hann",
    most_times: int = 500,
) -> Spectrogram:
    """Return the density against time: neighbouring segments are averaged where there are many.

    Parameters
    ----------
    samples : (n_channels, n_samples) array, or callable
        The crop, or a function that returns its samples start to stop [unit of the channel].
    sample_rate : float
        Samples per second [Hz].
    n_samples : int, optional
        Number of samples, where `samples` is a function.
    segment, overlap : int
        Samples of a segment, and those it shares with the next (by default half).
    window : str
        Name of the window.
    most_times : int
        Stretches of time at most.

    Returns
    -------
    Spectrogram
        Density of every channel.

    Raises
    ------
    SpectrumError
        If there are fewer samples than one segment.
    ValueError
        If the number of samples is not known, or the overlap does not fit.
    """
    checks.positive("sample_rate", sample_rate, "Hz")
    if isinstance(samples, np.ndarray):
        read, count = reader_of(samples)
    elif n_samples is None:
        raise ValueError("a function that reads samples needs n_samples beside it")
    else:
        read, count = samples, n_samples
    step = segment - (segment // 2 if overlap is None else overlap)
    if not 0 < step <= segment:
        raise ValueError(f"overlap must be 0 to {segment - 1} samples, not {overlap}")
    if count < segment:
        raise SpectrumError(f"{count} samples are fewer than one segment of {segment}")
    weights = window_samples(window, segment)
    n_segments = (count - segment) // step + 1
    together = -(-n_segments // most_times)
    columns, times = [], []
    for first in range(0, n_segments, together):
        number = min(together, n_segments - first)
        columns.append(_mean_power(read, first * step, number, step, weights))
        times.append((first + (number - 1) / 2.0) * step + segment / 2.0)
    density = np.stack(columns, axis=-1) / (sample_rate * float(weights @ weights))
    density[:, 1 : (segment + 1) // 2] *= 2.0
    return Spectrogram(
        time=np.array(times) / sample_rate,
        frequency=np.array(np.fft.rfftfreq(segment, 1.0 / sample_rate), dtype=np.float64),
        density=density,
    )


def _mean_power(
    read: SampleReader, start: int, n_segments: int, step: int, window: FloatArray
) -> FloatArray:
    """Return the mean squared spectrum of neighbouring segments, (n_channels, n_f)."""
    at_once = max(1, AT_ONCE // step)
    total: FloatArray | None = None
    for first in range(0, n_segments, at_once):
        number = min(at_once, n_segments - first)
        begin = start + first * step
        block = read(begin, begin + (number - 1) * step + window.size)
        frames = np.lib.stride_tricks.sliding_window_view(block, window.size, axis=1)[:, ::step]
        spectra = np.fft.rfft(frames * window)
        power = np.sum(spectra.real**2 + spectra.imag**2, axis=1)
        total = power if total is None else total + power
    return np.asarray(total) / n_segments
