"""Health of a recording: faults that are found as its samples pass by."""

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Final

from shakerproc.data import Recording
from shakerproc.recordings.health.base import AbstractHealthCheck, Flag, Gaps
from shakerproc.recordings.health.clipping import Extremes, ShortTails
from shakerproc.recordings.health.connection import Connection
from shakerproc.recordings.health.cross_channel import CrossChannel
from shakerproc.recordings.health.flatlines import Drift, Flatlines
from shakerproc.recordings.health.repeats import Repeats
from shakerproc.recordings.health.spikes import Spikes, Transients

HEALTH_CHECKS: Mapping[str, Callable[[Recording], AbstractHealthCheck]] = MappingProxyType({
    "flatlines": Flatlines,
    "extremes": Extremes,
    "short_tails": ShortTails,
    "spikes": Spikes,
    "transients": Transients,
    "drift": Drift,
    "repeats": Repeats,
    "cross_channel": CrossChannel,
    "connection": Connection,
})
"""What looks at the samples, by what it looks for."""

MOST_LOST: Final = 0.01
"""Share of the samples that a channel may miss and still be used [-].

Gaussian noise clipped at 1 % of its samples is in error by 4.3 % rms, about what `compare` lets
pass as small where the noise is unknown (3 %).
"""

MOST_CLIPPED: Final = 0.5
"""Share of clipped samples from which on a test cannot be judged [-].

They weigh nothing in the search; where they are the majority, too little is left.
"""

PASSING: Final = ("transient", "spike")
"""Faults of a moment, which do no harm outside the part that is used."""

BESIDE: Final = 0.05
"""How far outside it they still count: their times are those of windows [s]."""


def health(recording: Recording, *, block: int = 2**17) -> tuple[Flag, ...]:
    """Return the flags that a person should look at, in order of time.

    One pass over the samples, a second only where a channel seems to measure nothing, in memory
    for a few blocks. Quiet on a good recording.

    Parameters
    ----------
    recording : Recording
        The recording.
    block : int
        Samples read at a time.
    """
    looking = [check(recording) for check in HEALTH_CHECKS.values()]
    gaps = Gaps(recording)
    for number, samples in enumerate(recording.blocks(size=block)):
        finite = gaps.add(number * block, samples)
        for check in looking:
            check.add(number * block, finite)
    flags = [*file_flags(recording), *gaps.flags()]
    for check in looking:
        flags += check.flags()
    clipped = {flag.channel for flag in flags if flag.kind == "clipping"}
    flags = [f for f in flags if f.kind != "short tails" or f.channel not in clipped]
    return tuple(sorted(flags, key=lambda flag: (flag.start, flag.channel, flag.kind)))


def unusable(
    flags: Sequence[Flag], start: float, stop: float, *, most: float = MOST_LOST
) -> tuple[Flag, ...]:
    """Return the flags of channels that did not measure in a part of a recording.

    Parameters
    ----------
    flags : sequence of Flag
        What `health` found.
    start, stop : float
        The part that is used [s].
    most : float
        Share of its samples that a channel may miss and still be used [-].
    """
    return tuple(flag for flag in flags if flag.lost_share(start, stop) > most)


def within(flags: Sequence[Flag], start: float, stop: float) -> tuple[Flag, ...]:
    """Return the flags that concern a part of a recording, from `start` to `stop` [s]."""
    return tuple(
        flag for flag in flags
        if flag.kind not in PASSING
        or (flag.stop >= start - BESIDE and flag.start <= stop + BESIDE)
    )  # fmt: skip


def file_flags(recording: Recording) -> tuple[Flag, ...]:
    """Return the flags of the file that are known without a look at the samples."""
    return (*_incomplete(recording), *_skipped(recording), *_rate(recording))


def _incomplete(recording: Recording) -> list[Flag]:
    if not recording.incomplete or recording.expected_samples is None:
        return []
    expected = recording.expected_samples / recording.sample_rate
    message = (
        f"The file ends after {recording.duration:.6g} s of {expected:.6g} s. "
        "The complete part was used; copy the file again if there is more."
    )
    return [Flag("incomplete", "", message, recording.duration, expected)]


def _skipped(recording: Recording) -> list[Flag]:
    skipped = recording.skipped
    if skipped is None:
        return []
    start, stop = (at / recording.sample_rate for at in (skipped.first, skipped.last))
    return [Flag("bad rows", "", skipped.message, start, stop)]


def _rate(recording: Recording) -> list[Flag]:
    if not recording.rate_doubtful:
        return []
    return [Flag("sample rate", "", recording.rate_doubtful, 0.0, recording.duration)]
