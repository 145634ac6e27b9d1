"""What a search tells while it goes on, and what it has time for."""

import math
from collections.abc import Callable
from time import monotonic
from typing import Final, final

from shakerproc.numerals import numeral

TIME_LIMIT_S: Final = 300.0
"""About how long a diagnosis may take, where its user says nothing [s]."""

TWICE: Final = 2.0
"""Time that a search takes with one more part, over what it took before: a second effect takes
as long as the first, or less [-]."""


@final
class Progress:
    """What is told of a search, and what it has time for.

    Parameters
    ----------
    tell : callable, optional
        Called with what is being done.
    limit_s : float
        About how long the search may take; what a model without effects and with one takes is
        always done [s].
    """

    def __init__(
        self, tell: Callable[[str], None] | None = None, limit_s: float = math.inf
    ) -> None:
        self.limit_s, self._tell, self._begun_s = limit_s, tell, monotonic()
        self._left_out: dict[str, None] = {}

    def __call__(self, text: str) -> None:
        """Tell what is being done."""
        if self._tell is not None:
            self._tell(text)

    def has_time_for(self, part: str) -> bool:
        """Return whether a further part of the search is done, and tell it; else note it."""
        if TWICE * (monotonic() - self._begun_s) > self.limit_s:
            self._left_out[part] = None
            return False
        self(part)
        return True

    @property
    def notes(self) -> list[str]:
        """What there was no time for, in a sentence."""
        if not self._left_out:
            return []
        return [
            f"A diagnosis may take about {numeral(self.limit_s)} s (--time-limit); for want of "
            f"time this was not tried: {'; '.join(self._left_out)}."
        ]


def progress_of(tell: Callable[[str], None] | None) -> Progress:
    """Return what a caller gave as the progress of a search, without a limit of its own."""
    return tell if isinstance(tell, Progress) else Progress(tell)
