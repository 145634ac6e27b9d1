"""Parts of a test beside one recording: further files, other recorders, events."""

from dataclasses import dataclass
from typing import final

from shakerproc.data import ChannelUse


@final
@dataclass(frozen=True, slots=True)
class Beside:
    """Channels of the same time from another recorder, or from another group of the file.

    Attributes
    ----------
    recording : str, optional
        File below the folder of the recordings; None for the recording of the test itself.
    group : str, optional
        Group of that file.
    sample_rate : float, optional
        Only where the file does not say it, or `override_rate` [Hz].
    override_rate : bool
        Whether that counts although the file states another.
    common : (str or int, str or int), optional
        A channel of the test's recording and the channel beside that measured the same motion;
        without it both have one clock.
    channels : tuple of ChannelUse
        What its channels are used as.
    """

    recording: str | None
    channels: tuple[ChannelUse, ...]
    group: str | None = None
    sample_rate: float | None = None
    override_rate: bool = False
    common: tuple[str | int, str | int] | None = None


@final
@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened during a test.

    Attributes
    ----------
    time : float
        From the start of the recording [s].
    note : str
        What happened.
    """

    time: float
    note: str
