"""A file, read, checked against its schema, and still knowing where everything stands."""

import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, Generic, TypeVar, final

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator
from pydantic_core import ErrorDetails, PydanticCustomError

from shakerproc.documents.tree import DocumentPlace, Key, read_tree
from shakerproc.errors import DocumentError
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
    value = errors[0]["input"]
    types = {error["type"] for error in errors}
    if types == {"bool_type"} and isinstance(value, str):
        meant = {"yes": "true", "on": "true", "no": "false", "off": "false"}.get(value.lower())
        return f"; did you mean {meant}?" if meant else ""
    if types == {"string_type"} and isinstance(value, int | float):
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


KINDS: Final[Mapping[str, str]] = MappingProxyType({
    "testlog": "a test log",
    "study": "a study",
    "coupon": "a coupon",
    "model": "a model",
    "structure": "a structure",
    "materials": "a file of materials",
    "specimens": "a file of specimens",
})
"""What a file is by its key; the first that it has counts, for some have further ones."""

_LOOKED_AT: Final = 65_536
_KEY: Final = re.compile(r"^([a-z]+)[ \t]*:", re.MULTILINE)

MOST_BYTES: Final = 2_000_000

_CONTROL: Final = re.compile(
    r"[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]"
)
_SPACES: Final = {0x85: " ", 0x2028: " ", 0x2029: " "}
"""What ends a line for YAML 1.1 and not for YAML 1.2 (section 5.4) or an editor."""
_TAB: Final = re.compile(r"^ *\t[ \t]*[^\s]", re.MULTILINE)
_DIRECTIVE: Final = re.compile(r"^%", re.MULTILINE)

T = TypeVar("T", bound=BaseModel)


def kind_of(keys: Iterable[object]) -> str:
    """Return the kind of a file with these keys, such as ``a model``; empty if unknown."""
    names = set(keys)
    return next((name for key, name in KINDS.items() if key in names), "")


def kind_of_file(path: Path) -> str:
    """Return the apparent kind of a file by the keys at the start of its lines."""
    try:
        with path.open("rb") as file:
            text = file.read(_LOOKED_AT).decode("utf-8", errors="replace")
    except OSError:
        return ""
    return kind_of(_KEY.findall(text))


@final
@dataclass(frozen=True, slots=True, eq=False)
class Document(Generic[T]):
    """A file as its schema describes it.

    Attributes
    ----------
    value : pydantic model
        What the file says.
    path : Path
        The file.
    place : DocumentPlace
        Where everything in it stands.
    """

    value: T
    path: Path
    place: DocumentPlace

    def error(
        self, place: Sequence[Key], message: str, *, at_key: bool = False
    ) -> DocumentError:
        """Return the error to raise about a value found wrong after reading.

        Parameters
        ----------
        place : sequence of str and int
            Keys and positions (from 0) that lead to the value, as ``("tests", 0, "level")``;
            the nearest place that the file holds is named where it does not hold that one.
        message : str
            What was expected, what was found, what to do.
        at_key : bool
            Point at the key instead of its value.
        """
        return _error_at(self.path, self.place, place, message, at_key=at_key)

    def line(self, place: Sequence[Key]) -> int:
        """Return the line of a value, from 1; the nearest one where the file lacks it."""
        return self.place.position_of(place)[0]


def read_document(path: Path, schema: type[T]) -> Document[T]:
    """Return the content of a YAML file, checked against its schema.

    Parameters
    ----------
    path : Path
        A file of at most 2 MB in UTF-8.
    schema : type
        Best a child of `Section`, which suggests near misses of unknown keys.

    Raises
    ------
    DocumentError
        If the file cannot be read, is not strict YAML, or does not fit the schema; with the
        first mistake in the order of the file, and how many follow.
    """
    text = _text_of(path)
    values, place = read_tree(path, text)
    if values is None:
        raise DocumentError(path, 1, 1, "expected a mapping (key: value), got an empty file")
    _refuse_other_kind(path, values, schema)
    try:
        return Document(schema.model_validate(values), path, place)
    except ValidationError as error:
        first: DocumentError = _first_of(error.errors(include_url=False), path, place)
        raise first from error


def _refuse_other_kind(path: Path, values: object, schema: type[BaseModel]) -> None:
    """Raise where a file is surely of another kind.

    Raises
    ------
    DocumentError
        If it is another: a model where a test log is wanted.
    """
    if not isinstance(values, dict):
        return
    known = {field.alias or name for name, field in schema.model_fields.items()}
    kind, wanted = kind_of(set(values) - known), kind_of(known)
    if kind and wanted and wanted != kind_of(known & set(values)):
        raise DocumentError(path, 1, 1, f"expected {wanted}, and this is {kind}")


def _first_of(errors: list[ErrorDetails], path: Path, root: DocumentPlace) -> DocumentError:
    """Return the error that stands first in the file."""
    together: dict[tuple[Key, ...], list[ErrorDetails]] = {}
    for error in errors:
        if error["type"] == "too_short" and len(error["input"]) >= error["ctx"]["min_length"]:
            continue  # long enough, but for items that have an error of their own
        aim = (*error["loc"], *error.get("ctx", {}).get("place", ()))
        missing = (aim[-1],) if error["type"] == "missing" else ()
        together.setdefault((*root.find(aim)[1], *missing), []).append(error)
    problems = [
        _error_of(path, root, aim, some)
        for aim, some in together.items()
        if not _may_be_text(aim, some, together)
    ]
    first = min(problems, key=lambda error: (error.line, error.column))
    if len(problems) == 1:
        return first
    more = f"{first.says} (and {len(problems) - 1} more below)"
    return DocumentError(path, first.line, first.column, more)


def _may_be_text(
    aim: tuple[Key, ...],
    errors: Sequence[ErrorDetails],
    every: Collection[tuple[Key, ...]],
) -> bool:
    """Whether text would do where a mapping stands that has mistakes of its own."""
    mapped = all(
        one["type"] == "string_type" and isinstance(one["input"], dict) for one in errors
    )
    return mapped and any(other[: len(aim)] == aim != other for other in every)


def _error_of(
    path: Path, root: DocumentPlace, aim: tuple[Key, ...], errors: list[ErrorDetails]
) -> DocumentError:
    if errors[0]["type"] != "unknown_key":
        at_key = "[key]" in errors[0]["loc"]
        return _error_at(path, root, aim, message_of(errors), at_key=at_key)
    where = _in_words(root, root.find(aim)[1][:-1])
    return DocumentError(path, *root.position_of_key(aim), where + message_of(errors))


def _error_at(
    path: Path, root: DocumentPlace, aim: Sequence[Key], message: str, *, at_key: bool = False
) -> DocumentError:
    position = root.position_of_key(aim) if at_key else root.position_of(aim)
    return DocumentError(path, *position, _in_words(root, root.find(aim)[1]) + message)


def _in_words(root: DocumentPlace, way: Sequence[Key]) -> str:
    steps = [_step_in_words(root, way, depth) for depth in range(len(way))]
    return ".".join(steps) + ": " if steps else ""


def _step_in_words(root: DocumentPlace, way: Sequence[Key], depth: int) -> str:
    """Return one step of the way, counting the items of a list from 1."""
    step = way[depth]
    holder = root.find(way[:depth])[0]
    is_item = isinstance(holder, DocumentPlace) and isinstance(holder.children, list)
    text = str(step + 1) if is_item and isinstance(step, int) else str(step)
    return quoted(text).strip('"')


def _text_of(path: Path) -> str:
    """Return the text of a file that is small enough, in UTF-8, and without control characters.

    Raises
    ------
    DocumentError
        If it is not.
    """
    data = _bytes_of(path)
    if len(data) > MOST_BYTES:
        raise DocumentError(
            path,
            1,
            1,
            f"expected at most {MOST_BYTES / 1e6:g} MB of YAML; is this another file?",
        )
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise DocumentError(path, 1, 1, "expected UTF-8 text, got UTF-16; save it as UTF-8")
    if b"\0" in data:
        raise DocumentError(
            path, 1, 1, "expected text (YAML), got binary data; is this another file?"
        )
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = data[: error.start].decode("utf-8-sig", errors="replace")
        problem = (
            f"expected UTF-8 text, got the byte 0x{data[error.start]:02x}; save it as UTF-8"
        )
        raise DocumentError(path, *_line_and_column(before, len(before)), problem) from error
    text = text.replace("\r\n", "\n").replace("\r", "\n").translate(_SPACES)
    if match := _CONTROL.search(text):
        problem = f"expected text, got the control character 0x{ord(match[0]):02x}"
        raise DocumentError(path, *_line_and_column(text, match.start()), problem)
    if match := _TAB.search(text):
        at = text.index("\t", match.start())
        raise DocumentError(path, *_line_and_column(text, at), "a tab; indent with spaces")
    if match := _DIRECTIVE.search(text):
        problem = 'a line may not begin with "%"; put the text in quotes'
        raise DocumentError(path, *_line_and_column(text, match.start()), problem)
    return text


def _bytes_of(path: Path) -> bytes:
    """Return the bytes of a file, at most one more than is allowed.

    Raises
    ------
    DocumentError
        If it is no file that can be opened.
    """
    if path.exists() and not path.is_file():
        raise DocumentError(path, 1, 1, "expected a YAML file, got a folder or a device")
    try:
        with path.open("rb") as file:
            return file.read(MOST_BYTES + 1)
    except OSError as error:
        reason = error.strerror or "cannot be opened"
        raise DocumentError(path, 1, 1, f"cannot be read: {reason}") from error


def _line_and_column(text: str, position: int) -> tuple[int, int]:
    line = text.count("\n", 0, position)
    return line + 1, position - (text.rfind("\n", 0, position) + 1) + 1
