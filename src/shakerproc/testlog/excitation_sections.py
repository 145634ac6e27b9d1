"""The keys of multisines, of tones and of hammer tests in a test log."""

from collections.abc import Sequence
from typing import Annotated, Any, Final

from pydantic import BeforeValidator, Field

from shakerproc.documents import Section
from shakerproc.testlog.excitation import (
    LEVELS,
    Amount,
    DemandedTone,
    LevelUnit,
    LineGrid,
    Multisine,
    level_of,
)
from shakerproc.testlog.misfit import MisfitError
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
    """Return the multisine of the log; None where it states none."""
    return None if section is None else Multisine(**dict(section))


def _amplitude(written: object) -> tuple[float, LevelUnit]:
    return level_of(written, "sine")


class ToneSection(Section):
    """A tone of a sine on random; `start` and `stop` are those of a swept one, refused."""

    frequency: Annotated[float | None, in_unit("Hz", positive=True)] = None
    level: Annotated[tuple[float, LevelUnit] | None, BeforeValidator(_amplitude)] = None
    start: Any = Field(None, alias="from")
    stop: Any = Field(None, alias="to")


def tones_of(
    sections: Sequence[ToneSection],
    band: tuple[float | None, float | None],
    unit: LevelUnit | None,
) -> tuple[DemandedTone, ...]:
    """Return the tones that a log demands.

    Parameters
    ----------
    sections : sequence of ToneSection
        As the log has them.
    band : (float, float)
        From where to where the test excites [Hz]; None where the log does not say.
    unit : LevelUnit, optional
        Of the level of the random vibration.

    Raises
    ------
    MisfitError
        If a tone is swept, stands twice, lies outside the band, or is of another signal.
    """
    found: list[DemandedTone] = []
    for i, one in enumerate(sections):
        for key, said in (("from", one.start), ("to", one.stop)):
            if said is not None:
                raise MisfitError(
                    "expected fixed tones only, such as {frequency: 17 Hz, level: 2.5 g}; "
                    "tones that sweep are not known",
                    "tones", i, key,
                )  # fmt: skip
        if one.frequency is None:
            raise MisfitError(
                'expected the key "frequency", such as frequency: 17 Hz', "tones", i
            )
        low, high = band
        if low is not None and high is not None and not low <= one.frequency <= high:
            raise MisfitError(
                f"expected a tone within the band of the test, {low:g} to {high:g} Hz, got "
                f"{one.frequency:g} Hz",
                "tones", i, "frequency",
            )  # fmt: skip
        if any(one.frequency == other.frequency for other in found):
            raise MisfitError("expected each tone once", "tones", i, "frequency")
        if one.level is not None and unit is not None:
            signal, wanted = LEVELS[one.level[1]][1], LEVELS[unit][1]
            if signal != wanted:
                raise MisfitError(
                    f"expected an amplitude of the signal of the test's level, in {wanted}, "
                    f"got one in {signal}",
                    "tones", i, "level",
                )  # fmt: skip
        found.append(DemandedTone(one.frequency, None if one.level is None else one.level[0]))
    return tuple(found)


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
