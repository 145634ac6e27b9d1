"""What the shaker does: band-limited noise and logarithmic sweeps, with a quiet lead-in.

A test takes 20 s, or `BLIND_SECONDS`: other campaigns then, never to be mixed with these.
"""

import os
from dataclasses import dataclass

import numpy as np
from scipy import fft

SAMPLE_RATE = 5688.9
N_SAMPLES = round(float(os.environ.get("BLIND_SECONDS", "20")) * SAMPLE_RATE)


@dataclass(frozen=True)
class Drive:
    """One test as it is asked of the shaker; level is an rms (random) or amplitude (sweep)."""

    kind: str
    level: float
    low_hz: float
    high_hz: float
    up: bool
    lead_in: float
    tail: float
    seed: tuple[int, ...]


def shaped(values: np.ndarray, upsampling: int, lead_in: float, tail: float) -> np.ndarray:
    """Return the values with a quiet lead-in and tail, and cosine ramps of 0.1 s between."""
    start, length, end = (int(t * SAMPLE_RATE) * upsampling for t in (lead_in, 0.1, tail))
    stop = values.size - end
    fall = 0.5 * (1.0 + np.cos(np.pi * np.arange(length) / length))
    out = np.zeros(values.size + 1)
    out[start:stop] = values[start:stop]
    out[start : start + length] *= 1.0 - fall
    out[stop - length : stop] *= fall
    return out


def waveform(drive: Drive, upsampling: int, n_samples: int = N_SAMPLES) -> np.ndarray:
    """Return the excitation at `upsampling` times the sample rate, with one value more."""
    n, rate = n_samples * upsampling, SAMPLE_RATE * upsampling
    values = _noise(drive, n_samples, n) if drive.kind == "random" else _sweep(drive, n, rate)
    return shaped(values, upsampling, drive.lead_in, drive.tail)


def _noise(drive: Drive, n_samples: int, n: int) -> np.ndarray:
    rng = np.random.default_rng(drive.seed)
    first, last = (int(f / SAMPLE_RATE * n_samples) for f in (drive.low_hz, drive.high_hz))
    bins = np.zeros(last + 1, complex)
    bins[first:] = rng.standard_normal((last + 1 - first, 2)) @ [1.0, 1.0j]
    spectrum = np.zeros(n // 2 + 1, complex)
    spectrum[: bins.size] = bins
    noise: np.ndarray = fft.irfft(spectrum, n, norm="forward", overwrite_x=True)
    return noise * drive.level / np.sqrt(4.0 * (last + 1 - first))


def _sweep(drive: Drive, n: int, rate: float) -> np.ndarray:
    t = np.arange(n) / rate - drive.lead_in
    length = n / rate - drive.lead_in - drive.tail
    start, stop = (drive.low_hz, drive.high_hz) if drive.up else (drive.high_hz, drive.low_hz)
    stretch = length / np.log(stop / start)
    growth = np.exp(np.clip(t, 0.0, length) / stretch)
    return drive.level * np.sin(2.0 * np.pi * start * stretch * (growth - 1.0))
