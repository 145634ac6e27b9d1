"""Levels of a density: Grms in a band, cumulative rms; agreement of the controls."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.numerals import numeral
from shakerproc.spectra.welch.cross import CrossSpectra, psd

IMBALANCE: Final = 0.1
"""Relative difference of the control motions that deserves a warning [-] (trap 19)."""

AUDIBLE: Final = 0.01
"""Share of the mean control density below which a bin is not judged [-]."""


def shares_in_band(spectra: CrossSpectra, band: tuple[float, float] | None) -> FloatArray:
    """Return how much of each bin lies in a band.

    A bin reaches half a bin width to both sides of its frequency, at 0 and at half the sample
    rate to one side only.

    Parameters
    ----------
    spectra : CrossSpectra
        Matrix of cross spectra.
    band : (float, float), optional
        Lower and upper limit [Hz]; by default everything.

    Returns
    -------
    (n_frequencies,) array
        Shares, 0 to 1 [-].

    Raises
    ------
    ValueError
        If the band does not rise.
    """
    if band is None:
        return np.ones(spectra.frequency.size)
    if not band[0] < band[1]:
        raise ValueError(f"the band must rise, not run from {band[0]:g} to {band[1]:g} Hz")
    half = spectra.bin_width / 2.0
    low = np.maximum(spectra.frequency - half, 0.0)
    high = np.minimum(spectra.frequency + half, spectra.sample_rate / 2.0)
    inside = np.minimum(high, band[1]) - np.maximum(low, band[0])
    return np.array(np.maximum(inside, 0.0) / (high - low))


def rms_in_band(spectra: CrossSpectra, band: tuple[float, float] | None = None) -> FloatArray:
    r"""Return the root mean square of each channel in a band; of accelerations, the Grms.

    .. math:: \sqrt{\sum_k S_k \Delta f}

    Parameters
    ----------
    spectra : CrossSpectra
        Matrix of cross spectra.
    band : (float, float), optional
        Lower and upper limit [Hz]; by default everything from 0, the mean included.

    Returns
    -------
    (n_channels,) array
        Root mean squares [unit].

    Raises
    ------
    ValueError
        If the band does not rise.
    """
    return cumulative_rms(spectra, band)[:, -1]


def cumulative_rms(
    spectra: CrossSpectra, band: tuple[float, float] | None = None
) -> FloatArray:
    """Return the root mean square of each channel from the lower limit up to each frequency.

    Parameters
    ----------
    spectra : CrossSpectra
        Matrix of cross spectra.
    band : (float, float), optional
        Lower and upper limit [Hz]; by default everything from 0, the mean included.

    Returns
    -------
    (n_channels, n_frequencies) array
        Root mean squares up to the upper end of each bin [unit].

    Raises
    ------
    ValueError
        If the band does not rise.
    """
    power = psd(spectra) * shares_in_band(spectra, band) * spectra.bin_width
    return np.array(np.sqrt(np.cumsum(power, axis=1)))


@final
@dataclass(frozen=True, slots=True)
class Imbalance:
    """How far control channels, which should move as one, differ.

    Attributes
    ----------
    overall : float
        Rms difference of two controls over the rms of their mean, in the band [-].
    worst : float
        The same at the frequency where it is largest [-].
    worst_frequency : float
        That frequency [Hz].
    warning : str, optional
        A sentence, where the larger of the two exceeds 10 %.
    """

    overall: float
    worst: float
    worst_frequency: float
    warning: str | None


def control_imbalance(
    spectra: CrossSpectra, controls: Sequence[int], band: tuple[float, float]
) -> Imbalance | None:
    r"""Return how far the controls differ within a band.

    .. math:: \sqrt{\frac{2}{n - 1} \sum_i S_{d_i d_i} \Big/ S_{mm}}, \quad d_i = x_i - m

    with the mean control :math:`m`; of two controls it is the rms of their difference.
    The worst frequency is sought in bins where the controls have at least 1 % of their mean
    density, averaged over three bins.

    Parameters
    ----------
    spectra : CrossSpectra
        Matrix of cross spectra.
    controls : sequence of int
        Rows of the control channels, from 0.
    band : (float, float)
        Excited band [Hz].

    Returns
    -------
    Imbalance or None
        None where there is but one control, or no power in the band.

    Raises
    ------
    ValueError
        If the band does not rise.
    """
    inputs = list(controls)
    inside = shares_in_band(spectra, band) > 0.5
    if len(inputs) < 2 or not inside.any():
        return None
    matrix = spectra.between(inputs, inputs)[..., inside]
    mean = matrix.mean(axis=(0, 1)).real
    own = np.einsum("iif->f", matrix).real / len(inputs)
    if not own.any() or not mean.any():
        return None
    apart = 2.0 * len(inputs) / (len(inputs) - 1.0) * np.maximum(own - mean, 0.0)
    overall = float(np.sqrt(apart.sum() / mean.sum()))
    smooth_apart, smooth_mean = _smooth(apart), _smooth(mean)
    judged = (smooth_mean > 0.0) & (own >= AUDIBLE * np.mean(own))
    ratio = np.zeros(own.size)
    np.divide(smooth_apart, smooth_mean, out=ratio, where=judged)
    where = int(np.argmax(ratio))
    worst = float(np.sqrt(ratio[where]))
    frequency = float(spectra.frequency[inside][where])
    return Imbalance(overall, worst, frequency, _warning(overall, worst, frequency))


def _smooth(values: FloatArray) -> FloatArray:
    """Return the sums over three neighbours, the ends repeated."""
    padded = np.concatenate([values[:1], values, values[-1:]])
    return np.array(padded[:-2] + padded[1:-1] + padded[2:])


def _warning(overall: float, worst: float, frequency: float) -> str | None:
    """Return the warning of controls that differ by more than 10 %."""
    if max(overall, worst) <= IMBALANCE:
        return None
    return (
        f"the controls differ by {overall:.0%} of their mean overall and by {worst:.0%} at "
        f"{numeral(frequency, 4)} Hz: response functions against the mean control are "
        "doubtful there"
    )
