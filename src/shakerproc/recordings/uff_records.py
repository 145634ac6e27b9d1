"""The data sets of a universal file, one behind the other, and the records of kind 58.

A record says how many values it holds and, in the binary form, in how many bytes: what a
file that was cut short lacks is known.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import cycle
from typing import Any, Final, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.geometry.data_sets import (
    COMPLEX,
    HEAD,
    TYPES,
    UffDataSet,
    UffError,
    below_head,
    integer,
)
from shakerproc.recordings.guard import shown
from shakerproc.recordings.times import is_time

GENERAL, TIME_RESPONSE = 0, 1
"""Types of function that may be a recording."""

_QUANTITIES: Final = {"17": "Time", "18": "Frequency", "19": "Frequency"}
"""Types of an abscissa: time, frequency, and revolutions per minute."""

_ORDERS: Final = {1: "<", 2: ">"}
_SINGLE, _DOUBLE, _COMPLEX_SINGLE, _COMPLEX_DOUBLE = 2, 4, 5, 6
_COLUMNS: Final = {
    (_SINGLE, True): (13,), (_DOUBLE, True): (20,),
    (_SINGLE, False): (13,), (_DOUBLE, False): (13, 20),
    (_COMPLEX_SINGLE, True): (13,), (_COMPLEX_DOUBLE, True): (20,),
    (_COMPLEX_SINGLE, False): (13,), (_COMPLEX_DOUBLE, False): (13, 20, 20),
}  # fmt: skip
"""Letters of the numbers in the text form, by their type and whether they are evenly spaced:
6E13.5 and 4E20.12; 3(E13.5, E13.5) and 2(E13.5, E20.12) with the abscissa before each; of
complex ones E13.5, 2E20.12."""

_IN_LINE: Final = {_SINGLE: 6, _DOUBLE: 4, _COMPLEX_SINGLE: 6, _COMPLEX_DOUBLE: 4}
"""Numbers of a line in the text form at most, an abscissa counted as one."""


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
        Those that are there, as they are stored; none where they are no samples.
    filled : int
        Zeros behind them that only fill the last line.
    spectrum : (n,) complex array, optional
        Values of any record, where they were asked for [unit].
    head : tuple of str
        The lines before the numbers.
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
    values: NDArray[Any]
    is_complex: bool
    cut: bool
    start: float = 0.0
    step_text: str = ""
    start_text: str = ""
    abscissa: str = ""
    abscissa_unit: str = ""
    times: FloatArray | None = None
    filled: int = 0
    spectrum: ComplexArray | None = None
    head: tuple[str, ...] = ()

    @property
    def is_recording(self) -> bool:
        """Whether the values are samples: a time response, or a general function of time."""
        over_time = self.function == TIME_RESPONSE or (
            self.function == GENERAL and is_time(self.abscissa or "?", self.abscissa_unit)
        )
        return over_time and not self.is_complex


def record_of(content: bytes, data_set: UffDataSet, *, spectra: bool = False) -> Record:
    """Return a record of kind 58; with `spectra`, the values of those that are no samples too.

    Raises
    ------
    UffError
        If its header is not what it should be, or it holds other than it says.
    """
    body = below_head(content, data_set.start)
    lines = content[data_set.start : body].splitlines()
    if data_set.cut and (body > data_set.stop or len(lines) < HEAD):
        return Record((), 1, "", "", 0.0, -1, np.empty(0), is_complex=False, cut=True)
    if body > data_set.stop:
        raise UffError(data_set.start, "a record ends inside its header")
    head = [line.decode("utf-8", errors="replace") for line in lines]
    place = data_set.start
    kind = integer(lines[6][:10], place)
    promised = integer(lines[6][10:20], place)
    function = integer(lines[5][:5], place)
    spacing = integer(lines[6][20:30], place)
    if kind not in TYPES:
        raise UffError(place, f"a record holds numbers of type {kind}, unknown here")
    record = Record(
        texts=tuple(text.strip() for text in head[:5]),
        function=function,
        place=head[5][31:41].strip(),
        unit=head[8][46:67].strip(),
        step=_real(lines[6][43:56], place) if spacing else 0.0,
        promised=promised,
        values=np.empty(0),
        is_complex=kind in COMPLEX,
        cut=data_set.cut,
        start=_real(lines[6][30:43], place) if spacing else 0.0,
        step_text=head[6][43:56],
        start_text=head[6][30:43],
        abscissa=_QUANTITIES.get(head[7][:10].strip(), "") or _said(head[7][25:46]),
        abscissa_unit=_said(head[7][46:67]),
    )
    if not (spectra or record.is_recording):
        return record
    record = replace(record, head=tuple(head)) if spectra else record
    return _with_values(record, _Numbers(content, data_set, body, kind, even=bool(spacing)))


def _said(text: str) -> str:
    """Return a text of a header, or none where it is the word for that."""
    return "" if text.strip().casefold() == "none" else text.strip()


@final
@dataclass(frozen=True, slots=True)
class _Numbers:
    """Where the numbers of a record stand, and how."""

    content: bytes
    data_set: UffDataSet
    body: int
    kind: int
    even: bool


def _with_values(record: Record, there: _Numbers) -> Record:
    """Return a record with its values, and with their abscissa where it is stored.

    Raises
    ------
    UffError
        If it holds more or less than it says.
    """
    binary = bool(there.data_set.binary)
    numbers = _binary_values(there, record.promised) if binary else _text_values(there)
    parts = 2 if record.is_complex else 1
    per_value = parts if there.even else parts + 1
    count = numbers.size // per_value
    filling = numbers[per_value * record.promised :]
    if not binary and 0 < filling.size < _IN_LINE[there.kind] and not np.any(filling):
        count = record.promised
    elif filling.size or (count < record.promised and not record.cut):
        raise UffError(
            there.data_set.start,
            f"the record {shown(record.texts[0], 30)} holds {-(-numbers.size // per_value)} "
            f"values but says "
            f"{record.promised}",
        )
    pairs = numbers[: per_value * count].reshape(count, per_value)
    times = None if there.even else pairs[:, 0].astype(np.float64)
    filled = filling.size if count == record.promised else 0
    if record.head:
        spectrum = pairs[:, -parts:] @ np.array([1.0, 1j][:parts])
        return replace(record, times=times, filled=filled, spectrum=spectrum.astype(complex))
    return replace(record, values=pairs[:, -1], times=times, filled=filled)


def _binary_values(there: _Numbers, promised: int) -> NDArray[Any]:
    """Return numbers as bytes; a stored abscissa may be single before a double, as in text.

    Raises
    ------
    UffError
        If they are no whole number of numbers, or no IEEE floats.
    """
    order = _byte_order(there.data_set.binary, there.body)
    dtype = np.dtype(order + TYPES[there.kind])
    data = memoryview(there.content)[
        there.body : there.data_set.stop
    ]  # no copy: files are large
    width = 2 if there.kind in COMPLEX else 1
    mixed = np.dtype([("x", order + "f4"), ("y", dtype, (width,))])
    double = dtype.itemsize == 8 and not there.even
    if double and len(data) == promised * mixed.itemsize:
        both = np.frombuffer(data, mixed)
        return np.column_stack([both["x"], both["y"]]).astype(np.float64).reshape(-1)
    if len(data) % dtype.itemsize and not there.data_set.cut:
        raise UffError(there.body, "a record holds no whole number of numbers")
    return np.frombuffer(data, dtype, len(data) // dtype.itemsize)  # single ones stay so: large


def _byte_order(binary: bytes, place: int) -> str:
    """Return the order of bytes that the first line of a binary data set states.

    Raises
    ------
    UffError
        If it states none, or floats of another computer.
    """
    stated = integer(binary[7:13], place)
    others = {b"1": "DEC VMS", b"3": "IBM 5/370"}
    kind = others.get(binary[13:19].strip())
    if stated not in _ORDERS or kind is not None:
        what = f"floats of {kind}" if kind else f"byte order {stated}"
        raise UffError(place, f"{what}: only IEEE floats, little (1) or big (2) end first")
    return _ORDERS[stated]


def _text_values(there: _Numbers) -> FloatArray:
    """Return numbers as text, in columns; the last of a cut file is left out.

    Raises
    ------
    UffError
        If one is none.
    """
    text = there.content[there.body : there.data_set.stop].replace(b"D", b"E")
    cells = text.split()
    if there.data_set.cut:
        cells = cells[:-1]
    try:
        return np.array(cells, dtype="S32").astype(np.float64)
    except ValueError:
        widths = _COLUMNS[there.kind, there.even]  # numbers that touch each other
    cells = [cell for line in text.splitlines() for cell in _in_columns(line, widths)]
    filled = [cell for cell in cells if cell]
    try:
        return np.array(filled[:-1] if there.data_set.cut else filled, dtype="S32").astype(
            np.float64
        )
    except ValueError as error:
        raise UffError(there.body, f"a record holds what is no number: {error}") from error


def _in_columns(line: bytes, widths: tuple[int, ...]) -> Iterator[bytes]:
    """Yield the cells of a line, whose widths repeat."""
    at = 0
    for width in cycle(widths):
        if at >= len(line):
            return
        yield line[at : at + width].strip()
        at += width


def _real(cell: bytes, place: int) -> float:
    try:
        return float(cell.replace(b"D", b"E"))
    except ValueError as error:
        raise UffError(place, f"{cell[:13]!r} should be a number") from error
