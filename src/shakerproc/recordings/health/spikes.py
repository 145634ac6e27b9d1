"""Isolated spikes of one to three samples, and jumps that one control makes alone.

Of jumps only controls are looked at: they sit on the same stiff table, so that what one shows
the others must show as well. A response may well meet its stop alone.
"""

from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray, Recording
from shakerproc.numerals import numeral
from shakerproc.recordings.health.base import (
    AbstractHealthCheck,
    Flag,
    control_rows,
    resolution,
)

FACTOR: Final = 15.0
"""How many times the usual departure from the neighbours a spike must depart.

Departures of Gaussian noise exceed 15 standard deviations never, of Laplacian noise once in a
billion samples.
"""

ROUNDING: Final = 12.0**-0.5
"""Rms of rounding over the step that is rounded to: no departure is known more finely."""

PART: Final = 4096
"""Samples over which the usual departure is taken: a sweep changes it on the way."""

WIDEST: Final = 3
AROUND: Final = 32
"""Samples on each side in which nothing else may happen."""

ALONE: Final = 0.2
"""Largest departure around a spike, relative to it: an impact rings, a spike does not."""

STEEP: Final = 0.5 * (1.0 - ALONE)
"""Departure over height of a spike that is seen from one side only [-].

A step of the whole height departs by half of it from the mean of its neighbours, give or take
what is around; the rest of a pulse that the recording cuts through falls more slowly.
"""

MOST: Final = 200
"""Departures in a block beyond which it is a rough block, without isolated spikes."""

MOST_BLOCKS: Final = 1000
"""Blocks of which what is rough is kept."""

QUIET: Final = 0.25
"""Time before and after an isolated spike without another [s]; impacts come in series."""

WINDOW: Final = 32
"""Samples of a window, of which the largest step from sample to sample is kept."""

MOST_WINDOWS: Final = 1 << 17
"""Windows that are kept of a channel; those of a long recording are longer."""

SUDDEN: Final = 12.0
"""Largest step of a window over the median of those around it; noise makes less than 3."""

LARGEST_OF_OTHERS: Final = 3.0
"""Largest such ratio of the other controls at that time: a shock moves all of them [-]."""

STANDING: Final = 16
"""Equal samples in a row that make it a dropout instead."""

UNIQUE: Final = 0.4
"""Largest step near a transient over that of the transient: impacts come in series."""


@final
class Spikes(AbstractHealthCheck):
    """Watches for samples far from where their neighbours lie."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        self._tail: FloatArray | None = None
        self._found: list[dict[int, float]] = [{} for _ in recording.channels]
        self._rough: list[list[NDArray[np.int64]]] = [[] for _ in recording.channels]

    def add(self, first: int, block: FloatArray) -> None:
        edge = 2 * AROUND
        if self._tail is not None:
            block = np.concatenate([self._tail, block], axis=1)
            first -= self._tail.shape[1]
        ends = (first == 0, first + block.shape[1] == self._recording.n_samples)
        for row, samples in enumerate(block):
            if samples.size > 2 * edge:
                spikes, rough = _spikes(first, samples, ends)
                self._found[row] |= spikes
                if rough.size and len(self._rough[row]) < MOST_BLOCKS:
                    self._rough[row].append(rough)
        self._tail = block[:, -edge:].copy()

    def flags(self) -> list[Flag]:
        flags = []
        rate = self._recording.sample_rate
        for row, channel in enumerate(self._recording.channels):
            distinct = self._isolated(row)
            if distinct:
                at, height = max(distinct.items(), key=lambda spike: abs(spike[1]))
                more = (
                    f"{len(distinct)} isolated spikes, the largest"
                    if len(distinct) > 1
                    else ("An isolated spike")
                )
                flags.append(
                    Flag(
                        "spike",
                        channel.name,
                        f"{more} of {numeral(height, 4)} {channel.unit} at {at / rate:.6g} s. "
                        "Keep it out of the crop (minimum hold), or check the cable.",
                        min(distinct) / rate,
                        max(distinct) / rate,
                    )
                )
        return flags

    def _isolated(self, row: int) -> dict[int, float]:
        """Return the spikes that have nothing rough within a quarter of a second.

        Nor in another channel at that time: what moves two sensors is mechanical.
        """
        if not self._found[row]:
            return {}
        rough = np.concatenate([*self._rough[row], np.empty(0, dtype=np.int64)])
        others = np.concatenate([
            np.empty(0, dtype=np.int64),
            *(part for i, parts in enumerate(self._rough) if i != row for part in parts),
        ])
        apart = max(QUIET * self._recording.sample_rate, AROUND)
        isolated = {}
        for at, height in self._found[row].items():
            distance = np.abs(rough - at)
            alone = not np.any(np.abs(others - at) < AROUND)
            if alone and not np.any((distance > WIDEST) & (distance < apart)):
                isolated[at] = height
        return isolated


def _departure(samples: FloatArray) -> FloatArray:
    """Return how far each sample lies from the mean of its neighbours."""
    departure = samples[:-2] + samples[2:]
    departure *= -0.5
    departure += samples[1:-1]
    return np.abs(departure, out=departure)


def _spikes(
    first: int, samples: FloatArray, ends: tuple[bool, bool]
) -> tuple[dict[int, float], NDArray[np.int64]]:
    """Return number and height of the spikes, and the number of everything that is rough.

    `ends` says whether the recording begins and ends with the samples.
    """
    departure = _departure(samples)
    limits = _limits(departure)
    largest = np.maximum.reduceat(departure, np.arange(0, departure.size, PART))
    if np.any(largest > limits):  # steps are looked at only where something may rise above
        limits = np.maximum(limits, FACTOR * ROUNDING * resolution(samples))
    if np.all(largest <= limits):
        return {}, np.empty(0, dtype=np.int64)
    candidates = np.flatnonzero(departure > np.repeat(limits, PART)[: departure.size]) + 1
    rough = first + candidates[:: 1 + candidates.size // MOST]
    if candidates.size > MOST:
        return {}, rough
    groups = np.split(candidates, np.flatnonzero(np.diff(candidates) > WIDEST) + 1)
    judged = [_judge(samples, departure, group, ends) for group in groups]
    return {first + at: height for at, height in judged if height}, rough


def _limits(departure: FloatArray) -> FloatArray:
    """Return the departure of a spike in each part: the larger of those of it and its sides."""
    whole = departure.size // PART
    parts = [departure[: whole * PART].reshape(whole, PART)[:, ::7]]
    if departure.size > whole * PART:
        parts.append(departure[np.newaxis, whole * PART :: 7])
    usual = np.zeros(whole + len(parts) + 1)
    # 1.4826 times the median of |x| is the standard deviation of a normal x
    usual[1:-1] = np.concatenate([
        np.maximum(1.4826 * np.median(some, axis=1), np.mean(some, axis=1)) for some in parts
    ])
    return FACTOR * np.maximum(np.maximum(usual[:-2], usual[2:]), usual[1:-1])


def _judge(
    samples: FloatArray, departure: FloatArray, group: NDArray[np.int64],
    ends: tuple[bool, bool],
) -> tuple[int, float]:  # fmt: skip
    """Return place and height of a spike, or a height of 0 where it is none.

    A spike of w samples makes w + 2 samples depart: one on each side of it as well. Near an
    end of the recording it is judged by the samples that are there; what another block shows
    whole is left to that.
    """
    low, high = int(group[0]), int(group[-1])
    near = (low < AROUND + 2, high >= samples.size - AROUND - 2)
    unseen = any(close and not end for close, end in zip(near, ends, strict=True))
    if unseen or high - low + 1 > WIDEST + 2:
        return 0, 0.0
    if low <= WIDEST:  # no more samples than a spike has lie before it: they may be part of it
        low = 1
    if high >= samples.size - 1 - WIDEST:
        high = samples.size - 2
    before = samples[max(0, low - AROUND) : max(0, low - 1)]
    after = samples[high + 2 : high + AROUND + 1]
    sides = [float(side.mean()) for side in (before[-3:], after[:3]) if side.size]
    level = sum(sides) / len(sides)
    start = max(0, low - 1)
    inside = samples[start : high + 2] - level
    peak = int(np.argmax(np.abs(inside)))
    height = float(inside[peak])
    parts = (
        departure[max(0, low - 1 - AROUND) : max(0, low - 3)],
        departure[high + 2 : high + AROUND],
    )
    around = max(float(part.max(initial=0.0)) for part in parts)
    if around > ALONE * abs(height) or max(sides) - min(sides) > ALONE * abs(height):
        return 0, 0.0
    if len(sides) == 1 and departure[low - 1 : high].max() < STEEP * abs(height):
        return 0, 0.0
    if _width(samples, start + peak, level) > WIDEST:
        return 0, 0.0
    return start + peak, height


def _width(samples: FloatArray, peak: int, level: float) -> int:
    """Return how many samples in a row lie beyond half the height of a peak."""
    start = max(0, peak - AROUND)
    near = samples[start : peak + AROUND + 1] - level
    top = peak - start
    inside = np.flatnonzero(near * np.sign(near[top]) <= 0.5 * abs(near[top]))
    before, after = inside[inside < top], inside[inside > top]
    first = int(before[-1]) if before.size else -1
    return (int(after[0]) if after.size else near.size) - first - 1


@final
class Transients(AbstractHealthCheck):
    """Watches the largest step in each short window, of all controls side by side."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        controls = control_rows(recording)
        self._controls = controls if len(controls) > 1 else []
        self._window = max(WINDOW, -(-recording.n_samples // MOST_WINDOWS))
        count = -(-recording.n_samples // self._window)
        self._steps = np.zeros((len(self._controls), max(1, count)))
        self._last = [np.nan] * len(self._controls)

    def add(self, first: int, block: FloatArray) -> None:
        """Keep the largest step of every window that the block touches."""
        offset = -first % self._window
        edges = np.arange(offset, block.shape[1], self._window)
        starts = edges if offset == 0 else np.concatenate([[0], edges])
        at = first // self._window
        for number, row in enumerate(self._controls):
            samples = block[row]
            steps = np.abs(
                np.diff(samples, prepend=samples[:1] if first == 0 else self._last[number])
            )
            self._last[number] = samples[-1]
            part = self._steps[number, at : at + starts.size]
            np.maximum(part, np.maximum.reduceat(steps, starts), out=part)

    def flags(self) -> list[Flag]:
        if self._steps.shape[1] < 64:
            return []
        sudden = np.array([_over_the_usual(steps) for steps in self._steps])
        flags = []
        for number, row in enumerate(self._controls):
            others = np.delete(sudden, number, axis=0).max(axis=0)
            times = self._of_channel(number, sudden[number], others)
            if times:
                flags.append(self._flag(self._recording.channels[row].name, times))
        return flags

    def _of_channel(self, number: int, mine: FloatArray, others: FloatArray) -> list[float]:
        """Return the times [s] of the transients of one control."""
        rate = self._recording.sample_rate
        reach = max(4, round(QUIET * rate / self._window))
        values = []
        candidates = np.flatnonzero((mine > SUDDEN) & (others < LARGEST_OF_OTHERS))
        for at in candidates[:200].tolist():
            near = self._steps[number, max(0, at - reach) : at + reach + 1].copy()
            middle = min(at, reach)
            peak = near[middle]
            near[max(0, middle - 2) : middle + 3] = 0.0
            if near.max() < UNIQUE * peak and self._is_wide(self._controls[number], at):
                values.append(at * self._window / rate)
        return values

    def _is_wide(self, row: int, at: int) -> bool:
        """Return whether it is wider than a spike, and no dropout."""
        start = max(0, (at - 2) * self._window)
        stop = min(self._recording.n_samples, (at + 3) * self._window)
        samples = self._recording.select([row]).samples(start, stop)[0]
        still = np.convolve(np.diff(samples) == 0.0, np.ones(STANDING - 1), "valid")
        height = np.abs(samples - np.median(samples))
        wide = int(np.count_nonzero(height > 0.3 * height.max())) > WIDEST
        return wide and still.max(initial=0.0) < STANDING - 1

    def _flag(self, name: str, times: list[float]) -> Flag:
        often = "A transient" if len(times) == 1 else f"{len(times)} transients, the first"
        return Flag(
            "transient",
            name,
            f"{often} at {times[0]:.6g} s that the other controls do not show: the "
            "cable or the sensor was touched. Keep it out of the crop (minimum hold).",
            times[0],
            times[-1],
        )


def _over_the_usual(steps: FloatArray) -> FloatArray:
    """Return the steps over the median of those around them."""
    size = max(16, -(-steps.size // 64)) if steps.size < 16 * 64 else 64
    count = -(-steps.size // size)
    padded = np.pad(steps, (0, count * size - steps.size), mode="edge")
    medians = np.median(padded.reshape(count, size), axis=1)
    wider = np.maximum(np.maximum(np.roll(medians, 1), np.roll(medians, -1)), medians)
    wider[0], wider[-1] = max(medians[0], medians[min(1, count - 1)]), max(medians[-2:])
    usual = np.repeat(wider, size)[: steps.size]
    ratio: FloatArray = np.zeros_like(steps)
    np.divide(steps, usual, out=ratio, where=usual > 0)
    return ratio
