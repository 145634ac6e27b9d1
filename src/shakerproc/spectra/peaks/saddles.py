"""The saddles beside a maximum: scipy.signal has them, but loads for 0.4 s."""

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray

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
    last = level.size - 1
    left = np.array(_lowest_before(level.tolist()), dtype=np.intp)[peaks]
    right = last - np.array(_lowest_before(level[::-1].tolist()), dtype=np.intp)[last - peaks]
    return np.where(level[left] >= level[right], left, right)


def _lowest_before(level: Sequence[float]) -> list[int]:
    """Return where the lowest value lies from each one back to the next that is taller.

    The nearest of several that are as low. What is taller waits in a stack, each with the
    lowest value between it and the one below it.
    """
    lowest: list[int] = []
    waiting: list[tuple[float, int]] = []
    for place, height in enumerate(level):
        low = place
        while waiting and waiting[-1][0] <= height:
            _, beside = waiting.pop()
            if level[beside] < level[low]:
                low = beside
        waiting.append((height, low))
        lowest.append(low)
    return lowest
