"""Tones of fixed frequency that stand on random vibration: tracked, and taken out."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.errors import SpectrumError

PARTS: Final = 8
"""Parts of the run, in each of which a tone is read alone [-]."""

UNSTEADY: Final = 0.01
"""Probability that chance alone moves a fixed tone of a run from part to part [-]."""

APART: Final = 2.0
"""Least distance of two tones times the length of a stretch, so that each is read alone [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class MixedTones:
    """Tones of fixed frequency in a run.

    Attributes
    ----------
    frequency : (n_tones,) array
        In the mean control [Hz].
    amplitude : (n_channels, n_tones) complex array
        Of each channel, phase at the first sample of the run against a cosine [unit].
    control : (n_tones,) complex array
        The same of the mean control [unit].
    parts : (n_parts, n_tones) complex array
        The same of the mean control in equal parts of the run [unit].
    error : (n_tones,) array
        How far chance carries the amplitude in the mean control, in 95 % of all runs [unit].
    moves : (n_tones,) array of bool
        Whether amplitude or phase moves from part to part by more than chance.
    """

    frequency: FloatArray
    amplitude: ComplexArray
    control: ComplexArray
    parts: ComplexArray
    error: FloatArray
    moves: NDArray[np.bool_]

    def at(self, rows: Sequence[int], first: int, count: int, sample_rate: float) -> FloatArray:
        """Return the tones of some channels, (n_rows, count) array [unit].

        `first` is the first sample from the start of the run, `sample_rate` in [Hz].
        """
        turn = 2j * np.pi * self.frequency[:, np.newaxis] / sample_rate
        waves = np.exp(turn * (first + np.arange(count)))
        return np.asarray((self.amplitude[list(rows)] @ waves).real)


def mixed_tones(
    read: Callable[[int, int], FloatArray],
    n_samples: int,
    sample_rate: float,
    controls: Sequence[int],
    *,
    frequency: Sequence[float],
    stretch: int,
) -> MixedTones:
    """Return the tones of fixed frequency near some frequencies.

    In stretches all tones and an offset are fitted to the samples together; the frequency of a
    tone is that at which the readings of the mean control add up to most, and its amplitude
    is their mean.

    Parameters
    ----------
    read : callable
        Samples start to stop of the run, an (n_channels, n) array [unit of the channel].
    n_samples : int
        Length of the run.
    sample_rate : float
        Samples per second [Hz].
    controls : sequence of int
        Rows of the control channels, from 0.
    frequency : sequence of float
        Of each tone, within half of one over the length of a stretch [Hz].
    stretch : int
        Samples of a stretch.

    Returns
    -------
    MixedTones
        In the order of `frequency`.

    Raises
    ------
    SpectrumError
        If stretches do not tell tones apart, or the run holds too few of them.
    """
    places = np.asarray(frequency, dtype=float)
    count = n_samples // stretch
    if count < 2 * PARTS:
        raise SpectrumError(
            f"tones need a run of {2 * PARTS} segments of {stretch} samples, and this one "
            f"holds {count}; take shorter segments: welch: {{segment: ...}}"
        )
    check_apart(frequency, stretch, sample_rate)
    for _ in range(2):
        readings = _readings(read, count, stretch, sample_rate, places)
        mean = readings[:, list(controls)].mean(axis=1)
        places = places + _offsets(mean, stretch / sample_rate)
    readings = _readings(read, count, stretch, sample_rate, places)
    mean = readings[:, list(controls)].mean(axis=1)
    # the random vibration in phase with a tone, of which half of the scatter is
    scatter = np.sqrt(np.var(mean, axis=0, ddof=1) / (2.0 * count))
    each = count // PARTS
    blocks = mean[: each * PARTS].reshape(PARTS, each, -1)
    return MixedTones(
        frequency=places,
        amplitude=readings.mean(axis=0),
        control=mean.mean(axis=0),
        parts=blocks.mean(axis=1),
        error=float(scipy.special.ndtri(0.975)) * scatter,
        moves=_moves(blocks),
    )


def check_apart(frequency: Sequence[float], stretch: int, sample_rate: float) -> None:
    """Pass tones that stretches of so many samples tell apart; `frequency` in [Hz].

    Raises
    ------
    SpectrumError
        If two of them are closer.
    """
    order = sorted(frequency)
    for low, high in pairwise(order):
        if (high - low) * stretch < APART * sample_rate:
            raise SpectrumError(
                f"tones of {low:.5g} and {high:.5g} Hz are not told apart by segments of "
                f"{stretch} samples: take longer ones, welch: {{segment: ...}}"
            )


def _readings(
    read: Callable[[int, int], FloatArray],
    count: int, stretch: int, sample_rate: float, places: FloatArray,
) -> ComplexArray:  # fmt: skip
    """Return the tones of each stretch, (n_stretches, n_channels, n_tones) [unit]."""
    waves = np.exp(2j * np.pi * places[:, np.newaxis] / sample_rate * np.arange(stretch))
    rows = np.concatenate([np.ones((1, stretch)), waves.real, waves.imag])
    solve = np.linalg.inv(rows @ rows.T) @ rows
    n = places.size
    found = []
    for k in range(count):
        weights = read(k * stretch, (k + 1) * stretch) @ solve.T
        back = np.exp(-2j * np.pi * places / sample_rate * (k * stretch))
        found.append((weights[:, 1 : n + 1] - 1j * weights[:, n + 1 :]) * back)
    return np.array(found)


def _offsets(mean: ComplexArray, length: float) -> FloatArray:
    """Return how far each tone lies beside its place [Hz]; `length` of a stretch in [s]."""
    count = mean.shape[0]
    size = 8 * count
    grid = np.fft.fftfreq(size, length)
    peaks = grid[np.abs(np.fft.fft(mean, size, axis=0)).argmax(axis=0)]
    time = length * np.arange(count)

    def lost(offset: float, values: ComplexArray) -> float:
        return -float(np.abs(np.sum(values * np.exp(-2j * np.pi * offset * time))))

    step = 1.0 / (size * length)
    return np.array([
        scipy.optimize.minimize_scalar(
            lost, args=(mean[:, k],), bounds=(peak - step, peak + step), method="bounded",
            options={"xatol": 1e-6 * step},
        ).x
        for k, peak in enumerate(peaks)
    ])  # fmt: skip


def _moves(blocks: ComplexArray) -> NDArray[np.bool_]:
    """Return whether the means of (n_parts, n_readings, n_tones) differ beyond chance.

    It is Fisher's test of the scatter of the means over that within the parts.
    """
    parts, each, n = blocks.shape
    means = blocks.mean(axis=1)
    between = each * np.sum(np.abs(means - means.mean(axis=0)) ** 2, axis=0) / (parts - 1)
    within = np.sum(np.abs(blocks - means[:, np.newaxis]) ** 2, axis=(0, 1))
    within /= parts * (each - 1)
    limit = scipy.special.fdtri(
        2 * (parts - 1), 2 * parts * (each - 1), 1.0 - UNSTEADY / max(n, 1)
    )
    return np.asarray(between > limit * within)
