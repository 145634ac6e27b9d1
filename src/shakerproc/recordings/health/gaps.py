"""Samples that are no numbers: told, and bridged for whatever looks at the others."""

from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray, Recording
from shakerproc.recordings.health.base import Flag

LARGEST: Final = 1e50
"""In SI; nothing that is measured comes near it, and its fourth power is still a number."""


@final
class Gaps:
    """Watches for what is no number, or too large to be one, and bridges it for the others."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        self._counts = np.zeros(len(recording.channels), dtype=np.int64)
        self._first = np.full(len(recording.channels), -1, dtype=np.int64)
        self._last = np.zeros(len(recording.channels), dtype=np.int64)

    def add(self, first: int, block: FloatArray) -> FloatArray:
        """Return the block with straight lines over what was no number."""
        if block.max() < LARGEST and block.min() > -LARGEST:  # not so where one is NaN
            return block
        bad = ~(np.abs(block) < LARGEST)
        for row in np.flatnonzero(bad.any(axis=1)):
            at = np.flatnonzero(bad[row])
            self._counts[row] += at.size
            self._last[row] = first + at[-1]
            if self._first[row] < 0:
                self._first[row] = first + at[0]
        return _bridged(block, bad)

    def flags(self) -> list[Flag]:
        """Return a flag for each channel that holds such samples."""
        rate = self._recording.sample_rate
        return [
            Flag(
                "not a number",
                channel.name,
                f"{count} samples are NaN or infinite, the first at "
                f"{first / rate:.6g} s. Keep them out of the crop, or export the recording "
                "again.",
                first / rate,
                (last + 1) / rate,
                int(count) / rate,
            )
            for channel, count, first, last in zip(
                self._recording.channels, self._counts, self._first, self._last, strict=True
            )
            if count
        ]


def _bridged(block: FloatArray, bad: NDArray[np.bool_]) -> FloatArray:
    whole = np.where(bad, 0.0, block)
    every = np.arange(block.shape[1])
    for row in np.flatnonzero(bad.any(axis=1)):
        good = ~bad[row]
        if good.any():
            whole[row] = np.interp(every, every[good], block[row, good])
    return whole
