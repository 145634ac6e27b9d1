"""Faults of sensors that show in the samples: clipping, and hum of the mains."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.recordings.health.clipping import runs_into
from shakerproc.spectra.welch.blocks import range_ends

REPEATED: Final = 8
"""Samples at a largest or smallest value from which on it is a limit: noise never repeats its
extremes [-]."""

MAINS: Final = (50.0, 60.0)
"""Frequencies of the mains [Hz]."""

HARMONICS: Final = (1, 2, 3, 4, 5, 6, 7)
"""Harmonics that are taken away with it [-]."""

STANDS_OUT: Final = 40.0
"""Power of a line over the mean beside it from which on it is hum: once in 10^17 by chance
[-]."""

BESIDE: Final = (0.4, 4.0)
"""What lies beside a line [Hz]."""


def clipped(rows: FloatArray) -> tuple[NDArray[np.bool_], FloatArray]:
    """Return which samples stand at a limit, and the limit of each row; NaN where none is.

    Where both ends are reached that is half of the range, whatever the mean.

    Parameters
    ----------
    rows : (n_sensors, n) array
        As recorded [unit of each sensor].
    """
    hit, limits = np.zeros(rows.shape, bool), np.full(len(rows), np.nan)
    for i, (row, low, high) in enumerate(zip(rows, *range_ends([rows]), strict=True)):
        ends = 0
        for one, end in ((row, high), (-row, -low)):
            mask = one >= end
            if _is_cut_off(one, mask):
                hit[i] |= mask
                ends += 1
        if ends:
            limits[i] = 0.5 * np.ptp(row) if ends == 2 else np.max(np.abs(row))
    return hit, limits


def _is_cut_off(row: FloatArray, mask: NDArray[np.bool_]) -> bool:
    """Return whether a sensor is cut off at its largest value, and does not rest there."""
    at = np.flatnonzero(mask)
    side_by_side = at.size - 1 - np.count_nonzero(np.diff(at) > 1)
    if at.size < REPEATED or side_by_side < 2:
        return False
    quantum = float(row[at[0]] - row[~mask].max(initial=-np.inf))
    firsts = at[np.insert(np.diff(at) > 1, 0, values=True)]
    return 2 * sum(runs_into(row, int(first), quantum) for first in firsts) > firsts.size


@final
@dataclass(frozen=True, slots=True)
class Hum:
    """Hum of the mains on a sensor.

    Attributes
    ----------
    sensor : int
        Which.
    frequency : float
        Of the mains [Hz].
    """

    sensor: int
    frequency: float

    def is_in(self, band: tuple[float, float]) -> bool:
        """Return whether a harmonic lies in a band [Hz]: elsewhere no error counts it."""
        return any(band[0] <= n * self.frequency <= band[1] for n in HARMONICS)


def hum_of(residuals: Sequence[FloatArray], rates: Sequence[float]) -> tuple[Hum, ...]:
    """Return the hum that most tests show in what a model leaves.

    Parameters
    ----------
    residuals : sequence of (n_sensors, n) array
        Of every test [unit of each sensor].
    rates : sequence of float
        Samples per second [Hz].
    """
    found = []
    for i in range(len(residuals[0])):
        for mains in MAINS:
            lines = [_line(r[i], rate, mains) for r, rate in zip(residuals, rates, strict=True)]
            if 2 * sum(line > STANDS_OUT for line in lines) > len(lines):
                found.append(Hum(i, mains))
    return tuple(found)


def _line(row: FloatArray, rate: float, frequency: float) -> float:
    """Return the power at a frequency over the mean beside it [-]."""
    window = np.hanning(row.size)
    length = scipy.fft.next_fast_len(row.size, real=True)
    power = np.abs(scipy.fft.rfft(row * window, length)) ** 2
    off = np.abs(scipy.fft.rfftfreq(length, 1.0 / rate) - frequency)
    beside = power[(off > BESIDE[0]) & (off < BESIDE[1])]
    turn = np.exp(-2j * np.pi * frequency / rate * np.arange(row.size))
    line = float(np.abs(np.sum(row * window * turn)) ** 2)
    return line / max(float(np.mean(beside)), 1e-300) if beside.size else 0.0


def hum_in(row: FloatArray, rate: float, frequency: float) -> FloatArray:
    """Return hum [unit of the row] of a frequency [Hz] and its harmonics, (n,) array."""
    angle = np.asarray(2.0 * np.pi * frequency / rate * np.arange(row.size), np.float64)
    each = [
        f for h in HARMONICS if h * frequency < 0.45 * rate for f in _pair(angle * float(h))
    ]
    columns = np.array(each).T
    return np.asarray(columns @ np.linalg.lstsq(columns, row, rcond=None)[0])


def _pair(angle: FloatArray) -> tuple[FloatArray, FloatArray]:
    return np.cos(angle), np.sin(angle)
