r"""A resonance that a sweep passes: lower, later and broader than steady.

Where the frequency of the excitation changes by :math:`\dot f`, a mode with the pole
:math:`p` answers a sine at :math:`f` not with :math:`1 / (i 2 \pi f - p)` but with

.. math:: E(f) = \int_0^\infty e^{(p - i 2 \pi f) s + i \pi \dot f s^2} ds

which is a complex error function. Damping, steady height and steady frequency are found by
fitting it to what was measured.
"""

from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc import checks
from shakerproc.data import ComplexArray, FloatArray
from shakerproc.spectra.peaks.damping import NORMAL, UNLIKE_SHARE
from shakerproc.spectra.tones.swept import Sweep

ENOUGH: Final = 0.95
"""Share of the steady resonance that a sweep should reach [-]."""

AROUND: Final = 3.0
"""Half-power widths to each side of a swept peak that are fitted."""

FEWEST: Final = 6
"""Points to each side of a swept peak that are fitted at least."""

UNSURE: Final = 0.5
"""Half-width of the interval of a damping ratio from which nothing is known of it [-]."""

RATIOS: Final = (1e-5, 0.5)
"""Damping ratios that the search does not pass [-]."""

IN_WINDOW: Final = np.linspace(-0.875, 0.875, 8)
"""Places in half a window, either way, over which the tracking's Hann window averages [-]."""

HANN: Final = (1.0 + np.cos(np.pi * IN_WINDOW)) / np.sum(1.0 + np.cos(np.pi * IN_WINDOW))
"""Weight of each of these places, their sum 1 [-]."""


@final
@dataclass(frozen=True, slots=True)
class SweptMode:
    """The mode behind a peak of a swept response.

    Attributes
    ----------
    frequency, ratio : float
        Natural frequency [Hz] and damping ratio [-].
    steady_frequency, steady_gain : float
        Where a sweep slow enough would have its peak [Hz], and how tall [-].
    rate : float
        How fast the frequency changed there [Hz/s].
    half : float
        Half-width of the 95 % interval of the damping ratio, as a share of it [-].
    """

    frequency: float
    ratio: float
    steady_frequency: float
    steady_gain: float
    rate: float
    half: float


def passing(frequency: FloatArray, natural: float, ratio: float, rate: float) -> ComplexArray:
    """Return how a mode of residue 1 answers a sine whose frequency changes [s].

    Parameters
    ----------
    frequency : array
        Where the sine is [Hz].
    natural, ratio : float
        Natural frequency [Hz] and damping ratio of the mode [-].
    rate : float
        How fast the frequency changes, negative downwards; 0 for steady [Hz/s].

    References
    ----------
    .. [1] F. M. Lewis, "Vibration during acceleration through a critical speed", Transactions
       of the ASME 54, 253-261, 1932.
    """
    omega = 2.0 * np.pi * natural
    pole = omega * complex(-ratio, np.sqrt(1.0 - ratio * ratio))
    decay = 2j * np.pi * np.asarray(frequency, dtype=np.float64) - pole
    return _answer(np.asarray(decay, dtype=np.complex128), rate)


def _answer(decay: ComplexArray, rate: float) -> ComplexArray:
    r"""Return :math:`\int_0^\infty e^{-d s + i \pi \dot f s^2} ds` for some decays d [s].

    Parameters
    ----------
    decay : array
        What each answer decays and turns with [1/s].
    rate : float
        How fast the frequency changes, negative downwards; 0 for steady [Hz/s].
    """
    if rate == 0.0:
        return np.asarray(1.0 / decay)
    root = np.sqrt(np.pi * abs(rate)) * np.exp(-0.25j * np.pi * np.sign(rate))
    with np.errstate(under="ignore"):
        shape = scipy.special.wofz(0.5j * decay / root)
    return np.asarray(0.5 * np.sqrt(np.pi) / root * shape)


def _tallest(rate: float, frequency: float, damping_ratio: float) -> tuple[float, float]:
    """Return share of the steady peak [-] and shift [Hz] of the peak under an upward sweep."""
    checks.positive("rate", rate, "Hz/s")
    checks.positive("frequency", frequency, "Hz")
    checks.positive("damping_ratio", damping_ratio, "-")
    width = damping_ratio * frequency
    kappa = rate / (2.0 * np.pi * width**2)
    # The peak lags by a time constant where the sweep is slow, by 2 / sqrt(kappa) where fast.
    late = (
        (min(3.0, 8.0 / np.sqrt(kappa)) + 2.0 / np.sqrt(kappa)) * rate / (2.0 * np.pi * width)
    )

    def height(shift: FloatArray | float) -> FloatArray:
        decay = 2.0 * np.pi * (width + 1j * np.asarray(shift))
        return np.abs(2.0 * np.pi * width * _answer(decay, rate))

    shifts = np.linspace(0.0, late, 400)
    start = int(np.argmax(height(shifts)))
    bounds = shifts[max(start - 1, 0)], shifts[min(start + 1, shifts.size - 1)]
    optimum = scipy.optimize.minimize_scalar(
        lambda shift: -float(height(shift)), bounds=bounds, method="bounded",
        options={"xatol": 1e-9 * width},
    )  # fmt: skip
    return float(-optimum.fun), float(optimum.x)


def swept_peak(rate: float, frequency: float, damping_ratio: float) -> float:
    r"""Return the peak that a sweep reaches, as a share of the steady resonance [-].

    .. math:: \max_\tau \left| \int_0^\infty e^{-s + i \kappa (\tau - s)^2 / 2} ds \right|,
              \qquad \kappa = \frac{\dot f}{2 \pi \zeta^2 f_n^2}

    the envelope of a lightly damped mode under a sine whose frequency passes through it; the
    integral is a complex error function. Upwards and downwards it is the same.

    Parameters
    ----------
    rate : float
        How fast the frequency changes where it passes the resonance [Hz/s].
    frequency : float
        Natural frequency [Hz].
    damping_ratio : float
        Of the mode [-].

    References
    ----------
    .. [1] F. M. Lewis, "Vibration during acceleration through a critical speed", Transactions
       of the ASME 54, 253-261, 1932.
    """
    return _tallest(rate, frequency, damping_ratio)[0]


def swept_shift(rate: float, frequency: float, damping_ratio: float) -> float:
    """Return how far a sweep moves the peak in its own direction [Hz].

    Parameters
    ----------
    rate : float
        How fast the frequency changes where it passes the resonance [Hz/s].
    frequency : float
        Natural frequency [Hz].
    damping_ratio : float
        Of the mode [-].
    """
    return _tallest(rate, frequency, damping_ratio)[1]


def fastest_rate(frequency: float, damping_ratio: float, share: float = ENOUGH) -> float:
    """Return the fastest sweep that reaches a share of the steady resonance [Hz/s].

    Parameters
    ----------
    frequency : float
        Natural frequency [Hz].
    damping_ratio : float
        Of the mode [-].
    share : float
        Of the steady peak, below 1 [-].
    """
    scale = (damping_ratio * frequency) ** 2
    root = scipy.optimize.brentq(
        lambda power: swept_peak(10.0**power * scale, frequency, damping_ratio) - share,
        -2.0,
        3.0,
        xtol=1e-6,
    )
    return float(10.0**root * scale)


def swept_mode(sweep: Sweep, channel: int) -> SweptMode | None:
    """Return the mode that a swept response passed at its tallest point.

    Parameters
    ----------
    sweep : Sweep
        Response to one sweep.
    channel : int
        Row of the response, from 0.

    Returns
    -------
    SweptMode or None
        None where no linear mode fits: a joint that jumps, a peak at the end of the sweep.
    """
    passage = _passage(sweep, channel)
    if passage is None:
        return None
    fit = _fitted(passage)
    residual, weights = passage.solved(fit.x)
    misfit = float(np.sqrt(np.mean(np.abs(residual) ** 2)) / passage.height)
    if fit.status <= 0 or fit.active_mask.any() or misfit > UNLIKE_SHARE:
        return None
    natural, ratio = (float(value) for value in np.exp(fit.x))
    half = _half_width(fit, residual.size)
    if half > UNSURE:
        return None
    near = natural * (1.0 + ratio * np.linspace(-2.0, 2.0, 401))
    mode = passing(near, natural, ratio, 0.0)
    steady = np.abs(np.column_stack([mode, passage.background(near)]) @ weights)
    top = int(np.argmax(steady))
    return SweptMode(natural, ratio, float(near[top]), float(steady[top]), passage.rate, half)


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Passage:
    """A swept response around its tallest point, and the response of one mode there.

    The logarithms of natural frequency and damping ratio are searched; residue and a straight
    background are solved for.

    Attributes
    ----------
    frequency : (n,) array
        In the middle of each window of the tracking [Hz].
    gain : (n,) complex array
        Fundamental over control there [-].
    seen : (n, n_places) array
        Frequencies within each window [Hz].
    rate : float
        How fast the frequency changes [Hz/s].
    peak, height : float
        Frequency of the tallest point [Hz], and how tall [-].
    ratio : float
        Damping ratio by the half-power width of the swept peak [-].
    """

    frequency: FloatArray
    gain: ComplexArray
    seen: FloatArray
    rate: float
    peak: float
    height: float
    ratio: float

    def solved(self, point: FloatArray) -> tuple[ComplexArray, ComplexArray]:
        """Return fit less gain, (n,), and the (3,) weights of mode, level and slope."""
        natural, ratio = (float(value) for value in np.exp(point))
        mode = passing(self.seen, natural, ratio, self.rate) @ HANN
        columns = np.column_stack([mode, self.background(self.frequency)])
        weights = np.asarray(np.linalg.lstsq(columns, self.gain, rcond=None)[0], np.complex128)
        return np.asarray(columns @ weights - self.gain), weights

    def residual(self, point: FloatArray) -> FloatArray:
        """Return fit less gain, (2 n,): real, then imaginary parts."""
        residuals = self.solved(point)[0]
        return np.concatenate([residuals.real, residuals.imag])

    def background(self, frequency: FloatArray) -> FloatArray:
        """Return level and slope of the modes far away, (n, 2) array [-]."""
        place = (frequency - self.peak) / np.ptp(self.frequency)
        return np.column_stack([np.ones(frequency.size), place])


def _passage(sweep: Sweep, channel: int) -> _Passage | None:
    """Return a swept response around its tallest point; None where that is at an end."""
    gain, frequency = sweep.gain[channel], sweep.frequency
    known = np.isfinite(gain) & (np.abs(gain) > 0.0)
    if known.sum() < 2 * FEWEST + 1:
        return None
    peak = int(np.argmax(np.where(known, np.abs(gain), 0.0)))
    low, high = _flanks(np.abs(gain), peak)
    reach = max(int(np.ceil(AROUND * max(high - low, 2))), FEWEST)
    part = np.arange(max(0, peak - reach), min(gain.size, peak + reach + 1))
    part = part[known[part]]
    if part[0] > peak - FEWEST or part[-1] < peak + FEWEST:
        return None
    course = np.diff(frequency[part])
    if not (course > 0.0).all() and not (course < 0.0).all():
        return None
    rate = float(np.polyfit(sweep.time[part], frequency[part], 1)[0])
    half = 0.5 * sweep.periods[part] / frequency[part]  # of each window [s]
    return _Passage(
        frequency=frequency[part],
        gain=gain[part],
        seen=frequency[part, np.newaxis] + rate * half[:, np.newaxis] * IN_WINDOW,
        rate=rate,
        peak=float(frequency[peak]),
        height=float(np.abs(gain[peak])),
        ratio=float(abs(frequency[high] - frequency[low]) / (2.0 * frequency[peak])),
    )


def _fitted(passage: _Passage) -> "scipy.optimize.OptimizeResult":
    """Return the least-squares fit of one mode, its point ln f [ln Hz] and ln zeta."""
    span = np.log(passage.frequency[[0, -1]])
    bounds = ([span.min(), np.log(RATIOS[0])], [span.max(), np.log(RATIOS[1])])
    start = np.log([passage.peak, np.clip(passage.ratio, 1e-3, 0.3)])
    tries = [start - np.array([0.0, less]) for less in (0.0, 1.0, 2.0)]  # a sweep broadens
    first = min(tries, key=lambda point: float(np.sum(passage.residual(point) ** 2)))
    return scipy.optimize.least_squares(
        passage.residual, first, bounds=bounds, x_scale=[max(passage.ratio, 1e-4), 1.0]
    )


def _half_width(fit: "scipy.optimize.OptimizeResult", n_points: int) -> float:
    """Return the half-width of the 95 % interval of ln zeta [-].

    Windows overlap by half: of their errors, two are worth one. The rate changes on the way
    through the peak: an error of first order in its width, which adds zeta.
    """
    slopes = np.asarray(fit.jac, dtype=np.float64)
    power = 2.0 * float(fit.cost) / max(1.0, n_points - 5.0)
    spread = power * float(np.linalg.pinv(slopes.T @ slopes)[1, 1])
    return NORMAL * float(np.sqrt(2.0 * spread)) + float(np.exp(fit.x[1]))


def _flanks(height: FloatArray, peak: int) -> tuple[int, int]:
    """Return the first points on both sides at which a peak has fallen to half its power."""
    fallen = np.flatnonzero(~(height > height[peak] / np.sqrt(2.0)))
    below, above = fallen[fallen < peak], fallen[fallen > peak]
    return (
        int(below[-1]) if below.size else 0,
        int(above[0]) if above.size else height.size - 1,
    )
