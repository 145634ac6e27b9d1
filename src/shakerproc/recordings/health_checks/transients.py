"""Transients on a cable or a sensor: a jump that one control makes alone, out of the quiet.

Only controls are looked at: they sit on the same stiff table, so that what one shows the others
must show as well. A response may well meet its stop alone.
"""

from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray, Recording
from shakerproc.recordings.health_checks.base import AbstractHealthCheck, Flag, control_rows
from shakerproc.recordings.health_checks.spikes import QUIET, WIDEST

WINDOW: Final = 32
"""Samples of a window, of which the largest step from sample to sample is kept."""

MOST_WINDOWS: Final = 1 << 17
"""Windows that are kept of a channel; those of a long recording are longer."""

SUDDEN: Final = 12.0
"""Largest step of a window over the median of those around it; noise makes less than 3."""

ALONE: Final = 3.0
"""The same of the other controls at that time, at most: a shock moves all of them."""

STANDING: Final = 16
"""Equal samples in a row that make it a dropout instead."""

UNIQUE: Final = 0.4
"""Largest step near a transient over that of the transient: impacts come in series."""


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
        found = []
        for number, row in enumerate(self._controls):
            others = np.delete(sudden, number, axis=0).max(axis=0)
            times = self._of_channel(number, sudden[number], others)
            if times:
                found.append(self._flag(self._recording.channels[row].name, times))
        return found

    def _of_channel(self, number: int, mine: FloatArray, others: FloatArray) -> list[float]:
        """Return the times [s] of the transients of one control."""
        rate = self._recording.sample_rate
        reach = max(4, round(QUIET * rate / self._window))
        found = []
        candidates = np.flatnonzero((mine > SUDDEN) & (others < ALONE))
        for at in candidates[:200].tolist():
            near = self._steps[number, max(0, at - reach) : at + reach + 1].copy()
            middle = min(at, reach)
            peak = near[middle]
            near[max(0, middle - 2) : middle + 3] = 0.0
            if near.max() < UNIQUE * peak and self._is_wide(self._controls[number], at):
                found.append(at * self._window / rate)
        return found

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


def _over_the_usual(steps: FloatArray, parts: int = 64) -> FloatArray:
    """Return the steps over the median of those around them."""
    size = max(16, -(-steps.size // parts)) if steps.size < 16 * parts else 64
    count = -(-steps.size // size)
    padded = np.pad(steps, (0, count * size - steps.size), mode="edge")
    medians = np.median(padded.reshape(count, size), axis=1)
    wider = np.maximum(np.maximum(np.roll(medians, 1), np.roll(medians, -1)), medians)
    wider[0], wider[-1] = max(medians[0], medians[min(1, count - 1)]), max(medians[-2:])
    usual = np.repeat(wider, size)[: steps.size]
    ratio: FloatArray = np.zeros_like(steps)
    np.divide(steps, usual, out=ratio, where=usual > 0)
    return ratio
