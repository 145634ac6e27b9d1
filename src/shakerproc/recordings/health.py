"""What may be wrong with a recording, found in one pass over its samples."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray, Recording
from shakerproc.recordings.health_checks import HEALTH_CHECKS, MEASURING, Flag

MOST_LOST: Final = 0.01
"""Share of the samples that a channel may miss and still be used [-].

Gaussian noise clipped at 1 % of its samples is in error by 4.3 % rms, about what `compare` lets
pass as small where the noise is unknown (3 %).
"""

MOST_CLIPPED: Final = 0.5
"""Share of clipped samples from which on a test cannot be judged [-].

They weigh nothing in the search; where they are the majority, too little is left.
"""


def health(
    recording: Recording, *, block: int = 2**17, checks: Sequence[str] = tuple(HEALTH_CHECKS)
) -> tuple[Flag, ...]:
    """Return what a person should look at, in order of time.

    One pass over the samples, in memory for a few blocks. Quiet on a good recording.

    Parameters
    ----------
    recording : Recording
        The recording.
    block : int
        Samples read at a time.
    checks : sequence of str
        What is looked for, of `HEALTH_CHECKS`; all of it by default.
    """
    looking = [HEALTH_CHECKS[name](recording) for name in checks]
    gaps = _Gaps(recording)
    for number, samples in enumerate(recording.blocks(size=block)):
        finite = gaps.add(number * block, samples)
        for check in looking:
            check.add(number * block, finite)
    found = [*_incomplete(recording), *_skipped(recording), *_rate(recording), *gaps.flags()]
    for check in looking:
        found += check.flags()
    return tuple(sorted(found, key=lambda flag: (flag.start, flag.channel, flag.kind)))


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


def measuring(recording: Recording) -> tuple[Flag, ...]:
    """Return what `health` says of channels that did not measure, and only that, sooner."""
    return health(recording, checks=MEASURING)


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
    if not recording.rate_overruled:
        return []
    message = (
        f"The rate of {recording.sample_rate:.9g} Hz is given against the file: "
        f"{recording.rate_overruled}. Where samples are missing, times, frequencies and "
        "damping are wrong: cut the recording there."
    )
    return [Flag("sample rate", "", message, 0.0, recording.duration)]


LARGEST: Final = 1e50
"""In SI; nothing that is measured comes near it, and its fourth power is still a number."""


class _Gaps:
    """Watches for what is no number, or too large to be one, and bridges it for the others."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        self._counts = np.zeros(len(recording.channels), dtype=np.int64)
        self._first = np.full(len(recording.channels), -1, dtype=np.int64)
        self._last = np.zeros(len(recording.channels), dtype=np.int64)

    def add(self, first: int, block: FloatArray) -> FloatArray:
        """Return the block with straight lines over what was no number."""
        if block.max() < LARGEST and block.min() > -LARGEST:  # not so where one is NaN
            return block
        bad = ~(np.abs(block) < LARGEST)
        for row in np.flatnonzero(bad.any(axis=1)):
            at = np.flatnonzero(bad[row])
            self._counts[row] += at.size
            self._last[row] = first + at[-1]
            if self._first[row] < 0:
                self._first[row] = first + at[0]
        return _bridged(block, bad)

    def flags(self) -> list[Flag]:
        rate = self._recording.sample_rate
        return [
            Flag(
                "not a number",
                channel.name,
                f"{count} samples are NaN or infinite, the first at "
                f"{first / rate:.6g} s. Keep them out of the crop, or export the recording "
                "again.",
                first / rate,
                (last + 1) / rate,
                int(count) / rate,
            )
            for channel, count, first, last in zip(
                self._recording.channels, self._counts, self._first, self._last, strict=True
            )
            if count
        ]


def _bridged(block: FloatArray, bad: NDArray[np.bool_]) -> FloatArray:
    whole = np.where(bad, 0.0, block)
    every = np.arange(block.shape[1])
    for row in np.flatnonzero(bad.any(axis=1)):
        good = ~bad[row]
        if good.any():
            whole[row] = np.interp(every, every[good], block[row, good])
    return whole
