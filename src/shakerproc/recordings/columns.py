"""Named columns of numbers in memory: what the text and array formats come down to."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import ArraySource, FloatArray, SampleSource
from shakerproc.recordings.guard import shown
from shakerproc.recordings.headers import Heading, headings
from shakerproc.recordings.rates import RATE_NAME, agreed_rate
from shakerproc.recordings.raw import SILENT, RawChannel, RawFile, RawGroup
from shakerproc.recordings.si import split_header
from shakerproc.recordings.times import like_time, rate_doubt, rate_of_times, time_columns

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
    sample_rate: float | None = None,
    rate_problem: str = "",
    cut: str = "",
    lengths: Sequence[int] = (),
    source: SampleSource | None = None,
    notes: Sequence[str] = (),
) -> RawFile:
    """Return a table as a file of one group; a time column gives the rate and is no channel.

    Where there are several, each is that of the columns behind it.

    Parameters
    ----------
    table : Columns
        The table.
    sample_rate : float, optional
        What the file says elsewhere [Hz].
    rate_problem : str
        Why it says nothing usable.
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
    if sample_rate is None and not rate_problem:
        sample_rate, rate_problem = _rate_beside_times(table, units, lengths, stated)
    is_silent = sample_rate is None and not rate_problem
    axes = [
        _axis(row, table.values[row, : lengths[row]] * seconds, rate=is_silent)
        for row, seconds in time_columns(table.headers, units)
    ]
    reading = _Reading(
        table,
        headings(table.headers, units if any(units) else ()),
        units,
        lengths,
        axes,
        stated,
        sample_rate,
        rate_problem,
        bool(cut),
    )
    times = {axis.row for axis in axes}
    channels = [reading.channel(row) for row in range(len(units)) if row not in times]
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
    axes : sequence of _Axis
        Its time columns.
    stated : mapping
        Columns that hold nothing but the sample rate, each with it [Hz].
    sample_rate : float or None
        Of all columns [Hz]; None where each time column gives that of those behind it.
    rate_problem : str
        Why there is no rate.
    cut : bool
        Whether the file stops short.
    """

    table: Columns
    headings: Sequence[Heading]
    units: Sequence[str]
    lengths: Sequence[int]
    axes: Sequence["_Axis"]
    stated: Mapping[int, float]
    sample_rate: float | None
    rate_problem: str
    cut: bool

    def channel(self, row: int) -> RawChannel:
        """Return a column as a channel, with what is wrong with it."""
        axis, heading = self.axis_of(row), self.headings[row]
        rate, doubt, problem = self.sample_rate, 0.0, ""
        if axis is not None:
            rate = axis.rate if rate is None else rate
            doubt, problem = axis.doubt, axis.rate_problem
        return RawChannel(
            name=heading.name or f"column {row + 1}",
            row=row,
            n_samples=self.lengths[row],
            promised=self.until(row) + self.cut,
            unit=heading.unit,
            sample_rate=rate,
            rate_doubt=doubt,
            rate_problem=problem or self.rate_problem or SILENT,
            problem=self.problem(row),
            alias=heading.alias,
            unit_doubt=heading.doubt,
        )

    def axis_of(self, row: int) -> "_Axis | None":
        """Return the time column before a column; where there is none, the first."""
        before = [axis for axis in self.axes if axis.row < row]
        return next(iter(before[-1:] or self.axes[:1]), None)

    def until(self, row: int) -> int:
        """Return how many values a column should hold: as many as its time column."""
        axis, length = self.axis_of(row), self.lengths[row]
        return max(self.lengths[axis.row], length) if axis and length else length

    def problem(self, row: int) -> str:
        """Return why a column is no channel; empty where it is one."""
        if row in self.stated:
            return f"it says the sample rate, {self.stated[row]:g} Hz"
        length, axis = self.lengths[row], self.axis_of(row)
        if not length:
            return NO_NUMBERS
        header = self.table.headers[row] or f"column {row + 1}"
        alike = like_time(header, self.units[row], self.table.values[row, :length])
        return alike or (late_start(self.axes[0], axis) if axis else "")

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


def _rate_beside_times(
    table: Columns, units: Sequence[str], lengths: Sequence[int], stated: Mapping[int, float]
) -> tuple[float | None, str]:
    """Return the rate that columns state, which times beside them must not contradict.

    None, and no problem, where none states any or the times say it themselves.
    """
    if not stated:
        return None, ""
    said = {shown(table.headers[row]): rate for row, rate in stated.items()}
    for row, seconds in time_columns(table.headers, units):
        found, problem = rate_of_times(table.values[row, : lengths[row]] * seconds)
        if found is None:
            return None, problem
        said[shown(table.headers[row])] = found
    rate, problem = agreed_rate(said)
    return (None, problem) if problem or len(said) > len(stated) else (rate, "")


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Axis:
    """A time column, which is that of the columns behind it.

    Attributes
    ----------
    row : int
        Its place.
    times : (n,) array
        Its times [s].
    rate : float, optional
        The sample rate that they give [Hz], where it was asked for.
    rate_problem : str
        Why they give none.
    doubt : float
        How far the rate may be off, relative [-].
    """

    row: int
    times: FloatArray
    rate: float | None
    rate_problem: str
    doubt: float


def _axis(row: int, times: FloatArray, *, rate: bool) -> _Axis:
    found, problem = rate_of_times(times) if rate else (None, "")
    return _Axis(row, times, found, problem, 0.0 if found is None else rate_doubt(times))


def late_start(first: _Axis, other: _Axis) -> str:
    """Return why a column cannot be beside those of the first time column, or an empty text."""
    if not (first.times.size > 1 and other.times.size > 1):
        return ""
    late = float(other.times[0] - first.times[0])
    if not abs(late) > 0.5 * abs(float(first.times[1] - first.times[0])):
        return ""
    return f"its time column begins {late:.6g} s after the first; save it in a file of its own"


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
