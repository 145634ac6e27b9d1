"""Effects that a condition of the test scales: ``scaled_by: {voltage: 2 V}`` of an element."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeVar, final

from pydantic import BaseModel

from shakerproc.documents import Document
from shakerproc.models.effects.base import AbstractEffect, times
from shakerproc.units import any_quantity, near_miss, quoted, to_si

KEY: Final = "scaled_by"

Schema = TypeVar("Schema", bound=BaseModel)


@final
@dataclass(frozen=True, slots=True)
class Conditions:
    """Conditions of a test: voltage of a damper, preload, temperature.

    Attributes
    ----------
    values : mapping of str to str
        Quantity with its unit, by the name of the condition.
    of : str
        Test that has them, for messages.
    """

    values: Mapping[str, str]
    of: str


def under(
    document: Document[Schema],
    place: Sequence[str | int],
    effect: AbstractEffect,
    said: Any,
    conditions: Conditions | None,
) -> AbstractEffect | None:
    """Return the effect of an element as a condition scales it; None where that leaves none.

    Its numbers are those at the condition that the file names; the force is proportional to it.

    Parameters
    ----------
    document : Document
        For errors.
    place : sequence of str and int
        Of the key.
    effect : AbstractEffect
        As it stands in the file.
    said : mapping
        The condition and the value at which the numbers hold.
    conditions : Conditions, optional
        Those of the test; None where no test says any.

    Raises
    ------
    DocumentError
        If the condition is not known, of another kind, or below 0, or cannot scale the effect.
    """
    if not isinstance(said, dict) or len(said) != 1:
        raise document.error(
            place, "expected one condition and its value at which the numbers hold, such as "
            "{voltage: 2 V}"
        )  # fmt: skip
    ((name, written),) = said.items()
    try:
        reference, unit = any_quantity(written)
    except ValueError as error:
        raise document.error((*place, name), str(error)) from error
    if reference <= 0.0:
        raise document.error((*place, name), f"expected more than 0, got {quoted(written)}")
    if conditions is None:
        raise document.error(
            place, f"{effect.kind} is scaled by {name}, which nothing says here; simulate and "
            "compare take it from the conditions of the tests of a log"
        )  # fmt: skip
    value = _value(document, (*place, name), conditions, unit, written)
    try:
        return times(effect, value / reference) if value > 0.0 else None
    except ValueError as error:
        raise document.error(place, str(error)) from error


def _value(
    document: Document[Schema],
    place: Sequence[str | int],
    conditions: Conditions,
    unit: str,
    written: str,
) -> float:
    """Return the condition of a test, at least 0 [SI].

    Raises
    ------
    DocumentError
        If the test does not say it, or it is of another kind or below 0.
    """
    name, of = str(place[-1]), conditions.of
    said = conditions.values.get(name)
    if said is None:
        meant = near_miss(name, list(conditions.values))
        hint = f"; did you mean its {meant}?" if meant else ""
        raise document.error(
            place, f"{of} says no {name}{hint}; add conditions: {{{name}: {written}}} to it"
        )
    try:
        value = to_si(said, unit)
    except ValueError as error:
        raise document.error(place, f"{name} of {of}: {error}") from error
    if value < 0.0:
        raise document.error(
            place,
            f"{name} of {of} is {said}; a condition that scales an effect is at "
            "least 0. Where its channel has an offset, state it in the test, under conditions",
        )
    return value
