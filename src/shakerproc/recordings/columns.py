"""Named columns of numbers in memory: what the text and array formats come down to."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Final, final

import numpy as np

from shakerproc.data import ArraySource, FloatArray, SampleSource
from shakerproc.recordings.guard import shown
from shakerproc.recordings.headers import RATE_NAME, Heading, headings
from shakerproc.recordings.raw import RawChannel, RawFile, RawGroup, TimeAxis, Times
from shakerproc.recordings.si import split_header
from shakerproc.recordings.times import axis_of_column, like_time, time_columns

NO_NUMBERS: Final = "it holds no numbers"


@final
@dataclass(frozen=True, slots=True, eq=False)
class Columns:
    """A table.

    Attributes
    ----------
    headers : sequence of str
        What stands over each column, such as ``ch3 [g]``.
    values : (n_columns, n_rows) array
        Not a number where nothing stood.
    units : sequence of str
        Where they stand in a row of their own; else empty.
    """

    headers: Sequence[str]
    values: FloatArray
    units: Sequence[str] = ()


def file_of_columns(
    table: Columns,
    *,
    axes: Sequence[TimeAxis] = (),
    times: Mapping[int, Times] | None = None,
    start_time: datetime | None = None,
    cut: str = "",
    lengths: Sequence[int] = (),
    source: SampleSource | None = None,
    notes: Sequence[str] = (),
) -> RawFile:
    """Return a table as a file of one group; time columns are no channels.

    Where there are several, each is that of the columns behind it.

    Parameters
    ----------
    table : Columns
        The table.
    axes : sequence of TimeAxis
        What the file states of its times elsewhere.
    times : mapping, optional
        The times of a column, where the table holds only the first of them.
    start_time : datetime, optional
        When time 0 of the time columns is.
    cut : str
        How the file stops short; empty where it is whole.
    lengths : sequence of int
        Values of each column, where the table holds only the first of them.
    source : SampleSource, optional
        Where they come from then.
    notes : sequence of str
        What is odd about the file.
    """
    units = list(table.units) or [""] * len(table.headers)
    lengths = lengths or [length_of(row) for row in table.values]
    stated = _stated_rates(table, lengths)
    said = (*axes, *(
        TimeAxis(f"column {shown(table.headers[row])}", rate=rate)
        for row, rate in stated.items()
    ))  # fmt: skip
    timed = {
        row: (*said, axis_of_column(
            table.headers[row], units[row],
            (times or {}).get(row, table.values[row, : lengths[row]]),
        ))
        for row in time_columns(table.headers, units)
    }  # fmt: skip
    over = headings(table.headers, units if any(units) else ())
    reading = _Reading(table, over, units, lengths, timed, stated, said, start_time, bool(cut))
    channels = [reading.channel(row) for row in range(len(units)) if row not in timed]
    remarks = [remark for channel in channels if (remark := reading.remark(channel))]
    notes = [*notes, *([f"The file is not whole: {cut}."] if cut else []), *remarks]
    return RawFile(
        (RawGroup("", tuple(channels)),), source or ArraySource(table.values), tuple(notes)
    )


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Reading:
    """What is known of a table when its columns become channels.

    Attributes
    ----------
    table : Columns
        The table.
    headings : sequence of Heading
        What stands over each column.
    units, lengths : sequence
        Unit and number of values of each column.
    timed : mapping
        What the file states of the times of the columns behind each time column.
    stated : mapping
        Columns that hold nothing but the sample rate, each with it [Hz].
    said : tuple of TimeAxis
        What it states without a time column.
    start_time : datetime, optional
        When time 0 of the time columns is.
    cut : bool
        Whether the file stops short.
    """

    table: Columns
    headings: Sequence[Heading]
    units: Sequence[str]
    lengths: Sequence[int]
    timed: Mapping[int, tuple[TimeAxis, ...]]
    stated: Mapping[int, float]
    said: tuple[TimeAxis, ...]
    start_time: datetime | None
    cut: bool

    def channel(self, row: int) -> RawChannel:
        """Return a column as a channel, with what is wrong with it."""
        heading, time = self.headings[row], self.time_of(row)
        return RawChannel(
            name=heading.name or f"column {row + 1}",
            row=row,
            n_samples=self.lengths[row],
            promised=self.until(row) + self.cut,
            unit=heading.unit,
            start_time=self.start_time,
            problem=self.problem(row),
            alias=heading.alias,
            unit_doubt=heading.doubt,
            axes=self.said if time is None else self.timed[time],
        )

    def time_of(self, row: int) -> int | None:
        """Return the time column before a column; where there is none, the first."""
        before = [time for time in self.timed if time < row]
        return next(iter(before[-1:] or list(self.timed)[:1]), None)

    def until(self, row: int) -> int:
        """Return how many values a column should hold: as many as its time column."""
        time, length = self.time_of(row), self.lengths[row]
        return max(self.lengths[time], length) if time is not None and length else length

    def problem(self, row: int) -> str:
        """Return why a column is no channel; empty where it is one."""
        if row in self.stated:
            return f"it says the sample rate, {self.stated[row]:g} Hz"
        length = self.lengths[row]
        if not length:
            return NO_NUMBERS
        header = self.table.headers[row] or f"column {row + 1}"
        return like_time(header, self.units[row], self.table.values[row, :length])

    def remark(self, channel: RawChannel) -> str:
        """Return what a person should know of a channel; empty where it is as it should be."""
        length, until = channel.n_samples, self.until(channel.row)
        if channel.problem and length:
            return f"{shown(channel.name)} is no channel: {channel.problem}."
        if length < until:
            return f"{shown(channel.name)} ends after {length} of {until} rows."
        return ""


def _stated_rates(table: Columns, lengths: Sequence[int]) -> dict[int, float]:
    """Return the columns that hold nothing but the sample rate, each with it [Hz]."""
    found = {}
    for row, header in enumerate(table.headers):
        if RATE_NAME.fullmatch(split_header(header)[0].strip()):
            values = table.values[row, : lengths[row]]
            there = values[~np.isnan(values)]
            if there.size and there[0] > 0.0 and np.all(there == there[0]):
                found[row] = float(there[0])
    return found


def length_of(values: FloatArray) -> int:
    """Return the number of values up to the last one that is there.

    `values` may be in any unit.
    """
    there = np.flatnonzero(~np.isnan(values))
    return int(there[-1]) + 1 if there.size else 0


def is_number(text: str, decimal: str = ".") -> bool:
    """Return whether a cell holds a number."""
    if decimal == "," and "." in text:
        return False
    try:
        return not math.isinf(float(text.strip().replace(decimal, ".")))
    except ValueError:
        return False
