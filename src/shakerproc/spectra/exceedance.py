"""Where a density lies beyond a limit by more than chance: single lines and their bands."""

from typing import Final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.spectra.welch.cross import CrossSpectra

CHANCE: Final = 0.05
"""Probability that chance alone carries a band at a limit beyond it, over all widths [-]. Bands
of one width overlap: of a density exactly at a limit 6 to 14 % of the lines were found beyond
it (40 runs of 6 s)."""


def surely_beyond(
    ratio: FloatArray, spectra: CrossSpectra, *, above: bool, anywhere: bool = False
) -> NDArray[np.bool_]:
    r"""Return which lines of a density lie beyond a limit by more than chance.

    Each line is judged alone, and together with its neighbours in bands of 2, 4, 8, ... lines:
    a band is beyond where a confidence limit of its mean is,

    .. math:: \frac{\nu_w \bar r_w}{\chi^2_{\nu_w, 1 - \alpha}} > 1, \quad
        \nu_w = \frac{\nu w}{1 + 2 \sum_{k<w} (1 - k / w) \rho_k}, \quad
        \rho_k = \frac{|\sum_n h_n^2 e^{2 \pi i k n / N}|^2}{(\sum_n h_n^2)^2}

    so that a band of some hertz has the same say whatever the segment. A line counts in a band
    with no more than its own confidence limit: a peak that is beyond alone carries no band.
    Of a band that is beyond, its middle counts and those lines that are beyond themselves.

    Parameters
    ----------
    ratio : (n_lines,) array
        Density over limit at neighbouring lines [-].
    spectra : CrossSpectra
        Of which the density is: its window and degrees of freedom.
    above : bool
        Whether what lies above the limit is beyond it, or what lies below.
    anywhere : bool
        Whether no line at all may be beyond by chance, as at an abort limit: the probability
        is then that of the whole band, else that of each line.

    Returns
    -------
    (n_lines,) array of bool
        True where a line is surely beyond the limit.

    References
    ----------
    .. [1] D. B. Percival and A. T. Walden, "Spectral Analysis for Univariate Time Series",
       Cambridge, 2020, ch. 6 and 8 (covariance of windowed periodograms).
    """
    n_scales = max(ratio.size, 1).bit_length()
    chance = CHANCE / n_scales / (max(ratio.size, 1) if anywhere else 1)
    correlation = _line_correlation(spectra, ratio.size)
    own = _critical(spectra.degrees_of_freedom, chance, above=above)
    clipped = np.minimum(ratio, own) if above else np.maximum(ratio, own)
    sums = np.concatenate([[0.0], np.cumsum(clipped)])
    result = ratio > own if above else ratio < own
    beyond = ratio > 1.0 if above else ratio < 1.0
    for width in 2 ** np.arange(1, n_scales):
        lags = np.arange(1, width)
        spread = 1.0 + 2.0 * float(np.sum((1.0 - lags / width) * correlation[lags]))
        freedom = spectra.degrees_of_freedom * width / spread
        limit = _critical(freedom, chance, above=above)
        means = (sums[width:] - sums[:-width]) / width
        sure = np.flatnonzero(means > limit if above else means < limit)
        covered = np.zeros(ratio.size + 1, dtype=int)
        np.add.at(covered, sure, 1)
        np.add.at(covered, sure + width, -1)
        result |= (np.cumsum(covered)[:-1] > 0) & beyond
        result[sure + width // 2] = True
    return np.asarray(result)


def _critical(freedom: float, chance: float, *, above: bool) -> float:
    """Return the ratio that chance alone passes with a probability [-]."""
    inverse = scipy.special.gammainccinv if above else scipy.special.gammaincinv
    return float(2.0 * inverse(freedom / 2.0, chance) / freedom)


def _line_correlation(spectra: CrossSpectra, n_lines: int) -> FloatArray:
    """Return how a density at two lines correlates by their distance, 0 to `n_lines` [-]."""
    transform = np.abs(np.fft.rfft(spectra.window**2, spectra.n_fft)) ** 2
    result = np.zeros(n_lines + 1)
    count = min(n_lines + 1, transform.size)
    result[:count] = transform[:count] / transform[0]
    return result
