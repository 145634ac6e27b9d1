"""Repeating blocks: a buffer of the measuring program that was handed out twice."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray, Recording
from shakerproc.numerals import numeral
from shakerproc.recordings.health.base import AbstractHealthCheck, Flag, rms

WINDOW: Final = 32
"""Samples that must be equal to the last bit for a place to be known again."""

DISTINCT: Final = 24
"""Different values among them at least: coarse steps repeat themselves by chance."""

TOP_BITS: Final = 8
"""Places are looked at where the top 8 bits of a mix of the sample are 0: one in 256."""

MOST: Final = 1 << 13
"""Places that are remembered of a channel: some two million samples back."""

FEWEST: Final = 4
"""Places in a row, one behind the other at the same distance, that make a repetition."""

SHORTEST: Final = 256
"""Samples that a repetition must last."""

ALIKE: Final = 0.2
"""Difference between neighbouring periods of a periodic signal, relative to its rms."""

_MIX: Final = np.uint64(0x9E3779B97F4A7C15)
_LIMIT: Final = np.uint64(1 << (64 - TOP_BITS))
_WEIGHTS: Final = np.random.default_rng(0).integers(2**64, size=WINDOW, dtype=np.uint64) | 1
"""Odd numbers: windows that differ have another sum of products, but for one in 2^64."""


@final
@dataclass(slots=True)
class _Row:
    """Places that were seen before, one behind the other at the same distance.

    Attributes
    ----------
    first, last : int
        The first and the last of them.
    distance : int
        How far back they were seen.
    places, often : int
        How many there are, and how many of them came for the third time or more.
    """

    first: int
    last: int
    distance: int
    places: int = 0
    often: int = 0

    def take(self, at: int, times: int) -> None:
        """Take in the next place."""
        self.last = at
        self.places += 1
        self.often += times > 2


@final
class _Channel:
    """Places of one channel that were seen, and the rows of those seen again."""

    def __init__(self) -> None:
        self.seen: dict[int, tuple[int, int]] = {}  # the latest last
        self.row: _Row | None = None
        self.all: _Row | None = None  # the rows that count, as one from first to last

    def add(self, first: int, samples: FloatArray) -> None:
        """Look at the places in a block that the samples themselves choose.

        Of one value that comes again within a window only the first place counts, so that a
        channel that stands still costs no more than any other.
        """
        bits = samples.view(np.uint64)
        mixed = bits[: bits.size - WINDOW] * _MIX
        places = np.flatnonzero(mixed < _LIMIT)
        again = np.zeros(places.size, dtype=bool)
        again[1:] = (np.diff(places) < WINDOW) & (np.diff(bits[places]) == 0)
        places = places[~again]
        windows = bits[places[:, np.newaxis] + np.arange(WINDOW)]
        values = np.sort(windows.view(np.float64), axis=1)
        distinct = 1 + np.count_nonzero(values[:, 1:] != values[:, :-1], axis=1)
        chosen = distinct >= DISTINCT
        keys = (windows[chosen] * _WEIGHTS).sum(axis=1, dtype=np.uint64).tolist()
        self._look_at((first + places[chosen]).tolist(), keys)

    def _look_at(self, places: Sequence[int], keys: Sequence[int]) -> None:
        """Look at places in order; where none was seen before, at all of them at once."""
        if not self.seen.keys().isdisjoint(keys) or len(set(keys)) < len(keys):
            for at, key in zip(places, keys, strict=True):
                self._look(at, key)
        elif keys:
            self._close_row()
            self.seen.update(zip(keys, ((at, 1) for at in places), strict=True))
        for key in list(islice(self.seen, max(0, len(self.seen) - MOST))):
            del self.seen[key]

    def _look(self, at: int, key: int) -> None:
        before, times = self.seen.pop(key, (-1, 0))
        if self.row is not None and (not times or self.row.distance != at - before):
            self._close_row()
        if times:
            self.row = self.row or _Row(at, at, at - before)
            self.row.take(at, times + 1)
        self.seen[key] = (at, times + 1)

    def _close_row(self) -> None:
        row, self.row = self.row, None
        if row is None or row.places < FEWEST or row.last - row.first < SHORTEST:
            return
        if self.all is None:
            self.all = row
            return
        self.all.last = row.last
        self.all.places += row.places
        self.all.often += row.often

    def repetition(self, n_samples: int) -> tuple[int, int, int] | None:
        """Return start, stop and distance of the repeated samples.

        None where the same stretch came again and again from early on: a periodic signal.
        """
        self._close_row()
        rows = self.all
        if rows is None or (rows.first < n_samples // 4 and 2 * rows.often > rows.places):
            return None
        return rows.first, rows.last + WINDOW, rows.distance


@final
class Repeats(AbstractHealthCheck):
    """Watches for stretches that are equal to an earlier one to the last bit."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        self._channels = [_Channel() for _ in recording.channels]

    def add(self, first: int, block: FloatArray) -> None:
        for channel, samples in zip(self._channels, block, strict=True):
            if samples.size > WINDOW:
                channel.add(first, np.ascontiguousarray(samples))

    def flags(self) -> list[Flag]:
        flags = []
        rate = self._recording.sample_rate
        for row, places in enumerate(self._channels):
            channel = self._recording.channels[row]
            repeated = places.repetition(self._recording.n_samples)
            if repeated is not None and not self._is_periodic(row, *repeated[::2]):
                start, stop, distance = repeated
                flags.append(
                    Flag(
                        "repeating",
                        channel.name,
                        f"From {start / rate:.6g} s on the samples are those of "
                        f"{numeral(distance / rate, 4)} s earlier, to the last bit: the "
                        "measuring program handed out a buffer twice. Measure again.",
                        start / rate,
                        stop / rate,
                    )
                )
        return flags

    def _is_periodic(self, row: int, start: int, distance: int) -> bool:
        """Return whether the signal roughly repeated itself before that, as a sine does."""
        if start < 2 * distance:
            return False
        length = min(distance, 1 << 16)
        channel = self._recording.select([row])
        earlier = channel.samples(start - 2 * distance, start - 2 * distance + length)
        later = channel.samples(start - distance, start - distance + length)
        return rms(later - earlier) < ALIKE * rms(later - later.mean())
