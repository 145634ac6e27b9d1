"""The tones that a test demands above its random vibration."""

from dataclasses import dataclass
from typing import final


@final
@dataclass(frozen=True, slots=True)
class DemandedTone:
    """A sine of fixed frequency in a test of sine on random.

    Attributes
    ----------
    frequency : float
        Where it is [Hz].
    level : float, optional
        Amplitude demanded, in SI, of the signal that the level of the test is of.
    """

    frequency: float
    level: float | None = None
