"""Natural frequency and damping of a peak, or the reason why they cannot be read."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.numerals import numeral
from shakerproc.spectra.peaks.chance import modelled
from shakerproc.spectra.peaks.fitted_modes import (
    LEAST_BINS,
    MOST_BINS,
    REACH_BINS,
    FittedModes,
    PeakData,
    bins_around,
    fitted_modes,
    maxima_around,
    nearest_peak,
    smoothing_of,
)
from shakerproc.spectra.responses import coherence, h1, psd_ratio
from shakerproc.spectra.welch.cross import CrossSpectra, psd
from shakerproc.spectra.welch.windows import correlation_of

READABLE_WIDTH: Final = 9.0
"""Half-power width, in widths of the window, from which leakage widens it by 3 % at most."""

LARGEST_ERROR: Final = 0.04
"""Largest half-width of the 95 % interval of a damping ratio that is reported [-]."""

NORMAL: Final = 1.96
"""Standard errors to the end of a 95 % interval."""

REACH_WIDTHS: Final = 2.0
"""Half-power widths to each side of a peak that are fitted."""

FEW_SEGMENTS: Final = 3.5
"""Segments that light a bin below which a sweep does not average the window's leakage."""

WIDE_PEAK: Final = 30.0
"""Half-power width in bins from which that does not matter, as many bins average it too."""

UNLIKE_SHARE: Final = 0.05
"""Misfit over the height of a peak that no linear mode has [-]."""

UNLIKELY_MISFIT: Final = 4.0
"""Squared misfit over chance from which a misfit is not chance [-]."""

NOISE_FLOOR: Final = 1e-6
"""Least share of noise assumed in the power of a response [-]."""


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
    """Return whether the bins resolve a peak, so that its width and height are true.

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
    return reading is not None and reading[1] >= READABLE_WIDTH * spectra.resolution


def resonance_width(seen: float, window: float) -> float:
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


def smeared_height(spectra: CrossSpectra, width: float) -> float:
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


@final
@dataclass(frozen=True, slots=True)
class Damping:
    """Natural frequency and damping ratio of one peak.

    Attributes
    ----------
    frequency, frequency_low, frequency_high : float or None
        Natural frequency and its 95 % interval [Hz]; None where no mode fits the peak.
    ratio : float or None
        Damping ratio [-]; None where it is withheld.
    ratio_low, ratio_high : float or None
        Its 95 % interval [-].
    reason : str or None
        Why the ratio is withheld.
    half_power : float or None
        Damping ratio read from the half-power width [-], where the width is resolved.
    bin_width : float
        Distance of the frequencies that it was read from [Hz].
    height : float or None
        Height of the peak by the fit, the window's leakage taken away [unit of the values];
        None where the ratio is withheld.
    width : float or None
        Half-power width of the mode that was fitted [Hz], also where the ratio is withheld;
        None where no mode fits the peak.
    """

    frequency: float | None
    frequency_low: float | None
    frequency_high: float | None
    ratio: float | None
    ratio_low: float | None
    ratio_high: float | None
    reason: str | None
    half_power: float | None
    bin_width: float
    height: float | None = None
    width: float | None = None

    @property
    def quality_factor(self) -> float | None:
        """Magnification at resonance, 1/(2 zeta) [-]."""
        return None if self.ratio is None else 0.5 / self.ratio


def damping_of_response(
    spectra: CrossSpectra,
    controls: Sequence[int],
    response: int,
    frequency: float,
    band: tuple[float, float],
) -> Damping:
    r"""Return frequency and damping of a mode from H1, the window's leakage allowed for.

    .. math:: \hat H_1(f) \approx \sum_\tau h(\tau) r_w(\tau) e^{-i 2 \pi f \tau}, \quad
              r_w(\tau) = \frac{\sum_t w_t w_{t + \tau}}{\sum_t w_t^2}

    is fitted by least squares with :math:`h` of the mode, of its resolved neighbours, of
    further modes as long as the information criterion of Takeuchi falls, and a straight
    background for the rest, so that a peak narrower than the window or beside others is still
    read rightly as long as chance allows. The interval is that of chance (`steady_chance`),
    widened by the misfit where that is larger. The ratio is withheld where the 95 % interval
    is wider than 4 % to each side, or where no linear mode fits the peak.

    Parameters
    ----------
    spectra : CrossSpectra
        Matrix of cross spectra.
    controls : sequence of int
        Rows of the control channels, from 0.
    response : int
        Row of the response channel, from 0.
    frequency : float
        Where the peak is [Hz].
    band : (float, float)
        Excited band [Hz]; nothing outside it is fitted.

    Returns
    -------
    Damping
        Frequency, ratio or reason, intervals, and the half-power reading.
    """
    values = h1(spectra, controls, [response])[0]
    ratio = psd_ratio_of_mean(spectra, controls, response)
    missing = np.maximum(1.0 - coherence(spectra, controls, [response])[0], NOISE_FLOOR) * ratio
    averages = spectra.effective_averages
    if averages > 1.0:  # a measured coherence is too large by chance
        missing *= averages / (averages - 1.0)
    errors = np.sqrt(missing / averages / 2.0)
    lit = spectra.lit_segments[controls[0]]
    return _damping(
        spectra, PeakData("response", values, errors, lit, missing), frequency, band
    )


def damping_of_density(
    spectra: CrossSpectra,
    channel: int,
    frequency: float,
    band: tuple[float, float],
    controls: Sequence[int] = (),
) -> Damping:
    """Return frequency and damping of a mode from the density of a response alone.

    The input is taken to be flat around the peak; with controls the PSD ratio is fitted
    instead, for which it need only be smooth. Chance makes a density far less certain than
    `damping_of_response`.

    Parameters
    ----------
    spectra : CrossSpectra
        Matrix of cross spectra.
    channel : int
        Row of the channel, from 0.
    frequency : float
        Where the peak is [Hz].
    band : (float, float)
        Excited band [Hz]; nothing outside it is fitted.
    controls : sequence of int
        Rows of the control channels, if any.

    Returns
    -------
    Damping
        Frequency, ratio or reason, intervals, and the half-power reading.
    """
    over = list(controls)
    values = psd_ratio(spectra, over, [channel])[0] if over else psd(spectra)[channel]
    errors = values / np.sqrt(spectra.effective_averages)
    return _damping(
        spectra,
        PeakData("density", values, errors, spectra.lit_segments[channel]),
        frequency,
        band,
    )


def longer_may_resolve(spectra: CrossSpectra, read: Damping, finer: float) -> bool:
    """Return whether spectra of longer segments may give a ratio that these withhold.

    They cannot where the bins resolve the mode already, for they average the same samples;
    nor where the bins that are fitted at most end inside its half-power points, beyond which
    its width shows.

    Parameters
    ----------
    spectra : CrossSpectra
        What the damping was read from.
    read : Damping
        What was read.
    finer : float
        Bin width of the spectra of longer segments [Hz].
    """
    if read.ratio is not None or read.width is None:
        return read.ratio is None
    return read.width < min(READABLE_WIDTH * spectra.resolution, 2.0 * MOST_BINS * finer)


def psd_ratio_of_mean(
    spectra: CrossSpectra, controls: Sequence[int], response: int
) -> FloatArray:
    """Return the density of a response over that of the mean control [-]."""
    gain = np.abs(h1(spectra, controls, [response])[0]) ** 2
    coherent = coherence(spectra, controls, [response])[0]
    result = np.full(gain.shape, np.nan)
    np.divide(gain, coherent, out=result, where=coherent > 0.0)
    return result


def _damping(
    spectra: CrossSpectra, data: PeakData, frequency: float, band: tuple[float, float]
) -> Damping:
    """Return the damping of a fit around a peak, and the reason where it is withheld."""
    usable = np.isfinite(data.values) & np.isfinite(data.errors) & (data.errors > 0.0)
    usable &= (spectra.frequency >= band[0]) & (spectra.frequency <= band[1])
    usable[[0, -1]] = False
    place = frequency / spectra.bin_width
    power = np.where(usable, np.abs(data.values) ** (2 if data.kind == "response" else 1), 0.0)
    n_smooth = smoothing_of(power, data, place)
    smooth = np.convolve(power, np.full(n_smooth, 1.0 / n_smooth), mode="same")
    maxima = maxima_around(data, usable, place)
    peak = nearest_peak(maxima, smooth, place)
    reading = half_power_ratio(spectra.frequency, smooth, peak)
    width = reading[1] / spectra.bin_width if reading else 0.0
    least = READABLE_WIDTH * max(spectra.resolution / spectra.bin_width, float(n_smooth))
    added = (spectra.decay_rate or 0.0) / np.pi  # width that a window of decays adds [Hz]
    narrowed = 0.5 * added / float(spectra.frequency[peak])
    readable = reading[0] - narrowed if reading and width >= least else None
    fitted: FittedModes | None = None
    for _ in range(3):
        reach = min(max(REACH_WIDTHS * width, REACH_BINS), MOST_BINS)
        # one blow has a coherence of 1 and no error by which a neighbour could be weighed
        weighed = width if spectra.effective_averages > 1.0 else 0.0
        bins, inside = bins_around(data, usable, maxima, peak, reach, width=weighed)
        if bins.size < LEAST_BINS:
            break
        fitted = fitted_modes(spectra, data, bins, (peak, *inside), maxima)
        wanted = 2.0 * float(fitted.fit.ratio[0] * fitted.fit.frequency[0]) / spectra.bin_width
        wanted += added / spectra.bin_width
        if reach > REACH_WIDTHS * min(wanted, MOST_BINS / REACH_WIDTHS) * 0.8:
            break
        width = min(wanted, 4.0 * reach)
    lit = np.inf if spectra.decay_rate is not None else float(data.lit_segments[peak])
    return _judged(spectra, fitted, peak, lit, readable)


def _judged(
    spectra: CrossSpectra, fitted: FittedModes | None, where: int, lit: float,
    readable: float | None,
) -> Damping:  # fmt: skip
    """Return the damping, withheld where it is not resolved."""
    step, peak = spectra.bin_width, float(spectra.frequency[where])
    few = f"fewer than {LEAST_BINS} bins of {numeral(step)} Hz are excited around this peak"
    unlike = few if fitted is None else _no_mode(fitted, peak, step, lit)
    if fitted is None or unlike:
        return Damping(None, None, None, None, None, None, unlike, readable, step)
    fit, errors = fitted.fit, NORMAL * np.sqrt(fitted.spread)
    frequency, ratio = float(fit.frequency[0]), float(fit.ratio[0])
    spread, half = float(errors[0]), float(errors[fit.frequency.size])
    coarse = _uncertain(ratio, half, step)
    return Damping(
        frequency=frequency,
        frequency_low=frequency * (1.0 - spread),
        frequency_high=frequency * (1.0 + spread),
        ratio=None if coarse else ratio,
        ratio_low=None if coarse else ratio * float(np.exp(-half)),
        ratio_high=None if coarse else ratio * float(np.exp(half)),
        reason=coarse,
        half_power=readable,
        bin_width=step,
        height=None if coarse else _height(spectra, fitted),
        width=2.0 * ratio * frequency,
    )


def _height(spectra: CrossSpectra, fitted: FittedModes) -> float:
    """Return the height of the first mode's peak, all modes together, before smearing."""
    frequency, ratio = float(fitted.fit.frequency[0]), float(fitted.fit.ratio[0])
    near = frequency * (1.0 + ratio * np.linspace(-1.0, 1.0, 101))
    bins = spectra.frequency[fitted.shape.bins]
    values = modelled(fitted.shape.kind, near, bins, fitted.fit, spectra.sample_rate)
    return float(np.abs(values).max())


def _no_mode(fitted: FittedModes, peak: float, step: float, lit: float) -> str | None:
    """Return why a fit says nothing of a mode at the peak, if it does not."""
    fit, scale = fitted.fit, fitted.scale
    frequency, ratio = float(fit.frequency[0]), float(fit.ratio[0])
    if not fit.converged or not 1e-5 < ratio < 0.5:
        return "the fit of the modes does not converge"
    if abs(frequency - peak) > max(2.0 * step, ratio * peak):
        return f"the mode that fits best lies at {numeral(frequency, 4)} Hz, beside the peak"
    if lit < FEW_SEGMENTS and 2.0 * ratio * frequency < WIDE_PEAK * step:
        return (
            "the sweep passes the peak within a segment or two: take shorter segments, or "
            "overlap them more"
        )
    if fit.misfit > UNLIKE_SHARE and scale > UNLIKELY_MISFIT:
        return f"the peak has not the shape of linear modes (misfit {fit.misfit:.0%})"
    return None


def _uncertain(ratio: float, half: float, step: float) -> str | None:
    """Return why the ratio of a mode is withheld although its frequency is known, if it is."""
    if half <= LARGEST_ERROR:
        return None
    about = f"zeta about {numeral(ratio, 2)} +- {half:.0%}, " if half < 0.5 else ""
    return f"{about}not resolved by bins of {numeral(step)} Hz and this length of run"
