"""Natural frequency and damping of a peak, or the reason why they cannot be read."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.spectra.cross import CrossSpectra
from shakerproc.spectra.peaks import local_maxima
from shakerproc.spectra.responses import coherence, h1, psd, psd_ratio
from shakerproc.spectra.single_mode import (
    Kind,
    ModeFit,
    ModeShape,
    bin_correlation,
    fit_mode,
    window_correlation,
)

RESOLVED: Final = 0.04
"""Largest half-width of the 95 % interval of a damping ratio that is reported [-]."""

NORMAL: Final = 1.96
"""Standard errors to the end of a 95 % interval."""

READABLE: Final = 9.0
"""Half-power width, in widths of the window, from which leakage widens it by 3 % at most."""

REACH_BINS: Final = 6
"""Bins to each side of a peak that are fitted at least."""

REACH_WIDTHS: Final = 2.0
"""Half-power widths to each side of a peak that are fitted."""

FURTHEST: Final = 600
"""Bins to each side of a peak that are fitted at most."""

LEAST_BINS: Final = 7
"""Bins below which six or eight unknowns are too many."""

NEIGHBOUR: Final = 0.03
"""Height of another peak, over that of this one, that ends the fit between them [-]."""

FEW: Final = 3.5
"""Segments that light a bin below which a sweep does not average the window's leakage."""

WIDE: Final = 30.0
"""Half-power width in bins from which that does not matter, as many bins average it too."""

UNLIKE: Final = 0.05
"""Misfit over the height of a peak that no linear mode has [-]."""

FLOOR: Final = 1e-6
"""Least share of noise assumed in the power of a response [-]."""


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

    is fitted by least squares with :math:`h` of one mode and a straight background, so that
    a peak narrower than the window is still read rightly as long as chance allows. The ratio
    is withheld where the 95 % interval is wider than 4 % to each side, or where the peak has
    not the shape of one linear mode.

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
    noise = np.maximum(1.0 - coherence(spectra, controls, [response])[0], FLOOR)
    errors = np.sqrt(ratio * noise / spectra.effective_averages / 2.0)
    return _damping(
        spectra,
        _Data("response", values, errors, spectra.lit_segments[controls[0]]),
        frequency,
        band,
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
        _Data("density", values, errors, spectra.lit_segments[channel]),
        frequency,
        band,
    )


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
        Squared magnitude or density.
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


def psd_ratio_of_mean(
    spectra: CrossSpectra, controls: Sequence[int], response: int
) -> FloatArray:
    """Return the density of a response over that of the mean control [-]."""
    gain = np.abs(h1(spectra, controls, [response])[0]) ** 2
    coherent = coherence(spectra, controls, [response])[0]
    result = np.full(gain.shape, np.nan)
    np.divide(gain, coherent, out=result, where=coherent > 0.0)
    return result


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Data:
    """What is fitted: values of every frequency and their standard errors."""

    kind: Kind
    values: ComplexArray | FloatArray
    errors: FloatArray
    lit_segments: FloatArray


def _damping(
    spectra: CrossSpectra, data: _Data, frequency: float, band: tuple[float, float]
) -> Damping:
    """Return what a fit around a peak says, and what may be said of it."""
    values, errors = data.values, data.errors
    usable = np.isfinite(values) & np.isfinite(errors) & (errors > 0.0)
    usable &= (spectra.frequency >= band[0]) & (spectra.frequency <= band[1])
    usable[[0, -1]] = False
    power = np.where(usable, np.abs(values) ** (2 if data.kind == "response" else 1), 0.0)
    place = frequency / spectra.bin_width
    n_smooth = _smoothing(power, data, place)
    smooth = np.convolve(power, np.full(n_smooth, 1.0 / n_smooth), mode="same")
    peak = _nearest_peak(smooth, place)
    reading = half_power_ratio(spectra.frequency, smooth, peak)
    width = reading[1] / spectra.bin_width if reading else 0.0
    least = READABLE * max(spectra.resolution / spectra.bin_width, float(n_smooth))
    readable = reading[0] if reading and width >= least else None
    fit: ModeFit | None = None
    for _ in range(3):
        reach = min(max(REACH_WIDTHS * width, REACH_BINS), FURTHEST)
        bins = _bins(smooth, usable, peak, reach)
        if bins.size < LEAST_BINS:
            break
        fit = _fit(spectra, data, bins)
        wanted = 2.0 * fit.ratio * fit.frequency / spectra.bin_width
        if reach > REACH_WIDTHS * wanted * 0.8:
            break
        width = min(wanted, 4.0 * reach)
    return _judged(spectra, fit, peak, float(data.lit_segments[peak]), readable)


def _fit(spectra: CrossSpectra, data: _Data, bins: NDArray[np.intp]) -> ModeFit:
    """Return the fit in these bins; a density's errors follow the fit, not its chance."""
    kernel = window_correlation(spectra.window, spectra.n_fft)
    shape = ModeShape(data.kind, bins, kernel, spectra.sample_rate)
    correlation = bin_correlation(spectra.window, spectra.n_fft)
    values = data.values[bins]
    start = float(spectra.frequency[bins[np.argmax(np.abs(values))]])
    fit = fit_mode(shape, values, data.errors[bins], correlation, start)
    for _ in range(3 if data.kind == "density" else 0):
        least = 1e-3 * np.abs(values).max()
        expected = np.maximum(fit.fitted.real, least) / np.sqrt(spectra.effective_averages)
        fit = fit_mode(shape, values, expected, correlation, fit.frequency, fit.ratio)
    return fit


def _judged(
    spectra: CrossSpectra, fit: ModeFit | None, where: int, lit: float, readable: float | None
) -> Damping:
    """Return the damping, withheld where it is not resolved."""
    step, peak = spectra.bin_width, float(spectra.frequency[where])
    few = f"fewer than {LEAST_BINS} bins of {step:.3g} Hz between this peak and the next"
    unlike = few if fit is None else _no_mode(fit, peak, step, lit)
    if fit is None or unlike:
        return Damping(None, None, None, None, None, None, unlike, readable, step)
    half = NORMAL * fit.ratio_error
    coarse = _uncertain(fit, half, step)
    spread = NORMAL * fit.frequency_error
    return Damping(
        frequency=fit.frequency,
        frequency_low=fit.frequency * (1.0 - spread),
        frequency_high=fit.frequency * (1.0 + spread),
        ratio=None if coarse else fit.ratio,
        ratio_low=None if coarse else float(fit.ratio * np.exp(-half)),
        ratio_high=None if coarse else float(fit.ratio * np.exp(half)),
        reason=coarse,
        half_power=readable,
        bin_width=step,
    )


def _no_mode(fit: ModeFit, peak: float, step: float, lit: float) -> str | None:
    """Return why a fit says nothing of a mode at the peak, if it does not."""
    if not fit.converged or not 1e-5 < fit.ratio < 0.5:
        return "the fit of one mode does not converge"
    if abs(fit.frequency - peak) > max(2.0 * step, fit.ratio * peak):
        return f"the mode that fits best lies at {fit.frequency:.4g} Hz, beside the peak"
    if lit < FEW and 2.0 * fit.ratio * fit.frequency < WIDE * step:
        return (
            "the sweep passes the peak within a segment or two: take shorter segments, or "
            "overlap them more"
        )
    if fit.misfit > UNLIKE and fit.chi_square > 4.0:
        return f"the peak has not the shape of one linear mode (misfit {fit.misfit:.0%})"
    return None


def _uncertain(fit: ModeFit, half: float, step: float) -> str | None:
    """Return why the ratio of a mode is withheld although its frequency is known, if it is."""
    if half <= RESOLVED:
        return None
    about = f"zeta about {fit.ratio:.2g} +- {half:.0%}, " if half < 0.5 else ""
    return f"{about}not resolved by bins of {step:.3g} Hz and this length of run"


def _smoothing(power: FloatArray, data: _Data, place: float) -> int:
    """Return over how many bins to average so that chance makes no peaks of its own."""
    centre = min(max(round(place), 2), power.size - 3)
    near = slice(centre - 2, centre + 3)
    kept = power[near] > 0.0
    if not kept.any():
        return 1
    error = np.median(data.errors[near][kept] / np.abs(data.values[near][kept]))
    error *= 2.0 if data.kind == "response" else 1.0
    return min(1 + 2 * round(8.0 * float(error) ** 2), 201)


def _nearest_peak(power: FloatArray, place: float) -> int:
    """Return the local maximum nearest to a place, or the bin there if there is none."""
    maxima = local_maxima(power)
    if not maxima.size:
        return round(min(max(place, 0.0), power.size - 1.0))
    return int(maxima[np.argmin(np.abs(maxima - place))])


def _bins(
    power: FloatArray, usable: NDArray[np.bool_], peak: int, reach: float
) -> NDArray[np.intp]:
    """Return the bins around a peak, up to half-way to the next peaks that matter."""
    maxima = local_maxima(power)
    others = maxima[(power[maxima] > NEIGHBOUR * power[peak]) & _valleys(power, maxima, peak)]
    low, high = peak - reach, peak + reach
    if (others < peak).any():
        low = max(low, (peak + others[others < peak].max()) / 2.0)
    if (others > peak).any():
        high = min(high, (peak + others[others > peak].min()) / 2.0)
    number = np.arange(power.size)
    bins = number[(number >= low) & (number <= high)]
    broken = bins[~usable[bins]]
    if (broken < peak).any():
        bins = bins[bins > broken[broken < peak].max()]
    if (broken > peak).any():
        bins = bins[bins < broken[broken > peak].min()]
    return bins


def _valleys(power: FloatArray, maxima: NDArray[np.intp], peak: int) -> NDArray[np.bool_]:
    """Return which maxima a real valley, to half of the lower peak, parts from the peak."""
    return np.array(
        [
            m != peak and power[min(m, peak) : max(m, peak) + 1].min() < 0.5 * power[m]
            for m in maxima
        ],
        dtype=bool,
    )


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
