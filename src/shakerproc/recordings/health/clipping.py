r"""Clipping: samples exactly at the extreme, and random vibration whose tails are cut.

A filter, or AC coupling, behind a clipped stage leaves no samples at one value, but the tails
stay short. Of random vibration through anything linear the excess kurtosis is 0, give or take

.. math:: \sigma = \sqrt{\frac{24}{n} \sum_k \rho_k^4}

with the autocorrelation :math:`\rho_k`. A sine, a sweep and a square wave have short tails as
well: a share s of such power explains an excess of :math:`-2 s^2` at most (-2 is that of a
square wave). It shows in the powers of the pieces: in a bin the mean square over the squared
mean is 2 - s, and their sum varies less than that of noise by :math:`(1 - s)^2`.

A lightly damped response tells its kurtosis badly, but its largest sample well: of n samples

.. math:: E = \frac{n}{\sum_k \rho_k^2} \operatorname{erfc}\frac{m}{\sqrt 2}

independent ones lie beyond the largest, m standard deviations, where n / sum are as many as
tell the power of so much noise [1]_. It has none with a probability of :math:`e^{-E}`.

.. [1] J. S. Bendat and A. G. Piersol, "Random Data", 4th ed., section 8.3.

Found of 8 simulated runs of 40 s, by the level of clipping in standard deviations:

============= ============ ================= ============ ==================
level         resonant AC  resonant low-pass broadband AC broadband low-pass
============= ============ ================= ============ ==================
1.2 (23 %)    8            8                 8            6
1.5 (13 %)    8            8                 8            6
1.7 (9 %)     8            8                 8            2
2.0 (4.6 %)   8            7                 8            0
2.3 (2.1 %)   7            0                 7            0
2.5 and above 0            0                 0            0
============= ============ ================= ============ ==================

The 1 % that controllers clip on purpose is not told.

What comes to rest at its extreme (a slider that sticks, a pendulum that is held) reads the same
value as often as what is cut off there. It slows down before, to a third of its way in each of
two equal times under a constant deceleration; what runs into a limit does not.
"""

import math
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray, Recording
from shakerproc.recordings.health.base import AbstractHealthCheck, Flag, Pieces

SHORTEST_ROW: Final = 3
"""Samples in a row at the extreme that count."""

FEWEST_IN_ROWS: Final = 6
"""Samples in such rows that make a flag."""

PILE: Final = 5.0
"""How many times as many samples as at the next value there must be at the extreme.

A quantized sine has 2.4 times as many at its crest as one step below, noise fewer.
"""

ARRIVING: Final = 0.62
"""Share of the way of one step that the next one has, below which the motion comes to rest: one
third to three fifths under a constant deceleration, 1 where a steep signal is cut off [-]."""

RESOLVED: Final = 8.0
"""Way of both steps at least, in steps of the converter [-]."""

LONGEST_STEP: Final = 64
"""Samples of a step at most [-]."""

RESTING: Final = 0.5
"""Share of samples from which on the extreme is where the channel rests."""

LOOK: Final = 2.0
"""Length of a piece at most [s]."""

FEWEST_PIECES: Final = 32
"""Pieces into which a recording is cut, at least."""

MOST: Final = 128
"""Pieces at most, spread over the recording."""

SHORTEST_PIECE: Final = 128
"""Samples of a piece at least."""

LOWEST: Final = 4
"""Bin below which a piece holds too few periods to tell noise from a tone."""

ABOVE: Final = 0.9
"""Share of the power that must lie above `LOWEST` [-]."""

AT_REST: Final = 0.01
"""Power of a piece over the mean, below which the channel rests [-]."""

ALLOWED: Final = 0.24
"""Lack of kurtosis of Gaussian noise clipped at 2.5 standard deviations [-].

Controllers clip their drive there or higher, on purpose.
"""

CERTAIN: Final = 5.0
"""Standard errors beyond that: 3e-7 of Gaussian noise on the edge of what is allowed [-]."""

CLIPPED_ON_PURPOSE: Final = 2.5
"""Level at which controllers clip their drive, or higher [standard deviations]."""

NONE_BEYOND: Final = 15.0
"""Independent samples expected beyond the largest: 3e-7 of Gaussian noise has none [-]."""

JUDGED: Final = frozenset({"m/s^2", "N"})
"""Units of what nothing in a structure limits but friction; a stop limits displacements."""


def runs_into(samples: FloatArray, first: int, quantum: float) -> bool:
    """Return whether a signal is cut off where it comes to its extreme, not at rest there.

    Parameters
    ----------
    samples : (n,) array
        The signal [unit of the channel].
    first : int
        First sample at the extreme.
    quantum : float
        Distance of the next value from the extreme [unit of the channel].
    """
    before, size = first - 1, 1
    while before >= 2 * size and size <= LONGEST_STEP:
        last, middle, begin = samples[[before, before - size, before - 2 * size]]
        near, far = abs(last - middle), abs(middle - begin)
        if near + far >= RESOLVED * quantum:
            return bool(near > ARRIVING * far)
        size *= 2
    return False


@final
class _Side:
    """The extreme of one channel on one side (+1 or -1)."""

    def __init__(self, sign: int) -> None:
        self.sign = sign
        self.value = -np.inf
        self.count = 0
        self.next_value = -np.inf
        self.next_count = 0
        self.in_rows = 0
        self.first = 0
        self.last = 0
        self._row = 0
        self._is_cut = False

    def add(self, first: int, samples: FloatArray) -> None:
        """Take in the samples of a block, times the sign."""
        top = float(samples.max())
        if top < self.next_value:
            self._row = 0
            return
        span = top - float(samples.min())
        near = samples[samples >= top - 1e-3 * span]
        values = near[near < top] if near.size > 1 else near[:0]
        if not values.size:
            values = samples[samples < top]
        largest = float(values.max()) if values.size else -np.inf
        counts = {top: int(np.count_nonzero(near == top))}
        if values.size:
            counts[largest] = int(np.count_nonzero(values == largest))
        if self.count:
            counts[self.value] = counts.get(self.value, 0) + self.count
        if self.next_count:
            counts[self.next_value] = counts.get(self.next_value, 0) + self.next_count
        ordered = sorted(counts, reverse=True)
        quantum = ordered[0] - ordered[1] if len(ordered) > 1 else 0.0
        self._rows(first, samples, top, quantum)
        self.value, self.count = ordered[0], counts[ordered[0]]
        if len(ordered) > 1:
            self.next_value, self.next_count = ordered[1], counts[ordered[1]]

    def _rows(self, first: int, samples: FloatArray, top: float, quantum: float) -> None:
        """Count the samples that stand in rows at the extreme, where they are cut off."""
        if top > self.value:
            self.in_rows, self._row, self.first = 0, 0, -1
        if top < self.value:
            self._row = 0
            return
        at = np.flatnonzero(samples == top)
        groups = (
            np.split(at, np.flatnonzero(np.diff(at) > 1) + 1) if at.size < 100_000 else [at]
        )
        for group in groups:
            length, goes_on = group.size, group[-1] == samples.size - 1
            if group[0] == 0 and self._row:
                length += self._row
            elif length >= SHORTEST_ROW or goes_on:
                self._is_cut = runs_into(samples, int(group[0]), quantum)
            if length >= SHORTEST_ROW and self._is_cut:
                self.in_rows += length
                self.first = first + int(group[0]) if self.first < 0 else self.first
                self.last = first + int(group[-1])
        self._row = groups[-1].size if groups[-1][-1] == samples.size - 1 else 0

    def is_clipped(self, n_samples: int) -> bool:
        """Return whether the samples pile up at the extreme."""
        return (
            self.in_rows >= FEWEST_IN_ROWS
            and self.value != 0.0
            and self.count > PILE * max(self.next_count, 1)
            and self.count < RESTING * n_samples
        )


@final
class Extremes(AbstractHealthCheck):
    """Watches the largest and the smallest value of every channel."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        self._sides = [(_Side(1), _Side(-1)) for _ in recording.channels]

    def add(self, first: int, block: FloatArray) -> None:
        for (high, low), samples in zip(self._sides, block, strict=True):
            high.add(first, samples)
            low.add(first, -samples)

    def flags(self) -> list[Flag]:
        flags = []
        rate = self._recording.sample_rate
        for channel, sides in zip(self._recording.channels, self._sides, strict=True):
            hit = [side for side in sides if side.is_clipped(self._recording.n_samples)]
            if hit:
                limits = " and ".join(f"{side.sign * side.value:.6g}" for side in hit)
                count = sum(side.count for side in hit)
                flags.append(
                    Flag(
                        "clipping",
                        channel.name,
                        f"{count} samples stand exactly at {limits} {channel.unit}: the range "
                        "was too small. Measure again with a larger range.",
                        min(side.first for side in hit) / rate,
                        max(side.last for side in hit) / rate,
                        count / rate,
                    )
                )
        return flags


@final
class ShortTails(AbstractHealthCheck):
    """Watches kurtosis and spectra of all channels in pieces of up to two seconds."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        n = recording.n_samples
        longest = min(LOOK * recording.sample_rate, n / FEWEST_PIECES)
        self._size = 1 << int(np.log2(longest)) if longest >= SHORTEST_PIECE else 0
        count = min(MOST, n // self._size) if self._size else 0
        self._rows = [i for i, c in enumerate(recording.channels) if c.unit in JUDGED]
        starts = [k * n // count for k in range(count)] if self._rows else []
        self._pieces = Pieces(starts, self._size)
        self._window = np.hanning(self._size)
        shape = (len(self._rows), self._size // 2 + 1)
        self._power, self._squares = np.zeros(shape), np.zeros(shape)
        self._moments: list[FloatArray] = []

    def add(self, first: int, block: FloatArray) -> None:
        for piece in self._pieces.of(first, block):
            level = piece[self._rows]
            level -= level.mean(axis=1, keepdims=True)
            square = level**2
            spectrum = np.fft.rfft(level * self._window, axis=1)
            power = spectrum.real**2 + spectrum.imag**2
            self._power += power
            self._squares += power**2
            self._moments.append(
                np.array([
                    square.mean(axis=1),
                    (square**2).mean(axis=1),
                    power.sum(axis=1),
                    square.max(axis=1),
                ])
            )

    def flags(self) -> list[Flag]:
        if not self._moments:
            return []
        moments = np.array(self._moments)
        flags = []
        for number, row in enumerate(self._rows):
            lack = self._lack(number, moments[:, :, number])
            if lack is not None:
                flags.append(self._flag(row, lack))
        # what limits two sensors is mechanical: friction, or a drive that is limited itself
        return flags if len(flags) == 1 else []

    def _lack(self, number: int, moments: FloatArray) -> float | None:
        """Return the lack of kurtosis that nothing but a limit explains, if there is one."""
        moving = moments[moments[:, 0] > AT_REST * moments[:, 0].mean()]
        power, squares, count = self._power[number], self._squares[number], len(moving)
        total = power.sum()
        if count < FEWEST_PIECES // 2 or not power[LOWEST:].sum() > ABOVE * total:
            return None
        lack = 3.0 - float(moving[:, 1].mean() / moving[:, 0].mean() ** 2)
        correlation = np.fft.irfft(power)
        correlation /= correlation[0]
        error = np.sqrt(24.0 * np.sum(correlation**4) / (count * self._size))
        bins = power[power > 0.0]
        ratio = len(moments) * squares[power > 0.0] / bins**2
        steady = abs(2.0 * count / (count + 1.0) - float(ratio @ bins / total))
        # neighbouring bins of a Hann window share 4/9, next but one 1/36 of their variance
        noise = power @ power + 2.0 * (power[1:] @ power[:-1]) * 4.0 / 9.0
        noise = (noise + 2.0 * (power[2:] @ power[:-2]) / 36.0) / total**2
        varies = float(np.var(moving[:, 2], ddof=1) / moving[:, 2].mean() ** 2 / noise)
        share = min(1.0, max(steady, 1.0 - np.sqrt(varies)))
        unexplained = lack - 2.0 * share**2
        if unexplained > ALLOWED + CERTAIN * error:
            return lack
        largest = float(np.sqrt(moving[:, 3].max() / moving[:, 0].mean()))
        independent = count * self._size / np.sum(correlation**2)
        beyond = independent * math.erfc(largest / math.sqrt(2.0))
        ends = largest < CLIPPED_ON_PURPOSE and beyond > NONE_BEYOND
        return lack if ends and unexplained > ALLOWED else None

    def _flag(self, row: int, lack: float) -> Flag:
        return Flag(
            "short tails",
            self._recording.channels[row].name,
            f"The kurtosis of this random vibration is {3.0 - lack:.2f}, of a Gaussian one 3: "
            "probably it was clipped before a filter or AC coupling. Measure again with a "
            "larger range, unless friction or the drive limits it.",
            0.0,
            self._recording.duration,
        )
