"""Result of every reader: groups, channels, and the statements of the file on their times.

Nothing is chosen or in SI yet. A reader says what the file says, each place in its own unit; it
converts and judges nothing, `time_base` does.
"""

import math
import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any, BinaryIO, Final, Protocol, TypeAlias, final, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray, SampleSource, SkippedRows
from shakerproc.errors import RecordingError
from shakerproc.recordings.guard import foreign

SILENT: Final = "the file does not say the sample rate"
"""What is wrong with the rate of a file that leaves it to the log."""

WHOLE: Final = slice(None)


@runtime_checkable
class Times(Protocol):
    """Times of the samples, in memory or read a slice at a time."""

    @property
    def size(self) -> int:
        """How many there are."""

    def __getitem__(self, key: slice, /) -> FloatArray:
        """Return some of them, in the unit of their axis."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class TimesInFile:
    """Times that a row of a file holds, read a piece at a time."""

    source: SampleSource
    row: int
    size: int

    def __getitem__(self, key: slice) -> FloatArray:
        first, last, _ = key.indices(self.size)
        read: FloatArray = self.source.read([self.row], first, max(first, last))[0]
        return read


@final
@dataclass(frozen=True, slots=True, eq=False)
class TimeAxis:
    """The abscissa of a channel as one place of a file states it: nothing converted or judged.

    A channel has one for each place that says something, such as a step in a header and a
    column of times. Exactly one of `step`, `rate` and `times` is given, or none where the
    place says something else of the abscissa, such as its start.

    Attributes
    ----------
    where : str
        Where the file says it, as a message names it: ``wf_increment``, ``column 'time'``.
    step : float, optional
        Between samples [unit].
    rate : float, optional
        Samples per second, where it is stated as such [Hz].
    times : Times, optional
        (n,) array of the time of each sample [unit].
    start : float
        Of the first sample, where `times` do not say it [unit].
    quantity : str
        Such as ``Time`` or ``Frequency``; empty where the file does not say it.
    unit : str
        As it stands in the file; empty where the file does not say it.
    name : str
        What the abscissa is called, such as ``time_ms``, where its unit may be part of it.
    digit : float
        Half of the last digit of `step` as it is printed [unit]; 0 where it is binary.
    start_digit : float
        The same of `start` [unit].
    problem : str
        Why what stands there is unusable, such as ``wf_increment is -1``; empty else.
    """

    where: str
    step: float | None = None
    rate: float | None = None
    times: Times | None = None
    start: float = 0.0
    quantity: str = ""
    unit: str = ""
    name: str = ""
    digit: float = 0.0
    start_digit: float = 0.0
    problem: str = ""


@final
@dataclass(frozen=True, slots=True)
class Sampling:
    """Statements of the log on the time axis of a recording.

    Attributes
    ----------
    rate : float, optional
        Samples per second [Hz]: where the file does not say it, or leaves two readings.
    override : bool
        Whether `rate` counts although the file states another.
    unit : str
        Unit of the times, where the file does not say it; empty where the log neither.
    resample : float, optional
        Rate of an even axis that every channel is interpolated to [Hz].
    ignore_starts : bool
        Whether all channels start together, whatever the file states.
    """

    rate: float | None = None
    override: bool = False
    unit: str = ""
    resample: float | None = None
    ignore_starts: bool = False


AS_STATED: Final = Sampling()
"""The log says nothing."""


@final
@dataclass(frozen=True, slots=True)
class TimeReading:
    """One way in which the statements of a file may be read.

    Attributes
    ----------
    unit : str
        Of the times; empty where a rate is stated.
    rate : float
        Samples per second [Hz]; the mean, where they are uneven.
    seconds : float
        In the unit.
    start_time : datetime, optional
        When time 0 is, where the times themselves say it.
    """

    unit: str
    rate: float
    seconds: float = 1.0
    start_time: datetime | None = None


@final
@dataclass(frozen=True, slots=True, eq=False)
class TimeBase:
    """When the samples of a channel were taken.

    Attributes
    ----------
    sample_rate : float, optional
        Samples per second [Hz]; None where the file does not tell it.
    doubt : float
        How far that may be off, relative [-]: what the printed digits resolve.
    problem : str
        Why there is no rate; begins with `SILENT` where the file says none.
    readings : tuple of TimeReading
        The ways between which the file does not decide.
    start : float
        Of the first sample, behind `start_time` or the time 0 that all channels share [s].
    start_doubt : float
        How far that may be off [s].
    start_time : datetime, optional
        When time 0 is, with its time zone.
    times : Times, optional
        (n,) array of times that do not advance evenly [unit of `readings`].
    note : str
        What had to be decided, a sentence; empty for nothing.
    spectrum : bool
        Whether the values are no samples over time.
    """

    sample_rate: float | None = None
    doubt: float = 0.0
    problem: str = SILENT
    readings: tuple[TimeReading, ...] = ()
    start: float = 0.0
    start_doubt: float = 0.0
    start_time: datetime | None = None
    times: Times | None = None
    note: str = ""
    spectrum: bool = False

    @property
    def first(self) -> datetime | None:
        """When the first sample was taken."""
        start = timedelta(seconds=self.start)  # raises where there is no such time
        return None if self.start_time is None else self.start_time + start

    @property
    def is_silent(self) -> bool:
        """Whether the file says nothing that a rate could contradict."""
        return self.sample_rate is None and self.problem.startswith(SILENT)


UNKNOWN: Final = TimeBase()
"""Of a channel of which the file says nothing."""


def half_digit(text: str, decimal: str = ".") -> float:
    """Return half of the last digit of a printed number, in its own unit; 0 where it is none.

    Examples
    --------
    >>> half_digit("0.000977"), half_digit("1.000000E-3"), half_digit("12")
    (5e-07, 5e-10, 0.5)
    """
    plain = text.strip().replace(decimal, ".").lower().replace("d", "e")
    mantissa, _, power = plain.partition("e")
    try:
        exponent = int(power or 0) - len(mantissa.partition(".")[2])
        return 0.5 * 10.0**exponent if float(plain) else 0.0
    except (ValueError, OverflowError):
        return 0.0


@final
@dataclass(frozen=True, slots=True)
class RawChannel:
    """One channel as the file describes it.

    Attributes
    ----------
    name : str
        Name in the file.
    row : int
        Which row of the file's source it is; -1 where it cannot be served.
    n_samples : int
        Values that are there.
    promised : int
        Values that the file says it holds.
    unit : str
        Unit as it stands in the file; empty where the file does not say it.
    sample_rate : float, optional
        Samples per second [Hz], where that is all that the file states of its times.
    start_time : datetime, optional
        When time 0 of its axes is, with its time zone; that of the first sample, where they
        state no start.
    problem : str
        Why the channel cannot be served; empty where it can.
    alias : str
        Another name it answers to, such as the whole header of a column.
    unit_doubt : str
        What may be a unit in its header and is not taken for one; empty for nothing.
    axes : tuple of TimeAxis
        What the file states of its times, one for each place that does; one and the same
        tuple for the channels that share them.
    time : TimeBase
        When its samples were taken: not for a reader to say, but decided by all the above.
    """

    name: str
    row: int
    n_samples: int
    promised: int
    unit: str = ""
    sample_rate: float | None = None
    start_time: datetime | None = None
    problem: str = ""
    alias: str = ""
    unit_doubt: str = ""
    axes: tuple[TimeAxis, ...] = ()
    time: TimeBase = UNKNOWN


@final
@dataclass(frozen=True, slots=True)
class RawGroup:
    """Channels that belong together.

    Attributes
    ----------
    name : str
        Name in the file; empty where the format has no groups.
    channels : tuple of RawChannel
        In the order of the file.
    reduced : bool
        Whether it holds decimated copies of another group.
    measurements : tuple of RawGroup
        The measurements that follow each other in its channels; empty where it is one.
    differs : tuple of str
        In what each of them differs from the one before, beginning with the second: ``time``,
        ``rate``, ``unit`` or ``scale``.
    more : int
        How many more there are that cannot be chosen.
    """

    name: str
    channels: tuple[RawChannel, ...]
    reduced: bool = False
    measurements: "tuple[RawGroup, ...]" = ()
    differs: tuple[str, ...] = ()
    more: int = 0


@final
@dataclass(frozen=True, slots=True, eq=False)
class RawFile:
    """A file, opened: its groups and the source of their samples.

    Attributes
    ----------
    groups : tuple of RawGroup
        In the order of the file.
    source : SampleSource
        Numbers in the units of the file.
    notes : tuple of str
        What the reader had to decide or found odd, a sentence each.
    skipped : SkippedRows, optional
        Lines that are no rows of numbers; left out here, for who asks for it.
    refusal : str
        Why the file is refused for them otherwise.
    """

    groups: tuple[RawGroup, ...]
    source: SampleSource
    notes: tuple[str, ...] = ()
    skipped: SkippedRows | None = None
    refusal: str = ""


Reader: TypeAlias = Callable[[Path, str], RawFile]
"""Opens a file, with the name of the run for its error messages."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class SlicedSource(SampleSource):
    """Samples that a function takes out of an open file when they are asked for.

    Attributes
    ----------
    run : str
        Name of the run, for messages.
    take : callable
        From rows, first sample and the one behind the last to the samples of each row.
    handle : object
        What has to be closed.
    """

    run: str
    take: Callable[[Sequence[int], int, int], Iterable[NDArray[Any]]]
    handle: Any

    def read(self, rows: Sequence[int], start: int, stop: int) -> FloatArray:
        out = np.empty((len(rows), max(0, stop - start)))
        if out.size:
            with foreign(self.run, "reading the samples"):
                for line, values in zip(out, self.take(rows, start, stop), strict=True):
                    line[:] = values
        return out

    def close(self) -> None:
        """Close the file."""
        self.handle.close()


@final
@dataclass(frozen=True, slots=True, eq=False)
class Frames:
    """An array of one or two axes in an open file, sliced like one in memory.

    Attributes
    ----------
    run : str
        Name of the run, for messages.
    file : BinaryIO
        The open file.
    first : int
        Byte of the first number.
    shape : tuple of int
        Length along every axis; the last one advances from number to number.
    stored : numpy.dtype
        Type of a number in the file.
    decoded : callable, optional
        From numbers of the file to values [as the format says].
    kind : numpy.dtype, optional
        Type of a value, where it is another than that of a number in the file.
    """

    run: str
    file: BinaryIO
    first: int
    shape: tuple[int, ...]
    stored: "np.dtype[Any]"
    decoded: Callable[[NDArray[Any]], NDArray[Any]] | None = None
    kind: "np.dtype[Any] | None" = None

    @property
    def dtype(self) -> "np.dtype[Any]":
        """Type of a value."""
        return self.stored if self.kind is None else self.kind

    @property
    def size(self) -> int:
        """How many values there are."""
        return math.prod(self.shape)

    def __getitem__(self, key: Any, /) -> NDArray[Any]:
        keys = key if isinstance(key, tuple) else (key,)
        rows, columns = (*(WHOLE if k is Ellipsis else k for k in keys), WHOLE)[:2]
        if isinstance(rows, int):
            return self._piece(rows, columns)
        start, stop, _ = rows.indices(self.shape[0])
        width = self.shape[1] if len(self.shape) == 2 else 1
        numbers = self._numbers(start * width, max(0, stop - start) * width)
        frames = numbers.reshape(-1, *self.shape[1:])
        return frames if columns == WHOLE else frames[:, columns]

    def _piece(self, row: int, columns: slice) -> NDArray[Any]:
        """Return a slice of one row of an array that is written row by row."""
        start, stop, _ = columns.indices(self.shape[1])
        return self._numbers(row * self.shape[1] + start, max(0, stop - start))

    def _numbers(self, first: int, count: int) -> NDArray[Any]:
        """Return numbers one after the other.

        Raises
        ------
        RecordingError
            If the file has become shorter.
        """
        if self.file.closed:
            raise RecordingError(f"{self.run}: the recording is closed. Open it again.")
        raw = np.empty(count, self.stored)
        self.file.seek(self.first + first * self.stored.itemsize)
        if self.file.readinto(raw.view(np.uint8)) != raw.nbytes:  # type: ignore[attr-defined]
            size = os.fstat(self.file.fileno()).st_size
            raise RecordingError(
                f"{self.run}: the file has become shorter, {size} bytes, while it was read. "
                "Wait until nothing changes it any more, then call again."
            )
        return raw if self.decoded is None else self.decoded(raw)
