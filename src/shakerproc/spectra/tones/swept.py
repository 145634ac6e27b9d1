"""Swept response: fundamental and harmonics of each channel against frequency.

The phase of the tone is that of the control signal itself. The ridge of the signal (or the
straight law that it follows) is integrated to a phase, and what is left of the phase of the
signal is added, twice.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

from shakerproc import checks
from shakerproc.data import ComplexArray, FloatArray
from shakerproc.errors import SpectrumError
from shakerproc.numerals import numeral
from shakerproc.spectra.welch.spectrograms import (
    CHUNK,
    QUIET,
    Ridge,
    SampleReader,
    mean_control,
    median_of_five,
    monotone_sections,
    reader_of,
    ridge_of,
)

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
    phase_error = np.unwrap(np.angle(amplitude[0, 0]))
    position = track.position_of(centres)
    slope = np.gradient(phase_error, position)
    inside = np.clip(track.position, position[0], position[-1])
    phase = track.phase + ToneTrack(position, phase_error, slope).phase_at(inside)
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


Direction: TypeAlias = Literal["up", "down"]

SMEAR: Final = 0.004
"""Relative change of frequency that a window may span [-]."""

FEWEST, MOST = 3.0, 40.0
"""Periods in a window at least and at most."""

MOST_WINDOWS: Final = 1000
"""Windows of a sweep, in whole widths: slower ones have longer windows instead."""

SPAN: Final = 0.1
"""Octaves that a section must sweep to count as a sweep."""

SHARE: Final = 0.01
"""Share of the recording that a section must last to count: noise shifts up and down."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Sweep:
    """Response to one sweep, up or down.

    Attributes
    ----------
    direction : str
        ``up`` or ``down``.
    time : (n_points,) array
        Middle of each window, from the start of the samples [s].
    frequency : (n_points,) array
        Frequency of the control there, rising with the index for ``up`` [Hz].
    periods : (n_points,) array
        Periods in each window.
    control : (n_points,) array
        Amplitude of the fundamental of the mean control [unit].
    purity : (n_points,) array
        Share of the power of the mean control in its fundamental [-].
    harmonics : (n_channels, n_harmonics, n_points) complex array
        Amplitude and phase of harmonic 1, 2, ... of each channel, phase against as many times
        the phase of the control (real: in phase with it) [unit]; not a number where the
        harmonic lies above half the sample rate.
    """

    direction: Direction
    time: FloatArray
    frequency: FloatArray
    periods: FloatArray
    control: FloatArray
    purity: FloatArray
    harmonics: ComplexArray

    @property
    def gain(self) -> ComplexArray:
        """Fundamental of each channel over that of the control, (n_channels, n_points) [-]."""
        return self.harmonics[:, 0] / self.control


def swept_response(
    samples: FloatArray | SampleReader,
    sample_rate: float,
    controls: Sequence[int],
    band: tuple[float, float],
    *,
    n_samples: int | None = None,
    n_harmonics: int = 5,
) -> tuple[Sweep, ...]:
    """Return the response to each sweep in a recording, tracked by its control signal.

    Amplitude and phase are means over windows of whole periods, as many as the frequency
    changes by 0.4 % in (from 3 to 40), so that slow sweeps are filtered narrowly and fast
    ones are not smeared.

    Parameters
    ----------
    samples : (n_channels, n_samples) array, or callable
        The crop, or a function that returns its samples start to stop [unit of the channel].
    sample_rate : float
        Samples per second [Hz].
    controls : sequence of int
        Rows of the control channels, from 0; the sweep is followed in their mean.
    band : (float, float)
        Lowest and highest frequency of the sweep [Hz].
    n_samples : int, optional
        Number of samples, where `samples` is a function.
    n_harmonics : int
        Harmonics to follow, the fundamental included.

    Returns
    -------
    tuple of Sweep
        One for each stretch that only rises or only falls, in the order of time.

    Raises
    ------
    SpectrumError
        If no sweep is found.
    ValueError
        If the number of samples is not known, or no harmonic is asked.
    """
    checks.positive("sample_rate", sample_rate, "Hz")
    if n_harmonics < 1:
        raise ValueError(f"n_harmonics must be at least 1, not {n_harmonics}")
    read, count = _reader(samples, n_samples)
    control = mean_control(read, count, controls)
    ridge = ridge_of(control, count, sample_rate, band)
    sweeps: list[Sweep] = []
    problem = (
        f"no sweep between {band[0]:g} and {band[1]:g} Hz in the control signal: its "
        "strongest line stays where it is"
    )
    for section in monotone_sections(ridge):
        ends = ridge.frequency[[section[0], section[1]]]
        short = section[1] - section[0] < SHARE * ridge.frequency.size
        if short or abs(np.log2(ends[1] / ends[0])) < SPAN:
            continue
        try:
            track = track_of(control, ridge, section, sample_rate)
            sweeps.append(_sweep(read, list(controls), track, sample_rate, n_harmonics))
        except SpectrumError as error:  # a transient before the sweep, say
            problem = str(error)
    if not sweeps:
        raise SpectrumError(problem)
    return tuple(sweeps)


def stitched(sweeps: Sequence[Sweep], direction: Direction) -> Sweep:
    """Return sweeps of one direction as one, by rising frequency.

    Where sweeps overlap, the one that covers the frequency with the longer window (the
    slower one) is kept; times stay those of the recording that a point comes from.

    Parameters
    ----------
    sweeps : sequence of Sweep
        Sweeps of the same channels, of one or more recordings.
    direction : str
        Which of them to join: ``up`` or ``down``.

    Returns
    -------
    Sweep
        All points of the chosen direction, frequencies rising.

    Raises
    ------
    SpectrumError
        If there is no sweep of that direction.
    """
    chosen = [_by_frequency(sweep) for sweep in sweeps if sweep.direction == direction]
    if not chosen:
        raise SpectrumError(f"there is no sweep {direction} to join")
    kept = [
        _selected(sweep, ~np.any([_covered(sweep, other) for other in chosen], axis=0))
        for sweep in chosen
    ]
    return _by_frequency(
        Sweep(
            direction,
            *(
                np.concatenate([getattr(sweep, name) for sweep in kept], axis=-1)
                for name in ("time", "frequency", "periods", "control", "purity", "harmonics")
            ),
        )
    )


def _covered(sweep: Sweep, other: Sweep) -> np.ndarray:
    """Return which points another sweep holds with a longer window."""
    if other is sweep:
        return np.zeros(sweep.frequency.size, dtype=bool)
    inside = (sweep.frequency >= other.frequency[0]) & (sweep.frequency <= other.frequency[-1])
    theirs = np.interp(sweep.frequency, other.frequency, other.periods)
    first = (theirs == sweep.periods) & (other.time[0] < sweep.time[0])
    return np.array(inside & ((theirs > sweep.periods) | first))


def _by_frequency(sweep: Sweep) -> Sweep:
    """Return the points by rising frequency."""
    return _selected(sweep, np.argsort(sweep.frequency, kind="stable"))


def _selected(sweep: Sweep, which: np.ndarray) -> Sweep:
    """Return some of the points."""
    return replace(
        sweep,
        time=sweep.time[which],
        frequency=sweep.frequency[which],
        periods=sweep.periods[which],
        control=sweep.control[which],
        purity=sweep.purity[which],
        harmonics=sweep.harmonics[..., which],
    )


def _reader(
    samples: FloatArray | SampleReader, n_samples: int | None
) -> tuple[SampleReader, int]:
    """Return a reader of the samples and how many there are.

    Raises
    ------
    ValueError
        If that is not known.
    """
    if isinstance(samples, np.ndarray):
        return reader_of(samples)
    if n_samples is None:
        raise ValueError("a function that reads samples needs n_samples beside it")
    return samples, n_samples


def _windows(track: ToneTrack) -> tuple[FloatArray, FloatArray]:
    """Return the phase in the middle of each window and its number of periods."""
    slope = np.abs(np.gradient(track.omega, track.position))
    smooth = np.interp(track.phase, *_thinned(track.phase, slope))
    change = 2.0 * np.pi * smooth / np.maximum(track.omega, 1e-12) ** 2  # per period
    phase, end = float(track.phase[0]), float(track.phase[-1])
    most = max(MOST, (end - phase) / (2.0 * np.pi * MOST_WINDOWS))
    wanted = np.clip(SMEAR / np.maximum(change, 1e-9), FEWEST, most)
    centres, periods = [], []
    while True:
        n = float(np.floor(np.interp(phase, track.phase, wanted)))
        if phase + 2.0 * np.pi * n > end:
            break
        centres.append(phase + np.pi * n)
        periods.append(n)
        phase += np.pi * max(1.0, n / 2.0)
    return np.array(centres), np.array(periods)


def _thinned(phase: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return medians over some forty stretches, against the phase in their middle."""
    size = max(1, values.size // 40)
    count = values.size // size
    shape = (count, size)
    return (
        phase[: count * size].reshape(shape).mean(axis=1),
        np.median(values[: count * size].reshape(shape), axis=1),
    )


def _sweep(
    read: SampleReader,
    controls: list[int],
    track: ToneTrack,
    sample_rate: float,
    n_harmonics: int,
) -> Sweep:
    """Return the response along one track.

    Raises
    ------
    SpectrumError
        If not one window fits.
    """
    centres, periods = _windows(track)
    if not centres.size:
        raise SpectrumError("the sweep is shorter than the shortest window of three periods")
    samples = _with_mean(read, controls)
    amplitude, power = demodulated(samples, track, centres, periods, n_harmonics)
    control = amplitude[-1, 0]
    turn = np.exp(-1j * np.angle(control))
    position = track.position_of(centres)
    omega = np.interp(position, track.position, track.omega)
    number = np.arange(1, n_harmonics + 1)
    harmonics = amplitude[:-1] * turn ** number[:, np.newaxis]
    frequency = omega * sample_rate / (2.0 * np.pi)
    beyond = number[:, np.newaxis] * frequency * (1.0 + 2.0 / periods) > sample_rate / 2.0
    harmonics[:, beyond] = np.nan
    sweep = Sweep(
        direction="up" if frequency[-1] > frequency[0] else "down",
        time=position / sample_rate,
        frequency=frequency,
        periods=periods,
        control=np.abs(control),
        purity=0.5 * np.abs(control) ** 2 / np.maximum(power[-1], 1e-300),
        harmonics=harmonics,
    )
    return _selected(sweep, sweep.control > QUIET * sweep.control.max())


def _with_mean(read: SampleReader, controls: list[int]) -> SampleReader:
    """Return a reader of all channels with the mean control below them."""

    def read_all(start: int, stop: int) -> FloatArray:
        samples = read(start, stop)
        return np.concatenate([samples, samples[controls].mean(axis=0, keepdims=True)])

    return read_all
