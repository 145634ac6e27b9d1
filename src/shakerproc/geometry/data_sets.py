"""The data sets of a universal file, one behind the other.

A binary one says in how many bytes its numbers are: marks inside them are none.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, final

import numpy as np

_MARK: Final = re.compile(rb"^ {4}-1[ \t]*\r?$", re.MULTILINE)
_MARK_HERE: Final = re.compile(rb" {4}-1[ \t]*\r?(?=\n|\Z)")
HEAD: Final = 11
"""Lines between the kind of a record and its numbers."""

TYPES: Final = {2: "f4", 4: "f8", 5: "f4", 6: "f8"}
COMPLEX: Final = {5, 6}


class UffError(Exception):
    """A universal file is not what it says.

    Attributes
    ----------
    place : int
        Byte of the file.
    """

    def __init__(self, place: int, message: str) -> None:
        self.place = place
        super().__init__(message)


@final
@dataclass(frozen=True, slots=True)
class DataSet:
    """What stands between two marks.

    Attributes
    ----------
    kind : int
        Number of the data set.
    start, stop : int
        Bytes of what follows the line with the kind.
    binary : bytes
        The line with the kind, where the numbers are binary; else empty.
    cut : bool
        Whether the file ends inside it.
    """

    kind: int
    start: int
    stop: int
    binary: bytes
    cut: bool


def data_sets(content: bytes) -> Iterator[DataSet]:
    """Yield the data sets of a file in their order.

    Raises
    ------
    UffError
        If something stands between them, or a binary one does not end where it should.
    """
    at = 0
    while (mark := _MARK.search(content, at)) is not None:
        if content[at : mark.start()].strip():
            raise UffError(at, "something stands between two data sets: a mark is missing")
        start = _after_line(content, mark.end())
        if content.find(b"\n", start) < 0:
            raise UffError(start, "the file ends where a data set begins")
        line = content[start : _after_line(content, start)].strip(b"\r\n")
        kind = line[:6].strip()
        if not kind.isdigit():
            raise UffError(start, "a data set has no number")
        body = _after_line(content, start)
        if line[6:7].lower() == b"b" and int(kind) == 58:
            stop = skip_lines(content, body, HEAD) + integer(line[31:43], start)
            closing = _MARK_HERE.match(content, _after_blank(content, stop))
            if closing is None:  # pyuff counts half the bytes of complex numbers
                counted = skip_lines(content, body, HEAD) + _counted(content, body)
                closing = _MARK_HERE.match(content, _after_blank(content, counted))
                stop = stop if closing is None else counted
            if closing is None and stop <= len(content) and content[stop:].strip():
                raise UffError(
                    stop, "a record does not end where it says, behind its bytes of numbers"
                )
        else:
            line = b""
            closing = _MARK.search(content, body)
            stop = closing.start() if closing else len(content)
        yield DataSet(int(kind), body, min(stop, len(content)), line, closing is None)
        if closing is None:
            return
        at = closing.end()
    if content[at:].strip():
        raise UffError(at, "something stands behind the last data set: a mark is missing")


def _counted(content: bytes, body: int) -> int:
    """Return the bytes of a binary record by its type and count; 0 where they are not said."""
    head = content[body : skip_lines(content, body, HEAD)].splitlines()
    try:
        kind, count, spacing = (int(head[6][at : at + 10]) for at in (0, 10, 20))
    except (ValueError, IndexError):
        return 0
    width = np.dtype(TYPES.get(kind, "f8")).itemsize
    parts = (2 if kind in COMPLEX else 1) + (0 if spacing else 1)
    return max(0, count) * width * parts


def _after_line(content: bytes, at: int) -> int:
    end = content.find(b"\n", at)
    return end + 1 if end >= 0 else len(content)


def skip_lines(content: bytes, at: int, count: int) -> int:
    """Return where the lines end; beyond the file where there are fewer."""
    for _ in range(count):
        end = content.find(b"\n", at)
        if end < 0:
            return len(content) + 1
        at = end + 1
    return at


def _after_blank(content: bytes, at: int) -> int:
    while content[at : at + 1] in {b"\r", b"\n"}:
        at += 1
    return at


def integer(cell: bytes, place: int) -> int:
    """Return the whole number of a cell, not below 0.

    Raises
    ------
    UffError
        If it is none.
    """
    try:
        number = int(cell)
    except ValueError as error:
        raise UffError(place, f"{cell[:12]!r} should be a whole number") from error
    if number < 0 or len(cell) > 20:
        raise UffError(place, f"{number} should not be below 0")
    return number
