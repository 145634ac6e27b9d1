"""Lines of an excitation: tones that stand still and are no resonances of the specimen."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.numerals import numeral
from shakerproc.spectra.peaks.chance import smearing_of
from shakerproc.spectra.peaks.finding import find_peaks
from shakerproc.spectra.responses.masks import NOTCH_BINS
from shakerproc.spectra.welch.cross import CrossSpectra, psd

ACCUSED: Final = 1e-4
"""Probability that chance makes a tone of a random run, by the normal law [-].

It is more than that, since the share of lit segments is skewed.
"""


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
    a probability of `ACCUSED`, is a tone.

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
    apart = np.abs(spectra.frequency - frequency)
    width = smearing.segment
    near = apart + width * np.linspace(-1.0, 1.0, 9)[:, np.newaxis]
    return np.asarray(2.0 * spectra.bin_width * np.max(smearing(near) ** 2, axis=0))


def beside_lines(
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
    z = float(scipy.special.ndtri(1.0 - ACCUSED / max(1, n_tries)))
    return 0.5 * spectra.n_segments * (1.0 + z / float(np.sqrt(spectra.effective_averages)))


def power_of(lines: Sequence[SpectralLine]) -> float:
    """Return the share of the control's power that lies in its tones [-]."""
    return float(sum(line.share for line in lines))


def told(lines: Sequence[SpectralLine]) -> str:
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
        f"{power_of(lines):.0%} of its power: what the responses do there and at its multiples "
        f"is not taken for a resonance.{drive}"
    )
