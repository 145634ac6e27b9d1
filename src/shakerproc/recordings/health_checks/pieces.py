"""Pieces of a recording that comes in blocks, copied only where two blocks meet in one."""

from collections.abc import Iterator, Sequence
from typing import final

import numpy as np

from shakerproc.data import FloatArray


@final
class Pieces:
    """Pieces of one length.

    Parameters
    ----------
    starts : sequence of int
        First sample of each, rising.
    size : int
        Samples of a piece.
    """

    def __init__(self, starts: Sequence[int], size: int) -> None:
        self.starts, self.size = starts, size
        self._next, self._base = 0, 0
        self._rest: FloatArray = np.empty((0, 0))

    def of(self, first: int, block: FloatArray) -> Iterator[FloatArray]:
        """Yield every piece that a block completes, (n_channels, size); they may be views.

        `block` begins at sample `first`, where the block before it ended [any unit].
        """
        end = first + block.shape[1]
        while self._next < len(self.starts) and self._start + self.size <= end:
            yield self._from(self._start, first, block[:, : self._start + self.size - first])
            self._next += 1
        if self._next < len(self.starts) and self._start < end:
            self._rest, self._base = self._from(self._start, first, block).copy(), self._start

    @property
    def _start(self) -> int:
        return self.starts[self._next]

    def _from(self, start: int, first: int, block: FloatArray) -> FloatArray:
        """Return what lies from a sample on to the end of a block."""
        if start >= first:
            return block[:, start - first :]
        return np.concatenate([self._rest[:, start - self._base :], block], axis=1)
