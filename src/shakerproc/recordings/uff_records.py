"""The data sets of a universal file, one behind the other, and the records of kind 58.

A record says how many values it holds and, in the binary form, in how many bytes: what a
file that was cut short lacks is known.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.recordings.guard import shown

_MARK: Final = re.compile(rb"^ {4}-1[ \t]*\r?$", re.MULTILINE)
_MARK_HERE: Final = re.compile(rb" {4}-1[ \t]*\r?(?=\n|\Z)")
_HEAD: Final = 11
"""Lines between the kind of a record and its numbers."""

_QUANTITIES: Final = {"17": "Time", "18": "Frequency", "19": "Frequency"}
"""Types of an abscissa: time, frequency, and revolutions per minute."""

_TYPES: Final = {2: "f4", 4: "f8", 5: "f4", 6: "f8"}
_COMPLEX: Final = {5, 6}
_COLUMNS: Final = {2: 13, 4: 20}
"""Letters of a number in the text form (6E13.5 and 4E20.12)."""


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


@final
@dataclass(frozen=True, slots=True, eq=False)
class Record:
    """A record of kind 58.

    Attributes
    ----------
    texts : tuple of str
        Its five lines of description; empty where the file ends before.
    function : int
        Type of function; 1 is a time response.
    place : str
        Where the response was measured.
    unit : str
        Of the values.
    step : float
        Between two of them [abscissa_unit]; 0 where they are unevenly spaced.
    start : float
        Of the first of them [abscissa_unit].
    step_text, start_text : str
        These, as they are printed.
    abscissa, abscissa_unit : str
        What the values are over, and its unit; empty where the file does not say it.
    times : (n,) array, optional
        Abscissa of each value, where they are unevenly spaced [abscissa_unit].
    promised : int
        Values that it says it holds; -1 where the file ends before it says so.
    values : (n,) array
        Those that are there.
    is_complex : bool
        Whether they are complex, so that none are given.
    cut : bool
        Whether the file ends inside it.
    """

    texts: tuple[str, ...]
    function: int
    place: str
    unit: str
    step: float
    promised: int
    values: FloatArray
    is_complex: bool
    cut: bool
    start: float = 0.0
    step_text: str = ""
    start_text: str = ""
    abscissa: str = ""
    abscissa_unit: str = ""
    times: FloatArray | None = None


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
        if b"\n" not in content[start:]:
            raise UffError(start, "the file ends where a data set begins")
        line = content[start : _after_line(content, start)].strip(b"\r\n")
        kind = line[:6].strip()
        if not kind.isdigit():
            raise UffError(start, "a data set has no number")
        body = _after_line(content, start)
        if line[6:7].lower() == b"b" and int(kind) == 58:
            stop = _skip_lines(content, body, _HEAD) + _integer(line[31:43], start)
            closing = _MARK_HERE.match(content, _after_blank(content, stop))
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


def record_of(content: bytes, found: DataSet) -> Record:
    """Return a record of kind 58.

    Raises
    ------
    UffError
        If its header is not what it should be, or it holds other than it says.
    """
    body = _skip_lines(content, found.start, _HEAD)
    lines = content[found.start : body].splitlines()
    if found.cut and (body > found.stop or len(lines) < _HEAD):
        return Record((), 1, "", "", 0.0, -1, np.empty(0), is_complex=False, cut=True)
    if body > found.stop:
        raise UffError(found.start, "a record ends inside its header")
    head = [line.decode("utf-8", errors="replace") for line in lines]
    place = found.start
    kind = _integer(lines[6][:10], place)
    promised = _integer(lines[6][10:20], place)
    function = _integer(lines[5][:5], place)
    spacing = _integer(lines[6][20:30], place)
    if kind not in _TYPES:
        raise UffError(place, f"a record holds numbers of type {kind}, unknown here")
    values, times = np.empty(0), None
    if kind not in _COMPLEX and function == 1:
        values = _values(content, found, body, kind)
        if not spacing:  # a time stands before each value
            times, values = values[0 : 2 * (values.size // 2) : 2], values[1::2]
        if values.size > promised or (values.size < promised and not found.cut):
            raise UffError(
                place,
                f"the record {shown(head[0].strip(), 30)} holds {values.size} values but says "
                f"{promised}",
            )
    return Record(
        texts=tuple(text.strip() for text in head[:5]),
        function=function,
        place=head[5][31:41].strip(),
        unit=head[8][46:67].strip(),
        step=_real(lines[6][43:56], place) if spacing else 0.0,
        promised=promised,
        values=values,
        is_complex=kind in _COMPLEX,
        cut=found.cut,
        start=_real(lines[6][30:43], place) if spacing else 0.0,
        step_text=head[6][43:56],
        start_text=head[6][30:43],
        abscissa=_QUANTITIES.get(head[7][:10].strip(), "") or _said(head[7][25:46]),
        abscissa_unit=_said(head[7][46:67]),
        times=times,
    )


def _values(content: bytes, found: DataSet, body: int, kind: int) -> FloatArray:
    if found.binary:
        order = "<" if _integer(found.binary[7:13], body) == 1 else ">"
        dtype = np.dtype(order + _TYPES[kind])
        data = content[body : found.stop]
        if len(data) % dtype.itemsize and not found.cut:
            raise UffError(body, "a record holds no whole number of numbers")
        whole = len(data) // dtype.itemsize
        values = np.frombuffer(data, dtype, whole).astype(np.float64)
    else:
        values = _text_values(content[body : found.stop], kind, body, cut=found.cut)
    return values


def _said(text: str) -> str:
    """Return a text of a header, or none where it is the word for that."""
    return "" if text.strip().casefold() == "none" else text.strip()


def _text_values(text: bytes, kind: int, place: int, *, cut: bool) -> FloatArray:
    """Return numbers as text, in columns of one width; the last of a cut file is left out.

    Raises
    ------
    UffError
        If one is none.
    """
    text = text.replace(b"D", b"E")
    cells = text.split()
    if cut:
        cells = cells[:-1]
    try:
        return np.array(cells, dtype="S32").astype(np.float64)
    except ValueError:
        width = _COLUMNS[kind]  # numbers that touch each other
    cells = [
        line[at : at + width].strip()
        for line in text.splitlines()
        for at in range(0, len(line), width)
    ]
    filled = [cell for cell in cells if cell]
    try:
        return np.array(filled[:-1] if cut else filled, dtype="S32").astype(np.float64)
    except ValueError as error:
        raise UffError(place, f"a record holds what is no number: {error}") from error


def _after_line(content: bytes, at: int) -> int:
    end = content.find(b"\n", at)
    return end + 1 if end >= 0 else len(content)


def _skip_lines(content: bytes, at: int, count: int) -> int:
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


def _integer(field: bytes, place: int) -> int:
    try:
        number = int(field)
    except ValueError as error:
        raise UffError(place, f"{field[:12]!r} should be a whole number") from error
    if number < 0 or len(field) > 20:
        raise UffError(place, f"{number} should not be below 0")
    return number


def _real(field: bytes, place: int) -> float:
    try:
        return float(field.replace(b"D", b"E"))
    except ValueError as error:
        raise UffError(place, f"{field[:13]!r} should be a number") from error
