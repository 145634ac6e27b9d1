"""The extremes of a long recording in a few hundred slices, for drawing."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import final

import numpy as np

from shakerproc.data import FloatArray


@final
@dataclass(frozen=True, slots=True, eq=False)
class Envelope:
    """Extremes of each slice of time.

    Attributes
    ----------
    time : (n_slices,) array
        Middle of each slice [s].
    low, high : (n_channels, n_slices) arrays
        Smallest and largest sample of each slice [unit of the channel].
    """

    time: FloatArray
    low: FloatArray
    high: FloatArray


def envelope(
    blocks: Iterable[FloatArray], n_samples: int, sample_rate: float, n_slices: int = 1200
) -> Envelope:
    """Return the extremes of samples that come in blocks.

    Parameters
    ----------
    blocks : iterable of (n_channels, n) arrays
        All samples in order [unit of the channel].
    n_samples : int
        How many there are.
    sample_rate : float
        Samples per second [Hz].
    n_slices : int
        Slices of equal length; fewer where there are fewer samples.

    Returns
    -------
    Envelope
        Extremes of each slice.
    """
    n_slices = max(1, min(n_slices, n_samples))
    edges = np.arange(n_slices + 1) * n_samples // n_slices
    low: FloatArray | None = None
    high: FloatArray | None = None
    position = 0
    for block in blocks:
        if low is None or high is None:
            low = np.full((block.shape[0], n_slices), np.inf)
            high = np.full((block.shape[0], n_slices), -np.inf)
        end = position + block.shape[1]
        first = int(np.searchsorted(edges, position, side="right")) - 1
        last = int(np.searchsorted(edges, end, side="left"))
        starts = np.maximum(edges[first:last] - position, 0)
        part = slice(first, last)
        low[:, part] = np.fmin(low[:, part], np.minimum.reduceat(block, starts, axis=1))
        high[:, part] = np.fmax(high[:, part], np.maximum.reduceat(block, starts, axis=1))
        position = end
    middle = np.asarray((edges[:-1] + edges[1:]) / (2.0 * sample_rate), dtype=float)
    if low is None or high is None:
        return Envelope(middle, np.zeros((0, n_slices)), np.zeros((0, n_slices)))
    return Envelope(middle, low, high)
