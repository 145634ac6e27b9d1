"""Breakpoint profiles, and where a density lies beyond one by more than chance."""

from typing import Final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.spectra.welch.cross import CrossSpectra

CHANCE: Final = 0.05
"""Probability that chance alone counts a line, or any line, of a density that is exactly at a
limit, at most [-]; shared evenly by all bands that could (Bonferroni)."""


def profile_at(
    frequency: FloatArray, breakpoints: FloatArray, levels: FloatArray
) -> FloatArray:
    r"""Return the level of a breakpoint profile at some frequencies.

    .. math:: L(f) = L_i \left(\frac{f}{f_i}\right)^{m_i}, \qquad
        m_i = \frac{\ln(L_{i+1} / L_i)}{\ln(f_{i+1} / f_i)}

    Parameters
    ----------
    frequency : (n_frequencies,) array
        Where the level is wanted [Hz].
    breakpoints, levels : (n_breakpoints,) arrays
        Rising frequencies [Hz], and the level at each [any unit].

    Returns
    -------
    (n_frequencies,) array
        Levels [unit of `levels`]; not a number outside the breakpoints.
    """
    inside = (frequency >= breakpoints[0]) & (frequency <= breakpoints[-1])
    values = np.full(frequency.shape, np.nan)
    values[inside] = np.exp(
        np.interp(np.log(frequency[inside]), np.log(breakpoints), np.log(levels))
    )
    return values


def profile_rms(
    breakpoints: FloatArray,
    levels: FloatArray,
    band: tuple[float, float] | None = None,
) -> float:
    r"""Return the root mean square of a density that is given by breakpoints; its Grms.

    Each straight line of slope :math:`m` has the area

    .. math:: \int_{f_1}^{f_2} L_1 (f / f_1)^m \, df
        = L_1 f_1 \ln r \, \frac{e^{(m + 1) \ln r} - 1}{(m + 1) \ln r}, \quad r = f_2 / f_1

    Parameters
    ----------
    breakpoints, levels : (n_breakpoints,) arrays
        Rising frequencies [Hz], and the density at each [unit²/Hz].
    band : (float, float), optional
        The part of it that counts [Hz]; by default all.

    Returns
    -------
    float
        Root mean square [unit].

    References
    ----------
    .. [1] D. S. Steinberg, "Vibration Analysis for Electronic Equipment", 3rd ed., Wiley,
       2000, ch. 8.
    """
    low, high = band or (breakpoints[0], breakpoints[-1])
    low, high = max(low, breakpoints[0]), min(high, breakpoints[-1])
    if not low < high:
        return 0.0
    inner = breakpoints[(breakpoints > low) & (breakpoints < high)]
    corners = np.concatenate(([low], inner, [high]))
    values = profile_at(corners, breakpoints, levels)
    octaves = np.log(corners[1:] / corners[:-1])
    rise = np.log(values[1:] / values[:-1]) + octaves  # (m + 1) ln r
    mean = np.ones(rise.shape)
    np.divide(np.expm1(rise), rise, out=mean, where=np.abs(rise) > 1e-12)
    return float(np.sqrt(np.sum(values[:-1] * corners[:-1] * octaves * mean)))


def surely_beyond(
    ratio: FloatArray, spectra: CrossSpectra, *, above: bool, anywhere: bool = False
) -> NDArray[np.bool_]:
    r"""Return which lines of a density lie beyond a limit by more than chance.

    Each line is judged alone, and together with its neighbours in bands of 2, 4, 8, ... lines
    that overlap by half: a band is beyond where a confidence limit of its mean is,

    .. math:: \frac{\nu_w \bar r_w}{\chi^2_{\nu_w, 1 - \alpha}} > 1, \quad
        \nu_w = \frac{\nu w}{1 + 2 \sum_{k<w} (1 - k / w) \rho_k}, \quad
        \rho_k = \frac{|\sum_n h_n^2 e^{2 \pi i k n / N}|^2}{(\sum_n h_n^2)^2}

    so that a band of some hertz has the same say whatever the segment. A line counts in a band
    with no more than its own confidence limit: a peak that is beyond alone carries no band.
    Of a band that is beyond, its middle half counts and those lines that are beyond themselves.

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
    starts, stops = _bands(ratio.size)
    n_scales = max(ratio.size, 1).bit_length()
    chance = CHANCE / (ratio.size + starts.size if anywhere else 2 * n_scales - 1)
    critical = _critical(spectra.degrees_of_freedom, chance, above=above)
    result = ratio > critical if above else ratio < critical
    beyond = ratio > 1.0 if above else ratio < 1.0
    clipped = np.minimum(ratio, critical) if above else np.maximum(ratio, critical)
    sums = np.concatenate([[0.0], np.cumsum(clipped)])
    means = (sums[stops] - sums[starts]) / (stops - starts)
    correlation = _line_correlation(spectra, ratio.size)
    for width in np.unique(stops - starts):
        lags = np.arange(1, width)
        spread = 1.0 + 2.0 * float(np.sum((1.0 - lags / width) * correlation[lags]))
        freedom = spectra.degrees_of_freedom * width / spread
        limit = _critical(freedom, chance, above=above)
        sure = (stops - starts == width) & (means > limit if above else means < limit)
        for start, stop in zip(starts[sure], stops[sure], strict=True):
            result[start:stop] |= beyond[start:stop]
            quarter = (stop - start) // 4
            result[start + quarter : stop - quarter] = True
    return np.asarray(result)


def _bands(n_lines: int) -> tuple[NDArray[np.int_], NDArray[np.int_]]:
    """Return where bands of 2, 4, 8, ... lines start and stop; a line is in two of each."""
    bands = [
        (start, min(start + width, n_lines))
        for width in (2**scale for scale in range(1, n_lines.bit_length()))
        for start in range(0, n_lines - width // 2, width // 2)
    ]
    starts, stops = np.array(bands, dtype=np.int_).reshape(-1, 2).T
    return starts, stops


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
