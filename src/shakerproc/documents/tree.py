"""YAML text to plain values and the place of each: bounded, without surprises.

The text is read as events, so that depth, aliases and size are checked before anything is
built (PyYAML's own composer recurses, and crashes on 200,000 levels). Scalars follow the YAML
1.2 core schema: `on` and `NO` are text, `1e3` is a number, `010` is ten, `12:30` is text.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, TypeAlias, final

import yaml

from shakerproc.errors import DocumentError
from shakerproc.units import quoted

MOST_LEVELS: Final = 32
"""Lists and mappings within each other; no honest file comes near."""

_BACKSLASH: Final = r'"\" in double quotes; write / or use single quotes'
_BESIDE: Final = (
    'a key that does not belong here; does the line above lack ": " after its key, '
    "or is one of the two too far in?"
)
_QUOTE: Final = "put text with special characters in quotes"

# Part of libyaml's problem: what to say, and whether the mistake is where the context began.
_ADVICE: Final[tuple[tuple[str, str, bool], ...]] = (
    ("mapping values are not allowed", f'a second ": " in one line; {_QUOTE}', False),
    ("could not find expected ':'", 'expected ": " after the key; write key: value', True),
    (
        "did not find expected ',' or '}'",
        'expected "," or "}"; is a comma, a closing brace or a quote missing?',
        False,
    ),
    (
        "did not find expected ',' or ']'",
        'expected "," or "]"; is a comma, a closing bracket or a quote missing?',
        False,
    ),
    ("did not find expected key", "expected a key as far in as its neighbours above", False),
    ("did not find expected '-'", 'expected "- " as far in as its neighbours above', False),
    ("found unexpected end of stream", "a quote that opens here is never closed", True),
    ("found unexpected document indicator", "a quote that opens here is never closed", True),
    ("unknown escape character", _BACKSLASH, False),
    ("block sequence entries", '"- " is not allowed here; start a new line', False),
    ("mapping keys are not allowed", '"? " is not allowed here', False),
    ("did not find expected alphabetic", f'"*", "&" and "!" begin a name; {_QUOTE}', True),
    ("undefined tag handle", f'"!" begins a tag; {_QUOTE}', False),
    ("did not find URI", f'"!" begins a tag; {_QUOTE}', True),
    ("did not find expected whitespace", f'"*", "&" and "!" begin a name; {_QUOTE}', False),
    ("did not find expected <document start>", "expected the end of the file", False),
    ("tab character", "a tab; indent with spaces", False),
    # newer libyaml gives up by itself where 1000 brackets open, before we can count
    ("maximum nesting depth", f"nested deeper than {MOST_LEVELS} levels", False),
)  # fmt: skip

Key: TypeAlias = str | int

MOST_ALIASES: Final = 1_000
MOST_ITEMS: Final = 100_000

_MOST_DIGITS: Final = 100
_SPECIAL: Final = frozenset("+-.0123456789~ntfNTF")
"""How text begins that may be something else than text."""

_NULL: Final = frozenset({"", "~", "null", "Null", "NULL"})
_BOOLEAN: Final = {
    "true": True, "True": True, "TRUE": True, "false": False, "False": False, "FALSE": False,
}  # fmt: skip
_INTEGER: Final = re.compile(r"[-+]?[0-9]+")
_OTHER_BASE: Final = re.compile(r"0o[0-7]+|0x[0-9a-fA-F]+")
_DECIMAL: Final = re.compile(r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?")
_NOT_FINITE: Final = re.compile(r"[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)")
_SWALLOWED: Final = re.compile(r"[ \t]+#(?=\w)")


Position: TypeAlias = tuple[int, int]
"""Line and column, from 1."""


def advice_on(error: yaml.MarkedYAMLError, text: str) -> tuple[int, int, str]:
    """Return line and column from 1, and the fault there in the user's words."""
    problem = error.problem or "cannot be read"
    mark = error.problem_mark or error.context_mark
    line, column = _from_one(mark)
    before, after = _around(text, line, column)
    if "cannot start any token" in problem:
        return line, column, _on_first_character(after[:1])
    if "mapping values are not allowed" in problem and ": " not in before:
        return line, column, _BESIDE
    if "\\" in before and ("hexdecimal" in problem or "Unicode" in problem):
        return line, before.rindex("\\") + 1, _BACKSLASH
    for part, advice, at_context in _ADVICE:
        if part in problem:
            where = error.context_mark if at_context and error.context_mark else mark
            return *_from_one(where), advice + _opening(error)
    return line, column, f"not YAML: {problem}"


def _opening(error: yaml.MarkedYAMLError) -> str:
    """Return where the brace or bracket opens that is not closed."""
    if "',' or" not in (error.problem or "") or error.context_mark is None:
        return ""
    line, column = _from_one(error.context_mark)
    return f" (what opens on line {line}, column {column}, is still open)"


def _from_one(mark: yaml.Mark | None) -> tuple[int, int]:
    return (mark.line + 1, mark.column + 1) if mark is not None else (1, 1)


def _around(text: str, line: int, column: int) -> tuple[str, str]:
    """Return a line up to a column, and the rest of it."""
    lines = text.split("\n")
    text_line = lines[line - 1] if line <= len(lines) else ""
    return text_line[: column - 1], text_line[column - 1 :]


def _on_first_character(character: str) -> str:
    if character == "\t":
        return "a tab; indent with spaces"
    return f'nothing may begin with "{character}"; put the text in quotes'


@final
@dataclass(slots=True, eq=False)
class DocumentPlace:
    """Where a list or mapping stands, and everything in it.

    Attributes
    ----------
    position : Position
        Of its beginning.
    children : dict or list of (DocumentPlace or Position)
        Where each value stands.
    keys : dict of Position
        Where each key of a mapping stands.
    """

    position: Position
    children: "dict[Key, DocumentPlace | Position] | list[DocumentPlace | Position]"
    keys: dict[Key, Position]

    def find(self, path: Sequence[Key]) -> "tuple[DocumentPlace | Position, list[Key]]":
        """Return the deepest place along a path, and the part of the path that leads there.

        Steps that the file does not hold are left out.
        """
        place: DocumentPlace | Position = self
        way: list[Key] = []
        for step in path:
            child = _child(place, step)
            if child is not None:
                place = child
                way.append(step)
        return place, way

    def position_of(self, path: Sequence[Key]) -> Position:
        """Return where the deepest value along a path stands."""
        place = self.find(path)[0]
        return place.position if isinstance(place, DocumentPlace) else place

    def position_of_key(self, path: Sequence[Key]) -> Position:
        """Return where the last key along a path stands; the item itself in a list."""
        way = self.find(path)[1]
        holder = self.find(way[:-1])[0]
        if way and isinstance(holder, DocumentPlace) and way[-1] in holder.keys:
            return holder.keys[way[-1]]
        return self.position_of(way)


def _child(place: DocumentPlace | Position, step: Key) -> DocumentPlace | Position | None:
    if not isinstance(place, DocumentPlace):
        return None
    if isinstance(place.children, dict):
        return place.children.get(step)
    if isinstance(step, int) and 0 <= step < len(place.children):
        return place.children[step]
    return None


class _Node:
    """A list or mapping, or a scalar with an anchor.

    Its size counts the values in it with aliases written out; its levels are how deep it is.
    """

    __slots__ = ("anchor", "key", "key_at", "levels", "place", "size", "value")

    def __init__(self, value: Any, place: DocumentPlace | Position, anchor: str | None) -> None:
        self.value, self.place, self.anchor = value, place, anchor
        self.size = 1
        self.levels = 0
        self.key: Key | None = None
        self.key_at: Position = (0, 0)


class _Builder:
    """Takes events one by one; holds the values and places built so far."""

    def __init__(self, path: Path, text: str) -> None:
        self.path = path
        has_comments = " #" in text or "\t#" in text
        self.lines = text.split("\n") if has_comments else []
        self.stack: list[_Node] = []
        self.anchors: dict[str, _Node | None] = {}
        self.n_aliases = 0
        self.n_items = 0
        self.n_documents = 0
        self.root: _Node | None = None
        self.take: Mapping[type, Callable[[Any], None]] = {
            yaml.ScalarEvent: self.scalar,
            yaml.MappingStartEvent: self.open_mapping,
            yaml.SequenceStartEvent: self.open_sequence,
            yaml.MappingEndEvent: self.close,
            yaml.SequenceEndEvent: self.close,
            yaml.AliasEvent: self.alias,
            yaml.DocumentStartEvent: self.start_document,
        }

    def error(self, position: Position, message: str) -> DocumentError:
        return DocumentError(self.path, *position, message)

    def start_document(self, event: Any) -> None:
        self.n_documents += 1
        if self.n_documents > 1:
            raise self.error(_position(event), "expected one document, got a second (---)")

    def scalar(self, event: Any) -> None:
        mark = event.start_mark
        position = (mark.line + 1, mark.column + 1)
        value = event.value
        if event.tag is not None:
            self._refuse_tag(event)
        if event.implicit[0]:
            value = self._plain(value, position)
            if self.lines:
                self._refuse_swallowed_text(event, position)
        holder = self.stack[-1] if self.stack else None
        if holder is not None and holder.key is None and type(holder.value) is dict:
            self._take_key(holder, value, position, is_plain=event.implicit[0])
            return
        self.n_items += 1
        if self.n_items > MOST_ITEMS:
            self._count(0, position)
        if event.anchor is not None:
            self.anchors[event.anchor] = _Node(value, position, event.anchor)
        if holder is None:
            self.root = _Node(value, position, event.anchor)
            return
        holder.size += 1
        self._put(holder, value, position)

    def _plain(self, text: str, position: Position) -> object:
        if " " in text or (text and text[0] not in _SPECIAL):
            return text
        try:
            return plain_scalar(text)
        except ValueError as problem:
            raise self.error(position, str(problem)) from problem

    def _take_key(
        self, holder: _Node, value: object, position: Position, *, is_plain: bool
    ) -> None:
        if not isinstance(value, str | int) or isinstance(value, bool):
            raise self.error(
                position, f"expected a key that is text, got {quoted(value)}; put it in quotes"
            )
        if value == "<<" and is_plain:
            raise self.error(position, 'merge keys ("<<") are not read; write the keys out')
        if value in holder.value:
            line = holder.place.keys[value][0]  # type: ignore[union-attr]
            raise self.error(position, f"duplicate key {quoted(value)}, first on line {line}")
        holder.key = value
        holder.key_at = position

    def open_mapping(self, event: Any) -> None:
        self._open(event, {}, {})

    def open_sequence(self, event: Any) -> None:
        self._open(event, [], [])

    def _open(self, event: Any, value: Any, children: Any) -> None:
        position = _position(event)
        self._refuse_tag(event)
        self._refuse_more_levels(1, position)
        self._refuse_as_key("a list or mapping", position)
        if event.anchor is not None:
            self.anchors[event.anchor] = None  # until it is closed
        self._count(1, position)
        self.stack.append(_Node(value, DocumentPlace(position, children, {}), event.anchor))

    def close(self, _: Any) -> None:
        done = self.stack.pop()
        if done.anchor is not None:
            self.anchors[done.anchor] = done
        if not self.stack:
            self.root = done
            return
        holder = self.stack[-1]
        self._put(holder, done.value, done.place)
        holder.size += done.size
        holder.levels = max(holder.levels, done.levels + 1)

    def alias(self, event: Any) -> None:
        position = _position(event)
        self.n_aliases += 1
        if self.n_aliases > MOST_ALIASES:
            raise self.error(position, f"more than {MOST_ALIASES} aliases (*name)")
        if event.anchor not in self.anchors:
            raise self.error(
                position, f'no anchor "&{event.anchor}"; put text with * in quotes'
            )
        node = self.anchors[event.anchor]
        if node is None:
            raise self.error(position, f'"*{event.anchor}" stands inside what it names')
        self._refuse_as_key("an alias", position)
        self._refuse_more_levels(node.levels + 1, position)
        self._count(node.size, position)
        holder = self.stack[-1]
        self._put(holder, node.value, node.place)
        holder.size += node.size
        holder.levels = max(holder.levels, node.levels + 1)

    @staticmethod
    def _put(holder: _Node, value: object, place: DocumentPlace | Position) -> None:
        """Put a value into the list or mapping that is open."""
        where: Any = holder.place
        if holder.key is None:
            holder.value.append(value)
            where.children.append(place)
        else:
            holder.value[holder.key] = value
            where.children[holder.key] = place
            where.keys[holder.key] = holder.key_at
            holder.key = None

    def _count(self, n: int, position: Position) -> None:
        self.n_items += n
        if self.n_items > MOST_ITEMS:
            raise self.error(position, f"more than {MOST_ITEMS} values, aliases written out")

    def _refuse_more_levels(self, n: int, position: Position) -> None:
        if len(self.stack) + n > MOST_LEVELS:
            raise self.error(position, f"nested deeper than {MOST_LEVELS} levels")

    def _refuse_as_key(self, what: str, position: Position) -> None:
        if self.stack and self.stack[-1].key is None and type(self.stack[-1].value) is dict:
            raise self.error(
                position, f"expected a key that is text, got {what}; put it in quotes"
            )

    def _refuse_tag(self, event: Any) -> None:
        if event.tag not in {None, "!"}:
            raise self.error(
                _position(event), f"tags are not read, got {quoted(event.tag)}; take it out"
            )

    def _refuse_swallowed_text(self, event: Any, position: Position) -> None:
        end = event.end_mark
        if event.value and _SWALLOWED.match(self.lines[end.line], end.column):
            raise self.error(
                position,
                f'text after " #" is a comment, so only {quoted(event.value)} is read; '
                'put the text in quotes, or a space after "#"',
            )


def _position(event: Any) -> Position:
    return event.start_mark.line + 1, event.start_mark.column + 1


def read_tree(path: Path, text: str) -> tuple[object, DocumentPlace]:
    """Return the values of a YAML text, and their places.

    Raises
    ------
    DocumentError
        If the text is no YAML, is ambiguous, or is larger or deeper than any honest file.
    """
    builder = _Builder(path, text)
    take = builder.take
    try:
        for event in yaml.parse(text, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader)):
            handle = take.get(type(event))
            if handle is not None:
                handle(event)
    except yaml.MarkedYAMLError as error:
        line, column, message = advice_on(error, text)
        last = text.count("\n") + 1
        if line > last:  # libyaml ends each text with a line of its own
            line, column = last, len(text) - (text.rfind("\n") + 1) + 1
        raise DocumentError(path, line, column, message) from error
    except yaml.YAMLError as error:
        raise DocumentError(path, 1, 1, f"not YAML: {quoted(str(error))}") from error
    if builder.root is None:
        return None, DocumentPlace((1, 1), [], {})
    place = builder.root.place
    return builder.root.value, place if isinstance(place, DocumentPlace) else DocumentPlace(
        place, [], {}
    )


def plain_scalar(text: str) -> object:
    """Return the value of unquoted text by the YAML 1.2 core schema.

    Raises
    ------
    ValueError
        If it is a number that is not finite, or far too long.
    """
    if text in _NULL:
        return None
    if text in _BOOLEAN:
        return _BOOLEAN[text]
    if _INTEGER.fullmatch(text) and len(text) <= _MOST_DIGITS:
        return int(text)
    is_number = _DECIMAL.fullmatch(text) or _OTHER_BASE.fullmatch(text)
    if is_number and len(text) > _MOST_DIGITS:
        raise ValueError(f"expected a number of at most {_MOST_DIGITS} digits")
    if _OTHER_BASE.fullmatch(text):
        return int(text, 0)
    if _NOT_FINITE.fullmatch(text) or (is_number and abs(float(text)) == float("inf")):
        raise ValueError(f"expected a finite number, got {text}")
    return float(text) if is_number else text
