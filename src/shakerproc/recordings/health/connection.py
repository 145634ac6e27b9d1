"""Channels to which nothing is connected: noise or hum that no other channel shares.

Between the pieces of a recording, noise has random phases against whatever another channel
measures. Its coherence over K pieces is then Beta(1, K - 1) distributed at every frequency,
however the other channel moves: random, swept, or once for a moment. A channel is called open
where no coherence with any other channel rises above what that leaves to chance, while the
others show that the same test finds a common motion.
"""

from collections.abc import Iterator
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import FloatArray, Recording
from shakerproc.numerals import numeral
from shakerproc.recordings.health.base import (
    AbstractHealthCheck,
    Flag,
    Gaps,
    Pieces,
    control_rows,
)

SIGNIFICANCE: Final = 1e-4
"""Probability that chance alone makes an open channel look connected, at each length [-]."""

LOOKS: Final = (0.2, 2.0)
"""Lengths of the pieces: many for what is noisy, long ones for what is slow [s]."""

FEWEST: Final = 24
"""Pieces at least: a coherence of 0.6 at a single one of 1000 frequencies then counts."""

MOST: Final = 512
"""Pieces at most, spread over the recording."""

SHORTEST: Final = 256
LONGEST: Final = 16384
"""Samples of a piece, at least and at most."""

REFERENCES: Final = 8
"""Channels that the others are compared with: the controls first."""

JUDGED: Final = frozenset({"m/s^2", "m/s", "m", "N", "rad/s^2", "rad/s", "rad", "N m"})
"""Units of what moves with the specimen; a temperature need not."""

SEEN: Final = 0.1
"""Share of a channel's power that its pieces must have caught for it to be judged [-].

Of noise and of anything steady they catch about all. A single blow may fall between two pieces,
or under the edge of a window; what is left of it is the recorder's noise.
"""

APART: Final = 3
"""Bins from one to the next whose noise a Blackman window leaves independent."""

AT_ONCE: Final = 2**17
"""Samples of a channel that are read at once for the longer pieces."""

MAINS: Final = (50.0, 60.0)
HARMONICS: Final = 7
"""Multiples of the mains frequency that hum is looked for at."""

HUM: Final = 0.5
"""Share of the power at the mains from which on it is hum, or the excitation itself [-]."""

HALF: Final = 0.5
"""Share of another channel's power that a channel of a lower rate must be able to see [-]."""

STEADY: Final = 1.5
"""Unsteadiness half-way between that of a tone (1) and that of noise (2) [-]."""

PASSING: Final = 3.0
"""Unsteadiness from which on it is no stationary noise: over 24 pieces noise reaches 2.9 [-].

The mean is 2, one standard deviation is 2 / sqrt(K), here 0.4; it is taken over many bins.
"""

LOUDER: Final = 10.0
"""How many times as loud a channel that measures must be as one that is not connected [-]."""


@final
class _Averages:
    """Cross spectra of all channels with the first ones over pieces of one length."""

    def __init__(self, n_samples: int, count: int, size: int) -> None:
        self.size = size
        n_pieces = min(MOST, n_samples * 8 // (size * 9))
        stride = n_samples / max(n_pieces, 1)
        generator = np.random.default_rng(0)  # no tone keeps its phase from piece to piece
        room = max(1, int(stride) - size)
        offsets = generator.integers(0, room, size=n_pieces)
        starts = [int(k * stride) + int(at) for k, at in enumerate(offsets)]
        self._pieces = Pieces(starts, size)
        self._window = np.blackman(size)
        time = np.linspace(-1.0, 1.0, size)
        self._line = np.array([np.full(size, size**-0.5), time / np.sqrt(time @ time)])
        bins = size // 2 + 1
        self.power = np.zeros((count, bins))
        self.fourth = np.zeros((count, bins))  # squares of the powers of the pieces
        self.cross = [  # of each reference with all that follow: once is enough
            np.zeros((count - reference - 1, bins), dtype=np.complex128)
            for reference in range(min(REFERENCES, count))
        ]
        self.moved = np.zeros(count, dtype=bool)

    @property
    def pieces(self) -> int:
        return len(self._pieces.starts)

    def add(self, first: int, block: FloatArray) -> None:
        """Take in a block and transform every piece that it completes."""
        for piece in self._pieces.of(first, block):
            self._transform(piece)

    def _transform(self, piece: FloatArray) -> None:
        if not self.moved.all():
            self.moved |= np.ptp(piece, axis=1) > 0.0
        seen = piece - (piece @ self._line.T) @ self._line
        seen *= self._window
        spectrum = np.fft.rfft(seen, axis=1)
        power = spectrum.real**2 + spectrum.imag**2
        self.power += power
        self.fourth += power**2
        mirrored = spectrum.conj()
        for reference in range(len(self.cross)):
            self.cross[reference] += spectrum[reference + 1 :] * mirrored[reference]

    def caught(self) -> FloatArray:
        """Return the mean power of each channel in the pieces [its unit, squared]."""
        both = 2.0 * self.power.sum(axis=1) - self.power[:, 0] - self.power[:, -1]  # Parseval
        return np.asarray(both / (self.size * np.sum(self._window**2) * max(self.pieces, 1)))

    def unsteadiness(self) -> FloatArray:
        """Return the mean square of the power over its squared mean, by channel and bin [-].

        It is 1 of a tone that stands still, 2 of noise (its power is spread exponentially),
        and K over the pieces that hold it of what passes by; 0 where there is no power.
        """
        values: FloatArray = np.zeros_like(self.power)
        np.divide(self.pieces * self.fourth, self.power**2, out=values, where=self.power > 0.0)
        return values

    def coherent(self, keep: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return which channels share a motion with any other."""
        mask = np.zeros(self.moved.size, dtype=bool)
        for reference in range(len(self.cross)):
            for row in range(reference + 1, self.moved.size):
                if mask[reference] and mask[row]:
                    continue  # another pair has shown it of both
                if self.moved[reference] and self.moved[row]:
                    chance = self._p_value(row, reference, keep)
                    mask[[reference, row]] |= chance < SIGNIFICANCE
        return mask

    def _p_value(self, row: int, reference: int, keep: NDArray[np.bool_]) -> float:
        """Return how likely chance makes coherences as large, at one frequency or at all.

        The largest of M coherences exceeds x with a probability of at most
        M (1 - x)^(K - 1), and -(K - 1) sum ln(1 - x) over M independent ones is Gamma(M).
        """
        product = self.power[row] * self.power[reference]
        used = np.flatnonzero(keep & (product > 0.0))
        if not used.size:
            return 1.0
        unexplained = (
            1.0 - np.abs(self.cross[reference][row - reference - 1, used]) ** 2 / product[used]
        )
        depth = -(self.pieces - 1) * np.log(np.clip(unexplained, 1e-300, 1.0))
        tries = 2.0 * len(self.cross)
        at_one = used.size * float(np.exp(-depth.max()))
        independent = depth[::APART]
        at_all = float(scipy.special.gammaincc(independent.size, independent.sum()))
        return min(1.0, tries * min(at_one, at_all))


@final
class Connection(AbstractHealthCheck):
    """Watches for channels whose samples have nothing in common with those of any other."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        self._rows = [i for i, c in enumerate(recording.channels) if c.unit in JUDGED]
        inputs = [i for i, c in enumerate(recording.channels) if c.role == "force"]
        self._inputs = {*control_rows(recording), *inputs} & set(self._rows)
        self._rows.sort(key=lambda row: row not in self._inputs)  # stable: inputs come first
        self._squares, self._sums = np.zeros(len(self._rows)), np.zeros(len(self._rows))
        self._sizes = list(_sizes(recording)) if len(self._rows) > 1 else []
        self._averages = [self._of_size(size) for size in self._sizes[:1]]

    def _of_size(self, size: int) -> _Averages:
        return _Averages(self._recording.n_samples, len(self._rows), size)

    def _judged(self, block: FloatArray) -> FloatArray:
        return block if self._rows == list(range(len(block))) else block[self._rows]

    def add(self, first: int, block: FloatArray) -> None:
        judged = self._judged(block)
        self._squares += np.einsum("ij,ij->i", judged, judged)
        self._sums += judged.sum(axis=1)
        for averages in self._averages:
            averages.add(first, judged)

    def flags(self) -> list[Flag]:
        if not self._averages:
            return []
        if not np.any(self._averages[0].moved & ~self._connected()):
            return []  # what many short pieces show to be connected needs no longer ones
        self._look_longer()
        connected = self._connected()
        judged = self._averages[0].moved & self._caught_enough()
        alone = [
            row
            for row in np.flatnonzero(judged & ~connected).tolist()
            if self._should_move(row, connected, judged) and self._is_noise_or_hum(row)
        ]
        return [self._flag(row) for row in alone if connected.any() or self._is_quiet(row)]

    def _spread(self, row: int) -> float:
        """Return the standard deviation of a channel [its unit]."""
        n = self._recording.n_samples
        return float(np.sqrt(max(self._squares[row] / n - (self._sums[row] / n) ** 2, 0.0)))

    def _is_quiet(self, row: int) -> bool:
        """Return whether it may be the one that is not connected, where none is seen to be.

        Of two channels without anything in common one measures, and by far the louder one.
        """
        unit = self._recording.channels[self._rows[row]].unit
        largest = max(
            self._spread(other)
            for other, at in enumerate(self._rows)
            if self._recording.channels[at].unit == unit
        )
        spread = self._spread(row)
        quietest = min(self._spread(other) for other in range(len(self._rows)))
        return spread * LOUDER <= largest or quietest * LOUDER > largest

    def _is_noise_or_hum(self, row: int) -> bool:
        """Return whether half of its power is noise or hum, as of an open input.

        Orders of a shaft and tones that no other channel shares come from something.
        """
        averages = self._averages[-1]
        power, steady = averages.power[row], averages.unsteadiness()[row]
        noise = float(power[(steady > STEADY) & (steady < PASSING)].sum() / power.sum())
        return noise + max(self._hum(row, mains) for mains in MAINS) >= HUM

    def _hum(self, row: int, mains: float) -> float:
        """Return the share of its power that is steady, on multiples of the mains [-].

        A resonance there holds noise, whose power varies from piece to piece.
        """
        averages = self._averages[-1]
        near = self._near(averages, mains) & (averages.unsteadiness()[row] <= STEADY)
        return float(_share(averages.power[[row]], near)[0])

    def _look_longer(self) -> None:
        """Take the averages of the longer pieces, in a pass of their own."""
        self._averages += [self._of_size(size) for size in self._sizes[1:]]
        gaps = Gaps(self._recording)
        for number, block in enumerate(self._recording.blocks(size=AT_ONCE)):
            judged = self._judged(gaps.add(number * AT_ONCE, block))
            for averages in self._averages[1:]:
                averages.add(number * AT_ONCE, judged)

    def _connected(self) -> NDArray[np.bool_]:
        """Return which channels share a motion with any other."""
        coherent = [one.coherent(self._without_hum(one)) for one in self._averages]
        return np.asarray(np.any(coherent, axis=0))

    def _caught_enough(self) -> NDArray[np.bool_]:
        """Return which channels the pieces show as they are, and not between two blows."""
        n = self._recording.n_samples
        power = self._squares / n - (self._sums / n) ** 2
        caught = np.max([averages.caught() for averages in self._averages], axis=0)
        return np.asarray(caught >= SEEN * power)

    def _should_move(
        self, row: int, connected: NDArray[np.bool_], judged: NDArray[np.bool_]
    ) -> bool:
        """Return whether it is known that the channel must share a motion with another.

        The log says that the table is driven, and another channel is seen to move; or other
        channels move together, for a control (which rests while something decays) other
        controls with anything. Half of their power must lie where the channel sees it, which
        one with a low rate of its own does not.
        """
        others = (np.arange(len(self._rows)) != row) & (self._reach(row) >= HALF)
        if self._recording.driven:
            return bool(judged[others].any())
        if self._rows[row] in self._inputs:
            others[len(self._inputs) :] = False  # the inputs come first
        return bool(connected[others].any())

    def _reach(self, row: int) -> FloatArray:
        """Return the share of each channel's power below half the own rate of one [-]."""
        averages, rate = self._averages[-1], self._recording.sample_rate
        channel_rate = self._recording.channels[self._rows[row]].own_rate or rate
        below = np.arange(averages.power.shape[1]) * rate / averages.size <= channel_rate / 2.0
        return _share(averages.power, below)

    def _without_hum(self, averages: _Averages) -> NDArray[np.bool_]:
        """Return which bins are judged: those of hum are not, unless hum is the excitation."""
        keep = np.ones(averages.power.shape[1], dtype=bool)
        keep[:2], keep[-1] = False, False
        for mains in MAINS:
            near = self._near(averages, mains)
            share = _share(averages.power, near)
            if np.median(share) < HUM:
                keep &= ~near
        return keep

    def _near(self, averages: _Averages, mains: float) -> NDArray[np.bool_]:
        """Return the bins within the window's width of the mains frequency's multiples."""
        width = self._recording.sample_rate / averages.size
        frequency = np.arange(averages.power.shape[1]) * width
        order = np.rint(frequency / mains)
        near = np.abs(frequency - order * mains) <= APART * width
        known = mains > 2.0 * (APART + 1) * width
        return np.asarray(near & (order >= 1) & (order <= HARMONICS) & known)

    def _flag(self, row: int) -> Flag:
        recording = self._recording
        channel = recording.channels[self._rows[row]]
        spread = self._spread(row)
        hum, mains = max((self._hum(row, mains), mains) for mains in MAINS)
        text = f", {hum:.0%} of its power mains hum ({mains:g} Hz)" if hum > HUM else ""
        time = recording.duration
        return Flag(
            "open input",
            channel.name,
            f"Noise of {numeral(spread)} {channel.unit} rms{text} that has nothing in common "
            "with any other channel: nothing is connected, a cable is broken, or the sensor "
            "sits where nothing moves. Check it, or give the channel the role ignore.",
            0.0,
            time,
            time,
        )


def _share(power: FloatArray, near: NDArray[np.bool_]) -> FloatArray:
    """Return the share of each channel's power in some bins; 0 of nothing."""
    total = power.sum(axis=1)
    share: FloatArray = np.zeros_like(total)
    np.divide(power[:, near].sum(axis=1), total, out=share, where=total > 0.0)
    return share


def _sizes(recording: Recording) -> Iterator[int]:
    """Yield the lengths of pieces of which the recording holds enough [samples]."""
    n, seen = recording.n_samples, 0
    for look in LOOKS:
        wanted = min(look * recording.sample_rate, n * 8 / (FEWEST * 9), float(LONGEST))
        size = 1 << int(np.log2(max(wanted, 1.0)))
        if size >= SHORTEST and size > seen:
            seen = size
            yield size
