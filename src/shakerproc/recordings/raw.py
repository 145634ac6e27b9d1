"""What every reader hands over: the groups and channels of a file, not yet chosen or in SI."""

from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import TypeAlias, final

from shakerproc.data import SampleSource, SkippedRows
from shakerproc.recordings.time_axis import UNKNOWN, TimeAxis, TimeBase


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
    """A file, opened: what it holds and where its numbers come from.

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
