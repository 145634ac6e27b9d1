"""One mode of a free decay, and what lies beside it."""

from dataclasses import dataclass
from typing import final


@final
@dataclass(frozen=True, slots=True)
class DecayLine:
    """A mode of a decay as its spectrum shows it.

    Attributes
    ----------
    frequency : float
        Of the line [Hz].
    row : int
        Channel in which it stands out of the noise most.
    apart : float
        How far away the next other line, rest (0 Hz) or half the sample rate is [Hz].
    ratio : float
        Height of that line over its own, 1 at least [-].
    """

    frequency: float
    row: int
    apart: float
    ratio: float
