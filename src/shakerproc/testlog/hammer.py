"""How the blows of a hammer test are cut out and windowed."""

from dataclasses import dataclass
from typing import Final, NamedTuple, final


class Amount(NamedTuple):
    """A quantity that may be given in two ways, with the unit that it was given in."""

    value: float
    unit: str


USUAL_TRIGGER: Final = Amount(0.1, "1")
"""Share of the largest force at which a blow begins where the log does not say it."""


@final
@dataclass(frozen=True, slots=True)
class Hammer:
    """How the blows of a hammer test are cut out and windowed.

    Attributes
    ----------
    trigger : Amount
        Force at which a blow begins [N], or its share of the largest force [1].
    pretrigger : float, optional
        What of a block lies before [s]; by default a hundredth of it.
    length : float, optional
        Of a block [s]; by default until the next blow.
    force_window : float, optional
        After this time from the trigger the force is set to 0, as before it [s]; by default
        it is left as it was measured.
    exponential : Amount, optional
        Time constant of the exponential window [s], or what is left at the end of a block
        [1]; by default there is no such window.
    """

    trigger: Amount = USUAL_TRIGGER
    pretrigger: float | None = None
    length: float | None = None
    force_window: float | None = None
    exponential: Amount | None = None
