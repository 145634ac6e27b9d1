"""Read CSV: delimiter, decimal sign, headers, units and time column are found by looking."""

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.errors import RecordingError
from shakerproc.recordings.columns import SECONDS, Columns, file_of_columns, is_number
from shakerproc.recordings.guard import foreign, shown
from shakerproc.recordings.raw import RawFile
from shakerproc.recordings.si import parse_unit

LOOK: Final = 1 << 16
"""Bytes at the start from which the format is judged."""

LARGEST: Final = 1 << 31
"""Bytes of text that are read at most; text is held in memory whole."""

_FORMULAS: Final = {"'=", "'+", "'-", "'@"}
"""How text begins that was kept from being run by a spreadsheet."""

_FORMATS: Final = ((",", "."), (";", ","), (";", "."), ("\t", "."), ("\t", ","), (" ", "."))


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
    """

    encoding: str
    delimiter: str
    decimal: str
    first: int
    headers: tuple[str, ...]
    units: tuple[str, ...]


def read_csv(path: Path, run: str) -> RawFile:
    """Return the columns of a text file as channels.

    Raises
    ------
    RecordingError
        If it holds no table of numbers.
    """
    found = find_format(_look(path, run), run)
    values = read_numbers(path, found, run)
    values, cut, note = drop_torn_row(path, found, values)
    file = file_of_columns(Columns(found.headers, values, found.units), cut=cut)
    return replace(file, notes=(*file.notes, note)) if note else file


def _look(path: Path, run: str) -> bytes:
    try:
        if path.stat().st_size > LARGEST:
            raise RecordingError(
                f"{run}: {path.stat().st_size >> 20} MB of text are too many to hold in "
                "memory. Export the recording as TDMS instead."
            )
        with path.open("rb") as file:
            return file.read(LOOK)
    except OSError as error:
        raise RecordingError(f"{run}: cannot be opened: {error.strerror}.") from error


def start_of(path: Path, run: str) -> tuple[str, list[str]]:
    """Return the encoding of a text file and its first lines."""
    start = _look(path, run)
    encoding = encoding_of(start)
    return encoding, start.decode(encoding, errors="replace").splitlines()


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


def find_format(start: bytes, run: str) -> TextFormat:
    """Return how a text file holds its table, judged by its start.

    Raises
    ------
    RecordingError
        If no table of numbers is found.
    """
    if not start:
        raise RecordingError(f"{run}: the file is empty (0 bytes).")
    encoding = encoding_of(start)
    text = start.decode(encoding, errors="replace")
    lines = text.splitlines()
    if len(start) == LOOK and len(lines) > 1:
        lines = lines[:-1]  # the look ends inside it
    best: tuple[int, TextFormat] | None = None
    for delimiter, decimal in _FORMATS:
        found = _try_format(lines, encoding, delimiter, decimal)
        if found is not None and (best is None or found[0] > best[0]):
            best = found
    if best is None:
        raise RecordingError(
            f"{run}: no table of numbers in the first {len(lines)} lines; line 1 is "
            f"{shown(lines[0] if lines else '', 60)}. Columns separated by comma, semicolon or "
            "tab with one line of headers are read."
        )
    return best[1]


def split(line: str, delimiter: str) -> list[str]:
    """Return the cells of a line."""
    if delimiter == " ":
        return line.split()
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
    """Return the table that one pair of signs makes, with the number of its cells."""
    rows = [split(line, delimiter) for line in lines]
    while rows and not any(rows[-1]):
        rows.pop()
    first = len(rows)
    width = 0
    for i in range(len(rows) - 1, -1, -1):
        if not any(rows[i]):
            break
        numbers = sum(is_number(cell, decimal) for cell in rows[i])
        if numbers != sum(bool(cell) for cell in rows[i]):
            break
        if (
            width
            and len(rows[i]) != width
            and not (i == len(rows) - 2 and len(rows[i]) > width)
        ):
            break
        width = max(width, len(rows[i]))
        first = i
    if first == len(rows) or (delimiter != "," and width < 2):
        return None
    headers, units = _headers(rows[:first], width)
    cells = (len(rows) - first) * width
    return cells, TextFormat(encoding, delimiter, decimal, first, headers, units)


def _headers(above: Sequence[list[str]], width: int) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return names and units from the lines above the numbers."""
    fitting: list[list[str]] = []
    for row in reversed(above):
        if len(row) != width or len(fitting) == 2:
            break
        fitting.insert(0, row)
    if not fitting:
        return tuple(f"column {i + 1}" for i in range(width)), ()
    if len(fitting) == 2 and _are_units(fitting[1]):
        return tuple(fitting[0]), tuple(fitting[1])
    return tuple(fitting[-1]), ()


def _are_units(cells: Sequence[str]) -> bool:
    """Return whether a row holds units rather than names: most of its words are units."""
    words = [cell for cell in cells if cell]
    known = sum(word.casefold() in SECONDS or parse_unit(word) is not None for word in words)
    return 2 * known > len(words)


def read_numbers(
    path: Path, found: TextFormat, run: str, *, strings: Sequence[str] = ()
) -> FloatArray:
    """Return the numbers of the table, (n_columns, n_rows) array.

    Columns whose header is among `strings` hold text and come out as not a number.
    """
    import pandas as pd

    separator = r"\s+" if found.delimiter == " " else found.delimiter
    width = len(found.headers)
    texts = [i for i, header in enumerate(found.headers) if header in strings]
    with foreign(run, "reading the table of numbers"):
        frame = pd.read_csv(
            path,
            sep=separator,
            decimal=found.decimal,
            header=None,
            names=list(range(width)),
            skiprows=found.first,
            dtype={i: str if i in texts else np.float64 for i in range(width)},
            encoding=found.encoding,
            engine="c",
            index_col=False,
            skip_blank_lines=True,
            on_bad_lines="error",
        )
    for i in texts:
        frame[i] = np.nan
    return np.ascontiguousarray(frame.to_numpy(np.float64).T)


def unended(path: Path, found: TextFormat) -> list[str]:
    """Return the last lines of a text that does not end with a line end, else nothing."""
    with path.open("rb") as file:
        size = file.seek(0, io.SEEK_END)
        file.seek(max(0, size - LOOK))
        end = file.read()
    if end[-1:] in {b"\n", b"\r"} or end[-2:] in {b"\n\0", b"\r\0", b"\0\n", b"\0\r"}:
        return []
    if found.encoding == "utf-16":
        return ["", ""]  # which half of a letter it starts with cannot be told
    return end.decode(found.encoding, errors="replace").splitlines()[-50:]


def drop_torn_row(
    path: Path, found: TextFormat, values: FloatArray
) -> tuple[FloatArray, str, str]:
    """Return the complete rows, how the file stops short, and a note where that is in doubt."""
    lines = unended(path, found)
    if len(lines) < 2 or values.shape[1] < 2:
        return values, "", ""
    torn = np.isnan(values[:, -1]) & ~np.isnan(values[:, -2])
    if np.any(torn) or _is_shorter(lines, found):
        return values[:, :-1], f"it stops inside row {values.shape[1]}", ""
    return values, "", "The file does not end with a line end: its last number may be cut."


def _is_shorter(lines: Sequence[str], found: TextFormat) -> bool:
    """Return whether the last number has fewer decimals than all above it."""
    cells = [split(line, found.delimiter)[-1:] for line in lines[1:]]
    decimals = [len(c[0].partition(found.decimal)[2]) if c else 0 for c in cells]
    return len(decimals) > 1 and decimals[-1] < min(decimals[:-1])
