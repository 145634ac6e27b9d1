"""Orders of a rotating machine: speed from a tachometer, amplitudes by least squares."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc import checks
from shakerproc.data import ComplexArray, FloatArray
from shakerproc.errors import SpectrumError

HYSTERESIS: Final = 0.1
"""How far beside its trigger level, the middle of its range, a tachometer must be before the
next pulse counts, over that range [-]: noise of an rms up to 2.5 % of the range (four standard
deviations) makes no pulse of its own, and a pulse of 60 % of the range still counts."""

OUTLIERS: Final = 1e-3
"""Share of the samples at either end of the range that do not move the trigger level [-]: a
spike is shorter, the mark of a shaft that makes a pulse is wider than 0.36 degrees."""

NEIGHBOURS: Final = 3
"""Intervals on either side that one is compared with; their median passes one odd one [-]."""

IRREGULAR: Final = 1.5
"""Ratio to both sides from which an interval is not one of the shaft's own: halfway between one
pulse and two. A speed that rises or falls lies between its neighbours [-]."""

MOST_IRREGULAR: Final = 0.1
"""Share of pulses missing or extra up to which the angle is still known [-]."""

LEAST_PULSES: Final = 4
"""Fewest pulses that a cubic spline of the angle takes [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Pulses:
    """Pulses of a shaft, numbered by the angle at which they stand.

    Attributes
    ----------
    times : (n_pulses,) array
        When each begins [s].
    numbers : (n_pulses,) array
        Of each from the first one on; a missing one leaves its number out [-].
    missing : (n_missing,) array
        When the pulses before the places of missing ones begin [s].
    extra : (n_extra,) array
        When those began that were left out [s].
    """

    times: FloatArray
    numbers: FloatArray
    missing: FloatArray
    extra: FloatArray


def rising_edges(tachometer: FloatArray, sample_rate: float) -> tuple[FloatArray, str]:
    """Return the times [s] of the rising edges, and the range they were looked for in.

    An edge is where a straight line between two samples crosses the middle of the range, of
    which a few samples at either end do not count.

    Parameters
    ----------
    tachometer : (n_samples,) array
        Samples, in any unit.
    sample_rate : float
        Samples per second [Hz].
    """
    low = float(np.quantile(tachometer, OUTLIERS, method="higher"))
    high = float(np.quantile(tachometer, 1.0 - OUTLIERS, method="lower"))
    middle, margin = 0.5 * (low + high), HYSTERESIS * (high - low)
    state = np.where(tachometer > middle + margin, 1, 0)
    state[tachometer < middle - margin] = -1
    known = np.flatnonzero(state)  # samples that are clearly above or below
    rising = np.flatnonzero((state[known[:-1]] < 0) & (state[known[1:]] > 0))
    below = tachometer <= middle
    before = np.maximum.accumulate(np.where(below, np.arange(below.size), 0))[known[rising + 1]]
    a, b = tachometer[before], tachometer[before + 1]
    return (before + (middle - a) / (b - a)) / sample_rate, f"between {low:g} and {high:g}"


def numbered(times: FloatArray) -> Pulses:
    """Return pulses with their numbers, those left out that are too many.

    Parameters
    ----------
    times : (n,) array
        When the edges rise [s].

    Raises
    ------
    SpectrumError
        If so many are missing or extra that the angle is not known.
    """
    kept = times
    extra: list[float] = []
    most = MOST_IRREGULAR * times.size
    while len(extra) <= most:
        longer, shorter = _neighbouring_intervals(kept)
        short = np.flatnonzero(IRREGULAR * np.diff(kept) < shorter)
        if not short.size:
            break
        odd = _extra(kept, int(short[0]), float(longer[short[0]]))
        extra.append(float(kept[odd]))
        kept = np.delete(kept, odd)
    interval = np.diff(kept)
    longer, _ = _neighbouring_intervals(kept)
    ratio = np.divide(interval, longer, out=np.ones_like(interval), where=longer > 0.0)
    steps = np.where(ratio > IRREGULAR, np.maximum(np.round(ratio), 2.0), 1.0)
    missing = kept[:-1][steps > 1.0]
    if missing.size + len(extra) > most:
        first = min([*missing, *extra])
        raise SpectrumError(
            f"{missing.size} gaps and {len(extra)} extra among {times.size} pulses, the first "
            f"at {first:.6g} s: they do not stand at equal angles"
        )
    numbers = np.concatenate([[0.0], np.cumsum(steps)])
    return Pulses(kept, numbers, missing, np.array(extra))


def _neighbouring_intervals(times: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the longer and the shorter of the usual intervals before and after each [s].

    The first and the last have one side only, and are not judged: 0 and infinity stand beside
    the other way round, so that neither is irregular.
    """
    interval = np.diff(times)
    n = interval.size
    padded = np.concatenate([
        np.full(NEIGHBOURS, np.nan),
        interval,
        np.full(NEIGHBOURS, np.nan),
    ])
    windows = np.lib.stride_tricks.sliding_window_view(padded, NEIGHBOURS)
    before, after = windows[:n], windows[NEIGHBOURS + 1 :]
    longer, shorter = np.full(n, np.inf), np.zeros(n)
    inner = slice(1, n - 1)
    sides = np.array([np.nanmedian(before[inner], axis=1), np.nanmedian(after[inner], axis=1)])
    longer[inner], shorter[inner] = sides.max(axis=0), sides.min(axis=0)
    return longer, shorter


def _extra(times: FloatArray, short: int, usual: float) -> int:
    """Return which end of a short interval is the extra pulse.

    It is the one without which the interval that remains is closest to the usual one.
    """
    ends = [end for end in (short, short + 1) if 0 < end < times.size - 1]
    return min(ends, key=lambda end: abs(times[end + 1] - times[end - 1] - usual))


@final
@dataclass(frozen=True, slots=True, eq=False)
class Rotation:
    """Angle of a shaft against time.

    Attributes
    ----------
    pulses : Pulses
        Those of the tachometer; none of one that measures speed or angle.
    revolutions : float
        From the first pulse or sample to the last [-].
    angle, time : callable
        Revolutions since the first pulse or sample at some times, and the inverse.
    """

    pulses: Pulses
    revolutions: float
    angle: Callable[[FloatArray], FloatArray]
    time: Callable[[FloatArray], FloatArray]


def rotation(
    tachometer: FloatArray, sample_rate: float, pulses_per_revolution: int
) -> Rotation:
    """Return the angle of a shaft from the rising edges of its tachometer.

    A pulse that is missing or extra, by the intervals beside it, is allowed for and told.

    Parameters
    ----------
    tachometer : (n_samples,) array
        Samples, in any unit.
    sample_rate : float
        Samples per second [Hz].
    pulses_per_revolution : int
        Pulses in one revolution, at equal angles.

    Raises
    ------
    SpectrumError
        If there are fewer than four pulses, or too many of them are missing or extra.
    """
    checks.positive("sample_rate", sample_rate, "Hz")
    times, where = rising_edges(tachometer, sample_rate)
    if times.size < LEAST_PULSES:
        raise SpectrumError(
            f"{times.size} pulse{'s' * (times.size != 1)} {where}, "
            f"where {LEAST_PULSES} or more are needed"
        )
    return _smoothed(numbered(times), sample_rate, pulses_per_revolution)


def _smoothed(pulses: Pulses, sample_rate: float, pulses_per_revolution: int) -> Rotation:
    """Return cubic splines that pass the edges as closely as sampling places them.

    An edge between two samples lies anywhere between them: its standard deviation is that of a
    uniform law, and the splines are the smoothest whose residuals are as large (Reinsch).
    """
    times, turned = pulses.times, pulses.numbers / pulses_per_revolution
    weight = np.full(times.size, np.sqrt(12.0) * sample_rate)  # one over the deviation
    speed = np.gradient(turned, times)
    spline = partial(scipy.interpolate.UnivariateSpline, s=times.size)
    return Rotation(
        pulses=pulses,
        revolutions=float(turned[-1]),
        angle=spline(times, turned, w=weight / speed),
        time=spline(turned, times, w=weight),
    )


def rotation_at_speed(speed: FloatArray, sample_rate: float) -> Rotation:
    r"""Return the angle of a shaft whose speed is measured.

    .. math:: \theta(t) = \int_0^t \omega \, dt

    by the trapezoidal rule.

    Parameters
    ----------
    speed : (n_samples,) array
        Speed of the shaft [rad/s].
    sample_rate : float
        Samples per second [Hz].

    Raises
    ------
    SpectrumError
        If the shaft stands still or turns back.
    """
    checks.positive("sample_rate", sample_rate, "Hz")
    steps = 0.5 * (speed[1:] + speed[:-1]) / sample_rate
    return rotation_at_angle(np.concatenate([[0.0], np.cumsum(steps)]), sample_rate)


def rotation_at_angle(angle: FloatArray, sample_rate: float) -> Rotation:
    """Return the rotation of a shaft whose angle is measured, turning either way.

    Parameters
    ----------
    angle : (n_samples,) array
        Angle of the shaft, not wrapped to one revolution [rad].
    sample_rate : float
        Samples per second [Hz].

    Raises
    ------
    SpectrumError
        If the shaft stands still or turns back.
    """
    turned = np.abs(angle - angle[0]) / (2.0 * np.pi)
    still = np.flatnonzero(np.diff(turned) <= 0.0)
    if still.size:
        raise SpectrumError(
            f"the shaft stands still or turns back at {still[0] / sample_rate:.6g} s of the run"
        )
    time, none = np.arange(angle.size) / sample_rate, np.empty(0)
    return Rotation(
        pulses=Pulses(none, none, none, none),
        revolutions=float(turned[-1]),
        angle=lambda at: np.interp(at, time, turned),
        time=lambda at: np.interp(at, turned, time),
    )


def order_amplitudes(
    samples: FloatArray, angle: FloatArray, orders: FloatArray
) -> ComplexArray:
    r"""Return the amplitudes of orders in one stretch of samples.

    All orders and an offset are fitted together, with Hann weights over the angle, so that
    neighbours do not leak into each other:

    .. math:: x(\theta) = x_0 + \sum_o \mathrm{Re}(A_o e^{2 \pi i o \theta})

    Parameters
    ----------
    samples : (n_channels, n_samples) array
        Values [unit of the channel].
    angle : (n_samples,) array
        Revolutions at each sample, rising [-].
    orders : (n_orders,) array
        Cycles in one revolution [-].

    Returns
    -------
    (n_channels, n_orders) array
        Complex amplitudes, phase against the cosine at angle 0 [unit of the channel].

    References
    ----------
    .. [1] J. R. Blough, "Development and analysis of time variant discrete Fourier transform
       order tracking", Mechanical Systems and Signal Processing 17, 1185-1199, 2003.
    """
    share = (angle - angle[0]) / (angle[-1] - angle[0])
    weight = np.sin(np.pi * share)  # its square is the Hann window
    turning = np.exp(2j * np.pi * orders[:, np.newaxis] * angle)
    basis = np.vstack([np.ones_like(angle), turning.real, -turning.imag])
    amplitudes = np.linalg.lstsq((basis * weight).T, (samples * weight).T, rcond=None)[0]
    n = orders.size
    return np.asarray(amplitudes[1 : n + 1].T + 1j * amplitudes[n + 1 :].T)
