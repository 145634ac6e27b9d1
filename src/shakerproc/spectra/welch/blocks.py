"""Samples as blocks that lie in memory row by row, whatever they come as."""

from collections.abc import Iterable, Iterator

import numpy as np

from shakerproc.data import FloatArray

SLICE = 2**16
"""Samples of a slice: a few of them fit the cache."""


def in_order(blocks: Iterable[FloatArray] | FloatArray) -> Iterator[FloatArray]:
    """Yield (n_channels, n) blocks of float64 in row order, copied only where they are not.

    They may be in any unit.

    Raises
    ------
    ValueError
        If a block is not two-dimensional.
    """
    for block in (blocks,) if isinstance(blocks, np.ndarray) else blocks:
        if block.ndim != 2 or not block.shape[0]:
            raise ValueError(f"a block must be (n_channels, n) samples, not {block.shape}")
        if block.flags.c_contiguous and block.dtype == np.float64:
            yield block
            continue
        for start in range(0, block.shape[1], SLICE):
            yield np.ascontiguousarray(block[:, start : start + SLICE], dtype=np.float64)
