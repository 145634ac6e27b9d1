"""What every reader hands over: the groups and channels of a file, not yet chosen or in SI."""

from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Final, TypeAlias, final

from shakerproc.data import SampleSource, SkippedRows

SILENT: Final = "the file does not say the sample rate"
"""What is wrong with the rate of a file that leaves it to the log."""


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
        Samples per second [Hz]; None where the file does not say it in a usable way.
    rate_doubt : float
        How far that may be off, relative [-]: what the digits of a time column resolve.
    rate_problem : str
        What is wrong with the file's sample rate, where `sample_rate` is None; begins with
        `SILENT` where the file says none.
    rate_hint : float, optional
        One of the rates [Hz] between which the file does not decide.
    start_time : datetime, optional
        When the first sample was taken, with its time zone.
    problem : str
        Why the channel cannot be served; empty where it can.
    alias : str
        Another name it answers to, such as the whole header of a column.
    unit_doubt : str
        What may be a unit in its header and is not taken for one; empty for nothing.
    """

    name: str
    row: int
    n_samples: int
    promised: int
    unit: str = ""
    sample_rate: float | None = None
    rate_doubt: float = 0.0
    rate_problem: str = SILENT
    rate_hint: float | None = None
    start_time: datetime | None = None
    problem: str = ""
    alias: str = ""
    unit_doubt: str = ""

    @property
    def contradicts_rates(self) -> bool:
        """Whether the file says something of its rate or times that no rate agrees with."""
        return self.sample_rate is None and not self.rate_problem.startswith(SILENT)


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
