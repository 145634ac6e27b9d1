"""The phase of a tone whose frequency moves, from the control signal itself.

The ridge of the signal (or the straight law that it follows) is integrated to a phase, and
what is left of the phase of the signal is added, twice.
"""

from dataclasses import dataclass
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.errors import SpectrumError
from shakerproc.numerals import numeral
from shakerproc.spectra.welch.spectrograms import CHUNK, Ridge, SampleReader, median_of_five

LAW: Final = 0.03
"""Median relative distance from a straight law below which the law is used [-]."""

PULL_IN: Final = 6.0
"""Periods in a window in which what is left of the phase is measured."""


HALF_HANN: Final = 0.5 + 0.5 * np.cos(np.linspace(0.0, np.pi, 8193))
"""A Hann window from its middle to its end, fine enough to be read to eight digits."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class ToneTrack:
    """Phase of a tone at knots, a cubic with continuous slope between them.

    Attributes
    ----------
    position : (n,) array
        Samples from the start.
    phase : (n,) array
        Phase [rad].
    omega : (n,) array
        Its slope [rad/sample].
    """

    position: FloatArray
    phase: FloatArray
    omega: FloatArray

    def phase_at(self, position: FloatArray) -> FloatArray:
        """Return the phase at any place between the first and the last knot [rad]."""
        from shakerproc.spectra.kernels import phase_of_track  # loads the compiler: late

        result = np.empty(position.shape)
        phase_of_track(self.position, self.phase, self.omega, position, result)
        return result

    def position_of(self, phase: FloatArray) -> FloatArray:
        """Return where a rising phase reaches given values, to a few parts in a thousand.

        `phase` is in [rad].
        """
        return np.interp(phase, self.phase, self.position)


def track_of(
    read: SampleReader, ridge: Ridge, section: tuple[int, int], sample_rate: float
) -> ToneTrack:
    """Return the phase of the tone in one section of its ridge.

    Parameters
    ----------
    read : callable
        Gives (1, n) samples.
    ridge : Ridge
        Frequency against time.
    section : (int, int)
        First and last place of the ridge.
    sample_rate : float
        Samples per second [Hz].

    Returns
    -------
    Track
        Phase that agrees with that of the signal.

    Raises
    ------
    SpectrumError
        If the section holds too few periods to follow.
    """
    part = slice(section[0], section[1] + 1)
    position = ridge.position[part]
    omega = 2.0 * np.pi * _lawful(position, ridge.frequency[part]) / sample_rate
    steps = np.diff(position) * (omega[1:] + omega[:-1]) / 2.0
    track = ToneTrack(position, np.concatenate([[0.0], np.cumsum(steps)]), omega)
    for _ in range(2):
        track = _pulled_in(read, track)
    return track


def demodulated(
    read: SampleReader,
    track: ToneTrack,
    centres: FloatArray,
    periods: FloatArray,
    n_harmonics: int,
) -> tuple[ComplexArray, FloatArray]:
    """Return complex amplitudes against multiples of a phase, in windows along it.

    The window is a Hann window over the phase, over whole periods: to it neither the mean
    nor another harmonic is visible.

    Parameters
    ----------
    read : callable
        Gives (n_channels, n) samples.
    track : ToneTrack
        Phase of the tone.
    centres : (n_windows,) array
        Phase in the middle of each window, rising [rad].
    periods : (n_windows,) array
        Whole number of periods in each window [-].
    n_harmonics : int
        How many harmonics, from the first.

    Returns
    -------
    (n_channels, n_harmonics, n_windows) complex array
        Amplitudes; the real part goes with the cosine.
    (n_channels, n_windows) array
        Mean square in each window.
    """
    from shakerproc.spectra.kernels import demodulate  # loads the compiler: late

    half = np.pi * periods
    first = np.floor(track.position_of(centres - half)).astype(np.int64) - 2
    last = np.ceil(track.position_of(centres + half)).astype(np.int64) + 3
    first = np.maximum(first, int(np.ceil(track.position[0])))
    last = np.minimum(last, int(np.floor(track.position[-1])) + 1)
    amplitudes, squares = [], []
    for start, stop in _groups(first, last):
        begin = int(first[start:stop].min())
        block = np.ascontiguousarray(read(begin, int(last[start:stop].max())))
        sums = np.zeros((stop - start, block.shape[0], n_harmonics, 2))
        power = np.zeros((stop - start, block.shape[0]))
        phase = track.phase_at(np.arange(begin, begin + block.shape[1], dtype=np.float64))
        part = slice(start, stop)
        demodulate(
            block,
            np.array([first[part], last[part]]) - begin,
            phase,
            np.cos(phase),
            np.sin(phase),
            np.array([centres[part], half[part]]),
            HALF_HANN,
            sums,
            power,
        )
        amplitudes.append(sums.view(np.complex128)[..., 0])
        squares.append(power)
    return (
        np.moveaxis(np.concatenate(amplitudes), 0, -1),
        np.moveaxis(np.concatenate(squares), 0, -1),
    )


def _lawful(position: FloatArray, frequency: FloatArray) -> FloatArray:
    """Return the linear or logarithmic law that frequencies follow, else themselves."""
    smooth = median_of_five(frequency)
    linear = _straight(position, smooth)
    logarithmic = np.exp(_straight(position, np.log(smooth)))
    laws = []
    for law in (linear, logarithmic):
        if law.min() > 0.0:
            laws.append((float(np.median(np.abs(law / smooth - 1.0))), law))
    distance, law = min(laws, key=lambda pair: pair[0])
    return law if distance < LAW else smooth


def _straight(position: FloatArray, values: FloatArray) -> FloatArray:
    """Return the straight line through most of the values: outliers are left out."""
    centred = (position - position.mean()) / (np.ptp(position) or 1.0)
    keep = np.ones(values.size, dtype=bool)
    line = values
    for _ in range(6):
        slope, level = np.polyfit(centred[keep], values[keep], 1)
        line = level + slope * centred
        distance = np.abs(values - line)
        keep = distance <= 3.0 * np.median(distance[keep]) + 1e-12 * np.abs(line)
    return line


def _pulled_in(read: SampleReader, track: ToneTrack) -> ToneTrack:
    """Return the track with the remaining phase of the signal added.

    Raises
    ------
    SpectrumError
        If there are fewer periods than four windows hold.
    """
    turns = (track.phase[-1] - track.phase[0]) / (2.0 * np.pi)
    count = int((turns - PULL_IN) // (PULL_IN / 2.0)) + 1
    if count < 4:
        raise SpectrumError(f"{numeral(turns)} periods are too few to follow a sweep")
    centres = track.phase[0] + np.pi * PULL_IN
    centres += np.arange(count) * (turns - PULL_IN) / (count - 1) * 2.0 * np.pi
    amplitude, _ = demodulated(read, track, centres, np.full(count, PULL_IN), 1)
    left = np.unwrap(np.angle(amplitude[0, 0]))
    position = track.position_of(centres)
    slope = np.gradient(left, position)
    inside = np.clip(track.position, position[0], position[-1])
    phase = track.phase + ToneTrack(position, left, slope).phase_at(inside)
    omega = track.omega + np.interp(track.position, position, slope, left=0.0, right=0.0)
    return ToneTrack(track.position, phase, omega)


def _groups(first: NDArray[np.int64], last: NDArray[np.int64]) -> list[tuple[int, int]]:
    """Return runs of windows that together span no more than a chunk, or one window."""
    groups, start = [], 0
    for k in range(1, first.size + 1):
        if k == first.size or last[k] - first[start] > CHUNK:
            groups.append((start, k))
            start = k
    return groups
