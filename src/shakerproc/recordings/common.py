"""The rows that the chosen channels have in common."""

import math
from collections.abc import Sequence

from shakerproc.errors import RecordingError
from shakerproc.recordings.choosing import Chosen
from shakerproc.recordings.guard import shown
from shakerproc.recordings.resampling import Line


def common_length(
    chosen: Sequence[Chosen], begins: Sequence[int], run: str
) -> tuple[int, int | None, str]:
    """Return how many complete rows there are, how many there should be if more, and a note.

    A row is complete where every channel holds its sample: a program that is stopped between
    two writes leaves some channels longer than others.

    `begins` is the sample of each channel that is the first of them.

    Raises
    ------
    RecordingError
        If there is no complete row.
    """
    each = list(zip(chosen, begins, strict=True))
    n_samples = min(channel.n_samples - begin for (channel, _), begin in each)
    if n_samples <= 0 and any(begins):
        late = max(range(len(chosen)), key=lambda at: -begins[at])
        raise RecordingError(
            f"{run}: channel {shown(chosen[late][0].name)} starts after others have ended. Use "
            "only channels that were measured at one time."
        )
    if not n_samples:
        none = next(channel for channel, _ in chosen if not channel.n_samples)
        raise RecordingError(
            f"{run}: there is not one complete row of samples: channel {shown(none.name)} "
            f"holds none of its {none.promised}. Copy the file again, or leave the channel out "
            "of the log."
        )
    long = max((channel for channel, _ in chosen), key=lambda channel: channel.promised)
    short = min((channel for channel, _ in chosen), key=lambda channel: channel.promised)
    there = [channel.promised - begin for (channel, _), begin in each]
    if long.promised == short.promised:  # what only starts late is not cut short
        return n_samples, min(there) if min(there) > n_samples else None, ""
    note = (
        f"Channel {shown(long.name)} holds {long.n_samples} samples, {shown(short.name)} "
        f"{short.n_samples}: the {n_samples} rows that all channels have are used."
    )
    return n_samples, max(there) if max(there) > n_samples else None, note


def resampled_length(
    chosen: Sequence[Chosen], lines: Sequence[Line], start: float, rate: float
) -> tuple[int, int | None]:
    """Return how many interpolated rows there are, and how many there should be if more.

    Parameters
    ----------
    chosen : sequence of (RawChannel, ChannelUse)
        The channels.
    lines : sequence of Line
        When their samples were taken.
    start : float
        First of the interpolated times [s].
    rate : float
        Of them [Hz].
    """
    last = min(line.end - line.edge(rate) for line in lines)
    n_samples = int((last - start) * rate + 1e-6) + 1
    missing = max(
        (channel.promised - channel.n_samples) / line.rate
        for (channel, _), line in zip(chosen, lines, strict=True)
    )
    return n_samples, n_samples + math.ceil(missing * rate) if missing > 0.0 else None
