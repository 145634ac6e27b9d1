"""How a text file holds its table: encoding, delimiter, decimal sign, headers, first row."""

import csv
import io
import os
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from itertools import zip_longest
from pathlib import Path
from typing import BinaryIO, Final, final

from shakerproc.errors import RecordingError
from shakerproc.recordings.columns import is_number
from shakerproc.recordings.guard import opened, shown
from shakerproc.recordings.raw import TimeAxis
from shakerproc.recordings.si import split_header
from shakerproc.recordings.text_headers import (
    cells_in_use,
    column_names,
    fitted,
    is_comment,
    is_statement,
    is_stepped,
    numbered,
    stated_axes,
    stated_domain,
    title_rows,
    uncommented,
    unlabelled,
)
from shakerproc.recordings.times import FEWEST, is_time, seconds_in, time_name

LOOK: Final = 1 << 16
"""Bytes at the start from which the format is judged, where its lines are short."""

ROOM: Final = 8
"""Lines as long as the longest that the look has room for: headers, units, rows of numbers."""

FARTHEST: Final = 1 << 24
"""Bytes that are looked at for the end of a long line at most."""

LARGEST: Final = 1 << 31
"""Bytes of text that are read at most; its numbers are held in memory whole."""

MOST_ABOVE: Final = 4
"""Numbers above a table without headers: a rate, a start, a count and one more."""

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
    axes : tuple of TimeAxis
        What lines above the table state of the times of its rows.
    note : str
        What had to be decided; empty for nothing.
    start_time : datetime, optional
        When time 0 of `axes` is, with its time zone.
    """

    encoding: str
    delimiter: str
    decimal: str
    first: int
    headers: tuple[str, ...]
    units: tuple[str, ...]
    remark: bool = False
    axes: tuple[TimeAxis, ...] = ()
    note: str = ""
    start_time: datetime | None = None


def open_text(path: Path, run: str) -> tuple[BinaryIO, str, list[str]]:
    """Return a text file, open, with its encoding and the lines that it begins with.

    The file comes with one byte for each digit: UTF-16 is held in memory as UTF-8.

    Raises
    ------
    RecordingError
        If it cannot be opened, is empty, or is too long.
    """
    return looked_at(opened(path, run), run)


def looked_at(file: BinaryIO, run: str) -> tuple[BinaryIO, str, list[str]]:
    """Return an open text with its encoding and the lines that it begins with.

    Raises
    ------
    RecordingError
        If it is empty, or too long.
    """
    try:
        size = file.seek(0, os.SEEK_END)
        file.seek(0)
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
        start = _with_room(start, file)
        lines = [line.decode(encoding, errors="replace") for line in start.splitlines()]
        if len(start) >= LOOK and not start.endswith((b"\n", b"\r")):
            lines.pop()  # the look ends inside it
            if not lines:
                raise RecordingError(
                    f"{run}: line 1 does not end within {len(start)} bytes. A table with "
                    "a line for each sample is read; turn rows into columns."
                )
    except OSError as error:
        file.close()
        raise RecordingError(f"{run}: cannot be read: {error.strerror}.") from error
    except BaseException:
        file.close()
        raise
    return file, encoding, lines


def _with_room(start: bytes, file: BinaryIO) -> bytes:
    """Return the start of a file with room for several lines as long as the longest."""
    while True:
        longest = max(map(len, start.splitlines()))
        missing = min(ROOM * longest, FARTHEST) - len(start)
        more = file.read(missing) if missing > 0 else b""
        if not more:
            return start
        start += more


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
        guess = _try_format(lines, encoding, delimiter, decimal)
        if guess is not None and (best is None or guess[0] > best[0]):
            best = guess
    if best is None:
        middle = len(lines) // 2
        raise RecordingError(
            f"{run}: no table of numbers in the first {len(lines)} lines; line {middle + 1} is "
            f"{shown(lines[middle] if lines else '', 60)}. Columns separated by comma, "
            "semicolon or tab with one line of headers are read, times in seconds."
        )
    _check_names(lines, best[1], run)
    _check_units_of_times(lines, best[1], run)
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
    if delimiter != "," and width < 2:
        return None
    first, axes, note = _below_meta(rows, widths, width)
    if 2 * counts[width] <= sum(map(bool, filled[first:])):
        return None
    used = max(len(cells_in_use(r)) for r, w in zip(rows, widths, strict=True) if w == width)
    labelled = unlabelled(rows[:first], used, decimal)
    plain, interval = labelled or (rows[:first], None)
    comments = [
        is_comment(line, delimiter) or (line.lstrip()[:1] == '"' and len(row) == 1)
        for line, row in zip(lines[:first], rows, strict=False)
    ]
    rows[:first] = [
        [] if is_statement(line) and not labelled else fitted(row, used, width)
        for line, row in zip(lines[:first], plain, strict=True)
    ]
    titles = title_rows(rows[:first], numbers, width, comments)
    headers, units = column_names(rows, titles, width)
    start = _start(rows[:first], numbers, titles, comments, decimal)
    if labelled and not headers[0] and is_stepped(rows[first:], interval, decimal):
        headers, units = ("time", *headers[1:]), ("s", *units[1:])
    if not titles and (more := _printed_otherwise(rows[start:], width, decimal)):
        text = "; ".join(", ".join(row) for row in rows[start : start + more])
        note = (
            f"Line {start + 1} ({shown(text, 40)}) is no sample: it is printed in another way."
        )
        start += more
    axes += stated_axes(lines[:start])
    domain = stated_domain(lines[:start])
    if domain is not None and headers[0] == domain.column:
        headers = (f"time [{domain.unit}]", *headers[1:])
    elif domain is not None:
        axes += (domain.axis,)
    if interval is not None and not axes:
        axes = (TimeAxis("row Interval", step=interval, unit="s"),)
    text_format = TextFormat(
        encoding, delimiter, decimal, start, headers, units, axes=axes, note=note,
        start_time=None if domain is None else domain.origin,
    )  # fmt: skip
    return counts[width] * width, text_format


def _below_meta(
    rows: Sequence[list[str]], widths: Sequence[int], width: int
) -> tuple[int, tuple[TimeAxis, ...], str]:
    """Return the first row of numbers of the table, below rows of numbers that are none of it.

    Those stand above the headers, such as a start and a rate below their own names; what they
    state of the times, and a note, come with it.
    """
    first = widths.index(width)
    stop = next((i for i in range(first, len(rows)) if widths[i] != width), len(rows))
    title = next((i for i in range(stop, len(rows)) if any(rows[i])), len(rows))
    after = next((i for i in range(title, len(rows)) if widths[i] == width), len(rows))
    if after == len(rows) or 2 * (stop - first) > widths.count(width):
        return first, (), ""
    above, below = rows[first - 1] if first else [], rows[title]
    names = len(set(below)) == width == len(below) and all(c[:1].isalpha() for c in below)
    if not names or below == above or (_says_units(above) and not _says_units(below)):
        return first, (), ""
    pairs = zip(above, rows[first], strict=False) if stop == first + 1 else ()
    note = (
        f"Numbers above the headers in line {title + 1} (line {first + 1}: "
        f"{shown(', '.join(rows[first]), 40)}) are no samples."
    )
    return after, stated_axes([f"{name},{number}" for name, number in pairs]), note


def _printed_otherwise(rows: Sequence[list[str]], width: int, decimal: str) -> int:
    """Return how many rows a table without headers begins with that are none of it.

    A program prints the numbers of a table alike: where all rows below have the same number of
    decimals in each column, one that has another in every column is a rate, a start or a count.
    """
    printed = [
        tuple(len(cell.partition(decimal)[2]) for cell in row) if len(row) == width else ()
        for row in rows
    ]
    below = set(printed[MOST_ABOVE:])
    if len(printed) < MOST_ABOVE + FEWEST or len(below) != 1:
        return 0
    usual = next(iter(below))
    odd = [
        len(here) == width and all(n != m for n, m in zip(here, usual, strict=True))
        for here in printed[:MOST_ABOVE]
    ]
    return odd.index(False) if False in odd else MOST_ABOVE


def _says_units(names: Sequence[str]) -> bool:
    """Return whether a row of names says that one is a time, or a unit."""
    return any(is_time(name) or split_header(name)[1] for name in names)


def _start(
    above: Sequence[list[str]],
    numbers: Sequence[int],
    titles: Sequence[int],
    comments: Sequence[bool],
    decimal: str,
) -> int:
    """Return the line with which the table begins: its first row, whatever became of it.

    Below headers that is the next line that is neither blank nor a comment. Without headers
    it is the first of the lines above the numbers that hold a number themselves.
    """
    first = len(above)
    if titles:
        below = range(titles[-1] + 1, first)
        return next((i for i in below if any(above[i]) and not comments[i]), first)
    while first and not comments[first - 1] and _is_row(
        above[first - 1], numbers[first - 1], decimal
    ):  # fmt: skip
        first -= 1
    return first


def _is_row(row: Sequence[str], numbers: int, decimal: str) -> bool:
    """Return whether a line without headers above it was meant as a row of numbers."""
    broken = any(is_number(cell, decimal) and not _WHOLE.fullmatch(cell) for cell in row)
    return any(row) and (broken or numbers > 1)


def _check_names(lines: Sequence[str], text_format: TextFormat, run: str) -> None:
    """Pass a table without names, or with one for each of its columns.

    Raises
    ------
    RecordingError
        If the line above the numbers names more columns, or fewer, than there are.
    """
    width = len(text_format.headers)
    above = [i for i in range(text_format.first) if lines[i].strip()]
    if text_format.headers != numbered(width) or not above:
        return
    names = cells_in_use(split(lines[above[-1]], text_format.delimiter))
    if (
        len(names) < 2
        or not _says_units(names)
        or any(is_number(n, text_format.decimal) for n in names)
    ):
        return
    advice = "Give each column a name"
    if text_format.delimiter == "," and width == 2 * len(names):
        advice = (
            "Numbers with decimal commas cannot stand between commas: export with semicolons "
            "or tabs between the columns"
        )
    raise RecordingError(
        f"{run}: line {above[-1] + 1} names {len(names)} columns ({shown(names[0], 20)} to "
        f"{shown(names[-1], 20)}), but the rows below it have {width}. {advice}."
    )


def _check_units_of_times(lines: Sequence[str], text_format: TextFormat, run: str) -> None:
    """Pass headers of which no two name a column as a time in two units.

    Raises
    ------
    RecordingError
        If there are such two.
    """
    pairs = zip_longest(
        text_format.headers, text_format.units[: len(text_format.headers)], fillvalue=""
    )
    used = [time_name(name, unit) for name, unit in pairs]
    for number, line in enumerate(lines[: text_format.first], start=1):
        row = split(line, text_format.delimiter)
        for cell, one in zip(row, used, strict=False):
            other = time_name(uncommented(cell), "")
            said = (one[1].casefold(), other[1].casefold()) if one and other else ("", "")
            if (
                len(row) == len(used)
                and all(said)
                and seconds_in(said[0]) != seconds_in(said[1])
            ):
                raise RecordingError(
                    f"{run}: line {number} names the time {shown(cell, 20)}, the header below "
                    f"it has it in {said[0]}. Delete the header that is wrong."
                )
