"""The rows of a text table, block by block: bad ones counted, named, and left out in time."""

import csv
import io
import math
import re
from array import array
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Final, Protocol, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray, SkippedRows
from shakerproc.errors import RecordingError
from shakerproc.recordings.guard import AGAIN, shown
from shakerproc.recordings.text_format import LARGEST, TextFormat, split
from shakerproc.recordings.text_headers import is_comment

BLOCK: Final = 1 << 22
"""Bytes that are read at a time."""

NAMED: Final = 5
"""Bad rows that are described; the others are counted."""

LOOK_BACK: Final = 50
"""Lines by which the last one is judged where the file stops short."""

_NUMBER: Final = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
_NUMERALS: Final = b"0123456789+-eE "


@final
@dataclass(slots=True)
class Interruptions:
    """Lines in the midst of a table that are no rows of numbers.

    Attributes
    ----------
    after : array
        For each, how many rows of numbers stand above it.
    samples : array
        For each, whether it may have been a row of numbers: no blank line, no header.
    named : list of (int, str)
        Line, from 1, and what was found there, of the first few.
    """

    after: "array[int]" = field(default_factory=lambda: array("q"))
    samples: "array[int]" = field(default_factory=lambda: array("b"))
    named: list[tuple[int, str]] = field(default_factory=list)

    def add(self, line: int, after: int, text: str, *, sample: bool) -> None:
        """Take in a line."""
        self.after.append(after)
        self.samples.append(sample)
        if len(self.named) < NAMED:
            self.named.append((line, text))

    def drop_last(self) -> None:
        """Forget the last line."""
        self.after.pop()
        self.samples.pop()
        if len(self.after) < len(self.named):
            self.named.pop()


@final
@dataclass(frozen=True, slots=True, eq=False)
class TextTable:
    """The numbers of a text file.

    Attributes
    ----------
    values : (n_columns, n_rows) array
        Not a number where a cell is empty.
    bad : Interruptions
        What stands between them.
    torn : str
        How the file stops short; empty where its last row is whole.
    unended : bool
        Whether the last row lacks its line end, so that its last number may be cut.
    """

    values: FloatArray
    bad: Interruptions
    torn: str
    unended: bool


class Readable(Protocol):
    """A text that is read from its start on."""

    def read(self, size: int, /) -> bytes:
        """Return some bytes; none at the end."""

    def seek(self, place: int, /) -> int:
        """Go to a place."""


def read_table(
    file: Readable, text_format: TextFormat, run: str, *, span: tuple[int, int] | None = None
) -> TextTable:
    """Return the numbers of a text file from its first row on.

    Parameters
    ----------
    file : file
        Open; one byte for each digit.
    text_format : TextFormat
        How it holds its table.
    run : str
        Name of the run, for messages.
    span : tuple of int, optional
        Bytes of the first row and behind the last, where there are several tables.

    Raises
    ------
    RecordingError
        If it cannot be read.
    """
    rows = _Rows(text_format, run)
    start, stop = span or (0, LARGEST)
    file.seek(start)
    for block in _blocks(file, 0 if span else text_format.first, stop - start):
        rows.add(block)
    return rows.table()


def _blocks(file: Readable, skip: int, size: int) -> Iterator[bytes]:
    """Yield whole lines, many at a time, without the first few; the last may be unended."""
    rest = file.read(min(BLOCK, size))
    size -= len(rest)
    lines = rest.splitlines(keepends=True)
    rest = rest[sum(map(len, lines[:skip])) :]
    while more := file.read(min(BLOCK, size)):
        size -= len(more)
        end = max(rest.rfind(b"\n"), rest.rfind(b"\r") if b"\n" not in rest else -1) + 1
        if end:
            yield rest[:end]
        rest = rest[end:] + more
    yield rest


def _one_column(block: bytes, delimiter: str) -> bytes:
    """Return the cells of whole rows below each other, a line each."""
    if delimiter == " ":
        return b"\n".join(block.split())
    rows = block.replace(b"\r\n", b"\n").removesuffix(b"\n")
    return rows.replace(delimiter.encode(), b"\n") + b"\n"


@final
class _Rows:
    """Takes in a table block by block."""

    def __init__(self, text_format: TextFormat, run: str) -> None:
        self._found = text_format
        self._run = run
        self._width = len(text_format.headers)
        self._line = text_format.first
        self._count = 0
        self._parts: list[FloatArray] = []
        self._bad = Interruptions()
        self._blank_end = 0
        self._above: list[bytes] = []
        self._torn = ""
        self._unended = False
        numerals = _NUMERALS + text_format.decimal.encode()
        self._numerals = numerals + b"\t" if text_format.delimiter == " " else numerals

    def add(self, block: bytes) -> None:
        """Take in some lines."""
        ended = not block or block.endswith((b"\n", b"\r"))
        end = len(block) if ended else max(block.rfind(b"\n"), block.rfind(b"\r")) + 1
        self._add_lines(block[:end])
        if not ended:
            self._add_last(block[end:])

    def table(self) -> TextTable:
        """Return the table of all rows; blank lines at the end are none."""
        for _ in range(self._blank_end):
            self._bad.drop_last()
        values = np.concatenate([np.empty((self._width, 0)), *self._parts], axis=1)
        return TextTable(values, self._bad, self._torn, self._unended)

    def _add_lines(self, block: bytes) -> None:
        values = self._at_once(block)
        if values is None:
            self._one_by_one(block.splitlines())
        else:
            self._take(values)
            self._line += values.shape[1]
        self._above = [*self._above, *block[-64 * LOOK_BACK * self._width :].splitlines()]
        self._above = self._above[-LOOK_BACK:]

    def _take(self, values: FloatArray) -> None:
        if values.shape[1]:
            self._parts.append(values)
            self._count += values.shape[1]
            self._blank_end = 0

    def _at_once(self, block: bytes) -> FloatArray | None:
        """Return the numbers of a block in which every line is a row, else None.

        What remains of the block without all that numbers are made of must be the delimiters
        and line ends of that many rows.
        """
        count = block.count(b"\n")
        end = b"\r\n" if block.endswith(b"\r\n") else b"\n"
        between = self._width - 1 if self._found.delimiter != " " else 0
        remains = block.translate(None, self._numerals)
        for extra in range(1 + self._found.remark):
            row = self._found.delimiter.encode() * (between + extra) + end
            if remains != row * count:
                continue
            if not between and len(block.split()) != self._width * count:
                return None
            values = self._parsed(block, self._found.delimiter, self._found.decimal, extra)
            if values is None or values.shape[1] != count or np.isinf(values).any():
                return None
            return None if np.isnan(values).all(axis=0).any() else values
        return None

    def _parsed(
        self, block: bytes, delimiter: str, decimal: str, extra: int = 0
    ) -> FloatArray | None:
        import pandas as pd

        if not block:
            return np.empty((self._width, 0))
        width = self._width + extra
        if flat := width > block.count(b"\n"):  # a frame takes its time for each column
            block, width = _one_column(block, delimiter), 1
        try:
            frame = pd.read_csv(
                io.BytesIO(block),
                sep=r"\s+" if delimiter == " " else delimiter,
                decimal=decimal,
                header=None,
                names=list(range(width)),
                usecols=list(range(min(width, self._width))),
                dtype=np.float64,
                engine="c",
                index_col=False,
                skip_blank_lines=False,
                keep_default_na=False,
                na_values=[""],
                quoting=csv.QUOTE_NONE,
                **to_the_last_digit(),
            )
        except (ValueError, OverflowError):
            return None
        values = frame.to_numpy(np.float64)
        if flat:
            if values.size % (self._width + extra):
                return None
            values = values.reshape(-1, self._width + extra)[:, : self._width]
        return np.ascontiguousarray(values.T)

    def _one_by_one(self, lines: list[bytes]) -> None:
        good: list[str] = []
        for line in lines:
            self._line += 1
            cells, problem = self._judged(line)
            if not problem:
                good.append(",".join(cells))
                self._blank_end = 0
                continue
            blank = not any(cells) or is_comment(line.decode("latin-1"), self._found.delimiter)
            sample = not blank and tuple(cells) not in {self._found.headers, self._found.units}
            self._bad.add(self._line, self._count + len(good), problem, sample=sample)
            self._blank_end = self._blank_end + 1 if blank else 0
        blank_end = self._blank_end
        self._take(self._numbers(good))
        self._blank_end = blank_end

    def _numbers(self, rows: list[str]) -> FloatArray:
        """Return rows that were judged to be numbers.

        Raises
        ------
        RecordingError
            If they are none.
        """
        values = self._parsed("".join(f"{row}\n" for row in rows).encode(), ",", ".")
        if values is None or values.shape[1] != len(rows):
            raise RecordingError(
                f"{self._run}: the table of numbers cannot be read above line "
                f"{self._line + 1}. {AGAIN}"
            )
        return values

    def _judged(self, line: bytes) -> tuple[list[str], str]:
        """Return the cells of a line, and their problem, if any."""
        text = line.decode(self._found.encoding, errors="replace")
        try:
            cells = split(text, self._found.delimiter)
        except csv.Error as error:
            return [text], f"{shown(text, 30)} is no row ({error})"
        if not any(cells):
            return cells, "it is blank"
        width = self._width
        if self._found.remark and len(cells) > width:
            cells = cells[:width]
        if len(cells) != width:
            return cells, f"it has {len(cells)} cell{'s' * (len(cells) != 1)}"
        for column, cell in enumerate(cells):
            plain = cell.replace(self._found.decimal, ".") if "." not in cell else cell
            if self._found.decimal == "," and "." in cell:
                plain = "?"
            if cell and not (_NUMBER.fullmatch(plain) and math.isfinite(float(plain))):
                return cells, f"{shown(cell, 30)} in column {column + 1} is no number"
            cells[column] = plain
        return cells, ""

    def _add_last(self, line: bytes) -> None:
        """Take in a last line that has no line end."""
        cells, problem = self._judged(line)
        if problem and not any(cells):
            return
        if problem or self._is_shorter(cells):
            self._torn = f"it stops inside row {self._count + 1}"
            return
        self._take(self._numbers([",".join(cells)]))
        self._unended = True

    def _is_shorter(self, cells: list[str]) -> bool:
        """Return whether the last number has fewer decimals than all above it."""
        above = [self._judged(line) for line in self._above]
        decimals = [len(row[-1].partition(".")[2]) for row, problem in above if not problem]
        return bool(decimals) and len(cells[-1].partition(".")[2]) < min(decimals)


def to_the_last_digit() -> dict[str, Any]:
    """Return the option by which pandas reads a number as it was written.

    From 3.1 on it always does, and warns of the option.
    """
    import pandas as pd

    release = tuple(int(part) for part in pd.__version__.split(".")[:2])
    return {} if release >= (3, 1) else {"float_precision": "round_trip"}


def without_bad_rows(
    values: FloatArray, bad: Interruptions, times: FloatArray | None
) -> tuple[FloatArray, SkippedRows | None]:
    """Return the rows of a table with straight lines where rows are left out.

    A row that is left out is a gap in time. The time column says how many samples are missing
    there, none for a blank line or a header that is repeated; without one, every bad row that
    is neither counts as a sample.

    Parameters
    ----------
    values : (n_columns, n_rows) array
        The rows of numbers [units of the columns].
    bad : Interruptions
        What stands between them.
    times : (n_rows,) array, optional
        The time column [s].
    """
    if not bad.after:
        return values, None
    n_rows = values.shape[1]
    after = np.frombuffer(bad.after, dtype=np.int64)
    at, index = np.unique(after, return_inverse=True)
    lines = np.bincount(index)
    missing = np.bincount(index, weights=np.frombuffer(bad.samples, dtype=np.int8)).astype(int)
    inside = (at > 0) & (at < n_rows)
    if times is not None:
        missing[inside] = _missing_in_time(times, at[inside], lines[inside])
    missing[~inside] = 0  # nothing stands on the other side to bridge to
    shift = np.zeros(n_rows, dtype=np.int64)
    np.add.at(shift, at[inside], missing[inside])
    place = np.arange(n_rows) + np.cumsum(shift)
    whole = _bridged(values, place) if missing.any() else values
    ends = np.append(place, whole.shape[1])
    first, last = int(ends[at[0]]) - int(missing[0]), int(ends[at[-1]])
    filled = int(missing.sum())
    return whole, SkippedRows(
        count=len(bad.after),
        bridged=filled,
        first=first,
        last=last,
        message=_message(bad, filled, timed=times is not None),
    )


def refusal(bad: Interruptions, width: int) -> str:
    """Return the message on bad rows: the first of them, and how many there are."""
    line, text = bad.named[0]
    count = len(bad.after)
    wanted = f"{width} numbers are" if width > 1 else "a number is"
    such = f" {count} lines are no rows of numbers ({_listed(bad)})." if count > 1 else ""
    return f"line {line}: {text}, where {wanted} wanted.{such}"


def _listed(bad: Interruptions) -> str:
    lines = ", ".join(str(line) for line, _ in bad.named)
    return f"lines {lines}{' and so on' if len(bad.after) > len(bad.named) else ''}"


def _message(bad: Interruptions, filled: int, *, timed: bool) -> str:
    count = len(bad.after)
    line, text = bad.named[0]
    lines = f"{count} lines that are no rows of numbers were"
    if count == 1:
        lines = "1 line that is no row of numbers was"
    where = f"{_listed(bad)}; " if count > 1 else ""
    bridged = f"{filled} samples are" if filled != 1 else "1 sample is"
    why = "as the time column says" if timed else "no time column says how many were missing"
    return (
        f"{lines} skipped ({where}line {line}: {text}); {bridged} bridged by "
        f"straight lines ({why})."
    )


def _missing_in_time(
    times: FloatArray, at: NDArray[np.int64], lines: NDArray[np.int64]
) -> FloatArray:
    """Return how many samples the time column lacks at each gap, one for a line at most.

    The step is that of the longest stretch without a gap.
    """
    edges = np.concatenate([[0], at, [times.size]])
    longest = int(np.argmax(np.diff(edges)))
    start, stop = int(edges[longest]), int(edges[longest + 1]) - 1
    step = (times[stop] - times[start]) / (stop - start) if stop > start else 0.0
    if not (np.isfinite(step) and step > 0.0):
        return np.zeros(at.size)
    gaps = np.nan_to_num((times[at] - times[at - 1]) / step, nan=0.0)
    missing: FloatArray = np.clip(np.rint(np.clip(gaps, 0.0, 1e15)) - 1.0, 0, lines)
    return missing


def _bridged(values: FloatArray, place: NDArray[np.int64]) -> FloatArray:
    every = np.arange(int(place[-1]) + 1)
    return np.stack([np.interp(every, place, row) for row in values])
