"""Channels of a TDMS file that hold the times of the others."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from typing import Any, Final, final

from numpy.typing import NDArray

from shakerproc.data import FloatArray, SampleSource
from shakerproc.recordings.guard import shown
from shakerproc.recordings.raw import RawChannel, RawGroup
from shakerproc.recordings.tdms.said import MOST_SECONDS
from shakerproc.recordings.time_axis import TimeAxis
from shakerproc.recordings.times import time_name

_EPOCH: Final = datetime(1904, 1, 1, tzinfo=UTC)

FRACTION: Final = 2.0**-64
"""Of a second, in which time stamps count."""


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
        found: NDArray[Any] = (seconds - (self.zero or 0)) + fraction * FRACTION
        return found

    @property
    def start(self) -> datetime | None:
        """When the times count from."""
        if self.zero is None or not 0 < self.zero < MOST_SECONDS:
            return None
        return _EPOCH + timedelta(seconds=self.zero)


@final
@dataclass(frozen=True, slots=True, eq=False)
class TimesChannel:
    """The times of a channel, read a piece at a time."""

    source: SampleSource
    row: int
    size: int

    def __getitem__(self, key: slice) -> FloatArray:
        first, last, _ = key.indices(self.size)
        read: FloatArray = self.source.read([self.row], first, max(first, last))[0]
        return read


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
    times = TimesChannel(source, holding.row, holding.n_samples)
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
