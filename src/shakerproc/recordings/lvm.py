"""Read LVM, LabVIEW's text format: headers, then columns that may be of unequal length.

Each write of the measuring program is a segment. Segments whose times follow on are one
recording; others are measurements that follow each other in the same channels.
"""

import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from mmap import ACCESS_READ, mmap
from pathlib import Path
from typing import BinaryIO, Final, final

import numpy as np

from shakerproc.data import FloatArray, SampleSource, SkippedRows
from shakerproc.errors import RecordingError
from shakerproc.recordings.columns import length_of
from shakerproc.recordings.guard import AGAIN, shown
from shakerproc.recordings.lvm_heads import Head, heads_of
from shakerproc.recordings.raw import RawChannel, RawFile, RawGroup, TimeAxis
from shakerproc.recordings.text_format import TextFormat, open_text
from shakerproc.recordings.text_rows import TextTable, read_table, refusal, without_bad_rows
from shakerproc.recordings.time_base import SAME_RATE, follows
from shakerproc.recordings.times import axis_of_column

MOST: Final = 100
"""Measurements that can be chosen from."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class SplicedSource(SampleSource):
    """Samples of which each row is a few arrays, one behind the other."""

    lines: tuple[tuple[FloatArray, ...], ...]

    def read(self, rows: Sequence[int], start: int, stop: int) -> FloatArray:
        out = np.empty((len(rows), max(0, stop - start)))
        for number, row in enumerate(rows):
            at = 0
            for piece in self.lines[row]:
                first, last = max(start - at, 0), min(stop - at, piece.size)
                if first < last:
                    out[number, at + first - start : at + last - start] = piece[first:last]
                at += piece.size
        return out

    def close(self) -> None:
        """Do nothing: there is no file."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Segment:
    """A segment of the file, written at once.

    Attributes
    ----------
    head : Head
        What stands above it.
    values : (n_columns, n_rows) array
        Its table.
    lengths, promised : tuple of int
        Values of each column that are there, and that there should be.
    skipped : SkippedRows, optional
        Lines that are no rows of numbers.
    refusal : str
        What is wrong with these.
    """

    head: Head
    values: FloatArray
    lengths: tuple[int, ...]
    promised: tuple[int, ...]
    skipped: SkippedRows | None = None
    refusal: str = ""

    @property
    def whole(self) -> bool:
        """Whether every channel has all samples that it should, and as many as the others."""
        there = {(self.lengths[row], self.promised[row]) for row in self.head.rows}
        return len(there) == 1 and all(n == promised for n, promised in there)

    def column(self, row: int) -> FloatArray:
        """Return the values of a column that are there."""
        return self.values[row, : self.lengths[row]]

    def start(self) -> float:
        """Return when the first sample was taken [s], from a time that all segments share."""
        row = self.head.rows[0]
        moment = self.head.moment(row)
        times = [self.column(time) for time in self.head.times if self.lengths[time]]
        first = float(times[0][0]) if times else self.head.starts(row)[0]
        return first + (moment.timestamp() if moment else 0.0)

    def step(self) -> float:
        """Return the time between samples [s]; 0 where nothing says it."""
        times = [self.column(time) for time in self.head.times if self.lengths[time] > 1]
        if times:
            return float(times[0][-1] - times[0][0]) / (times[0].size - 1)
        return self.head.number("Delta_X", self.head.rows[0]) or 0.0


def read_lvm(path: Path, run: str) -> RawFile:
    """Return the columns of a LabVIEW measurement file as channels.

    Raises
    ------
    RecordingError
        If its headers are not those of the format, or a channel is longer than they say.
    """
    file, encoding, _ = open_text(path, run)
    with file:
        content = _content(file)
        heads = heads_of(content, encoding, run)
        if isinstance(content, mmap):
            content.close()
        segments = [
            segment
            for head in heads
            for segment in _read(file, head, encoding, run, last=head is heads[-1])
        ]
    lines: list[tuple[FloatArray, ...]] = []
    group = _group(segments, lines)
    return RawFile(
        (group,),
        SplicedSource(tuple(lines)),
        tuple(_notes(segments, max(len(group.measurements) + group.more, 1))),
        _all_skipped(segments),
        next((segment.refusal for segment in segments if segment.refusal), ""),
    )


def _content(file: BinaryIO) -> mmap | bytes:
    if isinstance(file, io.BytesIO):
        return file.getvalue()
    return mmap(file.fileno(), 0, access=ACCESS_READ)


def _read(
    file: BinaryIO, head: Head, encoding: str, run: str, *, last: bool
) -> Iterator[_Segment]:
    """Yield the segments below a header: more than one where times begin again.

    Raises
    ------
    RecordingError
        If a channel is longer than its header says.
    """
    text_format = TextFormat(
        encoding, head.separator, head.decimal, head.first, head.titles, (), remark=True
    )
    table = read_table(file, text_format, run, span=(head.start, head.stop))
    axis = next(iter(head.times), None)
    timed = axis is not None and length_of(table.values[axis]) == table.values.shape[1] > 0
    times = table.values[axis] if timed and axis is not None else None
    values, skipped = without_bad_rows(table.values, table.bad, times)
    lengths = [length_of(row) for row in values]
    if last and table.unended and any(lengths[row] < _promised(head, row, lengths[row])
                                      for row in head.rows):  # fmt: skip
        values = values[:, :-1]  # its last number may be cut
        lengths = [length_of(row) for row in values]
    if skipped is None:
        _check_lengths(head, lengths, run)
    yield from _divided(head, values, lengths, table, skipped)


def _divided(
    head: Head,
    values: FloatArray,
    lengths: Sequence[int],
    table: TextTable,
    skipped: SkippedRows | None,
) -> Iterator[_Segment]:
    """Yield the writes of a table where the times of one do not follow those before."""
    edges = [0, *(_restarts(head, values) if skipped is None else ()), values.shape[1]]
    why = refusal(table.bad, len(head.titles)) if skipped else ""
    for first, last in pairwise(edges):
        there = [min(max(n - first, 0), last - first) for n in lengths]
        more = int((bool(table.torn) or head.cut) and last == edges[-1])
        promised = [max(_promised(head, row, n), n + more) for row, n in enumerate(there)]
        yield _Segment(head, values[:, first:last], tuple(there), tuple(promised), skipped, why)


def _restarts(head: Head, values: FloatArray) -> list[int]:
    """Return the rows with which a further write under one header begins at another time.

    There the times go back, or jump at the end of a write of as many samples as the header
    counts.
    """
    if not head.many_writes or not head.times or head.time_per_channel:
        return []
    times = values[head.times[0]]
    steps, size = np.diff(times), head.samples(head.rows[0])
    if not steps.size or not np.all(np.isfinite(steps)):
        return []
    usual = float(np.median(steps))
    at = np.arange(1, times.size)
    ends = (at % size == 0) if size else np.zeros(at.size, dtype=bool)
    return [int(n) for n in at[(steps < 0.0) | (ends & (np.abs(steps - usual) > 0.5 * usual))]]


def _promised(head: Head, row: int, there: int) -> int:
    """Return how many values a column should hold, by whole writes where there are several."""
    return head.samples(row) * head.writes(row, there) or there


def _check_lengths(head: Head, lengths: Sequence[int], run: str) -> None:
    """Pass channels that are no longer than the headers say.

    Raises
    ------
    RecordingError
        If one is.
    """
    for row in head.rows:
        if lengths[row] > _promised(head, row, lengths[row]):
            raise RecordingError(
                f"{run}: {shown(head.titles[row])} holds {lengths[row]} values but Samples "
                f"says {head.samples(row)}. {AGAIN}"
            )


def _group(segments: Sequence[_Segment], lines: list[tuple[FloatArray, ...]]) -> RawGroup:
    """Return segments as a group; adds its rows to `lines`."""
    parts: list[list[_Segment]] = [[segments[0]]]
    differs: list[str] = []
    for before, after in pairwise(segments):
        other = _difference(before, after)
        if other:
            parts.append([])
            differs.append(other)
        parts[-1].append(after)
    if len(parts) == 1:
        return RawGroup("", _channels(segments, lines, timed=True))
    measurements = [RawGroup("", _channels(part, lines, timed=True)) for part in parts[:MOST]]
    same_titles = [s for s in segments if s.head.titles == segments[0].head.titles]
    return RawGroup(
        "",
        _channels(same_titles, lines, timed=False),
        measurements=tuple(measurements),
        differs=tuple(differs),
        more=len(parts) - len(measurements),
    )


def _difference(before: _Segment, after: _Segment) -> str:
    """Return why a segment does not continue the one before; empty where it does."""
    step, other = before.step(), after.step()
    if before.head.titles != after.head.titles:
        return "channels"
    if [before.head.text("Y_Unit_Label", row) for row in before.head.rows] != [
        after.head.text("Y_Unit_Label", row) for row in after.head.rows
    ]:
        return "unit"
    if step > 0.0 and other > 0.0 and abs(other / step - 1.0) > SAME_RATE:
        return "rate"
    if not before.whole:
        return "length"
    duration = before.lengths[before.head.rows[0]] * step
    return "" if follows(after.start() - before.start(), duration, step) else "time"


def _channels(
    segments: Sequence[_Segment], lines: list[tuple[FloatArray, ...]], *, timed: bool
) -> tuple[RawChannel, ...]:
    """Return the channels of segments one behind the other; adds their rows to `lines`.

    The steps and times of all are stated of each, but where each has times of its own. Times
    are left out where they do not follow on.
    """
    head, last = segments[0].head, segments[-1]
    stepped = {row: axis for row in head.rows if (axis := head.axis(row))}
    times = {row: _times(segments, row) for row in head.times if segments[0].lengths[row]}
    columns = {
        row: replace(
            axis_of_column(head.titles[row], "", values),
            quantity=head.text("X_Dimension", head.rows[0]),
        )
        for row, values in times.items()
        if timed
    }
    known: dict[object, tuple[TimeAxis, ...]] = {}

    def axes(row: int) -> tuple[TimeAxis, ...]:
        rows = [row] if head.time_per_channel else head.rows
        times = [time for time in columns if time == row - 1 or not head.time_per_channel]
        start, digit = head.starts(row)
        key = (start, digit, *rows, *times)
        if key not in known:
            known[key] = (
                *(
                    replace(stepped[r], start=start, start_digit=digit)
                    for r in rows
                    if r in stepped
                ),
                *(columns[time] for time in times),
            )
        return known[key]

    first = len(lines)
    lines += [tuple(segment.column(row) for segment in segments) for row in head.rows]
    counts = {row: sum(segment.lengths[row] for segment in segments) for row in head.rows}
    return tuple(
        RawChannel(
            name=head.titles[row],
            row=first + number,
            n_samples=counts[row],
            promised=counts[row] + last.promised[row] - last.lengths[row],
            unit=head.text("Y_Unit_Label", row),
            start_time=head.moment(row),
            problem="" if counts[row] else "it holds no numbers",
            axes=axes(row),
        )
        for number, row in enumerate(head.rows)
    )


def _times(segments: Sequence[_Segment], row: int) -> FloatArray:
    """Return a column of times, of segments whose headers say when its zero is [s]."""
    channel = segments[0].head.rows[0]
    zero = segments[0].head.moment(channel)
    shifts = [
        (moment - zero).total_seconds() if zero and (moment := s.head.moment(channel)) else 0.0
        for s in segments
    ]
    return np.concatenate([
        s.column(row) + shift for s, shift in zip(segments, shifts, strict=True)
    ])


def _notes(segments: Sequence[_Segment], parts: int) -> Iterator[str]:
    if len(segments) > parts:
        yield f"{len(segments)} segments, of which the times follow on, are read as {parts}."
    yield from dict.fromkeys(s.skipped.message for s in segments if s.skipped is not None)
    for segment in segments:
        row = segment.head.rows[0]
        size, there = segment.head.samples(row), segment.lengths[row]
        if size and there > size:
            yield (
                f"Samples says {size} of {shown(segment.head.titles[row])}, {there} are there: "
                "several writes under one header, taken as without a gap between them."
            )
            break
    less = [
        segment.head.titles[row]
        for segment in segments
        for row in segment.head.rows
        if segment.lengths[row] < segment.promised[row]
    ]
    if less:
        yield f"The file is not whole: {shown(less[0])} is shorter than it says."


def _all_skipped(segments: Sequence[_Segment]) -> SkippedRows | None:
    """Return the lines that are left out of any segment, places counted over all of them."""
    at, skipped = 0, list[tuple[int, SkippedRows]]()
    for segment in segments:
        if segment.skipped is not None:
            skipped.append((at, segment.skipped))
        at += segment.values.shape[1]
    if not skipped:
        return None
    return SkippedRows(
        count=sum(one.count for _, one in skipped),
        bridged=sum(one.bridged for _, one in skipped),
        first=min(start + one.first for start, one in skipped),
        last=max(start + one.last for start, one in skipped),
        message=" ".join(one.message for _, one in skipped),
    )
