"""Measured samples made ready for the observer: noise, fine input, slopes, weights."""

from dataclasses import dataclass

import numpy as np
import scipy  # its parts load when they are first used
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq

from shakerproc.data import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Prepared:
    """One test ready for the observer.

    Attributes
    ----------
    measured, slope : (n_sensors, n) array
        Responses and their time derivatives.
    weight : (n_sensors, n) array
        1 where a sample may be used, 0 where it is clipped.
    input : (n * fine,) array
        Input on the fine grid, sharpened for the first-order hold.
    noise : (n_sensors,) array
        Standard deviation of a sample of each response.
    input_noise : float
        Standard deviation of a sample of the input.
    """

    name: str
    sample_rate: float
    measured: FloatArray
    slope: FloatArray
    weight: FloatArray
    input: FloatArray
    noise: FloatArray
    input_noise: float
    hold_out: bool
    start: int


def upsample(samples: FloatArray, factor: int) -> FloatArray:
    """Return samples on a grid `factor` times finer, sharpened for a first-order hold.

    A hold that is linear between the fine points attenuates by sinc² of frequency over the fine
    rate; the spectrum is divided by it, so that the held signal is the band-limited one.
    """
    n = samples.size
    pad = 512
    first, last = samples[0], samples[-1]
    length = next_fast_len(n + 2 * pad, real=True)
    padded = np.empty(length)
    padded[:n] = samples
    ramp = np.arange(length - n) / (length - n)
    padded[n:] = last + (first - last) * (3.0 * ramp**2 - 2.0 * ramp**3)
    spectrum = rfft(padded)
    fine = np.zeros(length * factor // 2 + 1, dtype=complex)
    fine[: spectrum.size] = spectrum * factor
    if length % 2 == 0:
        fine[spectrum.size - 1] *= 0.5
    relative = np.arange(spectrum.size) / (length * factor)
    fine[: spectrum.size] /= np.sinc(relative) ** 2
    return irfft(fine, length * factor)[: n * factor]


def shifted(
    samples: FloatArray, shift: float, *, slope: bool, sample_rate: float
) -> FloatArray:
    """Return samples (or their slope) `shift` seconds later, along the last axis."""
    n = samples.shape[-1]
    length = next_fast_len(n + 1024, real=True)
    ramp = np.arange(length - n) / (length - n)
    bridge = 3.0 * ramp**2 - 2.0 * ramp**3
    padded = np.empty((*samples.shape[:-1], length))
    padded[..., :n] = samples
    padded[..., n:] = samples[..., -1:] + (samples[..., :1] - samples[..., -1:]) * bridge
    spectrum = rfft(padded)
    omega = 2.0 * np.pi * rfftfreq(length, 1.0 / sample_rate)
    turn = np.exp(1j * omega * shift)
    if slope:
        turn = turn * 1j * omega
        if length % 2 == 0:
            turn[-1] = 0.0
    return irfft(spectrum * turn, length)[..., :n]


def signal_slope(samples: FloatArray, noise: float, sample_rate: float) -> FloatArray:
    """Return the slope of what stands above white noise of this standard deviation.

    The slope of the noise itself would be larger than that of the signal, and bias a delay.
    """
    n = samples.size
    frequency, power = scipy.signal.welch(
        samples, sample_rate, nperseg=min(1024, n), detrend=False
    )
    share = (
        np.clip(1.0 - 2.0 * noise**2 / sample_rate / np.maximum(power, 1e-300), 0.0, 1.0) ** 2
    )
    length = next_fast_len(n + 1024, real=True)
    ramp = np.arange(length - n) / (length - n)
    padded = np.empty(length)
    padded[:n] = samples
    padded[n:] = samples[-1] + (samples[0] - samples[-1]) * (3.0 * ramp**2 - 2.0 * ramp**3)
    at = rfftfreq(length, 1.0 / sample_rate)
    turn = 2j * np.pi * at * np.interp(at, frequency, share)
    if length % 2 == 0:
        turn[-1] = 0.0
    return irfft(rfft(padded) * turn, length)[:n]


def white_level(samples: FloatArray, sample_rate: float) -> float:
    """Return the standard deviation of white noise that the quiet top of the band shows.

    Spectra of short Hann segments are averaged over the band 0.82-0.97 of half the rate; the
    lowest tenth of the segments (bias removed) stands for the noise, so that segments with
    contact noise or clipping do not count.
    """
    size = 512
    segments = samples[: samples.size // size * size].reshape(-1, size)
    window = np.hanning(size)
    power = np.abs(rfft((segments - segments.mean(axis=1, keepdims=True)) * window)) ** 2
    low, high = int(0.82 * size / 2), int(0.97 * size / 2)
    power = power[:, low:high] / np.sum(window**2)
    level = np.sort(np.mean(power, axis=1))
    keep = level[: max(level.size // 5, 1)]
    # mean of the lowest fifth of gamma variates with k = bins * 2/3 effective degrees
    k = (high - low) * 2.0 / 3.0
    bias = 1.0 - 1.40 / np.sqrt(k)
    return float(np.sqrt(np.mean(keep) / bias))
