r"""Clipping before a filter: random vibration whose distribution has no tails.

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
"""

import math
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray, Recording
from shakerproc.recordings.health_checks.base import AbstractHealthCheck, Flag
from shakerproc.recordings.health_checks.pieces import Pieces

LOOK: Final = 2.0
"""Length of a piece at most [s]."""

FEWEST: Final = 32
"""Pieces into which a recording is cut, at least."""

MOST: Final = 128
"""Pieces at most, spread over the recording."""

SHORTEST: Final = 128
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


@final
class ShortTails(AbstractHealthCheck):
    """Watches kurtosis and spectra of all channels in pieces of up to two seconds."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        n = recording.n_samples
        longest = min(LOOK * recording.sample_rate, n / FEWEST)
        self._size = 1 << int(np.log2(longest)) if longest >= SHORTEST else 0
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
        found = []
        for number, row in enumerate(self._rows):
            lack = self._lack(number, moments[:, :, number])
            if lack is not None:
                found.append(self._flag(row, lack))
        # what limits two sensors is mechanical: friction, or a drive that is limited itself
        return found if len(found) == 1 else []

    def _lack(self, number: int, moments: FloatArray) -> float | None:
        """Return the lack of kurtosis that nothing but a limit explains, if there is one."""
        moving = moments[moments[:, 0] > AT_REST * moments[:, 0].mean()]
        power, squares, count = self._power[number], self._squares[number], len(moving)
        total = power.sum()
        if count < FEWEST // 2 or not power[LOWEST:].sum() > ABOVE * total:
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
