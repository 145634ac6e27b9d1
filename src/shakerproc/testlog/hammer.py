"""How the blows of a hammer test are cut out and windowed, and the keys that say so."""

from dataclasses import dataclass
from typing import Annotated, Final, NamedTuple, final

from pydantic import BeforeValidator

from shakerproc.documents import Section
from shakerproc.units import in_unit, is_unit_of, quoted, to_si

_NUMBER: Final = "+-0123456789.eE "


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


def amount_of(written: object, units: tuple[str, str], largest_share: float) -> Amount:
    """Return a quantity written in one of two units, the second of which is a share, ``1``.

    Raises
    ------
    ValueError
        If it is none, not above 0, or a share that is too large.
    """
    first, share = units
    unit = written.lstrip(_NUMBER) if isinstance(written, str) else ""
    chosen = first if is_unit_of(unit, first) else share
    if not isinstance(written, str) or not (chosen == first or unit == "%"):
        raise ValueError(f"expected a number in {first} or in %, got {quoted(written)}")
    value = to_si(written, chosen)
    if value <= 0.0 or (chosen == share and value >= largest_share):
        raise ValueError(
            f"expected more than 0 {first}, or between 0 and 100 %, got {quoted(written)}"
        )
    return Amount(value, chosen)


def _trigger(written: object) -> Amount:
    return amount_of(written, ("N", "1"), 1.0)


def _exponential(written: object) -> Amount | None:
    return None if written == "none" else amount_of(written, ("s", "1"), 1.0)


class HammerSection(Section):
    """How the blows of a hammer test are cut out and windowed."""

    trigger: Annotated[Amount | None, BeforeValidator(_trigger)] = None
    pretrigger: Annotated[float | None, in_unit("s", not_negative=True)] = None
    length: Annotated[float | None, in_unit("s", positive=True)] = None
    force_window: Annotated[float | None, in_unit("s", positive=True)] = None
    exponential: Annotated[Amount | None, BeforeValidator(_exponential)] = None
