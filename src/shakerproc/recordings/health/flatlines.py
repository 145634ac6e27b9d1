"""Channels that stand still (zero tails, stuck, dropouts), or whose mean drifts."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray, Recording
from shakerproc.numerals import numeral
from shakerproc.recordings.health.base import AbstractHealthCheck, Flag, resolution

SHORTEST: Final = 16
"""Equal samples in a row that are looked at."""

FACTOR: Final = 8
"""How much longer than the usual runs of equal samples a run must be, with none between.

A quantized signal repeats a value now and then, a slow one often, in runs of every length:
those of noise are spread exponentially, and at the crest of a coarsely quantized sine the
longest is 2.4 times the next. A cable that fails makes runs of another kind.
"""

SHORTEST_TAIL: Final = 5
"""Zeros at an end that are looked at."""

TAIL_FACTOR: Final = 4
"""How much longer than the usual runs the zeros at the end must be: there is only one end."""

HELD: Final = 0.5
"""Share of samples in long runs from which on a channel is a slow one, its values held."""

MOST_RUNS: Final = 1000

LOBES: Final = 3
"""Lobes of a shock at most: the pulse, one before and one after it."""

LOBE: Final = 0.2
"""Height of a lobe that counts, over the largest: what IEC 60068-2-27 tolerates [-]."""

LONGEST_SHOCK: Final = 2**18
"""Samples of which a shock is looked for in what is before a channel's first rest."""

BEFORE: Final = 4
"""Samples before a run by which what comes to rest is told from what breaks off."""

ONE_STEP: Final = 1.5
"""Steps of the converter in which what decays comes to rest; a cable fails from anywhere."""

PARTS: Final = 32
"""Equal parts of the recording whose means are compared."""

CERTAIN: Final = 10.0
"""Slope of the means over its standard error; chance never makes 10."""

RELEVANT: Final = 0.2
"""Change of the mean over the recording, relative to the standard deviation."""

COUNTER: Final = 3.3
"""The same of a straight line is the root of 12: a counter, not a drift."""


@final
@dataclass(slots=True)
class _Run:
    """Equal samples in a row, and how far from them the samples before lie at most.

    Of a run at the beginning, how far the sample after it.
    """

    start: int
    length: int
    value: float
    jump: float = 0.0

    @property
    def stop(self) -> int:
        return self.start + self.length


def _runs(samples: FloatArray) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return start and length of every run of at least two equal samples."""
    same = np.flatnonzero(samples[1:] == samples[:-1])
    breaks = np.flatnonzero(np.diff(same) > 1)
    firsts = same[np.concatenate([[0], breaks + 1])] if same.size else same
    lasts = same[np.concatenate([breaks, [same.size - 1]])] if same.size else same
    return firsts, lasts - firsts + 2


def _jump(samples: FloatArray, at: int) -> float:
    """Return how far from a sample those before it lie at most, `BEFORE` of them."""
    return float(np.abs(samples[max(0, at - BEFORE) : at] - samples[at]).max())


@final
class _ConstantRuns:
    """The runs of equal samples of one channel."""

    def __init__(self) -> None:
        self.lengths: Counter[int] = Counter()
        self.long: list[_Run] = []
        self.open: _Run | None = None
        self.lead: _Run | None = None
        self.step = np.inf

    def add(self, first: int, samples: FloatArray) -> None:
        """Split a block into runs; the last one stays open for the next block."""
        starts, lengths = _runs(samples)
        n = samples.size
        self.step = min(self.step, resolution(samples) or np.inf)
        head = _Run(first, int(lengths[0]) if starts.size and starts[0] == 0 else 1, samples[0])
        if self.open is not None and self.open.value == head.value:
            length = self.open.length + head.length
            joined = _Run(self.open.start, length, head.value, self.open.jump)
        else:
            joined = head
            if self.open is not None:
                joined.jump = abs(self.open.value - head.value)
                self.open.jump = self.open.jump if self.open.start else joined.jump
            self._close(self.open)
        if head.length == n:
            self.open = joined
            return
        if not joined.start:
            joined.jump = abs(samples[head.length] - head.value)
        self.lead = self.lead or joined
        self._close(joined)
        ends_long = bool(starts.size) and int(starts[-1] + lengths[-1]) == n
        tail = int(starts[-1]) if ends_long else n - 1
        inner = (starts > 0) & (starts < tail)
        self.lengths[1] += n - head.length - int(lengths[inner].sum()) - (n - tail)
        values, counts = np.unique(lengths[inner], return_counts=True)
        self.lengths.update(dict(zip(values.tolist(), counts.tolist(), strict=True)))
        for i in np.flatnonzero(inner & (lengths >= SHORTEST)):
            at, stop = int(starts[i]), int(starts[i] + lengths[i])
            self._keep(_Run(first + at, stop - at, samples[at], _jump(samples, at)))
        self.open = _Run(first + tail, n - tail, samples[tail], _jump(samples, tail))

    def _close(self, run: _Run | None) -> None:
        if run is None:
            return
        self.lengths[run.length] += 1
        if run.length >= SHORTEST:
            self._keep(run)

    def _keep(self, run: _Run) -> None:
        self.long.append(run)
        if len(self.long) > 2 * MOST_RUNS:
            self.long.sort(key=lambda one: -one.length)
            del self.long[MOST_RUNS:]

    def rests(self, limit: int) -> bool:
        """Return whether it begins at exactly 0: a simulation, or a channel that waits.

        Noise that dwells at a value for some samples leaves it by one step of the converter;
        a shock leaves its rest by more.
        """
        lead = self.lead
        if lead is None or lead.value:
            return False
        shaken = lead.length >= SHORTEST_TAIL and not self.is_rest(lead)
        return shaken or lead.length >= limit

    def is_rest(self, run: _Run) -> bool:
        """Return whether it came to rest: the samples before lie one step of it away."""
        return run.jump < ONE_STEP * self.step

    def usual(self) -> int:
        """Return the longest of the usual runs: beyond it there is none for a factor of 8."""
        usual = 1
        for length in sorted(self.lengths):
            if length >= SHORTEST and length >= FACTOR * usual:
                break
            usual = max(usual, length)
        return usual


@final
class Flatlines(AbstractHealthCheck):
    """Watches for samples that repeat themselves exactly."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        self._channels = [_ConstantRuns() for _ in recording.channels]

    def add(self, first: int, block: FloatArray) -> None:
        for channel, samples in zip(self._channels, block, strict=True):
            channel.add(first, samples)

    def flags(self) -> list[Flag]:
        flags = []
        for row, runs in enumerate(self._channels):
            flags += self._judge(row, runs)
        return flags

    def _judge(self, row: int, runs: _ConstantRuns) -> list[Flag]:
        name = self._recording.channels[row].name
        n = self._recording.n_samples
        tail = runs.open
        if tail is None:
            return []
        if tail.length == n:
            return [] if n < SHORTEST else [self._constant(name, tail)]
        usual = runs.usual()
        limit = max(SHORTEST, FACTOR * usual)
        often = {length: times for length, times in runs.lengths.items() if length >= limit}
        if runs.rests(limit) or self._is_held(often):
            return []
        inside = [
            run for run in runs.long
            if run.length >= limit and run.start > 0 and not runs.is_rest(run)
        ]  # fmt: skip
        runs_found = self._tail(name, runs, usual) + self._inside(name, inside, often)
        return [] if runs_found and self._rests_after_a_shock(row, runs, limit) else runs_found

    def _rests_after_a_shock(self, row: int, runs: _ConstantRuns, limit: int) -> bool:
        """Return whether nothing but a shock comes before the first rest at exactly 0.

        A cable that fails breaks off vibration, of many lobes.
        """
        rests = [run for run in (*runs.long, runs.open) if run and run.value == 0.0]
        first = min((run.start for run in rests if run.length >= limit), default=0)
        if not 0 < first <= LONGEST_SHOCK:
            return False
        before = self._recording.select([row]).samples(0, first)[0]
        if not np.isfinite(before).all():
            return False
        signs = np.sign(before[np.abs(before) >= LOBE * np.abs(before).max()])
        return int(np.count_nonzero(np.diff(signs))) < LOBES

    def _is_held(self, often: Mapping[int, int]) -> bool:
        """Return whether long runs are the rule: a slow channel whose values are held."""
        held = sum(length * times for length, times in often.items())
        return sum(often.values()) > 20 and held > HELD * self._recording.n_samples

    def _tail(self, name: str, runs: _ConstantRuns, usual: int) -> list[Flag]:
        """Return a flag if the channel stands still at the end."""
        n, rate, tail = self._recording.n_samples, self._recording.sample_rate, runs.open
        if tail is None or tail.length < SHORTEST_TAIL or runs.is_rest(tail):
            return []
        if tail.value:
            still = tail.length >= max(SHORTEST, FACTOR * usual)
            return [self._stuck(name, tail)] if still else []
        zeros = max((run.length for run in runs.long if run.value == 0.0), default=0)
        if tail.length < TAIL_FACTOR * usual or tail.length <= 2 * zeros:
            return []
        message = (
            f"The last {tail.length} samples ({numeral(tail.length / rate)} s) are exactly 0: "
            "the file was allocated but not filled. Crop before them, or copy the file again."
        )
        lost = tail.length / rate
        return [Flag("zero tail", name, message, tail.start / rate, n / rate, lost)]

    def _constant(self, name: str, run: _Run) -> Flag:
        unit = next(c.unit for c in self._recording.channels if c.name == name)
        time = self._recording.duration
        return Flag(
            "constant",
            name,
            f"Stands at exactly {run.value or 0.0:.6g} {unit} from the first sample to the "
            "last: it measured nothing. Check sensor and cable.",
            0.0,
            time,
            time,
        )

    def _stuck(self, name: str, run: _Run) -> Flag:
        rate = self._recording.sample_rate
        return Flag(
            "stuck",
            name,
            f"Stands at {run.value:.6g} to the end ({run.length} samples). Check sensor and "
            "cable.",
            run.start / rate,
            run.stop / rate,
            run.length / rate,
        )

    def _inside(self, name: str, runs: list[_Run], often: Mapping[int, int]) -> list[Flag]:
        """Return a flag for all the times that a channel stood still between its ends."""
        if not runs:
            return []
        rate = self._recording.sample_rate
        longest = max(runs, key=lambda run: run.length)
        first, last = min(r.start for r in runs), max(r.stop for r in runs)
        zero = longest.value == 0.0
        times = "once" if len(runs) == 1 else f"{sum(often.values())} times"
        return [
            Flag(
                "dropout" if zero else "stuck",
                name,
                f"Stands exactly still at {longest.value:.6g} {times}, for {longest.length} "
                f"samples ({numeral(longest.length / rate)} s) at "
                f"{numeral(longest.start / rate, 4)} s. Check the cable, or keep the time out "
                "of the crop.",
                first / rate,
                last / rate,
                sum(run.length for run in runs) / rate,
            )
        ]


@final
class Drift(AbstractHealthCheck):
    """Watches the mean of every channel over time."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        count = len(recording.channels)
        self._sums = np.zeros((count, PARTS))
        self._squares = np.zeros(count)
        self._edges = np.linspace(0, recording.n_samples, PARTS + 1).astype(np.int64)

    def add(self, first: int, block: FloatArray) -> None:
        self._squares += np.einsum("ij,ij->i", block, block)
        inner = np.clip(self._edges - first, 0, block.shape[1])
        for part in range(PARTS):
            if inner[part + 1] > inner[part]:
                self._sums[:, part] += block[:, inner[part] : inner[part + 1]].sum(axis=1)

    def flags(self) -> list[Flag]:
        n = self._recording.n_samples
        if n < 8 * PARTS:
            return []
        means = self._sums / np.diff(self._edges)
        mean = self._sums.sum(axis=1) / n
        spread = np.sqrt(np.maximum(self._squares / n - mean**2, 0.0))
        time = np.linspace(-0.5, 0.5, PARTS)
        slopes = (means - means.mean(axis=1, keepdims=True)) @ time / (time @ time)
        rest = means - means.mean(axis=1, keepdims=True) - np.outer(slopes, time)
        error = np.sqrt(np.sum(rest**2, axis=1) / (PARTS - 2) / (time @ time))
        flags = []
        for row, channel in enumerate(self._recording.channels):
            change = abs(slopes[row])
            relative = change / spread[row] if spread[row] else 0.0
            if change > CERTAIN * error[row] and RELEVANT < relative < COUNTER:
                flags.append(
                    Flag(
                        "drift",
                        channel.name,
                        f"The mean moves steadily by {numeral(slopes[row], 4)} {channel.unit} "
                        f"from beginning to end, {numeral(relative, 2)} of the standard "
                        "deviation. Let the sensor warm up, or remove the trend.",
                        0.0,
                        self._recording.duration,
                    )
                )
        return flags
