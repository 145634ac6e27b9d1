"""The data sets of a universal file: read one behind the other, and written as text.

A binary one says in how many bytes its numbers are: marks inside them are none.

Exponents are written with E where the format has D: both are read as numbers of Fortran, and
some programs of today know E alone.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, final

import numpy as np

from shakerproc import files
from shakerproc.data import ComplexArray, FloatArray
from shakerproc.geometry import Wireframe

_MARK: Final = re.compile(rb"^ {4}-1[ \t]*\r?$", re.MULTILINE)
_MARK_HERE: Final = re.compile(rb" {4}-1[ \t]*\r?(?=\n|\Z)")
HEAD: Final = 11
"""Lines between the kind of a record and its numbers."""

TYPES: Final = {2: "f4", 4: "f8", 5: "f4", 6: "f8"}
COMPLEX: Final = {5, 6}

MARK: Final = "    -1\n"
LONGEST_LINE: Final = 250
"""Nodes of a trace line at most, by the format."""

_TRIANGLE, _QUADRANGLE = 91, 94  # thin shells, linear
_NORMAL_MODE, _COMPLEX_MODE, _TRANSLATIONS, _WITH_ROTATIONS = 2, 3, 2, 3
_REAL, _COMPLEX, _LENGTH = 2, 5, 8
_GREEN: Final = 8


class UffError(Exception):
    """A universal file contradicts its format.

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
class UffDataSet:
    """One data set: the lines between two marks.

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


def data_sets(content: bytes) -> Iterator[UffDataSet]:
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
            stop = below_head(content, body) + integer(line[31:43], start)
            closing = _MARK_HERE.match(content, _after_blank(content, stop))
            if closing is None:  # pyuff counts half the bytes of complex numbers
                counted = below_head(content, body) + _counted(content, body)
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
        yield UffDataSet(int(kind), body, min(stop, len(content)), line, closing is None)
        if closing is None:
            return
        at = closing.end()
    if content[at:].strip():
        raise UffError(at, "something stands behind the last data set: a mark is missing")


def _counted(content: bytes, body: int) -> int:
    """Return the bytes of a binary record by its type and count; 0 where they are not said."""
    head = content[body : below_head(content, body)].splitlines()
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


def below_head(content: bytes, at: int) -> int:
    """Return where the lines of a head end; beyond the file where there are fewer."""
    for _ in range(HEAD):
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


@final
@dataclass(frozen=True, slots=True, eq=False)
class NodalShape:
    """A complex mode at the nodes of a structure, for a data set 55.

    Attributes
    ----------
    texts : tuple of str
        Up to five lines about it.
    number : int
        Of the mode, from 1.
    pole : complex
        Eigenvalue [rad/s].
    modal_a : complex
        Residue scaling, products of the shape over residues; 0 where it is not known.
    nodes : sequence of int
        Numbers of the nodes.
    values : (n_nodes, 3) complex array
        Along x, y and z; only their ratios count.
    quantity : int
        Number of the quantity in the format: 8 displacement, 11 velocity, 12 acceleration.
    """

    texts: tuple[str, ...]
    number: int
    pole: complex
    modal_a: complex
    nodes: Sequence[int]
    values: ComplexArray
    quantity: int


@final
@dataclass(frozen=True, slots=True, eq=False)
class NormalMode:
    """A real mode at the nodes of a structure, for a data set 55.

    Attributes
    ----------
    number : int
        Of the mode, from 1.
    frequency, damping_ratio : float
        [Hz] and [-].
    nodes : sequence of int
        Numbers of the nodes.
    values : (n_nodes, 3) or (n_nodes, 6) array
        Along x, y and z, and about them, for a unit modal mass [1/sqrt(kg)].
    """

    number: int
    frequency: float
    damping_ratio: float
    nodes: Sequence[int]
    values: FloatArray


def data_set(kind: int, lines: Iterable[str]) -> str:
    """Return a data set between its marks."""
    return "\n".join([f"{MARK}{kind:6d}", *lines, MARK])


def text_line(content: str) -> str:
    """Return a line of text as the format has it: 80 letters, none empty."""
    return (files.printable(content).strip()[:80] or "NONE").ljust(80)


def header(title: str, description: str, program: str) -> str:
    """Return data sets 151 and 164: the header, and metre and newton as units.

    The dates stay open, so that the same results give the same file.
    """
    dates = f"{'NONE':10}{'NONE':10}"
    about = [*map(text_line, (title, description, program)), f"{dates}{0:10d}{0:10d}{0:10d}"]
    units = [
        f"{1:10d}{'SI: metre (newton)':20}{2:10d}",
        "".join(f"{1.0:25.17E}" for _ in range(3)),
        f"{273.15:25.17E}",
    ]
    return data_set(151, [*about, dates, text_line(program), dates]) + data_set(164, units)


def geometry(wireframe: Wireframe) -> str:
    """Return data sets 2411, 82 and 2412: nodes, lines and surfaces, those that there are."""
    nodes = [
        line
        for number, place in wireframe.nodes.items()
        for line in (
            f"{number:10d}{0:10d}{0:10d}{_GREEN:10d}",
            "".join(f"{value:25.16E}" for value in place),
        )
    ]
    parts = [data_set(2411, nodes)] if nodes else []
    traces = [part for line in wireframe.lines for part in _parts(line)]
    parts += [
        data_set(
            82,
            [
                f"{number:10d}{len(line):10d}{_GREEN:10d}",
                text_line(f"line {number}"),
                *(
                    "".join(f"{node:10d}" for node in line[at : at + 8])
                    for at in range(0, len(line), 8)
                ),
            ],
        )
        for number, line in enumerate(traces, 1)
    ]
    shells = [one for surface in wireframe.surfaces for one in _shells(surface)]
    if shells:
        parts.append(
            data_set(
                2412,
                [
                    line
                    for number, one in enumerate(shells, 1)
                    for line in (
                        "".join(
                            f"{value:10d}"
                            for value in (number, _kind(one), 1, 1, _GREEN, len(one))
                        ),
                        "".join(f"{node:10d}" for node in one),
                    )
                ],
            )
        )
    return "".join(parts)


def _parts(line: Sequence[int]) -> Iterator[Sequence[int]]:
    """Yield a line in parts that are not too long, each from the end of that before."""
    for first in range(0, max(1, len(line) - 1), LONGEST_LINE - 1):
        yield line[first : first + LONGEST_LINE]


def _shells(surface: Sequence[int]) -> Iterator[Sequence[int]]:
    """Yield a surface as triangle or quadrangle, one of more corners as triangles."""
    if len(surface) <= 4:
        yield surface
        return
    for a, b in pairwise(surface[1:]):
        yield surface[0], a, b


def _kind(shell: Sequence[int]) -> int:
    return _TRIANGLE if len(shell) == 3 else _QUADRANGLE


def shape(one: NodalShape) -> str:
    """Return a data set 55: a complex mode."""
    kinds = (1, _COMPLEX_MODE, _TRANSLATIONS, one.quantity, _COMPLEX, 3)
    scales = (one.pole, one.modal_a, 0j)
    lines = [
        *(text_line(text) for text in (*one.texts, *[""] * 5)[:5]),
        "".join(f"{value:10d}" for value in kinds),
        "".join(f"{value:10d}" for value in (2, 6, 1, one.number)),
        "".join(f"{part:13.5E}" for value in scales for part in (value.real, value.imag)),
    ]
    rows = np.stack([one.values.real, one.values.imag], axis=-1).reshape(len(one.nodes), -1)
    return data_set(55, [*lines, *_nodal(one.nodes, rows)])


def normal_mode(one: NormalMode, title: str) -> str:
    """Return a data set 55: a real mode of unit modal mass."""
    columns = one.values.shape[1]
    kind = _TRANSLATIONS if columns == 3 else _WITH_ROTATIONS
    texts = (title, f"mode {one.number}", f"{one.frequency:.7g} Hz", "unit modal mass", "")
    lines = [
        *map(text_line, texts),
        "".join(f"{value:10d}" for value in (1, _NORMAL_MODE, kind, _LENGTH, _REAL, columns)),
        "".join(f"{value:10d}" for value in (2, 4, 1, one.number)),
        "".join(f"{value:13.5E}" for value in (one.frequency, 1.0, one.damping_ratio, 0.0)),
    ]
    return data_set(55, [*lines, *_nodal(one.nodes, one.values)])


def _nodal(nodes: Sequence[int], rows: FloatArray) -> Iterator[str]:
    """Yield two lines for each node: its number, and its values."""
    for node, row in zip(nodes, rows.tolist(), strict=True):
        yield f"{node:10d}"
        yield "".join(f"{value:13.5E}" for value in row)
