"""What a watcher is: it sees every block once and says at the end what was wrong."""

import re
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray, Recording

_CONTROL: Final = re.compile(r"control|ctrl|pilot", re.IGNORECASE)


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
    """

    kind: str
    channel: str
    message: str
    start: float
    stop: float


class AbstractWatcher(ABC):
    """Sees the samples of a recording block by block, in order."""

    @abstractmethod
    def add(self, first: int, block: FloatArray) -> None:
        """Take in one block.

        Parameters
        ----------
        first : int
            Number of its first sample.
        block : (n_channels, n) array
            Finite samples in SI; what was not finite is bridged.
        """

    @abstractmethod
    def flags(self) -> list[Flag]:
        """Return what was wrong, once all blocks are in."""


def control_rows(recording: Recording) -> list[int]:
    """Return which channels are controls: by their role, else by their names."""
    rows = [i for i, c in enumerate(recording.channels) if c.role == "control"]
    if rows or any(c.role for c in recording.channels):
        return rows
    return [i for i, c in enumerate(recording.channels) if _CONTROL.search(c.name)]


def rms(values: FloatArray) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(np.square(values)))) if values.size else 0.0


def listed(names: Sequence[str]) -> str:
    """Return names as a sentence has them."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
