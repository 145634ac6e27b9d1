"""Where the run begins and ends in a recording: by threshold or by time."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Final, NamedTuple, final

import numpy as np

from shakerproc import checks
from shakerproc.data import FloatArray
from shakerproc.errors import SpectrumError
from shakerproc.numerals import numeral

PAUSE: Final = 0.5
"""Silence [s] that makes two exceedances of the threshold separate events."""

ISOLATED_SHARE: Final = 0.01
"""Share of all exceedances below which a separate first or last event is suspicious."""


@final
@dataclass(frozen=True, slots=True)
class Crop:
    """The part of a recording that is the run.

    Attributes
    ----------
    start, stop : int
        First sample, and the sample after the last.
    warning : str, optional
        What looks odd about it, a sentence.
    """

    start: int
    stop: int
    warning: str | None = None

    @property
    def n_samples(self) -> int:
        """Samples in the crop."""
        return self.stop - self.start


def sample_at(time: float, sample_rate: float) -> int:
    r"""Return the sample that a time from the start of the recording means.

    .. math:: k = \lfloor t f_s + 1/2 \rfloor

    the nearest, counted from 0; half-way between two it is the later. As an end, a time means
    the first sample that no longer belongs: a part from sample `a` up to, not including, `b`
    lasts (b - a) / sample rate, and its last sample is b - 1.

    Parameters
    ----------
    time : float
        Time from the first sample [s].
    sample_rate : float
        Samples per second [Hz].
    """
    return math.floor(time * sample_rate + 0.5)


class ThresholdNotReachedError(SpectrumError):
    """No sample reaches the threshold.

    Attributes
    ----------
    threshold, largest : float
        What was wanted and the largest value seen [unit of the samples].
    """

    def __init__(self, threshold: float, largest: float, unit: str) -> None:
        self.threshold = threshold
        self.largest = largest
        super().__init__(
            f"the threshold of {numeral(threshold, 4)} {unit} is never reached: the largest "
            f"value is {numeral(largest, 4)} {unit}; lower the threshold or remove the offset "
            "of the channel"
        )


class _Event(NamedTuple):
    """Samples at and above the threshold with no long pause between them."""

    first: int
    last: int
    size: int


def crop_by_threshold(
    samples: FloatArray | Iterable[FloatArray],
    threshold: float,
    sample_rate: float,
    *,
    absolute: bool = False,
    hold: float = 0.0,
    skip: float = 0.0,
    remove_offset: bool = False,
    shown: tuple[str, float] = ("m/s^2", 1.0),
) -> Crop:
    """Return the part from the first to the last sample at or above a threshold.

    Parameters
    ----------
    samples : (n_samples,) array, or iterable of (n,) arrays
        One control channel, whole or in blocks of any size [any unit].
    threshold : float
        Value that the run reaches and rest does not [unit of the samples].
    sample_rate : float
        Samples per second [Hz].
    absolute : bool
        Compare the magnitude; otherwise, as in the thesis, the signed value.
    hold : float
        How long the signal must keep coming back to the threshold, with pauses shorter than
        this, to count as running [s]; 0 takes every sample.
    skip : float
        Time at the start that is not looked at [s]; the first sample looked at is that of
        `sample_at`.
    remove_offset : bool
        Compare with the mean of all samples taken away; iterates twice.
    shown : (str, float)
        Unit that messages have, and how many of it one unit of the samples is [-].

    Returns
    -------
    Crop
        First sample, sample after the last, and a warning where the first or the last event
        stands alone, as a spike does.

    Raises
    ------
    ThresholdNotReachedError
        If the threshold is never reached.
    SpectrumError
        If it is reached, but never held, or nothing is left to look at.
    ValueError
        If `remove_offset` is asked of an iterator, which can be read only once.
    """
    checks.positive("sample_rate", sample_rate, "Hz")
    checks.not_negative("hold", hold, "s")
    checks.not_negative("skip", skip, "s")
    unit, scale = shown
    offset = _mean(samples) if remove_offset else 0.0
    pause = max(1, round((hold or PAUSE) * sample_rate))
    events, largest = _events(
        _blocks(samples),
        threshold,
        offset,
        sample_at(skip, sample_rate),
        pause,
        absolute=absolute,
    )
    if not np.isfinite(largest):
        raise SpectrumError(f"no sample is left to compare after skipping {skip:g} s")
    if not events:
        raise ThresholdNotReachedError(scale * threshold, scale * largest, unit)
    held = [e for e in events if (e.last - e.first) >= hold * sample_rate or not hold]
    if not held:
        longest = max(e.last - e.first for e in events) / sample_rate
        raise SpectrumError(
            f"the threshold of {numeral(scale * threshold, 4)} {unit} is held for "
            f"{numeral(longest)} s at most, not for {hold:g} s: ask for a shorter hold"
        )
    return Crop(held[0].first, held[-1].last + 1, _warning(held, sample_rate))


def crop_by_time(
    n_samples: int, sample_rate: float, start: float = 0.0, stop: float | None = None
) -> Crop:
    """Return the part of a recording between two times.

    Parameters
    ----------
    n_samples : int
        Samples of the recording.
    sample_rate : float
        Samples per second [Hz].
    start, stop : float
        Times from the start of the recording [s]; by default its start and end.

    Returns
    -------
    Crop
        From the sample at `start` up to, not including, the sample at `stop`, both those of
        `sample_at`.

    Raises
    ------
    SpectrumError
        If the recording does not reach that far, or nothing is left.
    """
    first = sample_at(start, sample_rate)
    last = n_samples if stop is None else sample_at(stop, sample_rate)
    if not 0 <= first < last <= n_samples:
        end = "its end" if stop is None else f"{stop:g} s"
        raise SpectrumError(
            f"the crop from {start:g} s to {end} does not lie within the recording of "
            f"{n_samples / sample_rate:.6g} s"
        )
    return Crop(first, last)


def _blocks(samples: FloatArray | Iterable[FloatArray]) -> Iterator[FloatArray]:
    """Yield the samples in one-dimensional blocks.

    Raises
    ------
    ValueError
        If a block has more dimensions.
    """
    for block in (samples,) if isinstance(samples, np.ndarray) else samples:
        if block.ndim != 1:
            raise ValueError(f"samples of one channel are (n,) arrays, not {block.shape}")
        yield block


def _mean(samples: FloatArray | Iterable[FloatArray]) -> float:
    """Return the mean of samples that can be read again.

    Raises
    ------
    ValueError
        If they cannot.
    """
    if iter(samples) is samples:
        raise ValueError("remove_offset reads the samples twice: give an array or a list")
    total, count = 0.0, 0
    for block in _blocks(samples):
        total += float(np.sum(block))
        count += block.size
    return total / max(count, 1)


def _events(
    blocks: Iterable[FloatArray],
    threshold: float,
    offset: float,
    skip: int,
    pause: int,
    *,
    absolute: bool,
) -> tuple[list[_Event], float]:
    """Return the events in order, and the largest value seen."""
    events: list[_Event] = []
    largest, position = -np.inf, 0
    for block in blocks:
        begin = min(max(skip - position, 0), block.size)
        values = block[begin:] - offset
        values = np.abs(values) if absolute else values
        if values.size:
            largest = max(largest, float(np.fmax.reduce(values)))
        where = np.flatnonzero(values >= threshold) + (position + begin)
        position += block.size
        if where.size:
            _append(events, where, pause)
    return events, largest


def _append(events: list[_Event], where: np.ndarray, pause: int) -> None:
    """Add the samples at or above the threshold to the events."""
    edges = np.flatnonzero(np.diff(where) > pause) + 1
    for part in np.split(where, edges):
        event = _Event(int(part[0]), int(part[-1]), part.size)
        if events and event.first - events[-1].last <= pause:
            before = events.pop()
            event = _Event(before.first, event.last, before.size + event.size)
        events.append(event)


def _warning(events: list[_Event], sample_rate: float) -> str | None:
    """Return the warning of a first or last event that stands alone."""
    if len(events) < 2:
        return None
    total = sum(e.size for e in events)
    for name, event, other, remedy in (
        ("first", events[0], events[1].first, "skip it or ask for a hold"),
        ("last", events[-1], events[-2].last, "ask for a hold"),
    ):
        gap = min(abs(other - event.first), abs(other - event.last)) / sample_rate
        if event.size < ISOLATED_SHARE * total and gap > PAUSE:
            at = event.first / sample_rate
            return (
                f"the {name} exceedance of the threshold, at {numeral(at, 4)} s, stands alone "
                f"({event.size} samples, then silence for {numeral(gap)} s): if it is a spike, "
                f"{remedy}"
            )
    return None
