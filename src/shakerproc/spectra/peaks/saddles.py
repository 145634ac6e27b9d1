"""The saddles beside a maximum, compiled once: scipy.signal has them, but loads for 0.4 s."""

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.spectra.kernels import jit

IndexArray: TypeAlias = NDArray[np.intp]


def saddles(level: FloatArray, peaks: IndexArray) -> IndexArray:
    """Return the higher of the two saddles between each maximum and taller ground.

    Parameters
    ----------
    level : (n,) array
        Values without NaN [any unit].
    peaks : (m,) array of int
        Maxima among them.

    Returns
    -------
    (m,) array of int
        Where the saddles are; the left one of two that are as high.
    """
    found = np.empty(peaks.size, dtype=np.intp)
    _find_saddles(level, peaks, found)
    return found


@jit
def _find_saddles(level: FloatArray, peaks: IndexArray, found: IndexArray) -> None:
    """Walk to both sides of each maximum until the ground is taller."""
    for number in range(peaks.size):
        peak = peaks[number]
        left = right = peak
        at = peak - 1
        while at >= 0 and level[at] <= level[peak]:
            if level[at] < level[left]:
                left = at
            at -= 1
        at = peak + 1
        while at < level.size and level[at] <= level[peak]:
            if level[at] < level[right]:
                right = at
            at += 1
        found[number] = left if level[left] >= level[right] else right
