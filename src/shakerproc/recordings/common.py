"""The rows that the chosen channels have in common."""

import math
from collections.abc import Sequence

from shakerproc.errors import RecordingError
from shakerproc.recordings.choosing import Chosen
from shakerproc.recordings.guard import shown
from shakerproc.recordings.resampling import Line


def common_length(
    chosen: Sequence[Chosen], begins: Sequence[int], run: str
) -> tuple[int, int | None]:
    """Return how many complete rows there are, and how many there should be if more.

    `begins` is the sample of each channel that is the first of them.

    Raises
    ------
    RecordingError
        If the channels were not equally long to begin with, or nothing is there.
    """
    by_length: dict[int, str] = {}
    for channel, _ in chosen:
        by_length.setdefault(channel.promised, channel.name)
    if len(by_length) > 1:
        (long, first), (short, second) = sorted(by_length.items(), reverse=True)[:2]
        raise RecordingError(
            f"{run}: channel {shown(first)} holds {long} samples, {shown(second)} {short}. Use "
            "only channels of one length: leave the others out of the log, or give them "
            "role: ignore."
        )
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
    promised = min(channel.promised - begin for (channel, _), begin in each)
    return n_samples, promised if promised > n_samples else None


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
