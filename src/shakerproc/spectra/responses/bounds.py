"""Random errors of densities, levels, gains and phases, and of the place of a peak."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import FloatArray
from shakerproc.spectra.responses.estimators import coherence, h1
from shakerproc.spectra.welch.cross import CrossSpectra, psd


@final
@dataclass(frozen=True, slots=True, eq=False)
class Bounds:
    """Limits between which the true value lies with a given probability.

    Attributes
    ----------
    low, high : (..., n_frequencies) arrays
        Limits, in the unit of the value.
    """

    low: FloatArray
    high: FloatArray


def psd_bounds(spectra: CrossSpectra, confidence: float = 0.95) -> Bounds:
    r"""Return the confidence limits of every power spectral density.

    .. math:: \frac{\nu \hat S}{\chi^2_{1 - \alpha/2}} \le S \le
              \frac{\nu \hat S}{\chi^2_{\alpha/2}}, \quad \nu = 2 K_e

    with the effective averages :math:`K_e` of the overlapped segments; at 0 and at half the
    sample rate, where a spectrum is real, with half as many degrees of freedom. They hold
    for stationary random signals, not for sweeps.

    Parameters
    ----------
    spectra : CrossSpectra
        Matrix of cross spectra.
    confidence : float
        Probability that the limits hold the true value, for each bin by itself [-].

    Returns
    -------
    Bounds
        (n_channels, n_frequencies) arrays [unit²/Hz].

    Raises
    ------
    ValueError
        If the confidence does not lie between 0 and 1.

    References
    ----------
    .. [1] J. S. Bendat and A. G. Piersol, "Random Data", 4th ed., Wiley, 2010, ch. 8.
    """
    freedom = np.full(spectra.frequency.size, spectra.degrees_of_freedom)
    freedom[0] /= 2.0
    if spectra.n_fft % 2 == 0:
        freedom[-1] /= 2.0
    tail = _tail(confidence)
    density = psd(spectra)
    return Bounds(
        density * freedom / (2.0 * scipy.special.gammaincinv(freedom / 2.0, 1.0 - tail)),
        density * freedom / (2.0 * scipy.special.gammaincinv(freedom / 2.0, tail)),
    )


def gain_random_error(coherence: FloatArray, n_averages: float) -> FloatArray:
    r"""Return the random error of a measured gain, as a share of the gain.

    .. math:: \varepsilon = \sqrt{\frac{1 - \gamma^2}{2 \gamma^2 (n_d - 1)}}

    It is the random error of the phase [rad] too, as long as it is small. Bendat and Piersol
    have :math:`n_d` below; less 1 it is free of bias when the coherence is measured.

    Parameters
    ----------
    coherence : (..., n_frequencies) array
        Magnitude-squared coherence :math:`\gamma^2`, from 0 to 1 [-].
    n_averages : float
        Number of independent averages :math:`n_d` [-].

    Returns
    -------
    (..., n_frequencies) array
        One standard deviation [-]; infinite where the coherence is 0, and of one average,
        which tells nothing of its error.

    Raises
    ------
    ValueError
        If a coherence lies outside 0 to 1, or `n_averages` is below 1.

    References
    ----------
    .. [1] J. S. Bendat and A. G. Piersol, "Random Data", 4th ed., Wiley, 2010, ch. 9.
    """
    outside = coherence[(coherence < 0.0) | (coherence > 1.0 + 1e-9)]
    if outside.size:
        raise ValueError(f"coherence must lie in 0 to 1, not {outside[0]:g}")
    if n_averages < 1.0 - 1e-9:
        raise ValueError(f"n_averages must be at least 1, not {n_averages:g}")
    if n_averages <= 1.0:
        return np.full_like(coherence, np.inf)
    missing = np.maximum(1.0 - coherence, 0.0)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return np.array(np.sqrt(missing / (2.0 * coherence * (n_averages - 1.0))))


def response_bounds(
    spectra: CrossSpectra,
    controls: Sequence[int],
    responses: Sequence[int],
    confidence: float = 0.95,
) -> tuple[Bounds, FloatArray]:
    r"""Return the confidence limits of the gain of H1, and how far its phase may be off.

    .. math:: |\hat H| (1 \mp t_{2 n_d - 2} \varepsilon), \quad
              \Delta\varphi = \arcsin \min(1, t_{2 n_d - 2} \varepsilon)

    with :math:`\varepsilon` of `gain_random_error` and Student's :math:`t`.

    Parameters
    ----------
    spectra : CrossSpectra
        Matrix of cross spectra, of more than one average.
    controls, responses : sequence of int
        Rows of the control and of the response channels, from 0.
    confidence : float
        Probability that the limits hold the true value, for each bin by itself [-].

    Returns
    -------
    Bounds
        Limits of the gain, (n_responses, n_frequencies) arrays [-].
    (n_responses, n_frequencies) array
        Half the width of the interval of the phase [rad]; pi where it is not known at all.

    Raises
    ------
    ValueError
        If the confidence does not lie between 0 and 1.
    """
    averages = spectra.effective_averages
    if averages <= 1.0:
        unknown = np.full((len(responses), spectra.frequency.size), np.pi)
        return Bounds(np.zeros_like(unknown), np.full_like(unknown, np.inf)), unknown
    student = scipy.special.stdtrit(2.0 * averages - 2.0, 1.0 - _tail(confidence))
    gain = np.abs(h1(spectra, controls, responses))
    error = gain_random_error(coherence(spectra, controls, responses), averages)
    half = student * error
    phase = np.where(half < 1.0, np.arcsin(np.minimum(half, 1.0)), np.pi)
    with np.errstate(invalid="ignore"):
        return Bounds(gain * np.maximum(1.0 - half, 0.0), gain * (1.0 + half)), phase


def _tail(confidence: float) -> float:
    """Return the probability outside one limit.

    Raises
    ------
    ValueError
        If the confidence does not lie between 0 and 1.
    """
    if not 0.0 < confidence < 1.0:
        raise ValueError(f"confidence must lie between 0 and 1, not {confidence:g}")
    return (1.0 - confidence) / 2.0


def mean_square_error(
    density: FloatArray, bin_width: float, duration: float, averages: float
) -> float:
    r"""Return the standard deviation of the mean square of random vibration.

    .. math:: \sigma^2 = \frac{1}{T} \int S^2(f) \, df

    The square of an averaged density is too large by :math:`1/K_e` on average, which is taken
    out. The mean square over its own bandwidth B has then a relative error of
    :math:`1/\sqrt{B T}`.

    Parameters
    ----------
    density : (n_frequencies,) array
        Measured one-sided density within the band [unit²/Hz].
    bin_width : float
        Distance of the frequencies [Hz].
    duration : float
        Length of the run [s].
    averages : float
        Effective averages of the density [-].

    Returns
    -------
    float
        One standard deviation [unit²].

    References
    ----------
    .. [1] J. S. Bendat and A. G. Piersol, "Random Data", 4th ed., Wiley, 2010, ch. 8.
    """
    area = float(np.sum(density**2)) * bin_width / (1.0 + 1.0 / averages)
    return float(np.sqrt(area / duration))


def tallest_bins(
    values: FloatArray, errors: FloatArray, peak: int, level: float
) -> tuple[int, int]:
    r"""Return the first and the last bin that chance does not tell from the tallest.

    .. math:: \ln y_p - \ln y_k \le 2 \sqrt{\varepsilon_p^2 + \varepsilon_k^2}

    The peak ends where it has fallen to the level by more than that.

    Parameters
    ----------
    values : (n_values,) array
        The spectrum [any unit].
    errors : (n_values,) array
        Random error of each value, as a share of it [-].
    peak : int
        Bin of the peak.
    level : float
        Share of the height down to which bins belong to the peak, 1/2 for a density [-].

    Returns
    -------
    int, int
        Bins; both the peak's where it stands alone.
    """
    ends = []
    for step in (-1, 1):
        last = k = peak
        while 0 <= k + step < values.size and values[k + step] > 0.0:
            k += step
            fall = np.log(values[peak] / values[k]) - 2.0 * np.hypot(errors[peak], errors[k])
            if fall > -np.log(level):
                break
            last = k if fall <= 0.0 else last
        ends.append(last)
    return ends[0], ends[1]
