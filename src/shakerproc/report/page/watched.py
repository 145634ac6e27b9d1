"""A page that follows a watched folder: how often a browser loads it again."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

_SHOWN: Final = 20
"""Tests that are named at most."""


@final
@dataclass(frozen=True, slots=True)
class Watched:
    """What a page says while its folder is watched.

    Attributes
    ----------
    refresh : float
        Time after which a browser loads the page again [s].
    waiting : sequence of str
        Tests whose recordings have not come yet.
    """

    refresh: float
    waiting: Sequence[str] = ()

    @property
    def seconds(self) -> int:
        """Whole seconds, as HTML takes them."""
        return max(1, round(self.refresh))

    @property
    def sentence(self) -> str:
        """What the reader is told."""
        told = f"Watched: this page reloads every {self.seconds} s"
        if not self.waiting:
            return f"{told}."
        more = len(self.waiting) - _SHOWN
        names = ", ".join([*self.waiting[:_SHOWN], *([f"{more} more"] if more > 0 else [])])
        return f"{told}. Waiting for the recordings of: {names}."
