"""Samples of a TDMS file: blocks straight from its raw data, channels of times among them."""

import os
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime, timedelta
from typing import Any, BinaryIO, Final, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray, SampleSource
from shakerproc.errors import RecordingError
from shakerproc.recordings.guard import AGAIN, shown
from shakerproc.recordings.raw import RawChannel, RawGroup, TimeAxis, TimesInFile
from shakerproc.recordings.tdms.layout import Place
from shakerproc.recordings.tdms.metadata import Scaling
from shakerproc.recordings.tdms.objects import MOST_SECONDS
from shakerproc.recordings.tdms.structure import Extent
from shakerproc.recordings.times import time_name

_EPOCH: Final = datetime(1904, 1, 1, tzinfo=UTC)

FRACTION: Final = 2.0**-64
"""Of a second, in which time stamps count."""

BATCH: Final = 1 << 20
"""Bytes read at a time."""


@final
@dataclass(slots=True, eq=False)
class StampScaling:
    """How time stamps become seconds: behind the whole second of the first that is read.

    Attributes
    ----------
    zero : int, optional
        That second, since 1904.
    """

    zero: int | None = None

    def values(self, raw: Mapping[int | None, NDArray[Any]]) -> NDArray[Any]:
        """Return the seconds [s] of stamps, given as fractions (0) and whole seconds (1)."""
        fraction, seconds = raw[0], raw[1]
        if self.zero is None and seconds.size:
            self.zero = int(seconds.flat[0])
        values: NDArray[Any] = (seconds - (self.zero or 0)) + fraction * FRACTION
        return values

    @property
    def start(self) -> datetime | None:
        """When the times count from."""
        if self.zero is None or not 0 < self.zero < MOST_SECONDS:
            return None
        return _EPOCH + timedelta(seconds=self.zero)


def with_times(
    group: RawGroup, source: SampleSource, stamped: Mapping[int, StampScaling]
) -> RawGroup:
    """Return a group whose channels without a step have the times of one that holds them.

    Parameters
    ----------
    group : RawGroup
        The group.
    source : SampleSource
        Of the file.
    stamped : mapping
        Rows of time stamps.
    """
    measurements = tuple(with_times(part, source, stamped) for part in group.measurements)
    group = replace(group, measurements=measurements)
    holding = next((c for c in group.channels if _holds_times(c, stamped)), None)
    if holding is None or not any(_follows(c, holding) for c in group.channels):
        return group
    times = TimesInFile(source, holding.row, holding.n_samples)
    name, unit = time_name(holding.name, holding.unit) or (holding.name, "")
    axis = TimeAxis(f"channel {shown(holding.name)}", times=times, name=name, unit=unit)
    start = None
    if holding.row in stamped:
        source.read([holding.row], 0, 1)
        axis, start = replace(axis, unit="s"), stamped[holding.row].start
    axes = (axis,)
    return replace(
        group,
        channels=tuple(
            replace(c, axes=axes, start_time=start or c.start_time) if _follows(c, holding)
            else replace(c, problem="it holds the times of the others") if c is holding
            else c
            for c in group.channels
        ),
    )  # fmt: skip


def _holds_times(channel: RawChannel, stamped: Mapping[int, StampScaling]) -> bool:
    """Return whether a channel holds times: stamps, or numbers that are called so."""
    if not channel.n_samples or channel.row < 0:
        return False
    named = not channel.problem and time_name(channel.name, channel.unit) is not None
    return channel.row in stamped or named


def _follows(channel: RawChannel, holding: RawChannel) -> bool:
    """Return whether a channel says no step of its own, and is as long as the times.

    A step of 1 is what LabVIEW writes where none is given.
    """
    silent = all(axis.step is None or axis.step == 1.0 for axis in channel.axes)
    serves = not channel.problem and channel is not holding
    return serves and silent and channel.n_samples == holding.n_samples


@final
@dataclass(frozen=True, slots=True, eq=False)
class SampleClock:
    """Channels whose values stand in the same numbers in the same extents.

    Attributes
    ----------
    extents : tuple of Extent
        Those that hold values of the channels.
    counts : (n_extents,) array
        Values in a chunk of each.
    starts : (n_extents + 1,) array
        Values before each, and in all.
    """

    extents: tuple[Extent, ...]
    counts: NDArray[np.int64]
    starts: NDArray[np.int64]


@final
@dataclass(frozen=True, slots=True, eq=False)
class ServedChannel:
    """A channel that can be read.

    Attributes
    ----------
    path : str
        Such as ``/'group'/'channel'``.
    scaling : Scaling or StampScaling
        How its raw numbers become values.
    """

    path: str
    scaling: Scaling | StampScaling


def clocks(paths: Sequence[str], extents: Sequence[Extent]) -> dict[str, SampleClock]:
    """Return the clock of every channel; channels that go together share one."""
    counts: dict[str, list[tuple[int, int]]] = {path: [] for path in paths}
    for number, extent in enumerate(extents):
        for path, where in extent.layout.places.items():
            if where.count and path in counts:
                counts[path].append((number, where.count))
    shared: dict[tuple[tuple[int, int], ...], SampleClock] = {}
    sample_clocks = {}
    for path, steps in counts.items():
        key = tuple(steps)
        if key not in shared:
            shared[key] = _clock(key, extents)
        sample_clocks[path] = shared[key]
    return sample_clocks


def _clock(steps: Sequence[tuple[int, int]], extents: Sequence[Extent]) -> SampleClock:
    chosen = tuple(extents[number] for number, _ in steps)
    counts = np.array([count for _, count in steps], dtype=np.int64)
    totals = counts * np.array([extent.n_chunks for extent in chosen], dtype=np.int64)
    starts = np.concatenate([[0], np.cumsum(totals)]).astype(np.int64)
    return SampleClock(chosen, counts, starts)


@final
@dataclass(slots=True, eq=False)
class TdmsSource(SampleSource):
    """Samples of a TDMS file, in the units of the file.

    Attributes
    ----------
    run : str
        Name of the run, for messages.
    file : BinaryIO
        The open file.
    size : int
        Bytes that it had when it was walked over.
    channels : tuple of ServedChannel
        What each row is.
    clocks : tuple of SampleClock
        Where the values of each row stand.
    """

    run: str
    file: BinaryIO
    size: int
    channels: tuple[ServedChannel, ...]
    clocks: tuple[SampleClock, ...]
    _buffer: memoryview = field(default_factory=lambda: memoryview(bytearray(BATCH)))

    def close(self) -> None:
        """Close the file."""
        self.file.close()

    def read(self, rows: Sequence[int], start: int, stop: int) -> FloatArray:
        """Return samples start to stop of the channels in these rows.

        Raises
        ------
        RecordingError
            If the file is closed or has changed since it was opened, or ends too early.
        ValueError
            If there are no such samples.
        """
        if self.file.closed:
            raise RecordingError(f"{self.run}: the recording is closed. Open it again.")
        out = np.empty((len(rows), max(0, stop - start)))
        together: dict[int, list[int]] = defaultdict(list)
        for line, row in enumerate(rows):
            clock = self.clocks[row]
            if start < 0 or stop > clock.starts[-1]:
                raise ValueError(f"samples {start} to {stop} of {clock.starts[-1]}")
            together[id(clock)].append(line)
        for lines in together.values():
            self._read_clock([rows[line] for line in lines], lines, start, stop, out)
        self._check_size()
        return out

    def _check_size(self) -> None:
        if os.fstat(self.file.fileno()).st_size != self.size:
            raise RecordingError(
                f"{self.run}: the file changed its size while it was read. "
                "Wait until the measurement has ended, then read it again."
            )

    def _read_clock(
        self, rows: list[int], lines: list[int], start: int, stop: int, out: FloatArray
    ) -> None:
        channels = [self.channels[row] for row in rows]
        clock = self.clocks[rows[0]]
        first = int(np.searchsorted(clock.starts, start, side="right")) - 1
        position = start
        for number in range(first, len(clock.extents)):
            if position >= stop:
                break
            begin = int(clock.starts[number])
            end = min(stop, int(clock.starts[number + 1]))
            piece = _Piece(
                clock.extents[number], int(clock.counts[number]), position - begin, end - begin
            )
            target = out[:, position - start : end - start]
            self._read_extent(piece, channels, lines, target)
            position = end

    def _read_extent(
        self,
        piece: "_Piece",
        channels: Sequence[ServedChannel],
        lines: Sequence[int],
        out: FloatArray,
    ) -> None:
        if piece.extent.layout.size <= BATCH:
            self._read_chunks(piece, channels, lines, out)
            return
        bands: dict[tuple[int, int], list[tuple[ServedChannel, int]]] = defaultdict(list)
        for channel, line in zip(channels, lines, strict=True):
            where = piece.extent.layout.places[channel.path]
            bands[where.offset, where.width].append((channel, line))
        for (offset, width), members in bands.items():
            self._read_band(piece, offset, width, members, out)

    def _read_chunks(
        self,
        piece: "_Piece",
        channels: Sequence[ServedChannel],
        lines: Sequence[int],
        out: FloatArray,
    ) -> None:
        """Read whole chunks, as many at a time as the buffer holds."""
        layout, count, pitch = piece.extent.layout, piece.count, piece.extent.pitch
        step = max(1, BATCH // pitch)
        last = -(-piece.stop // count)
        for chunk in range(piece.start // count, last, step):
            n = min(step, last - chunk)
            begin = piece.extent.position + chunk * pitch
            raw = self._bytes(begin, (n - 1) * pitch + layout.size)
            low = max(piece.start, chunk * count)
            high = min(piece.stop, (chunk + n) * count)
            inside = slice(low - chunk * count, high - chunk * count)
            for channel, line in zip(channels, lines, strict=True):
                where = layout.places[channel.path]
                numbers = _view(raw, where, (n, count), (pitch, where.width), where.offset)
                flat = {scale: part.reshape(-1)[inside] for scale, part in numbers.items()}
                out[line, low - piece.start : high - piece.start] = channel.scaling.values(flat)

    def _read_band(
        self,
        piece: "_Piece",
        offset: int,
        width: int,
        members: Sequence[tuple[ServedChannel, int]],
        out: FloatArray,
    ) -> None:
        """Read rows of one band of a long chunk, as many at a time as the buffer holds."""
        layout, count = piece.extent.layout, piece.count
        step = max(1, BATCH // width)
        position = piece.start
        while position < piece.stop:
            chunk, row = divmod(position, count)
            n = min(step, count - row, piece.stop - position)
            begin = piece.extent.position + chunk * piece.extent.pitch + offset + row * width
            raw = self._bytes(begin, n * width)
            at = position - piece.start
            for channel, line in members:
                where = layout.places[channel.path]
                numbers = _view(raw, where, (n,), (width,), 0)
                out[line, at : at + n] = channel.scaling.values(numbers)
            position += n

    def _bytes(self, position: int, size: int) -> memoryview:
        """Return exactly these bytes of the file.

        Raises
        ------
        RecordingError
            If the file ends before them.
        """
        if size > len(self._buffer):
            self._buffer = memoryview(bytearray(size))  # a row longer than a batch
        part = self._buffer[:size]
        self.file.seek(position)
        filled = 0
        while filled < size:
            got: int = self.file.readinto(part[filled:])  # type: ignore[attr-defined]
            if not got:
                raise RecordingError(
                    f"{self.run}: byte {position + filled}: the file ends here, "
                    f"{size - filled} bytes too early. It has shrunk since it was opened. "
                    f"{AGAIN}"
                )
            filled += got
        return part


@final
@dataclass(frozen=True, slots=True)
class _Piece:
    """Values `start` to `stop` of an extent that has `count` in each chunk."""

    extent: Extent
    count: int
    start: int
    stop: int


def _view(
    raw: memoryview, where: Place, shape: tuple[int, ...], strides: tuple[int, ...], offset: int
) -> dict[int | None, NDArray[Any]]:
    """Return the numbers of each column of a channel as they stand in the bytes."""
    numbers: dict[int | None, NDArray[Any]] = {}
    for column in where.columns:
        part: NDArray[Any] = np.ndarray(
            shape, np.dtype(column.dtype), raw, offset + column.byte, strides
        )
        if column.bit is not None:
            part = (part >> column.bit) & 1
        numbers[column.scale] = part
    return numbers
