"""How a text file holds its table: encoding, delimiter, decimal sign, headers, first row."""

import csv
import io
import os
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Final, final

from shakerproc.errors import RecordingError
from shakerproc.recordings.columns import is_number
from shakerproc.recordings.guard import shown
from shakerproc.recordings.si import split_header
from shakerproc.recordings.text_labels import is_stepped, unlabelled
from shakerproc.recordings.text_names import (
    COMMENT,
    cells_in_use,
    column_names,
    fitted,
    numbered,
    title_rows,
)
from shakerproc.recordings.times import is_time

LOOK: Final = 1 << 16
"""Bytes at the start from which the format is judged."""

LARGEST: Final = 1 << 31
"""Bytes of text that are read at most; its numbers are held in memory whole."""

_FORMULAS: Final = {"'=", "'+", "'-", "'@"}
"""How text begins that was kept from being run by a spreadsheet."""

_FORMATS: Final = ((",", "."), (";", ","), (";", "."), ("\t", "."), ("\t", ","), (" ", "."))
_WHOLE: Final = re.compile(r"\d{1,6}")
_WORD: Final = re.compile(r"\S+(?:\s+\[[^\]]*\]|\s+\([^)]*\))?")
"""Between blanks, a unit in brackets belongs to the name before it."""


@final
@dataclass(frozen=True, slots=True)
class TextFormat:
    """How a text file holds its table.

    Attributes
    ----------
    encoding : str
        Of the text.
    delimiter, decimal : str
        Between cells; between whole and fraction.
    first : int
        Line of the first row of numbers, from 0.
    headers, units : tuple of str
        What stands over the columns; units are empty where they have no row of their own.
    remark : bool
        Whether a cell of text may follow the numbers of a row.
    interval : float, optional
        Between samples, where a row above the table says it [s].
    """

    encoding: str
    delimiter: str
    decimal: str
    first: int
    headers: tuple[str, ...]
    units: tuple[str, ...]
    remark: bool = False
    interval: float | None = None


def open_text(path: Path, run: str) -> tuple[BinaryIO, str, list[str]]:
    """Return a text file, open, with its encoding and the lines that it begins with.

    The file comes with one byte for each digit: UTF-16 is held in memory as UTF-8.

    Raises
    ------
    RecordingError
        If it cannot be opened, is empty, or is too long.
    """
    try:
        file: BinaryIO = path.open("rb")
    except OSError as error:
        raise RecordingError(f"{run}: cannot be opened: {error.strerror}.") from error
    try:
        size = os.fstat(file.fileno()).st_size
        if size > LARGEST:
            raise RecordingError(
                f"{run}: {size >> 20} MB of text are too many to hold in memory. Export the "
                "recording as TDMS instead."
            )
        start = file.read(LOOK)
        if not start:
            raise RecordingError(f"{run}: the file is empty (0 bytes).")
        encoding = encoding_of(start)
        if encoding == "utf-16":
            text = (start + file.read()).decode(encoding, errors="replace")
            file.close()
            file, encoding = io.BytesIO(text.encode("utf-8", errors="replace")), "utf-8-sig"
            start = file.read(LOOK)
        lines = [line.decode(encoding, errors="replace") for line in start.splitlines()]
        if len(start) == LOOK and not start.endswith((b"\n", b"\r")):
            lines.pop()  # the look ends inside it
            if not lines:
                raise RecordingError(
                    f"{run}: line 1 is longer than {LOOK} bytes. A table with a line for each "
                    "sample is read; turn rows into columns."
                )
    except OSError as error:
        file.close()
        raise RecordingError(f"{run}: cannot be read: {error.strerror}.") from error
    except BaseException:
        file.close()
        raise
    return file, encoding, lines


def encoding_of(start: bytes) -> str:
    """Return the encoding of a text by how it starts."""
    if start[:2] in {b"\xff\xfe", b"\xfe\xff"}:
        return "utf-16"
    for cut in range(4):  # the look may end inside a letter
        try:
            start[: len(start) - cut].decode("utf-8-sig")
        except UnicodeDecodeError:
            continue
        return "utf-8-sig"
    return "cp1252"


def find_format(lines: Sequence[str], encoding: str, run: str) -> TextFormat:
    """Return how a text holds its table, judged by its first lines.

    Raises
    ------
    RecordingError
        If no table of numbers is found.
    """
    best: tuple[int, TextFormat] | None = None
    letters = set().union(*lines)
    for delimiter, decimal in _FORMATS:
        if (delimiter != "," and delimiter not in letters) or decimal not in {".", *letters}:
            continue
        found = _try_format(lines, encoding, delimiter, decimal)
        if found is not None and (best is None or found[0] > best[0]):
            best = found
    if best is None:
        middle = len(lines) // 2
        raise RecordingError(
            f"{run}: no table of numbers in the first {len(lines)} lines; line {middle + 1} is "
            f"{shown(lines[middle] if lines else '', 60)}. Columns separated by comma, "
            "semicolon or tab with one line of headers are read, times in seconds."
        )
    _check_names(lines, best[1], run)
    return best[1]


def split(line: str, delimiter: str) -> list[str]:
    """Return the cells of a line."""
    if delimiter == " ":
        return _WORD.findall(line)
    cells = (
        next(csv.reader([line], delimiter=delimiter), [])
        if '"' in line
        else line.split(delimiter)
    )
    plain = [cell.strip() for cell in cells]
    return [cell[1:] if cell[:2] in _FORMULAS else cell for cell in plain]


def _try_format(
    lines: Sequence[str], encoding: str, delimiter: str, decimal: str
) -> tuple[int, TextFormat] | None:
    """Return the table that one pair of signs makes, with the number of its cells.

    It is as wide as most rows of numbers are, and begins below its headers: a row that is
    not as the others is part of it, to be judged when it is read.
    """
    rows = [split(line, delimiter) for line in lines]
    filled = [sum(bool(cell) for cell in row) for row in rows]
    numbers = [sum(is_number(cell, decimal) for cell in row) for row in rows]
    widths = [
        len(row) if n and n == there else 0
        for row, n, there in zip(rows, numbers, filled, strict=True)
    ]
    counts = Counter(width for width in widths if width)
    if not counts:
        return None
    width = max(counts, key=lambda w: (counts[w], w))
    first = widths.index(width)
    if (delimiter != "," and width < 2) or 2 * counts[width] <= sum(map(bool, filled[first:])):
        return None
    used = max(len(cells_in_use(r)) for r, w in zip(rows, widths, strict=True) if w == width)
    labelled = unlabelled(rows[:first], used, decimal)
    plain, interval = labelled or (rows[:first], None)
    rows[:first] = [fitted(row, used, width) for row in plain]
    titles = title_rows(rows[:first], numbers, width)
    headers, units = column_names(rows, titles, width)
    start = _start(rows[:first], numbers, titles, decimal)
    if labelled and not headers[0] and is_stepped(rows[first:], interval, decimal):
        headers, units = ("time", *headers[1:]), ("s", *units[1:])
    found = TextFormat(encoding, delimiter, decimal, start, headers, units, interval=interval)
    return counts[width] * width, found


def _start(
    above: Sequence[list[str]], numbers: Sequence[int], titles: Sequence[int], decimal: str
) -> int:
    """Return the line with which the table begins: its first row, whatever became of it.

    Below headers that is the next line that is neither blank nor a comment. Without headers
    it is the first of the lines above the numbers that hold a number themselves.
    """
    first = len(above)
    if titles:
        below = range(titles[-1] + 1, first)
        return next((i for i in below if not _is_aside(above[i])), first)
    while first and _is_row(above[first - 1], numbers[first - 1], decimal):
        first -= 1
    return first


def _is_aside(row: Sequence[str]) -> bool:
    return not any(row) or row[0].startswith(COMMENT)


def _is_row(row: Sequence[str], numbers: int, decimal: str) -> bool:
    """Return whether a line without headers above it was meant as a row of numbers."""
    broken = any(is_number(cell, decimal) and not _WHOLE.fullmatch(cell) for cell in row)
    return not _is_aside(row) and (broken or numbers > 1)


def _check_names(lines: Sequence[str], found: TextFormat, run: str) -> None:
    """Pass a table without names, or with one for each of its columns.

    Raises
    ------
    RecordingError
        If the line above the numbers names more columns, or fewer, than there are.
    """
    width = len(found.headers)
    above = [i for i in range(found.first) if lines[i].strip()]
    if found.headers != numbered(width) or not above:
        return
    names = cells_in_use(split(lines[above[-1]], found.delimiter))
    are_names = any(is_time(name) or split_header(name)[1] for name in names)
    if len(names) < 2 or not are_names or any(is_number(n, found.decimal) for n in names):
        return
    advice = "Give each column a name"
    if found.delimiter == "," and width == 2 * len(names):
        advice = (
            "Numbers with decimal commas cannot stand between commas: export with semicolons "
            "or tabs between the columns"
        )
    raise RecordingError(
        f"{run}: line {above[-1] + 1} names {len(names)} columns ({shown(names[0], 20)} to "
        f"{shown(names[-1], 20)}), but the rows below it have {width}. {advice}."
    )
