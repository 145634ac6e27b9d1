"""Where samples pile up at the end of the range of a channel."""

from collections.abc import Iterable
from typing import Final

import numpy as np

from shakerproc.data import FloatArray

FEWEST: Final = 3
"""Samples exactly at the largest value of a channel that make it the end of its range."""

PILE: Final = 3.0
"""How many times as many samples as at the next value there must be: a quantised sine has
2.4 times as many at its crest [-]."""

RESTING: Final = 0.5
"""Share of samples from which on the extreme is where the channel rests [-]."""


def range_ends(blocks: Iterable[FloatArray]) -> FloatArray:
    """Return the ends of the ranges at which samples of a recording pile up.

    Parameters
    ----------
    blocks : iterable of (n_channels, n) arrays
        The samples in order [unit of the channel].

    Returns
    -------
    (2, n_channels) array
        Low and high end of each channel; not a number where its samples do not reach one.
    """
    counts: list[list[dict[float, int]]] = []
    n_samples = 0
    for block in blocks:
        n_samples += block.shape[1]
        counts = counts or [[{} for _ in block] for _ in range(2)]
        for side, samples in ((0, -block), (1, block)):
            for known, row in zip(counts[side], samples, strict=True):
                _count_highest(known, row)
    sides = [[_end(known, n_samples) for known in side] for side in counts]
    return np.array([[-low for low in sides[0]], sides[1]])


def _count_highest(known: dict[float, int], row: FloatArray) -> None:
    """Count the samples at the highest two values, with those that are known already."""
    top = float(row.max())
    below = row[row < top]
    values = [top, float(below.max())] if below.size else [top]
    for value in values:
        known[value] = known.get(value, 0) + int(np.count_nonzero(row == value))
    for value in sorted(known)[:-2]:
        del known[value]


def _end(known: dict[float, int], n_samples: int) -> float:
    """Return the end of a range, not a number where samples do not pile up there."""
    top = max(known)
    count, beside = known[top], known[min(known)] if len(known) > 1 else 1
    piled = count >= max(FEWEST, PILE * beside) and count < RESTING * n_samples
    return top if piled and top != 0.0 else float("nan")
