"""Density of a whole crop at once, and density against time and frequency."""

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc import checks
from shakerproc.data import FloatArray
from shakerproc.errors import SpectrumError
from shakerproc.spectra.welch.ridges import SampleReader, reader_of
from shakerproc.spectra.welch.windows import window_samples

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
