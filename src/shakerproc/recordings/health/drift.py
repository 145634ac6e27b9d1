"""Drift: a mean that moves steadily from the first to the last sample."""

from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray, Recording
from shakerproc.numerals import numeral
from shakerproc.recordings.health.base import AbstractHealthCheck, Flag

PARTS: Final = 32
"""Equal parts of the recording whose means are compared."""

CERTAIN: Final = 10.0
"""Slope of the means over its standard error; chance never makes 10."""

RELEVANT: Final = 0.2
"""Change of the mean over the recording, relative to the standard deviation."""

COUNTER: Final = 3.3
"""The same of a straight line is the root of 12: a counter, not a drift."""


@final
class Drift(AbstractHealthCheck):
    """Watches the mean of every channel over time."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        count = len(recording.channels)
        self._sums = np.zeros((count, PARTS))
        self._squares = np.zeros(count)
        self._edges = np.linspace(0, recording.n_samples, PARTS + 1).astype(np.int64)

    def add(self, first: int, block: FloatArray) -> None:
        self._squares += np.einsum("ij,ij->i", block, block)
        inner = np.clip(self._edges - first, 0, block.shape[1])
        for part in range(PARTS):
            if inner[part + 1] > inner[part]:
                self._sums[:, part] += block[:, inner[part] : inner[part + 1]].sum(axis=1)

    def flags(self) -> list[Flag]:
        n = self._recording.n_samples
        if n < 8 * PARTS:
            return []
        means = self._sums / np.diff(self._edges)
        mean = self._sums.sum(axis=1) / n
        spread = np.sqrt(np.maximum(self._squares / n - mean**2, 0.0))
        time = np.linspace(-0.5, 0.5, PARTS)
        slopes = (means - means.mean(axis=1, keepdims=True)) @ time / (time @ time)
        rest = means - means.mean(axis=1, keepdims=True) - np.outer(slopes, time)
        error = np.sqrt(np.sum(rest**2, axis=1) / (PARTS - 2) / (time @ time))
        found = []
        for row, channel in enumerate(self._recording.channels):
            change = abs(slopes[row])
            relative = change / spread[row] if spread[row] else 0.0
            if change > CERTAIN * error[row] and RELEVANT < relative < COUNTER:
                found.append(
                    Flag(
                        "drift",
                        channel.name,
                        f"The mean moves steadily by {numeral(slopes[row], 4)} {channel.unit} "
                        f"from beginning to end, {numeral(relative, 2)} of the standard "
                        "deviation. Let the sensor warm up, or remove the trend.",
                        0.0,
                        self._recording.duration,
                    )
                )
        return found
