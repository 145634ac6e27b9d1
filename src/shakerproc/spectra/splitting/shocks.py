"""Shocks: short stretches that stand out of the vibration around them."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.spectra.splitting.cells import Cells

AROUND: Final = 10.0
"""Time over which the median tells the vibration around a cell [s]: shocks fill less than half
of it, and a step of the level moves it at once."""

BESIDE: Final = 0.5
"""Time to either side whose vibration counts as well [s]: the median of a cell beside a step of
the level is that of the quietest cells of the louder side.
"""

OVER: Final = 2.0
"""Rms of a cell, over the vibration around it, down to which a shock has not ended yet [-]."""

APART: Final = 0.1
"""Quiet that two shocks have between them at least [s]; with less they are one."""

FAINT: Final = 1e-3
"""Share of the largest peak of a channel, 60 dB below it, that is no shock in any case [-]."""


@final
@dataclass(frozen=True, slots=True)
class ShockRule:
    """Criterion of a shock.

    Attributes
    ----------
    crest : float
        Peak of a shock at least, over the rms of the vibration around it [-].
    least : float
        Peak of a shock at least [unit].
    longest : float
        Duration of a shock at most [s].
    """

    crest: float
    least: float
    longest: float


def background(cells: Cells) -> FloatArray:
    """Return the rms of the vibration around each cell, (n_channels, n_cells) [unit].

    The median over `AROUND`, which shocks do not move, the largest of those `BESIDE`.
    """
    size = min(round(AROUND / cells.seconds) | 1, (2 * cells.count - 1) | 1)
    median = scipy.ndimage.median_filter(cells.mean_square, (1, size), mode="nearest")
    beside = 2 * round(BESIDE / cells.seconds) + 1
    widened = scipy.ndimage.maximum_filter(median, (1, beside), mode="nearest")
    return np.sqrt(np.asarray(widened, dtype=np.float64))


def shocks_of(cells: Cells, rule: ShockRule) -> list[tuple[int, int]]:
    """Return the shocks of a record, first cell and the cell after the last.

    A shock begins and ends where no channel is more than `OVER` times the vibration around it,
    and holds a peak that is one by `rule`; a cell on either side belongs to it. What lasts
    longer than the rule allows is none.
    """
    around = background(cells)
    floor = FAINT * cells.peak.max(axis=1, keepdims=True)
    high = cells.peak >= np.maximum(np.maximum(rule.crest * around, floor), rule.least)
    high &= cells.peak > 0.0
    rms = np.sqrt(cells.mean_square)
    beyond = (rms > np.maximum(OVER * around, 0.5 * floor)) | high
    peaks = high.any(axis=0)
    joined = _closed(beyond.any(axis=0), round(APART / cells.seconds))
    most = max(1, round(rule.longest / cells.seconds))
    return [
        (max(first - 1, 0), min(stop + 1, cells.count))
        for first, stop in _runs(joined)
        if peaks[first:stop].any() and stop - first <= most
    ]


def _closed(mask: NDArray[np.bool_], gap: int) -> NDArray[np.bool_]:
    """Return a mask in which gaps of less than so many cells are filled."""
    found = mask.copy()
    for first, stop in _runs(~mask):
        if stop - first < gap and first > 0 and stop < mask.size:
            found[first:stop] = True
    return found


def _runs(mask: NDArray[np.bool_]) -> Iterator[tuple[int, int]]:
    """Yield where a mask holds, first place and the place after the last."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    for first, stop in edges.reshape(-1, 2):
        yield int(first), int(stop)
