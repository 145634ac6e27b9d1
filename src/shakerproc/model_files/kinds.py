"""A mapping of a model file, turned into the effect or fault that its kind names."""

import re
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, Final, Protocol, TypeVar

from pydantic import BaseModel

from shakerproc.documents import Document
from shakerproc.models.effects import SPELLINGS
from shakerproc.models.effects.base import Parameter, parameter_in
from shakerproc.models.motion import Motion
from shakerproc.units import example, near_miss, quoted, to_si

_NUMBERS: Final = re.compile(
    r"((?:[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?(?:\s*,\s*|\s+|$))+)(.*)", re.DOTALL
)
MOST_NUMBERS: Final = 4096
"""Numbers that a table may have in all."""

Schema = TypeVar("Schema", bound=BaseModel)


def read_numbers(value: object, parameter: Parameter) -> tuple[float, ...]:
    """Return the numbers of a text such as ``-0.1 0 0.1 mm`` in SI.

    Raises
    ------
    ValueError
        If it is none, with what was expected.
    """
    text = repr(value) if isinstance(value, int | float) else value
    found = _NUMBERS.fullmatch(text.strip()) if isinstance(text, str) else None
    if found is None:
        raise ValueError(
            "expected numbers with one unit at the end, such as "
            f"{example_numbers(parameter)}, got {quoted(value)}"
        )
    unit = found[2].strip()
    words = found[1].replace(",", " ").split()
    if len(words) > MOST_NUMBERS:
        raise ValueError(f"expected {MOST_NUMBERS} numbers at most, got {len(words)}")
    return tuple(to_si(f"{word} {unit}".strip(), parameter.unit) for word in words)


def read_rows(value: object, parameter: Parameter) -> tuple[tuple[float, ...], ...]:
    """Return rows of numbers, each a text.

    Raises
    ------
    ValueError
        If they are none, with what was expected.
    """
    if not isinstance(value, list) or not value:
        raise ValueError(f"expected a list of rows, such as [{example_numbers(parameter)}]")
    rows = []
    for i, row in enumerate(value, 1):
        try:
            rows.append(read_numbers(row, parameter))
        except ValueError as error:
            raise ValueError(f"row {i}: {error}") from error
    return tuple(rows)


def example_numbers(parameter: Parameter) -> str:
    """Return how numbers are written."""
    return f"-1 0 1 {parameter.unit}"


def is_list_of_mappings(value: Any) -> bool:
    """Return whether a value is a list of mappings, as effects within an effect are."""
    return isinstance(value, list) and all(isinstance(one, dict) for one in value)


class Kind(Protocol):
    """Interface that effects and faults have in common."""

    parameters: ClassVar[Mapping[str, Parameter]]


KindT = TypeVar("KindT", bound=Kind)


def read_kind(
    document: Document[Schema],
    place: Sequence[str | int],
    said: Mapping[str, Any],
    kinds: Mapping[str, type[KindT]],
    also: Sequence[str] = (),
    *,
    motion: Motion = "translation",
) -> KindT:
    """Return the effect or fault that a mapping of the file describes.

    Parameters
    ----------
    document : Document
        For errors.
    place : sequence of str and int
        Where the mapping stands.
    said : mapping
        Its keys and values.
    kinds : mapping of str to type
        What may be made.
    also : sequence of str
        Keys that are not parameters.
    motion : Motion
        Of the masses: says the units of the parameters.

    Raises
    ------
    DocumentError
        If the kind is not known, or a parameter is unknown, missing, or not a physical value.
    """
    kind = _kind(document, place, said, kinds)
    made = kinds[kind]
    values: dict[str, Any] = {}
    for key, value in said.items():
        if key == "kind" or key in also:
            continue
        if key not in made.parameters:
            allowed = [*made.parameters, *also]
            raise document.error(
                (*place, key), _unknown("parameter", key, allowed, f"of {kind}"), at_key=True
            )
        here, parameter = (*place, key), parameter_in(made.parameters[key], motion)
        if parameter.holds == "effects":
            values[key] = _kinds(document, here, value, kinds, motion)
        else:
            values[key] = _value(document, here, value, parameter)
    for name, parameter in made.parameters.items():
        if name not in values and not parameter.optional:
            raise document.error(
                place,
                f"{kind} needs {name}, such as {name}: "
                f"{_example(parameter_in(parameter, motion))}",
            )
    try:
        return made(**values)
    except ValueError as error:
        raise document.error(place, str(error)) from error


def _kind(
    document: Document[Schema],
    place: Sequence[str | int],
    said: Mapping[str, Any],
    kinds: Mapping[str, type[KindT]],
) -> str:
    kind = said.get("kind")
    if "kind" not in said:
        raise document.error(place, f"expected a kind, one of {', '.join(kinds)}")
    if not isinstance(kind, str) or kind not in kinds:
        raise document.error((*place, "kind"), _unknown("kind", kind, list(kinds)))
    return next((SPELLINGS[kind, key] for key in said if (kind, key) in SPELLINGS), kind)


def _kinds(
    document: Document[Schema],
    place: Sequence[str | int],
    value: Any,
    kinds: Mapping[str, type[KindT]],
    motion: Motion,
) -> tuple[KindT, ...]:
    """Return the effects that an effect is made of."""
    if not is_list_of_mappings(value):
        raise document.error(place, "expected a list of elements, such as [{kind: gap, ...}]")
    return tuple(
        read_kind(document, (*place, i), one, kinds, motion=motion)
        for i, one in enumerate(value)
    )


def _unknown(what: str, found: object, known: list[str], of: str = "") -> str:
    meant = near_miss(found, known) if isinstance(found, str) else None
    hint = f'did you mean "{meant}"?' if meant else f"there are {', '.join(known)}"
    return " ".join(f"unknown {what} {quoted(found)} {of}".split()) + f"; {hint}"


def _value(
    document: Document[Schema], place: Sequence[str | int], value: object, parameter: Parameter
) -> float | str | tuple[Any, ...]:
    """Return a value in SI, the word that it is, or the numbers that it holds."""
    if parameter.choices:
        if value not in parameter.choices:
            wanted = " or ".join(parameter.choices)
            raise document.error(place, f"expected {wanted}, got {quoted(value)}")
        return str(value)
    try:
        if parameter.holds == "numbers":
            return read_numbers(value, parameter)
        if parameter.holds == "rows":
            return read_rows(value, parameter)
        number = to_si(value, parameter.unit)
    except ValueError as error:
        raise document.error(place, str(error)) from error
    if (parameter.sign == "positive" and number <= 0.0) or (
        parameter.sign == "not negative" and number < 0.0
    ):
        bound = "more than 0" if parameter.sign == "positive" else "at least 0"
        raise document.error(
            place, f"expected {bound}, such as {_example(parameter)}, got {quoted(value)}"
        )
    return number


def _example(parameter: Parameter) -> str:
    if parameter.holds == "effects":
        return "[{kind: gap, stiffness: 1.2e5 N/m, clearance: 0.05 mm}, ...]"
    if parameter.holds != "number":
        return f"-1 0 1 {parameter.unit}"
    return parameter.choices[0] if parameter.choices else example(parameter.unit)
