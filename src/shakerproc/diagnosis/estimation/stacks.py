"""Windows of one test and one length side by side, so that one call treats them all."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.diagnosis.data import PreparedTest

if TYPE_CHECKING:
    from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.parts import Windows

TAPS: Final = 21
"""Length of the low-pass: as short as windows of two periods of a tenth of the rate [-]."""

HIGHEST_SHARE: Final = 0.3
"""Highest frequency of the residual over the sample rate: above it kinks and jumps of the force
alias, and the filters of recorders differ [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Stack:
    """Windows of one test and one length, of which the same samples count.

    Attributes
    ----------
    members : (n_members,) array of int
        Which windows.
    measured : (n_members, n_sensors, n) array
        What the sensors recorded [unit of the sensor].
    noise : (n_members, n_sensors, n_counted) array
        Standard deviation of what counts [unit of the sensor].
    counted : (n,) array of bool
        Which samples count; never the first, in which the filter fills.
    low_pass : (TAPS,) array
        Coefficients that keep the compared band [-].
    high_pass : array or None
        Second-order sections, for windows that begin at rest: those with starts of their own
        are too short for it.
    sample_rate : float
        Samples per second [Hz].
    sound : (n_members, n_sensors, n) array of bool, optional
        Which samples are not clipped; all by default.
    """

    members: NDArray[np.int64]
    measured: FloatArray
    noise: FloatArray
    counted: NDArray[np.bool_]
    low_pass: FloatArray
    high_pass: FloatArray | None
    sample_rate: float
    sound: NDArray[np.bool_] | None = None

    @property
    def size(self) -> int:
        """Residuals of one window."""
        return int(self.noise.shape[1] * self.noise.shape[2])

    def of(self, outputs: Sequence[FloatArray]) -> FloatArray:
        """Return the members' part of what every window has, (n_members, n_sensors, n)."""
        return np.array([outputs[i] for i in self.members])

    def weighted(self, rows: FloatArray) -> FloatArray:
        """Return counted values of rows, over the noise, (n_members, n_sensors, n_counted)."""
        if self.sound is not None:
            rows = np.where(self.sound, rows, 0.0)
        rows = scipy.ndimage.convolve1d(
            rows, self.low_pass, axis=-1, mode="constant", origin=-(TAPS // 2)
        )
        if self.high_pass is not None:
            rows = scipy.signal.sosfilt(self.high_pass, rows)
        kept: FloatArray = rows[..., self.counted] / self.noise
        return kept

    def slope_in_time(self, rows: FloatArray) -> FloatArray:
        """Return the slope of rows in time [unit of the sensor/s]."""
        return slope_in_time(rows, self.sample_rate)


def slope_in_time(rows: FloatArray, sample_rate: float) -> FloatArray:
    """Return the slope of rows in time, by differences of fourth order but at the ends.

    At a twentieth of the sample rate [Hz] it is right to 3e-4, where the difference of two
    neighbours misses 2 % of it: a delay would be larger by as much.
    """
    slope = np.asarray(np.gradient(rows, axis=-1))
    if rows.shape[-1] > 4:  # samples of the formula, less one
        near, far = rows[..., 3:-1] - rows[..., 1:-3], rows[..., 4:] - rows[..., :-4]
        slope[..., 2:-2] = (8.0 * near - far) / 12.0
    return slope * sample_rate


def stacks_of(data: "DataSet", windows: "Windows") -> tuple[Stack, ...]:
    """Return windows side by side."""
    alike: dict[tuple[int, int, bytes], list[int]] = {}
    for i, (test, _first, size) in enumerate(windows.table):
        mask = windows.counted[i]
        alike.setdefault((int(test), int(size), mask.tobytes()), []).append(i)
    return tuple(_stack(data, windows, np.array(members)) for members in alike.values())


def _stack(data: "DataSet", windows: "Windows", members: NDArray[np.int64]) -> Stack:
    test, _, size = windows.table[members[0]]
    counted = windows.counted[members[0]].copy()
    counted[:TAPS] = False
    firsts = windows.table[members, 1]
    lost = data.tests[test].clipped
    sound = ~np.array([lost[:, a : a + size] for a in firsts])
    noise = np.array([data.noise[test][:, a : a + size] for a in firsts])
    if windows.passed is not None:
        noise = np.hypot(noise, [windows.passed[i] for i in members])
    return Stack(
        members=members,
        measured=np.array([data.measured[test][:, a : a + size] for a in firsts]),
        noise=noise[..., counted],
        counted=counted,
        low_pass=_low_pass(data.tests[test]),
        high_pass=_high_pass(data.tests[test]) if windows.from_rest else None,
        sample_rate=data.tests[test].sample_rate,
        sound=None if sound.all() else sound,
    )


def _high_pass(test: PreparedTest) -> FloatArray:
    """Return the high-pass of a test, as second-order sections."""
    own = scipy.signal.butter(2, test.band[0], "high", output="sos", fs=test.sample_rate)
    return np.asarray(own)


def _low_pass(test: PreparedTest) -> FloatArray:
    """Return coefficients that keep the compared band of a test, (TAPS,) array [-]."""
    edge = min(test.band[1], HIGHEST_SHARE * test.sample_rate)
    return np.asarray(scipy.signal.firwin(TAPS, edge, fs=test.sample_rate))
