"""Tones of fixed frequency: lines of an excitation, and tones on random vibration."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.errors import SpectrumError
from shakerproc.numerals import numeral
from shakerproc.spectra.peaks.chance import smearing_of
from shakerproc.spectra.peaks.finding import find_peaks
from shakerproc.spectra.responses import NOTCH_BINS
from shakerproc.spectra.welch.cross import CrossSpectra, psd

FALSE_TONES: Final = 1e-4
"""Probability that chance makes a tone of a random run, by the normal law [-].

It is more than that, since the share of lit segments is skewed.
"""

N_PARTS: Final = 8
"""Parts of the run, in each of which a tone is read alone [-]."""

FALSE_MOVES: Final = 0.01
"""Probability that chance alone moves a fixed tone of a run from part to part [-]."""

LEAST_DISTANCE: Final = 2.0
"""Least distance of two tones times the length of a stretch, so that each is read alone [-]."""


@final
@dataclass(frozen=True, slots=True)
class SpectralLine:
    """A tone in the control that neither random vibration nor a sweep makes.

    Attributes
    ----------
    frequency : float
        Where it is [Hz].
    share : float
        Its power over that of the control [-].
    """

    frequency: float
    share: float


def steady_lines(
    spectra: CrossSpectra, controls: Sequence[int], band: tuple[float, float]
) -> tuple[SpectralLine, ...]:
    r"""Return the tones of the mean control, strongest first.

    A tone is a peak of the density that chance does not make and whose power is the same in
    every segment. Of random vibration the number of segments that light a bin,
    :math:`(\sum P)^2 / \sum P^2`, is half of them, give or take :math:`1 / \sqrt{n_e}` of
    that; of a tone it is all of them. What lies above chance, for all peaks together but for
    a probability of `FALSE_TONES`, is a tone.

    Parameters
    ----------
    spectra : CrossSpectra
        Matrix of cross spectra.
    controls : sequence of int
        Rows of the control channels, from 0.
    band : (float, float)
        Where to look [Hz].

    Returns
    -------
    tuple of SpectralLine
        Empty where there is no control, or too few segments to tell.
    """
    rows = list(controls)
    if not rows:
        return ()
    density = psd(spectra)[rows].mean(axis=0)
    chance = np.full(density.shape, spectra.effective_averages**-0.5)
    peaks = find_peaks(spectra.frequency, density, band, errors=chance)
    most = _most_by_chance(spectra, len(peaks))
    lit = spectra.lit_segments[rows].mean(axis=0)
    total, reach = float(density.sum()), int(NOTCH_BINS)
    lines: list[SpectralLine] = []
    leaked = np.zeros(density.shape)
    at = {peak.index: peak for peak in peaks}
    for peak in peaks:
        if not (lit[peak.index] > most and peak.value > leaked[peak.index]):
            continue
        # The mirror image below 0 Hz makes a tone of a few bins unsteady, not what it leaks.
        first = max(0, peak.index - 2 * reach)
        near = first + int(np.argmax(density[first : peak.index + 2 * reach + 1]))
        place = at[near].frequency if near in at else centre_of(spectra, density, near)
        power = _power_near(density, near)
        if power * _side_lobes(spectra, place)[peak.index] < peak.value:
            place, power = peak.frequency, _power_near(density, peak.index)
        lines.append(SpectralLine(place, power / total))
        leaked += power * _side_lobes(spectra, place)
    return tuple(lines)


def _power_near(density: FloatArray, index: int) -> float:
    """Return the sum of a density over the bins that a window smears a tone over."""
    reach = int(NOTCH_BINS)
    return float(density[max(0, index - reach) : index + reach + 1].sum())


def centre_of(spectra: CrossSpectra, density: FloatArray, index: int) -> float:
    """Return the mean frequency of the power in the main lobe about a bin [Hz]."""
    lobe = slice(max(0, index - 2), index + 3)
    return float(np.average(spectra.frequency[lobe], weights=density[lobe]))


def _side_lobes(spectra: CrossSpectra, frequency: float) -> FloatArray:
    """Return the most that a tone may leak into each bin, over its own power."""
    smearing = smearing_of(spectra)
    distances = np.abs(spectra.frequency - frequency)
    width = smearing.segment
    near = distances + width * np.linspace(-1.0, 1.0, 9)[:, np.newaxis]
    return np.asarray(2.0 * spectra.bin_width * np.max(smearing(near) ** 2, axis=0))


def clear_of_lines(
    spectra: CrossSpectra, lines: Sequence[SpectralLine], response: int
) -> NDArray[np.bool_]:
    """Return which frequencies of a response the lines of the control leave alone.

    Parameters
    ----------
    spectra : CrossSpectra
        Matrix of cross spectra.
    lines : sequence of SpectralLine
        Tones of the control.
    response : int
        Row of the response channel, from 0.

    Returns
    -------
    (n_frequencies,) array of bool
        False within three bins of each tone, over which the window smears it, and wherever
        the response is as steady as a tone: its multiples, and what the window leaks.
    """
    keep = np.ones(spectra.frequency.size, dtype=bool)
    if not lines:
        return keep
    reach = NOTCH_BINS * spectra.bin_width
    for line in lines:
        keep &= np.abs(spectra.frequency - line.frequency) > reach
    steady = spectra.lit_segments[response] > _most_by_chance(spectra, keep.size)
    return np.asarray(keep & ~steady)


def _most_by_chance(spectra: CrossSpectra, n_tries: int) -> float:
    """Return how many segments random vibration lights at most, in so many bins."""
    z = float(scipy.special.ndtri(1.0 - FALSE_TONES / max(1, n_tries)))
    return 0.5 * spectra.n_segments * (1.0 + z / float(np.sqrt(spectra.effective_averages)))


def power_of(lines: Sequence[SpectralLine]) -> float:
    """Return the share of the control's power that lies in its tones [-]."""
    return float(sum(line.share for line in lines))


def lines_sentence(lines: Sequence[SpectralLine]) -> str:
    """Return a sentence for people; empty where there is no tone."""
    if not lines:
        return ""
    hz = ", ".join(numeral(line.frequency, 4) for line in lines[:5])
    more = f" and {len(lines) - 5} more" if len(lines) > 5 else ""
    one = len(lines) == 1
    drive = (
        " If that is the drive, the log should say excitation: sine and its frequency."
        if one and power_of(lines) > 0.5
        else " If the test demands them above random vibration, the log should say excitation: "
        "sine on random and its tones."
    )
    return (
        f"The control holds {'a steady tone' if one else 'steady tones'} at {hz}{more} Hz with "
        f"{power_of(lines):.0%} of its power. Responses there and at its multiples "
        f"are not taken for a resonance.{drive}"
    )


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
    if count < 2 * N_PARTS:
        raise SpectrumError(
            f"tones need a run of {2 * N_PARTS} segments of {stretch} samples, and this one "
            f"holds {count}; take shorter segments: welch: {{segment: ...}}"
        )
    check_separable(frequency, stretch, sample_rate)
    for _ in range(2):
        readings = _readings(read, count, stretch, sample_rate, places)
        mean = readings[:, list(controls)].mean(axis=1)
        places = places + _offsets(mean, stretch / sample_rate)
    readings = _readings(read, count, stretch, sample_rate, places)
    mean = readings[:, list(controls)].mean(axis=1)
    # the random vibration in phase with a tone, of which half of the scatter is
    scatter = np.sqrt(np.var(mean, axis=0, ddof=1) / (2.0 * count))
    each = count // N_PARTS
    blocks = mean[: each * N_PARTS].reshape(N_PARTS, each, -1)
    return MixedTones(
        frequency=places,
        amplitude=readings.mean(axis=0),
        control=mean.mean(axis=0),
        parts=blocks.mean(axis=1),
        error=float(scipy.special.ndtri(0.975)) * scatter,
        moves=_moves(blocks),
    )


def check_separable(frequency: Sequence[float], stretch: int, sample_rate: float) -> None:
    """Pass tones that stretches of so many samples tell apart; `frequency` in [Hz].

    Raises
    ------
    SpectrumError
        If two of them are closer.
    """
    order = sorted(frequency)
    for low, high in pairwise(order):
        if (high - low) * stretch < LEAST_DISTANCE * sample_rate:
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
    readings = []
    for k in range(count):
        weights = read(k * stretch, (k + 1) * stretch) @ solve.T
        back = np.exp(-2j * np.pi * places / sample_rate * (k * stretch))
        readings.append((weights[:, 1 : n + 1] - 1j * weights[:, n + 1 :]) * back)
    return np.array(readings)


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
        2 * (parts - 1), 2 * parts * (each - 1), 1.0 - FALSE_MOVES / max(n, 1)
    )
    return np.asarray(between > limit * within)
