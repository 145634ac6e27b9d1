"""The keys of multisines and of hammer tests in a test log."""

from typing import Annotated, Final

from pydantic import BeforeValidator, Field

from shakerproc.documents import Section
from shakerproc.testlog.hammer import Amount
from shakerproc.testlog.multisine import LineGrid, Multisine
from shakerproc.units import in_unit, is_unit_of, quoted, to_si

_NUMBER: Final = "+-0123456789.eE "


class MultisineSection(Section):
    """How a multisine repeats."""

    period: Annotated[float, in_unit("s", positive=True)]
    periods: Annotated[int, Field(ge=1, le=1_000_000)] | None = None
    realisations: Annotated[int, Field(ge=1, le=10_000)] = 1
    every: Annotated[float | None, in_unit("s", positive=True)] = None
    lines: LineGrid = "odd with detection"


def multisine_of(section: MultisineSection | None) -> Multisine | None:
    """Return what the log says of a multisine; None where it says nothing."""
    return None if section is None else Multisine(**dict(section))


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
