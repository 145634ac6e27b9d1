"""The base of every schema of a file, and what its errors say."""

import re
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, Final

from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic_core import ErrorDetails, PydanticCustomError

from shakerproc.documents.tree import Key
from shakerproc.units import near_miss, quoted

FromList: Final = Field(strict=False)
"""Goes with a tuple field, ``Annotated[tuple[str, ...], FromList]``: YAML knows lists only."""


class Section(BaseModel):
    """A part of a file: unknown and blank keys are refused, nothing is converted silently."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, defer_build=True)

    @model_validator(mode="before")
    @classmethod
    def _know_every_key(cls, data: Any) -> Any:
        if isinstance(data, dict):
            known = _keys_of(cls)
            for key in data:
                if key not in known:
                    context = {
                        "place": (key,),
                        "known": sorted(known),
                        "comma": _decimal_comma(data, key),
                    }
                    raise PydanticCustomError("unknown_key", "unknown key", context)
            for key, value in data.items():
                if value is None:
                    raise PydanticCustomError("blank", "blank", {"place": (key,)})
        return data


def misplaced(message: str, *place: str | int) -> PydanticCustomError:
    """Return the error by which a validator of a section points at one of its keys."""
    return PydanticCustomError("misplaced", "misplaced", {"place": place, "says": message})


def message_of(errors: Sequence[ErrorDetails]) -> str:
    """Return the joint message of errors about one and the same place."""
    specific = [error for error in errors if error["type"] not in _WANTED]
    error = (specific or errors)[0]
    if not specific:
        names = " or ".join(dict.fromkeys(_WANTED[e["type"]] for e in errors))
        return f"expected {names}, got {quoted(error['input'])}" + _advice(errors)
    say = _SAY.get(error["type"])
    if say is not None:
        return say(error)
    return f"{error['msg'][:1].lower()}{error['msg'][1:]}, got {quoted(error['input'])}"


def _keys_of(section: type[BaseModel]) -> Mapping[str, None]:
    """Return the keys of a section as a file spells them (a mapping is quick to search)."""
    known = _KNOWN.get(section)
    if known is None:
        known = {field.alias or name: None for name, field in section.model_fields.items()}
        _KNOWN[section] = known
    return known


_KNOWN: Final[dict[type[BaseModel], Mapping[str, None]]] = {}

_WANTED: Final[Mapping[str, str]] = MappingProxyType({
    "string_type": "text",
    "int_type": "a whole number",
    "float_type": "a number",
    "finite_number": "a finite number",
    "bool_type": "true or false",
    "list_type": "a list",
    "tuple_type": "a list",
    "dict_type": "a mapping (key: value)",
    "model_type": "a mapping (key: value)",
    "model_attributes_type": "a mapping (key: value)",
    "none_required": "nothing",
})


def _advice(errors: Sequence[ErrorDetails]) -> str:
    found = errors[0]["input"]
    types = {error["type"] for error in errors}
    if types == {"bool_type"} and isinstance(found, str):
        meant = {"yes": "true", "on": "true", "no": "false", "off": "false"}.get(found.lower())
        return f"; did you mean {meant}?" if meant else ""
    if types == {"string_type"} and isinstance(found, int | float):
        return "; put it in quotes"
    return ""


def _missing(error: ErrorDetails) -> str:
    if isinstance(error["loc"][-1], int):  # of values in a row
        there = int(error["loc"][-1])
        return f"expected {there + 1} values at least, got {there}"
    return f'expected the key "{error["loc"][-1]}", which is missing'


def _decimal_comma(data: Mapping[Key, object], key: Key) -> str | None:
    """Return the number that a decimal comma cut in two: ``{level: 3,2 g}`` has a key "2 g"."""
    cut = re.fullmatch(r"(\d+)(\D.*)?", str(key))
    if cut is None or data[key] is not None:
        return None
    keys = list(data)
    before = data[keys[keys.index(key) - 1]]
    return f"{before}.{key}" if re.fullmatch(r"[+-]?\d+", str(before)) else None


def _unknown_key(error: ErrorDetails) -> str:
    key, known = error["ctx"]["place"][0], error["ctx"]["known"]
    if error["ctx"]["comma"] is not None:
        return f"unknown key {quoted(key)}; use a decimal point: {error['ctx']['comma']}"
    before, colon, after = str(key).partition(":")
    if colon and before in known:
        return f"unknown key {quoted(key)}; put a space after the colon: {before}: {after}"
    meant = near_miss(str(key), known)
    if meant is not None:
        return f'unknown key {quoted(key)}; did you mean "{meant}"?'
    return f"unknown key {quoted(key)}; the keys here are {', '.join(known)}"


def _not_one_of(error: ErrorDetails) -> str:
    choices = [part for part in error["ctx"]["expected"].split("'") if part.strip(" ,or")]
    said = f"expected {error['ctx']['expected']}".replace("'", '"')
    meant = near_miss(error["input"], choices) if isinstance(error["input"], str) else None
    question = f'; did you mean "{meant}"?' if meant else ""
    return f"{said}, got {quoted(error['input'])}{question}"


def _bound(words: str, key: str) -> Callable[[ErrorDetails], str]:
    return lambda error: (
        f"expected a number {words} {error['ctx'][key]:g}, got {quoted(error['input'])}"
    )


def _length(words: str, key: str) -> Callable[[ErrorDetails], str]:
    return lambda error: f"expected {words} {error['ctx'][key]} of them"


_SAY: Final[Mapping[str, Callable[[ErrorDetails], str]]] = MappingProxyType({
    "missing": _missing,
    "unknown_key": _unknown_key,
    "blank": lambda error: (
        f"expected a value after {error['ctx']['place'][0]}:, got nothing; "
        "write it, or take the key out"
    ),
    "misplaced": lambda error: error["ctx"]["says"],
    "value_error": lambda error: str(error["ctx"]["error"]),
    "literal_error": _not_one_of,
    "enum": _not_one_of,
    "greater_than": _bound("above", "gt"),
    "greater_than_equal": _bound("of at least", "ge"),
    "less_than": _bound("below", "lt"),
    "less_than_equal": _bound("of at most", "le"),
    "too_short": _length("at least", "min_length"),
    "too_long": _length("at most", "max_length"),
    "string_too_short": lambda error: f"expected text, got {quoted(error['input'])}",
    "string_too_long": lambda error: (
        f"expected text of at most {error['ctx']['max_length']} characters"
    ),
    "union_tag_not_found": lambda error: (
        f"expected the key {error['ctx']['discriminator']}, which is missing".replace("'", '"')
    ),
    "union_tag_invalid": lambda error: _not_one_of({
        **error,
        "input": error["ctx"]["tag"],
        "ctx": {"expected": error["ctx"]["expected_tags"]},
    }),
})
