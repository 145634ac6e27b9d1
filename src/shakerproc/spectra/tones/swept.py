"""Swept response: fundamental and harmonics of each channel against frequency."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal, TypeAlias, final

import numpy as np

from shakerproc import checks
from shakerproc.data import ComplexArray, FloatArray
from shakerproc.errors import SpectrumError
from shakerproc.spectra.tones.tracking import ToneTrack, demodulated, track_of
from shakerproc.spectra.welch.spectrograms import (
    QUIET,
    SampleReader,
    mean_control,
    monotone_sections,
    reader_of,
    ridge_of,
)

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
    found = Sweep(
        direction="up" if frequency[-1] > frequency[0] else "down",
        time=position / sample_rate,
        frequency=frequency,
        periods=periods,
        control=np.abs(control),
        purity=0.5 * np.abs(control) ** 2 / np.maximum(power[-1], 1e-300),
        harmonics=harmonics,
    )
    return _selected(found, found.control > QUIET * found.control.max())


def _with_mean(read: SampleReader, controls: list[int]) -> SampleReader:
    """Return a reader of all channels with the mean control below them."""

    def read_all(start: int, stop: int) -> FloatArray:
        samples = read(start, stop)
        return np.concatenate([samples, samples[controls].mean(axis=0, keepdims=True)])

    return read_all
