"""Evenly sampled signals at times between their samples."""

from collections.abc import Callable
from typing import Final

import numpy as np

from shakerproc.data import FloatArray

TAPS: Final = 32
"""Samples on either side of a time that make its value, at the slower of both rates [-]."""

KAISER: Final = 10.0
"""Shape of the window over them: what it leaves beside the band is below 1e-5 [-]."""

_BLOCK: Final = 1 << 14


def interpolated(
    read: Callable[[int, int], FloatArray],
    n_samples: int,
    sample_rate: float,
    times: FloatArray,
    wanted_rate: float,
) -> FloatArray:
    """Return a signal at other times, low-pass filtered to the new rate.

    The sum of its samples with a sinc in a Kaiser window; 0 beyond its ends.

    Parameters
    ----------
    read : callable
        From first and last but one sample to them, (..., n) array [any unit].
    n_samples : int
        How many there are.
    sample_rate : float
        Of the samples [Hz].
    times : (n,) array
        Rising, from the first sample [s].
    wanted_rate : float
        Of the times [Hz].

    Returns
    -------
    (..., n) array
        Values at the times.
    """
    cutoff = min(1.0, wanted_rate / sample_rate)
    half = int(np.ceil(TAPS / cutoff))
    parts = [_piece(read, n_samples, times[a : a + _BLOCK] * sample_rate, half, cutoff)
             for a in range(0, times.size, _BLOCK)]  # fmt: skip
    return np.concatenate(parts, axis=-1) if parts else read(0, 0)


def _piece(
    read: Callable[[int, int], FloatArray],
    n_samples: int,
    places: FloatArray,
    half: int,
    cutoff: float,
) -> FloatArray:
    """Return the values at places between samples [samples]."""
    whole = np.floor(places).astype(int)
    first, last = int(whole[0]) - half + 1, int(whole[-1]) + half + 1
    low, high = min(max(first, 0), n_samples), max(min(last, n_samples), 0)
    samples = read(low, max(low, high))
    out = np.zeros((*samples.shape[:-1], places.size))
    padded = np.zeros((*samples.shape[:-1], last - first))
    padded[..., low - first : low - first + samples.shape[-1]] = samples
    beta = np.i0(KAISER)
    for tap in range(-half + 1, half + 1):
        away = whole + tap - places
        window = np.i0(KAISER * np.sqrt(np.maximum(1.0 - (away / half) ** 2, 0.0))) / beta
        out += padded[..., whole + tap - first] * (cutoff * np.sinc(cutoff * away) * window)
    return out
