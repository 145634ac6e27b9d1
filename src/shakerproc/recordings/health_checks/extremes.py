"""Clipping: runs of samples exactly at the largest or the smallest value."""

from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray, Recording
from shakerproc.recordings.health_checks.base import AbstractHealthCheck, Flag

SHORTEST: Final = 3
"""Samples in a row at the extreme that count."""

FEWEST: Final = 6
"""Samples in such rows that make a flag."""

PILE: Final = 5.0
"""How many times as many samples as at the next value there must be at the extreme.

A quantized sine has 2.4 times as many at its crest as one step below, noise fewer.
"""

RESTING: Final = 0.5
"""Share of samples from which on the extreme is where the channel rests."""


@final
class _Side:
    """The extreme of one channel on one side (+1 or -1)."""

    def __init__(self, sign: int) -> None:
        self.sign = sign
        self.value = -np.inf
        self.count = 0
        self.next_value = -np.inf
        self.next_count = 0
        self.in_rows = 0
        self.first = 0
        self.last = 0
        self._row = 0

    def add(self, first: int, samples: FloatArray) -> None:
        """Take in the samples of a block, times the sign."""
        top = float(samples.max())
        if top < self.next_value:
            self._row = 0
            return
        span = top - float(samples.min())
        near = samples[samples >= top - 1e-3 * span]
        values = near[near < top] if near.size > 1 else near[:0]
        if not values.size:
            values = samples[samples < top]
        beside = float(values.max()) if values.size else -np.inf
        counts = {top: int(np.count_nonzero(near == top))}
        if values.size:
            counts[beside] = int(np.count_nonzero(values == beside))
        if self.count:
            counts[self.value] = counts.get(self.value, 0) + self.count
        if self.next_count:
            counts[self.next_value] = counts.get(self.next_value, 0) + self.next_count
        self._rows(first, samples, top)
        ordered = sorted(counts, reverse=True)
        self.value, self.count = ordered[0], counts[ordered[0]]
        if len(ordered) > 1:
            self.next_value, self.next_count = ordered[1], counts[ordered[1]]

    def _rows(self, first: int, samples: FloatArray, top: float) -> None:
        """Count the samples that stand in rows at the extreme."""
        if top > self.value:
            self.in_rows, self._row, self.first = 0, 0, -1
        if top < self.value:
            self._row = 0
            return
        at = np.flatnonzero(samples == top)
        groups = (
            np.split(at, np.flatnonzero(np.diff(at) > 1) + 1) if at.size < 100_000 else [at]
        )
        for group in groups:
            length = group.size
            if group[0] == 0 and self._row:
                length += self._row
            if length >= SHORTEST:
                self.in_rows += length
                self.first = first + int(group[0]) if self.first < 0 else self.first
                self.last = first + int(group[-1])
        self._row = groups[-1].size if groups[-1][-1] == samples.size - 1 else 0

    def is_clipped(self, n_samples: int) -> bool:
        """Return whether the samples pile up at the extreme."""
        return (
            self.in_rows >= FEWEST
            and self.value != 0.0
            and self.count > PILE * max(self.next_count, 1)
            and self.count < RESTING * n_samples
        )


@final
class Extremes(AbstractHealthCheck):
    """Watches the largest and the smallest value of every channel."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        self._sides = [(_Side(1), _Side(-1)) for _ in recording.channels]

    def add(self, first: int, block: FloatArray) -> None:
        for (high, low), samples in zip(self._sides, block, strict=True):
            high.add(first, samples)
            low.add(first, -samples)

    def flags(self) -> list[Flag]:
        found = []
        rate = self._recording.sample_rate
        for channel, sides in zip(self._recording.channels, self._sides, strict=True):
            hit = [side for side in sides if side.is_clipped(self._recording.n_samples)]
            if hit:
                limits = " and ".join(f"{side.sign * side.value:.6g}" for side in hit)
                count = sum(side.count for side in hit)
                found.append(
                    Flag(
                        "clipping",
                        channel.name,
                        f"{count} samples stand exactly at {limits} {channel.unit}: the range "
                        "was too small. Measure again with a larger range.",
                        min(side.first for side in hit) / rate,
                        max(side.last for side in hit) / rate,
                        count / rate,
                    )
                )
        return found
