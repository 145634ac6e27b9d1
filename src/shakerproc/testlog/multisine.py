"""The periods and realisations of a multisine."""

from dataclasses import dataclass
from typing import Literal, TypeAlias, final

LineGrid: TypeAlias = Literal["all", "odd", "odd with detection"]


@final
@dataclass(frozen=True, slots=True)
class Multisine:
    """How a multisine repeats.

    Attributes
    ----------
    period : float
        After this time it repeats; one over it is the distance of its lines [s].
    periods : int, optional
        How many each realisation lasts; by default as many as the run holds.
    realisations : int
        How many with phases of their own follow each other in the recording.
    every : float, optional
        From the beginning of one realisation to that of the next [s]; by default they follow
        each other without a pause.
    lines : {"all", "odd", "odd with detection"}
        Which multiples of one over the period are excited where a test is simulated: of the
        last, one of four odd ones in a row, at random, is left out. Of a recording they are
        found in its input.
    """

    period: float
    periods: int | None = None
    realisations: int = 1
    every: float | None = None
    lines: LineGrid = "odd with detection"

    @property
    def duration(self) -> float | None:
        """How long all realisations take [s]; None where their periods are not said."""
        if self.periods is None:
            return None
        one = self.periods * self.period
        return one + (self.realisations - 1) * (one if self.every is None else self.every)
