"""From acceleration to velocity and displacement, with a high-pass and without a baseline."""

from collections.abc import Callable, Iterator
from typing import Final, TypeAlias

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import FloatArray

Reader: TypeAlias = Callable[[int, int], FloatArray]
"""From the first sample and the one after the last to (n_channels, n_samples) array."""

ORDER: Final = 4
"""The high-pass has the magnitude of a Butterworth filter of this order run both ways."""

SETTLED: Final = 16.0
"""Periods of the high-pass after which it has forgotten all but a part in 10⁸."""

BLOCK: Final = 2**18
"""Samples of each channel that are integrated at once, at least."""


def high_pass_gain(frequency: FloatArray, corner: float) -> FloatArray:
    r"""Return the gain of the high-pass, which shifts no phase.

    .. math:: \frac{1}{1 + (f_c / f)^{2 n}}, \quad n = 4

    Parameters
    ----------
    frequency : (n_frequencies,) array
        Where [Hz].
    corner : float
        Where half is left, :math:`f_c` [Hz].

    Returns
    -------
    (n_frequencies,) array
        Gain, 0 at 0 Hz [-].
    """
    ratio = (frequency / corner) ** (2 * ORDER)
    return np.asarray(ratio / (1.0 + ratio))


def integrated(
    read: Reader,
    n_samples: int,
    sample_rate: float,
    part: tuple[int, int],
    *,
    corner: float | None,
) -> Iterator[FloatArray]:
    r"""Return the first and the second integral of a part of some channels, block by block.

    With a corner, spectra are divided by :math:`i \omega` and :math:`(i \omega)^2`, exact for
    what the samples show, and the high-pass is applied; samples beside the part are used where
    there are any, so that its ends are not disturbed. Without a corner, the samples are joined
    by straight lines and integrated from rest at the start of the part.

    Parameters
    ----------
    read : callable
        Gives samples, from which a baseline has been taken [unit].
    n_samples : int
        How many there are.
    sample_rate : float
        Samples per second [Hz].
    part : (int, int)
        First sample and the one after the last.
    corner : float, optional
        Of the high-pass [Hz].

    Yields
    ------
    (2, n_channels, n) array
        First integral [unit s] and second [unit s²].
    """
    if corner is None:
        yield from _from_rest(read, sample_rate, part)
        return
    margin = int(np.ceil(SETTLED * sample_rate / corner))
    size = max(BLOCK, 2 * margin)
    for start in range(part[0], part[1], size):
        stop = min(start + size, part[1])
        first, last = max(0, start - margin), min(n_samples, stop + margin)
        samples = read(first, last)
        length = scipy.fft.next_fast_len(samples.shape[1] + margin, real=True)
        frequency = scipy.fft.rfftfreq(length, 1.0 / sample_rate)
        omega = 2j * np.pi * np.maximum(frequency, 1e-300)
        spectrum = scipy.fft.rfft(samples, length) * high_pass_gain(frequency, corner)
        kept = slice(start - first, stop - first)
        outputs = []
        for power in (1, 2):
            whole = np.zeros_like(spectrum)
            np.divide(spectrum, omega**power, out=whole, where=frequency > 0.0)
            outputs.append(scipy.fft.irfft(whole, length)[:, kept])
        yield np.array(outputs)


def _from_rest(read: Reader, sample_rate: float, part: tuple[int, int]) -> Iterator[FloatArray]:
    """Return integrals of straight lines between samples, exact, block by block."""
    step = 1.0 / sample_rate
    last = np.zeros((0, 1))
    velocity = displacement = last
    for start in range(part[0], part[1], BLOCK):
        samples = read(start, min(start + BLOCK, part[1]))
        if not len(last):
            last = samples[:, :1]
            velocity = displacement = np.zeros(last.shape)
        joined = np.concatenate([last, samples], axis=1)
        pieces = np.full((1, samples.shape[1]), step)
        pieces[0, 0] = step if start > part[0] else 0.0
        before, after = joined[:, :-1], joined[:, 1:]
        first = velocity + np.cumsum(0.5 * (before + after) * pieces, axis=1)
        previous = np.concatenate([velocity, first[:, :-1]], axis=1)
        rises = previous * pieces + (2.0 * before + after) / 6.0 * pieces**2
        second = displacement + np.cumsum(rises, axis=1)
        last, velocity, displacement = samples[:, -1:], first[:, -1:], second[:, -1:]
        yield np.array([first, second])


def straight_baseline(
    read: Reader, part: tuple[int, int], *, sloped: bool
) -> tuple[FloatArray, FloatArray]:
    """Return the mean, or the straight line, that fits a part of some channels best.

    Parameters
    ----------
    read : callable
        Gives samples [unit].
    part : (int, int)
        First sample and the one after the last.
    sloped : bool
        Whether the line may rise.

    Returns
    -------
    middle, slope : (n_channels, 1) arrays
        Value in the middle of the part [unit], and rise from sample to sample [unit].
    """
    centre, count = 0.5 * (part[0] + part[1] - 1), part[1] - part[0]
    sums: list[FloatArray] = []
    moments: list[FloatArray] = []
    for start in range(part[0], part[1], BLOCK):
        stop = min(start + BLOCK, part[1])
        samples, places = read(start, stop), np.arange(start, stop) - centre
        sums.append(np.sum(samples, axis=1, keepdims=True))
        moments.append((samples @ places)[:, np.newaxis])
    middle = np.sum(sums, axis=0) / count
    spread = count * (count**2 - 1) / 12.0
    slope = np.sum(moments, axis=0) / spread if sloped and count > 1 else np.zeros_like(middle)
    return middle, slope
