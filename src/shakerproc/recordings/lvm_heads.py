"""Headers of an LVM file: their places, and the description of the table below them.

A file has one header of its own, and a header before each segment or before the first only. A
program that appends to a file writes both again.
"""

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from mmap import mmap
from types import MappingProxyType
from typing import Final, final

from shakerproc.errors import RecordingError
from shakerproc.recordings.guard import AGAIN, shown
from shakerproc.recordings.raw import TimeAxis, half_digit
from shakerproc.recordings.times import is_time

_END: Final = "***End_of_Header***"
_MARK: Final = re.compile(rb"(?<![^\r\n])\*\*\*End_of_Header\*\*\*[^\r\n]*(?:\r\n|\r|\n|\Z)")
_LINE: Final = re.compile(r"(?P<name>[A-Za-z_ ]+)[,;\t](?P<value>.*)")
_TAG: Final = re.compile(r"(?!X_Value)[A-Za-z][A-Za-z0-9_ ]*|\*\*\*\w+\*\*\*|(?=$)")
"""First cell of a line above a table: its name, or nothing if the line is blank."""
_SIGNS: Final = re.compile(r"[,;\t]")
_SEPARATORS: Final = {"tab": "\t", "comma": ",", "semicolon": ";"}
_LONGEST: Final = 1 << 22
"""Bytes of a header: 10,000 channels take 1 MB."""
_READ: Final = frozenset({
    "Separator", "Decimal_Separator", "Multi_Headings", "X_Columns", "Date", "Time", "Samples",
    "X0", "Delta_X", "X_Dimension", "X_Unit_Label", "Y_Unit_Label",
})  # fmt: skip
"""Names of header lines that are read."""
_DATE: Final = re.compile(r"(\d{4})[/.-](\d{1,2})[/.-](\d{1,2})")
_TIME: Final = re.compile(r"(\d{1,2}):(\d{2}):(\d{2})(?:[.,](\d{1,6})\d*)?")


@final
@dataclass(frozen=True, slots=True)
class Head:
    """The headers above a table.

    Attributes
    ----------
    file : mapping
        What the header of the file says, by name.
    cells : mapping
        What that of the segment says, a cell for each column, by name.
    titles : tuple of str
        Names of the columns of the table.
    first : int
        Line of its first row, from 0.
    start, stop : int
        Bytes of its rows.
    cut : bool
        Whether the file ends inside a header below it.
    """

    file: Mapping[str, str]
    cells: Mapping[str, Sequence[str]]
    titles: tuple[str, ...]
    first: int
    start: int
    stop: int
    cut: bool = False

    @property
    def separator(self) -> str:
        """Sign between cells."""
        return separator_of(self.file)

    @property
    def decimal(self) -> str:
        """Sign between whole and fraction."""
        return self.file.get("Decimal_Separator", ".") or "."

    @property
    def many_writes(self) -> bool:
        """Whether a table may hold several writes, of which the header counts the first."""
        return self.file.get("Multi_Headings", "").casefold() == "no"

    def writes(self, row: int, there: int) -> int:
        """Return how many writes so many samples of a channel come to, the last one whole.

        Where the file does not say whether it may hold several, they are only if all are whole.
        """
        size = self.samples(row)
        silent = "Multi_Headings" not in self.file and size and there % size == 0
        return max(-(-there // size), 1) if size and (self.many_writes or silent) else 1

    @property
    def time_per_channel(self) -> bool:
        """Whether every channel has a column of times before it."""
        return self.file.get("X_Columns", "").casefold() == "multi"

    @property
    def times(self) -> list[int]:
        """Columns that are times."""
        return [row for row, title in enumerate(self.titles) if is_time(title)]

    @property
    def rows(self) -> list[int]:
        """Columns that are channels."""
        times = set(self.times)
        return [
            row for row, title in enumerate(self.titles)
            if title not in {"X_Value", ""} and row not in times
        ]  # fmt: skip

    def text(self, name: str, row: int) -> str:
        """Return the cell of a header line above a column of the table."""
        cells = self.cells.get(name, ())
        at = row - (self.titles[0] == "X_Value")
        return cells[at] if 0 <= at < len(cells) else ""

    def samples(self, row: int) -> int:
        """Return how many samples of a channel the header counts; 0 where it does not say."""
        text = self.text("Samples", row)
        return int(text) if text.isdecimal() and len(text) < 12 else 0

    def moment(self, row: int) -> datetime | None:
        """Return when time 0 of a channel is."""
        return _moment(
            self.text("Date", row) or self.file.get("Date", ""),
            self.text("Time", row) or self.file.get("Time", ""),
        )

    def axis(self, row: int) -> TimeAxis | None:
        """Return the header's statement on the times of a channel; None where it has none."""
        text, quantity = self.text("Delta_X", row), self.text("X_Dimension", row)
        step = self.number("Delta_X", row)
        where = f"Delta_X of {shown(self.titles[row])}"
        if step is None and not quantity:
            return None
        digit = half_digit(text, self.decimal)
        unit = self.text("X_Unit_Label", row)
        return TimeAxis(where, step=step, quantity=quantity, unit=unit, digit=digit)

    def starts(self, row: int) -> tuple[float, float]:
        """Return the time of the first sample of a channel, and half of its last digit.

        It is NaN where something else stands there.
        """
        text = self.text("X0", row)
        start = self.number("X0", row) if text.strip() else 0.0
        return math.nan if start is None else start, half_digit(text, self.decimal)

    def number(self, name: str, row: int) -> float | None:
        """Return the number in the cell of a header line; None where it holds none."""
        try:
            return float(self.text(name, row).replace(self.decimal, "."))
        except ValueError:
            return None


def separator_of(header: Mapping[str, str]) -> str:
    """Return the sign between cells that the header of a file says."""
    return _SEPARATORS.get(header.get("Separator", "Tab").casefold(), "\t")


def heads_of(content: mmap | bytes, encoding: str, run: str) -> list[Head]:
    """Return the headers of every table of an LVM file.

    Raises
    ------
    RecordingError
        If they are not those of the format.
    """
    if not content[:64].lstrip(b"\xef\xbb\xbf").startswith(b"LabVIEW Measurement"):
        raise RecordingError(f"{run}: line 1 does not say LabVIEW Measurement. {AGAIN}")
    marks = [(mark.start(), mark.end()) for mark in _MARK.finditer(content)]
    header: Mapping[str, str] = MappingProxyType({})
    heads: list[Head] = []
    counted, line, above = 0, 0, 0
    for number, (mark, below) in enumerate(marks):
        before = marks[number - 1][1] if number else 0
        between = content[max(before, mark - _LONGEST) : mark]
        if number == 0 or before == above:  # no table stands between two headers
            _check_only_tags(between, before, run)
        tags = list(_tags(between, encoding))
        if any(_first(tag) == "LabVIEW Measurement" for tag in tags):
            pairs = _by_name(((name, (said,)) for name, said in map(_pair, tags)), run)
            header = MappingProxyType({name: said for name, (said,) in pairs.items()})
            _check(header, run)
            above = below
            continue
        after = marks[number + 1][0] if number + 1 < len(marks) else len(content)
        line += content[counted:below].count(b"\n")
        counted = below
        rows = below + len(_line_at(content, below))
        tail = _tags_as_they_are(content[max(rows, after - _LONGEST) : after])
        unfinished = number + 1 == len(marks) and any(
            _first(tag.decode("latin-1")) for tag in tail
        )
        place = (line + 1, rows, after - sum(map(len, tail)), unfinished)
        cells = _by_name((_cells(tag, separator_of(header)) for tag in tags), run)
        heads.append(_head(content[below:rows], encoding, header, cells, place))
        if not heads[-1].rows:
            raise RecordingError(f"{run}: line {line + 1} names no channels. {AGAIN}")
    if not heads or not heads[0].titles:
        raise RecordingError(f"{run}: the second {_END} of an LVM file is missing. {AGAIN}")
    return heads


def _check_only_tags(between: bytes, place: int, run: str) -> None:
    """Pass a text that holds nothing but the lines of a header.

    Raises
    ------
    RecordingError
        If rows of numbers stand there too: the end of a header is missing.
    """
    missing = len(between) - sum(map(len, _tags_as_they_are(between)))
    if missing > 0:
        raise RecordingError(
            f"{run}: byte {place}: the second {_END} of an LVM file is missing, or that of a "
            f"header further on. {AGAIN}"
        )


def _check(header: Mapping[str, str], run: str) -> None:
    """Pass a header of a file whose signs are known.

    Raises
    ------
    RecordingError
        If they are not.
    """
    decimal = header.get("Decimal_Separator", ".") or "."
    if decimal not in {".", ","}:
        raise RecordingError(f"{run}: the decimal sign {shown(decimal)} is unknown.")
    if decimal == "," == separator_of(header):
        raise RecordingError(
            f"{run}: the header says that commas stand between cells and before decimals. "
            "Export it with tabs."
        )


def _head(
    title: bytes,
    encoding: str,
    header: Mapping[str, str],
    cells: Mapping[str, Sequence[str]],
    place: tuple[int, int, int, bool],
) -> Head:
    text = title.decode(encoding, errors="replace")
    titles = [cell.strip() for cell in text.split(separator_of(header))]
    while titles and titles[-1].casefold() in {"comment", ""}:
        titles.pop()
    return Head(header, cells, tuple(titles), *place)


def _by_name(
    lines: Iterable[tuple[str, tuple[str, ...]]], run: str
) -> dict[str, tuple[str, ...]]:
    """Return the cells of header lines, by name.

    Raises
    ------
    RecordingError
        If two lines that are read have one name and say different things.
    """
    texts: dict[str, tuple[str, ...]] = {}
    for name, cells in lines:
        if name in _READ and texts.get(name, cells) != cells:
            before, after = (
                shown(" ".join(filter(None, dict.fromkeys(one))))
                for one in (texts[name], cells)
            )
            raise RecordingError(
                f"{run}: a header of this LVM file has two lines {name}: {before} and {after}. "
                "Delete the wrong one."
            )
        texts[name] = cells
    return texts


def _cells(line: str, separator: str) -> tuple[str, tuple[str, ...]]:
    """Return the name of a header line above a table, and its cells."""
    name, *cells = (cell.strip() for cell in line.rstrip("\r\n").split(separator))
    return name, tuple(cells)


def _line_at(content: mmap | bytes, at: int) -> bytes:
    end = content.find(b"\n", at)
    return content[at : end + 1] if end >= 0 else content[at:]


def _tags(text: bytes, encoding: str) -> Iterator[str]:
    """Yield the header lines with which a text ends, without blocks of other programs."""
    inside = False
    for line in _tags_as_they_are(text):
        tag = line.decode(encoding, errors="replace")
        inside = inside or _first(tag) == "***Start_Special***"
        if not inside and _first(tag):
            yield tag
        inside = inside and _first(tag) != "***End_Special***"


def _tags_as_they_are(text: bytes) -> list[bytes]:
    """Return the header and blank lines with which a text ends."""
    lines = text.splitlines(keepends=True)
    at, special = len(lines), False
    while at:
        first = _first(lines[at - 1].decode("latin-1"))
        special = special or first == "***End_Special***"
        if not special and not _TAG.fullmatch(first):
            break
        special = special and first != "***Start_Special***"
        at -= 1
    return lines[at:]


def _first(line: str) -> str:
    """Return the first cell of a line; a row of numbers without a time begins with none."""
    cells = _SIGNS.split(line.lstrip("\ufeff\u00ef\u00bb\u00bf").strip("\r\n"))
    first = cells[0].strip()
    return first or ("0" if any(cell.strip() for cell in cells) else "")


def _pair(line: str) -> tuple[str, str]:
    """Return name and value of a header line; the value may be a separator itself."""
    match = _LINE.fullmatch(line.strip())
    if match is None:
        return line.strip(), ""
    value = match["value"]
    return match["name"].strip(), value.rstrip(",;\t ") or value[:1]


def _moment(date: str, time: str) -> datetime | None:
    """Return the start; LVM gives local time without saying where, taken as UTC."""
    day, clock = _DATE.fullmatch(date.strip()), _TIME.fullmatch(time.strip())
    if day is None or clock is None:
        return None
    year, month, number = map(int, day.groups())
    hour, minute, second = map(int, clock.groups()[:3])
    microseconds = int((clock[4] or "0").ljust(6, "0"))
    try:
        return datetime(year, month, number, hour, minute, second, microseconds, tzinfo=UTC)
    except ValueError:
        return None
