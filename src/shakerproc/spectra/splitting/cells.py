"""Mean square and largest magnitude of a long record in short cells of time."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import final

import numpy as np

from shakerproc.data import FloatArray


@final
@dataclass(frozen=True, slots=True, eq=False)
class Cells:
    """Statistics of a record in cells of equal length; the last few samples may make none.

    Attributes
    ----------
    length : int
        Samples of a cell.
    sample_rate : float
        Samples per second [Hz].
    mean_square : (n_channels, n_cells) array
        Of the samples of a cell [unit²].
    peak : (n_channels, n_cells) array
        Largest magnitude in a cell [unit].
    """

    length: int
    sample_rate: float
    mean_square: FloatArray
    peak: FloatArray

    @property
    def seconds(self) -> float:
        """Length of a cell [s]."""
        return self.length / self.sample_rate

    @property
    def count(self) -> int:
        """Number of cells."""
        return int(self.peak.shape[1])


def cells_of(blocks: Iterable[FloatArray], sample_rate: float, length: int) -> Cells:
    """Return the cells of a record.

    Parameters
    ----------
    blocks : iterable of (n_channels, n) arrays
        The samples in order, without their means, in blocks of any size [unit].
    sample_rate : float
        Samples per second [Hz].
    length : int
        Samples of a cell.

    Returns
    -------
    Cells
        Of whole cells only.
    """
    squares, peaks = [], []
    rest: FloatArray | None = None
    for block in blocks:
        joined = block if rest is None else np.concatenate([rest, block], axis=1)
        whole = joined.shape[1] // length * length
        cut = joined[:, :whole].reshape(joined.shape[0], -1, length)
        squares.append(np.einsum("ijk,ijk->ij", cut, cut) / length)
        peaks.append(np.maximum(cut.max(axis=2), -cut.min(axis=2)) if whole else squares[-1])
        rest = joined[:, whole:].copy()
    return Cells(length, sample_rate, np.concatenate(squares, 1), np.concatenate(peaks, 1))
