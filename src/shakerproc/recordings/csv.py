"""Read CSV and XLSX: how a table is written is found by looking; dates become seconds."""

import csv
import io
import re
import zipfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, date, datetime, time, timedelta, timezone
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO, Final, final

import numpy as np

from shakerproc.data import ArraySource
from shakerproc.errors import RecordingError
from shakerproc.recordings.columns import Columns, file_of_columns
from shakerproc.recordings.guard import first_bytes, foreign, shown
from shakerproc.recordings.raw import RawFile, RawGroup
from shakerproc.recordings.si import split_header
from shakerproc.recordings.text_format import find_format, looked_at, open_text
from shakerproc.recordings.text_rows import read_table, refusal, without_bad_rows
from shakerproc.recordings.times import is_time, time_columns

_STAMP: Final = re.compile(
    rb"(?:(?<=[,;\t ])|^)(?P<quote>[\"']?)"
    rb"(?:(?:(?P<y>\d{4})[-/.](?P<m>\d{1,2})[-/.](?P<d>\d{1,2})"
    rb"|(?P<a>\d{1,2})(?P<sign>[-/.])(?P<b>\d{1,2})[-/.](?P<y2>\d{4}))"
    rb"(?P<between>[T ] ?|[\"']?[,;\t][\"']?))?"
    rb"(?:(?P<hour>\d{1,2}):)?(?P<minute>\d{1,2}):(?P<second>\d{2})"
    rb"(?:(?P<point>[.:,])(?P<fraction>\d{1,12}))?"
    rb"(?: ?(?P<half>[AaPp])[Mm])?(?: ?(?P<zone>Z|[-+]\d{2}:?\d{2}))?"
    rb"(?P=quote)(?=[,;\t ]|\r?\n?$)"
)
"""A date, where there is one, and a time of day: hours, minutes and seconds, or minutes and
seconds with a fraction. Between them stands a blank, a T, or the sign between two cells."""

_DECIMAL_COMMA: Final = re.compile(rb"[;\t][-+]?\d+,\d")

DAY: Final = 86400
HOUR: Final = 3600


@final
@dataclass(slots=True)
class _Clock:
    """One column of stamps, while its lines go by.

    Attributes
    ----------
    first : date, optional
        Day of the first stamp, where it says it.
    last : float
        The stamp before [s].
    turns : int
        Seconds of the days, or hours, that have passed by what the stamps do not say.
    """

    first: date | None = None
    last: float | None = None
    turns: int = 0


@final
@dataclass(slots=True, eq=False)
class Stamps:
    """The stamps of a text file.

    Attributes
    ----------
    decimal : bytes
        Sign between whole and fraction of the numbers in the file.
    start : datetime, optional
        Midnight before the first stamp, where it says its day.
    cells : int
        How many cells a stamp takes, 2 where date and time have one each.
    column : int
        Which column the time stands in.
    dated : bool
        Whether stamps say their day; one without it stays text.
    """

    decimal: bytes
    start: datetime | None
    cells: int
    column: int
    dated: bool
    _clocks: list[_Clock] = field(default_factory=list)

    def named(self, headers: Sequence[str]) -> tuple[str, ...]:
        """Return headers, the one of the time stamps renamed to seconds."""
        name = split_header(headers[self.column])[0] if self.column < len(headers) else ""
        mine = f"{name if is_time(name) else 'time'} [s]"
        return tuple(mine if at == self.column else h for at, h in enumerate(headers))

    def rewind(self) -> None:
        """Begin with the first line again."""
        self._clocks.clear()

    def replaced(self, line: bytes) -> bytes:
        """Return a line with seconds since the first midnight in place of its stamps."""
        parts, at = [], 0
        for number, match in enumerate(_STAMP.finditer(line)):
            if not _is_stamp(match) or (self.dated and _day(match) is None):
                continue
            while len(self._clocks) <= number:
                self._clocks.append(_Clock())
            parts += [line[at : match.start()], self._seconds(match, self._clocks[number])]
            at = match.end()
        return b"".join([*parts, line[at:]])

    def _seconds(self, match: re.Match[bytes], clock: _Clock) -> bytes:
        """Return a stamp as a number, with the digits of its fraction."""
        second = _second_of_day(match)
        day = _day(match)
        if day is not None:
            clock.first = clock.first or day
            second += DAY * (day - clock.first).days
        else:
            turn = DAY if match["hour"] else HOUR
            if clock.last is not None and second < clock.last - turn / 2:
                clock.turns += turn
            clock.last = second
            second += clock.turns
        number = b"%d" % second
        if match["fraction"]:
            number += self.decimal + match["fraction"]
        between = match["between"] or b""
        cell = between.strip(b"\"' T")  # the date had a cell of its own
        return cell + number


def stamps_of(lines: Sequence[str]) -> Stamps | None:
    """Return how the lines at the start of a text hold dates or times; None where they do not.

    Most lines have to.
    """
    raw = [line.encode("utf-8", errors="replace") for line in lines if line.strip()]
    matches = [m for line in raw if (m := _first(line)) is not None]
    if not matches or 2 * len(matches) < len(raw):
        return None
    days = [match for match in matches if _day(match) is not None]
    dated = 2 * len(days) > len(matches)
    first = (days if dated else matches)[0]
    before = first.string[: first.start()]
    commas = sum(_DECIMAL_COMMA.search(match.string) is not None for match in matches)
    separator = (first["between"] or b"").strip(b"\"' T")
    signs = separator or next((s for s in (b"\t", b";", b",") if s in first.string), b" ")
    return Stamps(
        decimal=b"," if 2 * commas > len(matches) and signs != b"," else b".",
        start=_midnight(days if dated else matches),
        cells=2 if separator else 1,
        column=(before.count(signs) if signs != b" " else len(before.split()))
        + bool(separator),
        dated=dated,
    )


def _first(line: bytes) -> re.Match[bytes] | None:
    return next((match for match in _STAMP.finditer(line) if _is_stamp(match)), None)


def _is_stamp(match: re.Match[bytes]) -> bool:
    """Return whether a match is a time of day: minutes alone need a fraction of a second."""
    if match["hour"] is None and (match["fraction"] is None or match["point"] == b":"):
        return False
    if match["point"] == b"," and not re.search(rb"[;\t]", match.string):
        return False  # the comma is the sign between cells
    hour, minute = int(match["hour"] or 0), int(match["minute"])
    return hour < 24 and minute < 60 and int(match["second"]) < 61


def _second_of_day(match: re.Match[bytes]) -> int:
    hour = int(match["hour"] or 0)
    if match["half"]:
        hour = hour % 12 + 12 * (match["half"] in b"Pp")
    return 3600 * hour + 60 * int(match["minute"]) + int(match["second"])


def _day(match: re.Match[bytes]) -> date | None:
    """Return the day of a stamp; of one that may be read in two ways, the day first."""
    try:
        if match["y"]:
            return date(int(match["y"]), int(match["m"]), int(match["d"]))
        if match["y2"]:
            day, month = int(match["a"]), int(match["b"])
            day, month = (month, day) if month > 12 else (day, month)
            return date(int(match["y2"]), month, day)
    except ValueError:
        return None
    return None


def _midnight(stamps: Sequence[re.Match[bytes]]) -> datetime | None:
    """Return the midnight before the first stamp, taken as UTC where no zone is said.

    None where it says no day, or one that may be read in two ways.
    """
    first = stamps[0]
    day = _day(first)
    two_ways = (
        first["a"] and first["sign"] == b"/" and max(int(first["a"]), int(first["b"])) < 13
    )
    if day is None or two_ways:
        return None
    return datetime.combine(day, time(), _zone(first["zone"]))


def _zone(text: bytes | None) -> timezone:
    if text is None or text == b"Z":
        return UTC
    digits = text[1:].replace(b":", b"")
    away = timedelta(hours=int(digits[:2]), minutes=int(digits[2:]))
    return timezone(-away if text[:1] == b"-" else away)


@final
class StampedFile:
    """A text file that is read with numbers in place of its stamps.

    Parameters
    ----------
    file : file
        Open; one byte for each digit.
    stamps : Stamps
        How it holds them.
    """

    def __init__(self, file: BinaryIO, stamps: Stamps) -> None:
        self._file = file
        self._stamps = stamps
        self._rest = b""

    def read(self, size: int) -> bytes:
        """Return some more lines, the last of them whole unless the file ends in it."""
        while block := self._file.read(size):
            lines = (self._rest + block).splitlines(keepends=True)
            self._rest = b"" if lines[-1].endswith((b"\n", b"\r")) else lines.pop()
            if lines:
                return b"".join(map(self._stamps.replaced, lines))
        last, self._rest = self._rest, b""
        return self._stamps.replaced(last)

    def seek(self, place: int) -> int:
        """Go to the start of the file."""
        self._stamps.rewind()
        self._rest = b""
        return self._file.seek(place)

    def __enter__(self) -> "StampedFile":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._file.close()


def read_csv(path: Path, run: str) -> RawFile:
    """Return the columns of a text file as channels.

    Raises
    ------
    RecordingError
        If it holds no table of numbers.
    """
    return table_of(*open_text(path, run), run)


def table_of(file: BinaryIO, encoding: str, lines: list[str], run: str) -> RawFile:
    """Return the columns of an open text as channels; arguments as `open_text` returns them.

    Raises
    ------
    RecordingError
        If it holds no table of numbers.
    """
    stamps = stamps_of(lines)
    with file:
        if stamps is None:
            text_format = find_format(lines, encoding, run)
            table = read_table(file, text_format, run)
        else:
            plain = [stamps.replaced(line.encode()).decode() for line in lines]
            text_format = find_format(plain, encoding, run)
            units = tuple(
                "" if at == stamps.column else u for at, u in enumerate(text_format.units)
            )
            text_format = replace(
                text_format, headers=stamps.named(text_format.headers), units=units
            )
            table = read_table(StampedFile(file, stamps), text_format, run)
    axes = time_columns(text_format.headers, text_format.units)
    times = table.values[axes[0]] if axes else None
    values, skipped = without_bad_rows(table.values, table.bad, times)
    raw = file_of_columns(
        Columns(text_format.headers, values, text_format.units),
        axes=text_format.axes,
        start_time=text_format.start_time if stamps is None else stamps.start,
        cut=table.torn,
    )
    notes = (*([text_format.note] if text_format.note else []), *raw.notes)
    if table.unended:
        notes += ("The file does not end with a line end: its last number may be cut.",)
    if skipped is None:
        return replace(raw, notes=notes)
    return replace(
        raw,
        notes=(skipped.message, *notes),
        skipped=skipped,
        refusal=refusal(table.bad, len(text_format.headers)),
    )


LARGEST: Final = 1 << 30
"""Bytes of a workbook once it is unpacked; a row of five cells takes some 300."""

_OLD: Final = b"\xd0\xcf\x11\xe0"
"""How workbooks begin that are encrypted, and those of before 2007."""


def read_xlsx(path: Path, run: str) -> RawFile:
    """Return the sheets of a workbook that hold a table of numbers, a group each.

    Raises
    ------
    RecordingError
        If none does, or it is encrypted.
    """
    if first_bytes(path, run, 4) == _OLD:
        raise RecordingError(
            f"{run}: is encrypted, or a workbook of before 2007. Save it as .xlsx without "
            "a password."
        )
    raw_files: dict[str, RawFile] = {}
    problems: dict[str, RecordingError] = {}
    for name, content in _sheets(path, run):
        try:
            raw_files[name] = table_of(*looked_at(io.BytesIO(content), run), run)
        except RecordingError as error:
            problems[name] = error
    if not raw_files:
        text = "; ".join(str(one) for one in list(problems.values())[:4])
        raise RecordingError(text or f"{run}: the workbook is empty.")
    notes = tuple(f"Sheet {shown(name)} holds no table of numbers." for name in problems)
    if len(raw_files) == 1:
        (raw,) = raw_files.values()
        return replace(raw, notes=(*raw.notes, *notes))
    return _joined(raw_files, notes, run)


def _joined(sheets: dict[str, RawFile], notes: tuple[str, ...], run: str) -> RawFile:
    """Return several sheets as one file.

    Raises
    ------
    RecordingError
        If one has lines that are no rows.
    """
    groups: list[RawGroup] = []
    values: list[Any] = []
    for name, raw in sheets.items():
        if raw.skipped is not None:
            raise RecordingError(f"{run}: sheet {shown(name)}: {raw.refusal} Repair the sheet.")
        channels = raw.groups[0].channels
        groups.append(
            RawGroup(name, tuple(replace(c, row=c.row + len(values)) for c in channels))
        )
        if isinstance(raw.source, ArraySource):
            values += list(raw.source.samples)
        notes += tuple(f"{name}: {note}" for note in raw.notes)
    joined = np.full((len(values), max(row.size for row in values)), np.nan)
    for number, row in enumerate(values):
        joined[number, : row.size] = row
    return RawFile(tuple(groups), ArraySource(joined), notes)


def _sheets(path: Path, run: str) -> Iterator[tuple[str, bytes]]:
    """Yield name and text of each sheet that is not empty.

    Raises
    ------
    RecordingError
        If it is no workbook, or too large.
    """
    import openpyxl

    with foreign(run, "opening the workbook"):
        with zipfile.ZipFile(path) as archive:
            unpacked = sum(entry.file_size for entry in archive.infolist())
        if unpacked > LARGEST:
            raise RecordingError(
                f"{run}: {unpacked >> 20} MB once unpacked are too many to hold in memory. "
                "Export the recording as CSV or TDMS instead."
            )
        book = openpyxl.load_workbook(path, read_only=True, data_only=True)
    try:
        for sheet in book.worksheets:
            with foreign(run, f"reading sheet {shown(sheet.title)}"):
                content = _text(sheet.iter_rows(values_only=True))
            if content.strip(b",\r\n"):
                yield sheet.title, content
    finally:
        book.close()


def _text(rows: Any) -> bytes:
    """Return rows as a table of text, without empty ones at the end."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    empty = 0
    for row in rows:
        cells = [_cell(cell) for cell in row]
        while cells and not cells[-1]:
            cells.pop()
        if not cells:
            empty += 1
            continue
        text.write("\n" * empty)
        writer.writerow(cells)
        empty = 0
    return text.getvalue().encode()


def _cell(cell: Any) -> str:
    """Return a cell as text; numbers with all their digits."""
    if cell is None:
        return ""
    if isinstance(cell, datetime):
        return cell.isoformat(" ")
    return cell.isoformat() if isinstance(cell, time) else str(cell)
