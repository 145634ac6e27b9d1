"""Lines between breakpoints: straight where level and frequency are both logarithmic."""

import numpy as np

from shakerproc.data import FloatArray


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
    found = np.full(frequency.shape, np.nan)
    found[inside] = np.exp(
        np.interp(np.log(frequency[inside]), np.log(breakpoints), np.log(levels))
    )
    return found


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
