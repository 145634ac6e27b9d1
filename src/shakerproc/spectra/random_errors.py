"""Random errors of levels, and of the place and the height of a peak."""

import numpy as np

from shakerproc.data import FloatArray


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
