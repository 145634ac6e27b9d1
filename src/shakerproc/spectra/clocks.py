"""The clock of one recorder against that of another."""

from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc import checks
from shakerproc.data import FloatArray
from shakerproc.errors import SpectrumError
from shakerproc.interpolation import interpolated

SEGMENTS: Final = 24
"""Parts of a recording whose delays are found one by one [-]."""

MOST_DRIFT: Final = 1e-3
"""Largest difference of rates that is looked for: quartz differs by less than 1e-4 [-]."""

LONGEST: Final = 1 << 15
"""Of those parts [samples]."""

LEAST_CORRELATION: Final = 0.5
"""From which on two signals are believed to be of one motion [-]."""

REPEATED: Final = 0.9
"""From which share of the highest correlation on another place is as good: the motion of a
periodic excitation repeats, and the recorders are taken to have begun within a period [-]."""

FINER: Final = 8
"""Lags of a correlation between two samples, before its peak is fitted by a parabola [-]."""


@final
@dataclass(frozen=True, slots=True)
class RecorderClock:
    """Clock of a recorder: time = (t - offset) (1 + drift) at time t of another's.

    Attributes
    ----------
    offset : float
        How much later it began [s].
    drift : float
        How much faster it runs, relative [-].
    correlation : float
        Median of the parts that it was found from [-].
    """

    offset: float
    drift: float = 0.0
    correlation: float = 1.0

    def at(self, time: FloatArray) -> FloatArray:
        """Return its readings at times of the other clock [s]."""
        return (time - self.offset) * (1.0 + self.drift)


def clock_against(
    reference: FloatArray, sample_rate: float, other: FloatArray, other_rate: float
) -> RecorderClock:
    """Return the clock of a recorder, from a motion that two recorders measured.

    The loudest part of the middle of the reference is looked for in all of the other, which
    gives the offset; then every part near the place where it should be, and a straight line
    through their delays gives offset and drift.

    Parameters
    ----------
    reference, other : (n,) and (m,) arrays
        The motion as each has it, in any unit.
    sample_rate, other_rate : float
        Samples per second of each [Hz].

    Raises
    ------
    SpectrumError
        If no part of one is found in the other.
    """
    checks.positive("sample_rate", sample_rate, "Hz")
    checks.positive("other_rate", other_rate, "Hz")
    x = reference - np.mean(reference)
    same = np.arange(int(other.size * sample_rate / other_rate)) / sample_rate
    y = interpolated(lambda a, b: (other - np.mean(other))[a:b], other.size, other_rate, same,
                     sample_rate)  # fmt: skip
    length = min(max(64, x.size // SEGMENTS), LONGEST)
    starts = np.linspace(0, max(x.size - length, 0), SEGMENTS).astype(int)
    power = np.array([float(np.sum(x[a : a + length] ** 2)) for a in starts])
    quarter = SEGMENTS // 4  # of a part in the middle, the other most likely has it as well
    loudest = int(starts[quarter + np.argmax(power[quarter:-quarter])])
    lag, similarity = _delay(x[loudest : loudest + length], y, -loudest)
    rows = []
    for start in starts:
        reach = int(MOST_DRIFT * abs(start - loudest)) + 16
        first = round(start + lag) - reach
        low, high = max(first, 0), min(first + length + 2 * reach, y.size)
        if high - low > length:
            delay, correlation = _delay(
                x[start : start + length], y[low:high], low - int(start)
            )
            rows.append((start + 0.5 * length, delay, correlation))
    table: FloatArray = np.array(rows, dtype=np.float64).reshape(-1, 3)
    middle, delays, strength = table[:, 0], table[:, 1], table[:, 2]
    known = strength >= LEAST_CORRELATION
    if not known.any():
        best = max([similarity, *strength.tolist()])
        raise SpectrumError(
            f"no part of one is found in the other: they correlate to {best:.2f} at most, "
            f"where {LEAST_CORRELATION:g} is needed"
        )
    slope, at_start = _line(middle[known], delays[known])
    # delay = other less reference, in samples: other = reference (1 + slope) + at_start
    return RecorderClock(
        -at_start / (1.0 + slope) / sample_rate, slope, float(np.median(strength[known]))
    )


def _delay(part: FloatArray, among: FloatArray, shift: int) -> tuple[float, float]:
    """Return where a part begins among samples, plus `shift` [samples], and how alike it is."""
    n = scipy.fft.next_fast_len(part.size + among.size, real=True)
    cross = np.fft.rfft(among, n) * np.conj(np.fft.rfft(part, n))
    places = max(among.size - part.size + 1, 1)
    summed = np.concatenate([[0.0], np.cumsum(among**2)])
    energy = summed[part.size :] - summed[: summed.size - part.size]
    energy = np.maximum(energy, 1e-12 * max(float(energy.max()), 1e-300))
    norm = np.sqrt(energy * max(float(np.sum(part**2)), 1e-300))
    correlation = np.abs(np.fft.irfft(cross, n)[:places]) / norm
    peak = int(np.argmax(correlation))
    repeated = np.flatnonzero(correlation >= REPEATED * correlation[peak])
    repeated = repeated[np.abs(repeated - peak) > part.size // 2]
    if repeated.size:  # a motion that repeats itself: the period with the smallest offset
        nearest = int(repeated[np.argmin(np.abs(repeated + shift))])
        if abs(nearest + shift) < abs(peak + shift):
            low = max(nearest - part.size // 4, 0)
            peak = low + int(np.argmax(correlation[low : nearest + part.size // 4]))
    return shift + peak + _offset_of_peak(part, among, peak), float(correlation[peak])


def _offset_of_peak(part: FloatArray, among: FloatArray, peak: int) -> float:
    """Return how far from a place [samples] the correlation is highest, within two samples."""
    near = np.zeros(part.size + 8)
    low, high = max(peak - 4, 0), min(peak + part.size + 4, among.size)
    near[low - peak + 4 : high - peak + 4] = among[low:high]
    n = scipy.fft.next_fast_len(part.size + near.size, real=True)
    cross = np.fft.rfft(near, n) * np.conj(np.fft.rfft(part, n))
    around = np.arange(-2 * FINER, 2 * FINER + 1) / FINER
    turn = np.exp(2j * np.pi * np.outer(4.0 + around, np.arange(cross.size)) / n)
    fine = np.abs((turn @ cross).real)
    best = int(np.clip(np.argmax(fine), 1, around.size - 2))
    left, top, right = fine[best - 1 : best + 2]
    bend = left - 2.0 * top + right
    rest = 0.5 * (left - right) / bend if bend else 0.0
    return float(around[best] + rest / FINER)


def _line(x: FloatArray, y: FloatArray) -> tuple[float, float]:
    """Return slope and start of a line through points, not led astray by a few odd ones."""
    if x.size < 3:
        return 0.0, float(np.median(y))
    slope, start, *_ = scipy.stats.theilslopes(y, x)
    near = np.abs(y - start - slope * x) <= 0.5  # of a sample
    if near.sum() >= 3:
        slope, start = np.polyfit(x[near], y[near], 1)
    return float(slope), float(start)
