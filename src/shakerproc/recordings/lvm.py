"""Read LVM, LabVIEW's text format: two headers, then columns that may be of unequal length."""

import re
from collections.abc import Sequence
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

from shakerproc.data import ArraySource, FloatArray
from shakerproc.errors import RecordingError
from shakerproc.recordings.columns import length_of
from shakerproc.recordings.guard import AGAIN, shown
from shakerproc.recordings.raw import RawChannel, RawFile, RawGroup
from shakerproc.recordings.skipped import refusal, without_bad_rows
from shakerproc.recordings.text_format import TextFormat, open_text
from shakerproc.recordings.text_rows import read_table
from shakerproc.recordings.time_axis import TimeAxis, half_digit
from shakerproc.recordings.times import axis_of_column, is_time

_END: Final = "***End_of_Header***"
_LINE: Final = re.compile(r"(?P<name>[A-Za-z_ ]+)[,;\t](?P<value>.*)")
_SIGNS: Final = re.compile(r"[,;\t]")
_SEPARATORS: Final = {"tab": "\t", "comma": ",", "semicolon": ";"}


def read_lvm(path: Path, run: str) -> RawFile:
    """Return the columns of a LabVIEW measurement file as channels.

    Raises
    ------
    RecordingError
        If its headers are not those of the format, or a channel is longer than they say.
    """
    file, encoding, lines = open_text(path, run)
    with file:
        head = _Head(lines, run)
        found = TextFormat(
            encoding, head.separator, head.decimal, head.first, head.titles, (), remark=True
        )
        table = read_table(file, found, run)
    axis = next(iter(head.times), None)
    timed = axis is not None and length_of(table.values[axis]) == table.values.shape[1] > 0
    times = table.values[axis] if timed and axis is not None else None
    values, skipped = without_bad_rows(table.values, table.bad, times)
    lengths = [length_of(row) for row in values]
    promised = [head.number("Samples", row, lengths[row]) for row in range(len(head.titles))]
    if table.unended and any(promised[row] > lengths[row] for row in head.rows):
        values = values[:, :-1]  # its last number may be cut
        lengths = [length_of(row) for row in values]
    if skipped is None:
        _check_lengths(head, lengths, promised, run)
    more = int(bool(table.torn))
    wanted = [max(p, n + more) for p, n in zip(promised, lengths, strict=True)]
    channels = _channels(head, values, lengths, wanted)
    less = [c.name for c in channels if c.n_samples < c.promised]
    notes = [] if skipped is None else [skipped.message]
    if less:
        notes.append(f"The file is not whole: {shown(less[0])} is shorter than it says.")
    return RawFile(
        (RawGroup("", channels),),
        ArraySource(values),
        tuple(notes),
        skipped,
        refusal(table.bad, len(head.titles)) if skipped else "",
    )


def _check_lengths(
    head: "_Head", lengths: Sequence[int], promised: Sequence[int], run: str
) -> None:
    """Pass channels that are no longer than the headers say.

    Raises
    ------
    RecordingError
        If one is.
    """
    for row in head.rows:
        if lengths[row] > promised[row]:
            raise RecordingError(
                f"{run}: {shown(head.titles[row])} holds {lengths[row]} values but Samples "
                f"says {promised[row]}. {AGAIN}"
            )


def _channels(
    head: "_Head", values: FloatArray, lengths: Sequence[int], promised: Sequence[int]
) -> tuple[RawChannel, ...]:
    """Return the channels, with how many samples each has and should have, by column.

    The steps and times of all are stated of each: a column of times is that of the file.
    """
    stepped = [axis for row in head.rows if (axis := head.axis(row))]
    timed = [
        replace(
            axis_of_column(head.titles[row], "", values[row, : lengths[row]]),
            quantity=head.text("X_Dimension", head.rows[0]),
        )
        for row in head.times
        if lengths[row]
    ]
    starts = {row: head.starts(row) for row in head.rows}
    every = {
        start: tuple(replace(axis, start=start[0], start_digit=start[1]) for axis in stepped)
        + tuple(timed)
        for start in starts.values()
    }
    return tuple(
        RawChannel(
            name=head.titles[row],
            row=row,
            n_samples=lengths[row],
            promised=promised[row],
            unit=head.text("Y_Unit_Label", row),
            start_time=head.moment(row),
            problem="" if lengths[row] else "it holds no numbers",
            axes=every[starts[row]],
        )
        for row in head.rows
    )


class _Head:
    """The headers of an LVM file, a line by its first cell.

    Raises
    ------
    RecordingError
        If they are not those of the format.
    """

    def __init__(self, lines: Sequence[str], run: str) -> None:
        if not lines or not lines[0].startswith("LabVIEW Measurement"):
            raise RecordingError(f"{run}: line 1 does not say LabVIEW Measurement. {AGAIN}")
        named = [_SIGNS.split(line, maxsplit=1)[0].strip() for line in lines]
        ends = [i for i, name in enumerate(named) if name == _END]
        if len(ends) < 2 or ends[1] + 1 >= len(lines):
            raise RecordingError(f"{run}: the second {_END} of an LVM file is missing. {AGAIN}")
        first = dict(_pair(line) for line in lines[: ends[0]])
        self.separator = _SEPARATORS.get(first.get("Separator", "Tab").casefold(), "\t")
        self.decimal = first.get("Decimal_Separator", ".") or "."
        if self.decimal not in {".", ","}:
            raise RecordingError(f"{run}: the decimal sign {shown(self.decimal)} is unknown.")
        self.first = ends[1] + 2
        titles = [c.strip() for c in lines[ends[1] + 1].split(self.separator)]
        while titles and titles[-1] in {"Comment", ""}:
            titles.pop()
        self.titles = tuple(titles)
        middle = [line.split(self.separator) for line in lines[ends[0] + 1 : ends[1]]]
        self._cells = {cells[0].strip(): [c.strip() for c in cells[1:]] for cells in middle}
        self.times = [row for row, title in enumerate(self.titles) if is_time(title)]
        self.rows = [
            row for row, title in enumerate(self.titles)
            if title not in {"X_Value", ""} and row not in self.times
        ]  # fmt: skip
        if not self.rows:
            raise RecordingError(f"{run}: line {self.first} names no channels. {AGAIN}")

    def moment(self, row: int) -> datetime | None:
        """Return when time 0 of a channel is."""
        return _moment(self.text("Date", row), self.text("Time", row))

    def text(self, name: str, row: int) -> str:
        """Return the cell of a header line above a column of the table."""
        cells = self._cells.get(name, [])
        return cells[row - 1] if 1 <= row <= len(cells) else ""

    def number(self, name: str, row: int, otherwise: int) -> int:
        """Return the whole number of such a cell."""
        text = self.text(name, row)
        return int(text) if text.isdecimal() and len(text) < 12 else otherwise

    def axis(self, row: int) -> TimeAxis | None:
        """Return what the header states of the times of a channel; None where nothing."""
        text, quantity = self.text("Delta_X", row), self.text("X_Dimension", row)
        step = self._real(text)
        where = f"Delta_X of {shown(self.titles[row])}"
        if step is None and not quantity:
            return None
        digit = half_digit(text, self.decimal)
        return TimeAxis(where, step=step, quantity=quantity, digit=digit)

    def starts(self, row: int) -> tuple[float, float]:
        """Return the time of the first sample of a channel, and half of its last digit."""
        text = self.text("X0", row)
        return self._real(text) or 0.0, half_digit(text, self.decimal)

    def _real(self, text: str) -> float | None:
        try:
            return float(text.replace(self.decimal, "."))
        except ValueError:
            return None


def _pair(line: str) -> tuple[str, str]:
    """Return name and value of a header line; the value may be a separator itself."""
    match = _LINE.fullmatch(line.strip())
    if match is None:
        return line.strip(), ""
    value = match["value"]
    return match["name"].strip(), value.rstrip(",;\t ") or value[:1]


def _moment(date: str, time: str) -> datetime | None:
    """Return the start; LVM gives local time without saying where, taken as UTC."""
    try:
        return datetime.strptime(f"{date} {time[:15]}", "%Y/%m/%d %H:%M:%S.%f").replace(
            tzinfo=UTC
        )
    except ValueError:
        return None
