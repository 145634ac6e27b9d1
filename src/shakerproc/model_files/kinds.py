"""A mapping of a model file, turned into the effect or fault that its kind names."""

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, Protocol, TypeVar

from pydantic import BaseModel

from shakerproc.documents import Document
from shakerproc.models.effects.base import Parameter
from shakerproc.units import example, near_miss, quoted, to_si

Schema = TypeVar("Schema", bound=BaseModel)


class Kind(Protocol):
    """What effects and faults have in common."""

    parameters: ClassVar[Mapping[str, Parameter]]


KindT = TypeVar("KindT", bound=Kind)


def read_kind(
    document: Document[Schema],
    place: Sequence[str | int],
    said: Mapping[str, Any],
    kinds: Mapping[str, type[KindT]],
    also: Sequence[str] = (),
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
        values[key] = _value(document, (*place, key), value, made.parameters[key])
    for name, parameter in made.parameters.items():
        if name not in values and not parameter.optional:
            raise document.error(
                place, f"{kind} needs {name}, such as {name}: {_example(parameter)}"
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
    return kind


def _unknown(what: str, found: object, known: list[str], of: str = "") -> str:
    meant = near_miss(found, known) if isinstance(found, str) else None
    hint = f'did you mean "{meant}"?' if meant else f"there are {', '.join(known)}"
    return " ".join(f"unknown {what} {quoted(found)} {of}".split()) + f"; {hint}"


def _value(
    document: Document[Schema], place: Sequence[str | int], value: object, parameter: Parameter
) -> float | str:
    """Return a value in SI, or the word that it is."""
    if parameter.choices:
        if value not in parameter.choices:
            wanted = " or ".join(parameter.choices)
            raise document.error(place, f"expected {wanted}, got {quoted(value)}")
        return str(value)
    try:
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
    return parameter.choices[0] if parameter.choices else example(parameter.unit)
