"""Interface of health checks, pieces of a recording for them, and gaps that are bridged."""

import re
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray, Recording

FAULTS: Final[Mapping[str, str]] = MappingProxyType({
    "constant": "is constant",
    "open input": "is an open input",
    "clipping": "is clipped",
    "stuck": "is stuck",
    "zero tail": "ends in zeros",
    "dropout": "drops out",
    "not a number": "holds values that are NaN or infinite",
})
"""What a channel that does not measure is or does, by the kind of its flag."""

_CONTROL: Final = re.compile(r"control|ctrl|pilot", re.IGNORECASE)

LARGEST: Final = 1e50
"""In SI; nothing that is measured comes near it, and its fourth power is still a number."""


@final
@dataclass(frozen=True, slots=True)
class Flag:
    """Something about a recording that a person should look at.

    Attributes
    ----------
    kind : str
        What it is in a word or two: ``zero tail``, ``clipping``, ``polarity`` and so on.
    channel : str
        Name of the channel; empty where it concerns the whole recording.
    message : str
        What was found and what to do, a sentence or two.
    start, stop : float
        From when to when it lasts [s].
    lost : float
        How long the channel did not measure meanwhile: it stood still, was at its limit, or is
        not connected [s].
    """

    kind: str
    channel: str
    message: str
    start: float
    stop: float
    lost: float = 0.0

    @property
    def line(self) -> str:
        """The finding and its place, in a line."""
        where = f" ({self.channel})" if self.channel else ""
        return f"{self.kind}{where}: {self.message}"

    def lost_share(self, start: float, stop: float) -> float:
        """Return the share of a part of the recording that the channel did not measure [-].

        Parameters
        ----------
        start, stop : float
            The part [s].
        """
        common, length = min(self.stop, stop) - max(self.start, start), self.stop - self.start
        if not self.lost or common <= 0.0 or length <= 0.0:
            return 0.0
        return min(1.0, self.lost * common / length / (stop - start))


class AbstractHealthCheck(ABC):
    """Sees the samples of a recording block by block, in order."""

    @abstractmethod
    def add(self, first: int, block: FloatArray) -> None:
        """Take in one block.

        Parameters
        ----------
        first : int
            Number of its first sample.
        block : (n_channels, n) array
            Finite samples in SI; what was not finite is bridged [SI unit of the channel].
        """

    @abstractmethod
    def flags(self) -> list[Flag]:
        """Return the flags, once all blocks are in."""


def control_rows(recording: Recording) -> list[int]:
    """Return which channels are controls: by their role, else by their names."""
    rows = [i for i, c in enumerate(recording.channels) if c.role == "control"]
    if rows or any(c.role for c in recording.channels):
        return rows
    return [i for i, c in enumerate(recording.channels) if _CONTROL.search(c.name)]


def rms(values: FloatArray) -> float:
    """Return the root of the mean square. It is in the unit of the values."""
    return float(np.sqrt(np.mean(np.square(values)))) if values.size else 0.0


def resolution(samples: FloatArray) -> float:
    """Return the smallest step from a sample to the next, 0 where there is none.

    It is in the unit of the samples.
    """
    steps = np.abs(np.diff(samples))
    return float(np.min(steps, where=steps > 0.0, initial=np.inf)) if np.any(steps) else 0.0


def listed(names: Sequence[str]) -> str:
    """Return names as a sentence has them."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


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
        """Return the part of a block from a sample on."""
        if start >= first:
            return block[:, start - first :]
        return np.concatenate([self._rest[:, start - self._base :], block], axis=1)


@final
class Gaps:
    """Watches for samples that are no numbers or too large, and bridges them for the others."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        self._counts = np.zeros(len(recording.channels), dtype=np.int64)
        self._first = np.full(len(recording.channels), -1, dtype=np.int64)
        self._last = np.zeros(len(recording.channels), dtype=np.int64)

    def add(self, first: int, block: FloatArray) -> FloatArray:
        """Return the block with straight lines over samples that were no numbers."""
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
