"""Read LVM, LabVIEW's text format: two headers, then columns that may be of unequal length."""

import re
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

import numpy as np

from shakerproc.data import ArraySource, FloatArray
from shakerproc.errors import RecordingError
from shakerproc.recordings.columns import length_of
from shakerproc.recordings.guard import AGAIN, shown
from shakerproc.recordings.rates import CONTRADICTION
from shakerproc.recordings.raw import SILENT, RawChannel, RawFile, RawGroup
from shakerproc.recordings.skipped import refusal, without_bad_rows
from shakerproc.recordings.text_format import TextFormat, open_text
from shakerproc.recordings.text_rows import read_table
from shakerproc.recordings.times import is_time, rate_of_times

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
    axis = next((i for i, title in enumerate(head.titles) if is_time(title)), None)
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
    channels = _channels(head, _Rates(head, values, lengths), lengths, wanted)
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
    head: "_Head", rates: "_Rates", lengths: Sequence[int], promised: Sequence[int]
) -> tuple[RawChannel, ...]:
    """Return the channels, with how many samples each has and should have, by column."""
    return tuple(
        RawChannel(
            name=head.titles[row],
            row=row,
            n_samples=lengths[row],
            promised=promised[row],
            unit=head.text("Y_Unit_Label", row),
            sample_rate=rates.agreed,
            rate_problem=rates.problem,
            rate_hint=rates.hint,
            start_time=head.start,
            problem="" if lengths[row] else "it holds no numbers",
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
        self.rows = [
            row for row, title in enumerate(self.titles)
            if title not in {"X_Value", ""} and not is_time(title)
        ]  # fmt: skip
        if not self.rows:
            raise RecordingError(f"{run}: line {self.first} names no channels. {AGAIN}")
        self.start = _moment(self.text("Date", 1), self.text("Time", 1))

    def text(self, name: str, row: int) -> str:
        """Return the cell of a header line above a column of the table."""
        cells = self._cells.get(name, [])
        return cells[row - 1] if 1 <= row <= len(cells) else ""

    def number(self, name: str, row: int, otherwise: int) -> int:
        """Return the whole number of such a cell."""
        text = self.text(name, row)
        return int(text) if text.isdecimal() and len(text) < 12 else otherwise

    def step(self, row: int) -> float | None:
        """Return the step of a channel [s]."""
        try:
            return float(self.text("Delta_X", row).replace(self.decimal, "."))
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


class _Rates:
    """The sample rates that an LVM file gives, and whether they agree."""

    def __init__(self, head: _Head, values: FloatArray, lengths: Sequence[int]) -> None:
        said: dict[float, list[str]] = {}
        self.problem = ""
        for row in head.rows:
            step = head.step(row)
            if step is not None and np.isfinite(step) and step > 0.0:
                said.setdefault(1.0 / step, []).append(head.titles[row])
            elif step is not None:
                self.problem = f"Delta_X of {shown(head.titles[row])} is {step:g} s"
        texts = {
            rate: f"Delta_X of {', '.join(map(shown, names))}" for rate, names in said.items()
        }
        for row, title in enumerate(head.titles):
            if is_time(title) and lengths[row]:
                rate, problem = rate_of_times(values[row, : lengths[row]])
                self.problem = self.problem or ("" if rate else problem)
                if rate:
                    before = f"{texts[rate]}, " if rate in texts else ""
                    texts[rate] = f"{before}column {shown(title)}"
        if texts and max(texts) / min(texts) - 1.0 > CONTRADICTION:
            listed = ", ".join(f"{rate:.6g} Hz ({where})" for rate, where in texts.items())
            self.problem = f"the file contradicts itself: {listed}"
        elif not texts:
            self.problem = self.problem or SILENT
        self.hint = max(texts, key=lambda rate: len(said.get(rate, ()))) if texts else None
        self.agreed = None if self.problem else next(iter(texts))
