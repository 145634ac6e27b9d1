"""Damping from the points at half the power of a peak, and whether bins resolve it."""

from typing import Final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.spectra.welch.cross import CrossSpectra
from shakerproc.spectra.welch.windows import correlation_of

READABLE: Final = 9.0
"""Half-power width, in widths of the window, from which leakage widens it by 3 % at most."""


def half_power_ratio(
    frequency: FloatArray, power: FloatArray, peak: int
) -> tuple[float, float] | None:
    r"""Return damping ratio and width of a peak from the points at half its power.

    .. math:: \zeta = \frac{f_2^2 - f_1^2}{4 f_0^2}

    with the points found on straight lines between bins.

    Parameters
    ----------
    frequency : (n_frequencies,) array
        Frequencies [Hz].
    power : (n_frequencies,) array
        Squared magnitude or density [any unit].
    peak : int
        Bin of the peak.

    Returns
    -------
    (float, float) or None
        Ratio [-] and half-power width [Hz]; None where one side does not fall to half.
    """
    half = power[peak] / 2.0
    below, above = _crossing(power, peak, half, -1), _crossing(power, peak, half, 1)
    if below is None or above is None:
        return None
    low, high = np.interp([below, above], np.arange(frequency.size), frequency)
    ratio = (high**2 - low**2) / (4.0 * frequency[peak] ** 2)
    return float(ratio), float(high - low)


def is_resolved(spectra: CrossSpectra, power: FloatArray, peak: int) -> bool:
    """Return whether the bins resolve a peak: its width and height are what they seem to be.

    Parameters
    ----------
    spectra : CrossSpectra
        What it was read from.
    power : (n_frequencies,) array
        Squared magnitude or density [any unit].
    peak : int
        Bin of the peak.
    """
    reading = half_power_ratio(spectra.frequency, power, peak)
    return reading is not None and reading[1] >= READABLE * spectra.resolution


def own_width(seen: float, window: float) -> float:
    r"""Return the half-power width of a resonance that is seen through a window [Hz].

    .. math:: B_s \approx 0.5346 \, B + \sqrt{0.2166 \, B^2 + B_w^2}

    `seen` is the width that shows, `window` that of the window, which is less [Hz].

    References
    ----------
    .. [1] J. J. Olivero and R. L. Longbothum, "Empirical fits to the Voigt line width: a brief
       review", J. Quant. Spectrosc. Radiat. Transfer 17, 233-236, 1977.
    """
    a, b = 0.5346, 0.2166
    root = np.sqrt((a * seen) ** 2 - (a * a - b) * (seen**2 - window**2))
    return float((a * seen - root) / (a * a - b))


def seen_share(spectra: CrossSpectra, width: float) -> float:
    r"""Return the share of the height of a resonance that a window lets be seen.

    .. math:: \frac{\sum_\tau r_w(\tau) e^{-\pi B \tau}}{\sum_\tau e^{-\pi B \tau}}

    with the correlation :math:`r_w` of the window with itself, the first sample halved. It is
    the same for the density of a mode under white noise and for its response function.

    Parameters
    ----------
    spectra : CrossSpectra
        What the height is read from.
    width : float
        Half-power width :math:`B` of the resonance itself [Hz].

    Returns
    -------
    float
        From 0 to 1 [-]; 1 of whole decays, of which no window takes anything.
    """
    if spectra.decay_rate is not None:
        return 1.0
    decay = np.array([-np.pi * width / spectra.sample_rate], dtype=np.complex128)
    seen = correlation_of(spectra.window_name, spectra.window).transform(decay)[0]
    whole = -1.0 / np.expm1(decay) - 0.5
    return float((seen / whole)[0].real)


def _crossing(power: FloatArray, peak: int, level: float, step: int) -> float | None:
    """Return where the power first falls to a level on one side of a peak."""
    k = peak
    while 0 <= k + step < power.size:
        if power[k + step] <= level:
            share = (power[k] - level) / (power[k] - power[k + step])
            return k + step * float(share)
        if power[k + step] > power[peak]:
            return None
        k += step
    return None
