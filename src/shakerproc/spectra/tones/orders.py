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
from shakerproc.spectra.tones.tachometer import Pulses, numbered, rising_edges

LEAST_PULSES: Final = 4
"""Fewest pulses that a cubic spline of the angle takes [-]."""


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
    found = np.linalg.lstsq((basis * weight).T, (samples * weight).T, rcond=None)[0]
    n = orders.size
    return np.asarray(found[1 : n + 1].T + 1j * found[n + 1 :].T)
