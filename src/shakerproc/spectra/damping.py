"""Natural frequency and damping of a peak, or the reason why they cannot be read."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.spectra.chance import Chance, modelled, plain_chance, smearing_of, steady_chance
from shakerproc.spectra.cross import CrossSpectra
from shakerproc.spectra.mode_fit import (
    Kind,
    ModesFit,
    ModeShape,
    best_ratio,
    fit_modes,
)
from shakerproc.spectra.peaks import IndexArray, local_maxima, resolved
from shakerproc.spectra.responses import coherence, h1, psd, psd_ratio
from shakerproc.spectra.windows import AbstractCorrelation, DecayCorrelation, correlation_of

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

FURTHEST: Final = 64
"""Bins to each side of a peak that are fitted at most."""

LEAST_BINS: Final = 7
"""Bins below which six or eight unknowns are too many."""

SEEN: Final = 400
"""Bins to each side of a peak in which its neighbours are looked for."""

MOST_MODES: Final = 6
"""Modes that are fitted together at most."""

FIRST_RATIOS: Final = np.geomspace(2e-4, 0.3, 13)
"""Damping ratios tried before the search [-]."""

FEW: Final = 3.5
"""Segments that light a bin below which a sweep does not average the window's leakage."""

WIDE: Final = 30.0
"""Half-power width in bins from which that does not matter, as many bins average it too."""

UNLIKE: Final = 0.05
"""Misfit over the height of a peak that no linear mode has [-]."""

UNLIKELY: Final = 4.0
"""Squared misfit over chance from which a misfit is not chance [-]."""

UNSTEADY: Final = 3.0
"""Standard deviations by which fewer segments light a bin than random vibration lights."""

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
    height : float or None
        Height of the peak by the fit, the window's leakage taken away [unit of the values];
        None where the ratio is withheld.
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
    missing = np.maximum(1.0 - coherence(spectra, controls, [response])[0], FLOOR) * ratio
    averages = spectra.effective_averages
    if averages > 1.0:  # a measured coherence is too large by chance
        missing *= averages / (averages - 1.0)
    errors = np.sqrt(missing / averages / 2.0)
    lit = spectra.lit_segments[controls[0]]
    return _damping(spectra, _Data("response", values, errors, lit, missing), frequency, band)


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


def is_resolved(spectra: CrossSpectra, power: FloatArray, peak: int) -> bool:
    """Return whether the bins resolve a peak: its width and height are what they seem to be.

    Parameters
    ----------
    spectra : CrossSpectra
        What it was read from.
    power : (n_frequencies,) array
        Squared magnitude or density.
    peak : int
        Bin of the peak.
    """
    reading = half_power_ratio(spectra.frequency, power, peak)
    return reading is not None and reading[1] >= READABLE * spectra.resolution


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
    missing: FloatArray | None = None


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Reading:
    """The modes that fit a peak (the first) and what is beside it, and what chance made."""

    shape: ModeShape
    fit: ModesFit
    chance: Chance
    covariance: FloatArray  # of the weighted values
    errors: FloatArray

    @property
    def followed(self) -> float:
        """How much of the squared errors the fit follows: its penalty."""
        return float(np.sum(self.fit.basis * (self.covariance @ self.fit.basis)))

    @property
    def scale(self) -> float:
        """Squared misfit over what chance makes of it [-]."""
        left = float(np.trace(self.covariance)) - self.followed
        return self.fit.squares / max(left, 1e-3 * self.fit.residual.size)

    @property
    def spread(self) -> FloatArray:
        """Variances of the logarithms of frequencies and ratios, the misfit included."""
        slopes = self.fit.slopes
        inverse = np.linalg.pinv(slopes.T @ slopes) @ slopes.T
        return np.asarray(np.diag(inverse @ self.covariance @ inverse.T) * max(1.0, self.scale))


def _damping(
    spectra: CrossSpectra, data: _Data, frequency: float, band: tuple[float, float]
) -> Damping:
    """Return what a fit around a peak says, and what may be said of it."""
    usable = np.isfinite(data.values) & np.isfinite(data.errors) & (data.errors > 0.0)
    usable &= (spectra.frequency >= band[0]) & (spectra.frequency <= band[1])
    usable[[0, -1]] = False
    place = frequency / spectra.bin_width
    power = np.where(usable, np.abs(data.values) ** (2 if data.kind == "response" else 1), 0.0)
    n_smooth = _smoothing(power, data, place)
    smooth = np.convolve(power, np.full(n_smooth, 1.0 / n_smooth), mode="same")
    maxima = _maxima(data, usable, place)
    peak = _nearest_peak(maxima, smooth, place)
    reading = half_power_ratio(spectra.frequency, smooth, peak)
    width = reading[1] / spectra.bin_width if reading else 0.0
    least = READABLE * max(spectra.resolution / spectra.bin_width, float(n_smooth))
    added = (spectra.decay_rate or 0.0) / np.pi  # width that a window of decays adds [Hz]
    narrowed = 0.5 * added / float(spectra.frequency[peak])
    readable = reading[0] - narrowed if reading and width >= least else None
    found: _Reading | None = None
    for _ in range(3):
        reach = min(max(REACH_WIDTHS * width, REACH_BINS), FURTHEST)
        bins, inside = _bins(usable, maxima, peak, reach)
        if bins.size < LEAST_BINS:
            break
        found = _reading(spectra, data, bins, (peak, *inside), maxima)
        wanted = 2.0 * float(found.fit.ratio[0] * found.fit.frequency[0]) / spectra.bin_width
        wanted += added / spectra.bin_width
        if reach > REACH_WIDTHS * min(wanted, FURTHEST / REACH_WIDTHS) * 0.8:
            break
        width = min(wanted, 4.0 * reach)
    lit = np.inf if spectra.decay_rate is not None else float(data.lit_segments[peak])
    return _judged(spectra, found, peak, lit, readable)


def _reading(
    spectra: CrossSpectra,
    data: _Data,
    bins: IndexArray,
    starts: tuple[int, ...],
    maxima: IndexArray,
) -> _Reading:
    """Return the modes that fit these bins, as many as the data tell apart."""
    kernel = _kernel(spectra)
    shape = ModeShape(data.kind, bins, kernel, spectra.n_fft, spectra.sample_rate)
    frequency = spectra.frequency[list(starts)]
    near = bins[np.abs(bins - starts[0]) <= _clearance(starts)]
    alone = replace(shape, bins=near)
    first = best_ratio(
        alone, data.values[near], data.errors[near], float(frequency[0]), FIRST_RATIOS
    )
    ratio = first * frequency[0] / frequency
    fit = fit_modes(shape, data.values[bins], data.errors[bins], frequency, ratio)
    found = _settled(spectra, data, shape, fit)
    while found.scale > 1.0 and found.fit.frequency.size < MOST_MODES:
        more = _one_more(spectra, data, shape, found, maxima)
        if more is None:
            break
        found = more
    return found


def _kernel(spectra: CrossSpectra) -> AbstractCorrelation:
    """Return what the averaging multiplies the decay of a mode by."""
    if spectra.decay_rate is not None:
        return DecayCorrelation(spectra.decay_rate / spectra.sample_rate)
    return correlation_of(spectra.window_name, spectra.window)


def _settled(spectra: CrossSpectra, data: _Data, shape: ModeShape, fit: ModesFit) -> _Reading:
    """Return modes fitted again with the errors that they themselves imply."""
    chance = _chance(spectra, data, shape.bins, fit)
    errors = chance.errors
    values = data.values[shape.bins] - chance.bias
    again = fit_modes(shape, values, errors, fit.frequency, fit.ratio)
    return _Reading(shape, again, chance, _weighted(chance, errors, data.kind), errors)


def _one_more(
    spectra: CrossSpectra, data: _Data, shape: ModeShape, found: _Reading, maxima: IndexArray
) -> _Reading | None:
    """Return a reading with one more mode if the information criterion falls, else None."""
    values = data.values[shape.bins] - found.chance.bias
    trials = []
    for place in _candidates(shape.bins, found, maxima):
        frequency = float(spectra.frequency[place])
        ratio = spectra.bin_width / frequency
        trial = fit_modes(
            shape,
            values,
            found.errors,
            np.append(found.fit.frequency, frequency),
            np.append(found.fit.ratio, ratio),
        )
        if trial.converged:
            trials.append(trial)
    if not trials:
        return None
    best = min(trials, key=lambda trial: trial.squares)
    more = _Reading(shape, best, found.chance, found.covariance, found.errors)
    gained = (found.fit.squares - best.squares) / max(1.0, more.scale)
    if gained <= 2.0 * (more.followed - found.followed):
        return None
    settled = _settled(spectra, data, shape, best)
    return settled if settled.fit.converged else None


def _candidates(bins: IndexArray, found: _Reading, maxima: IndexArray) -> Iterator[int]:
    """Yield where another mode may be: at the largest misfit, at the peaks beside the bins."""
    missed = np.sum(found.fit.residual.reshape(-1, bins.size) ** 2, axis=0)
    yield int(bins[int(np.argmax(missed))])
    below, above = maxima[maxima < bins[0]], maxima[maxima > bins[-1]]
    if below.size:
        yield int(below.max())
    if above.size:
        yield int(above.min())


def _chance(spectra: CrossSpectra, data: _Data, bins: IndexArray, fit: ModesFit) -> Chance:
    """Return the errors of the values: by theory where the excitation was steady and random."""
    smearing = smearing_of(spectra)
    wanted = 0.5 * spectra.n_segments * (1.0 - UNSTEADY / np.sqrt(spectra.effective_averages))
    transient = spectra.decay_rate is not None
    if transient or float(data.lit_segments[bins].mean()) < wanted:
        is_complex = data.kind == "response"
        return plain_chance(smearing, data.errors[bins], is_complex=is_complex)
    missing = None if data.missing is None else data.missing[bins]
    return steady_chance(smearing, data.kind, spectra.frequency[bins], fit, missing)


def _weighted(chance: Chance, errors: FloatArray, kind: Kind) -> FloatArray:
    """Return the covariance of values over their errors."""
    every = errors if kind == "density" else np.concatenate([errors, errors])
    return np.asarray(chance.covariance / (every * every[:, np.newaxis]))


def _judged(
    spectra: CrossSpectra, found: _Reading | None, where: int, lit: float,
    readable: float | None,
) -> Damping:  # fmt: skip
    """Return the damping, withheld where it is not resolved."""
    step, peak = spectra.bin_width, float(spectra.frequency[where])
    few = f"fewer than {LEAST_BINS} bins of {step:.3g} Hz are excited around this peak"
    unlike = few if found is None else _no_mode(found, peak, step, lit)
    if found is None or unlike:
        return Damping(None, None, None, None, None, None, unlike, readable, step)
    fit, errors = found.fit, NORMAL * np.sqrt(found.spread)
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
        height=None if coarse else _height(spectra, found),
    )


def _height(spectra: CrossSpectra, found: _Reading) -> float:
    """Return the height of the first mode's peak, all modes together, before smearing."""
    frequency, ratio = float(found.fit.frequency[0]), float(found.fit.ratio[0])
    near = frequency * (1.0 + ratio * np.linspace(-1.0, 1.0, 101))
    bins = spectra.frequency[found.shape.bins]
    values = modelled(found.shape.kind, near, bins, found.fit, spectra.sample_rate)
    return float(np.abs(values).max())


def _no_mode(found: _Reading, peak: float, step: float, lit: float) -> str | None:
    """Return why a fit says nothing of a mode at the peak, if it does not."""
    fit, scale = found.fit, found.scale
    frequency, ratio = float(fit.frequency[0]), float(fit.ratio[0])
    if not fit.converged or not 1e-5 < ratio < 0.5:
        return "the fit of the modes does not converge"
    if abs(frequency - peak) > max(2.0 * step, ratio * peak):
        return f"the mode that fits best lies at {frequency:.4g} Hz, beside the peak"
    if lit < FEW and 2.0 * ratio * frequency < WIDE * step:
        return (
            "the sweep passes the peak within a segment or two: take shorter segments, or "
            "overlap them more"
        )
    if fit.misfit > UNLIKE and scale > UNLIKELY:
        return f"the peak has not the shape of linear modes (misfit {fit.misfit:.0%})"
    return None


def _uncertain(ratio: float, half: float, step: float) -> str | None:
    """Return why the ratio of a mode is withheld although its frequency is known, if it is."""
    if half <= RESOLVED:
        return None
    about = f"zeta about {ratio:.2g} +- {half:.0%}, " if half < 0.5 else ""
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


def _maxima(data: _Data, usable: NDArray[np.bool_], place: float) -> IndexArray:
    """Return the peaks around a place that chance does not make."""
    low = max(0, int(place) - SEEN)
    part = slice(low, int(place) + SEEN + 1)
    height = np.where(usable[part], np.abs(data.values[part]), np.nan)
    share = np.full(height.shape, np.nan)
    np.divide(data.errors[part], height, out=share, where=height > 0.0)
    return low + resolved(local_maxima(height), height, share)


def _nearest_peak(maxima: IndexArray, power: FloatArray, place: float) -> int:
    """Return the peak nearest to a place, or the tallest bin there if there is none near."""
    near = maxima[np.abs(maxima - place) <= SEEN / 4]
    if near.size:
        return int(near[np.argmin(np.abs(near - place))])
    low = min(max(round(place) - 2, 1), power.size - 2)
    return low + int(np.argmax(power[low : low + 5]))


def _bins(
    usable: NDArray[np.bool_], maxima: IndexArray, peak: int, reach: float
) -> tuple[IndexArray, tuple[int, ...]]:
    """Return the bins around a peak, those of near neighbours included, and these."""
    others = maxima[(maxima != peak) & (np.abs(maxima - peak) <= 2.0 * reach)]
    beyond = max(reach / 2.0, REACH_BINS / 2.0)
    low = min([peak - reach, *(others - beyond)])
    high = max([peak + reach, *(others + beyond)])
    number = np.arange(usable.size)
    bins = number[(number >= low) & (number <= high) & (np.abs(number - peak) <= 2 * FURTHEST)]
    broken = bins[~usable[bins]]
    if (broken < peak).any():
        bins = bins[bins > broken[broken < peak].max()]
    if (broken > peak).any():
        bins = bins[bins < broken[broken > peak].min()]
    inside = others[np.isin(others, bins)]
    nearest = inside[np.argsort(np.abs(inside - peak), kind="stable")][: MOST_MODES - 1]
    return bins, tuple(int(k) for k in nearest)


def _clearance(starts: tuple[int, ...]) -> float:
    """Return how many bins around the first of some peaks are nearer to it than to others."""
    nearest = min((abs(other - starts[0]) for other in starts[1:]), default=2 * FURTHEST)
    return max(nearest / 2.0, LEAST_BINS / 2.0)


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
