"""Orders of a rotating machine: speed from tachometer pulses, amplitudes by least squares."""

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

LEAST_PULSES: Final = 4
"""Fewest pulses that a cubic spline of the angle takes [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Rotation:
    """Angle of a shaft against time.

    Attributes
    ----------
    times : (n_pulses,) array
        When each pulse begins [s].
    revolutions : float
        From the first pulse to the last [-].
    angle, time : callable
        Revolutions since the first pulse at some times, and the inverse.
    """

    times: FloatArray
    revolutions: float
    angle: Callable[[FloatArray], FloatArray]
    time: Callable[[FloatArray], FloatArray]


def rotation(
    tachometer: FloatArray, sample_rate: float, pulses_per_revolution: int
) -> Rotation:
    """Return the angle of a shaft from the rising edges of its tachometer.

    An edge is where a straight line between two samples crosses the middle between the least
    and the largest sample.

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
        If there are fewer than four pulses.
    """
    checks.positive("sample_rate", sample_rate, "Hz")
    low, high = float(tachometer.min()), float(tachometer.max())
    middle, margin = 0.5 * (low + high), HYSTERESIS * (high - low)
    state = np.where(tachometer > middle + margin, 1, 0)
    state[tachometer < middle - margin] = -1
    told = np.flatnonzero(state)  # samples that are clearly above or below
    rising = np.flatnonzero((state[told[:-1]] < 0) & (state[told[1:]] > 0))
    if rising.size < LEAST_PULSES:
        raise SpectrumError(
            f"{rising.size} pulse{'s' * (rising.size != 1)} between {low:g} and {high:g}, "
            f"where {LEAST_PULSES} or more are needed"
        )
    below = tachometer <= middle
    before = np.maximum.accumulate(np.where(below, np.arange(below.size), 0))[told[rising + 1]]
    a, b = tachometer[before], tachometer[before + 1]
    times = (before + (middle - a) / (b - a)) / sample_rate
    return _smoothed(times, sample_rate, pulses_per_revolution)


def _smoothed(times: FloatArray, sample_rate: float, pulses_per_revolution: int) -> Rotation:
    """Return cubic splines that pass the edges as closely as sampling places them.

    An edge between two samples lies anywhere between them: its standard deviation is that of a
    uniform law, and the splines are the smoothest whose residuals are as large (Reinsch).
    """
    turned = np.arange(times.size) / pulses_per_revolution
    weight = np.full(times.size, np.sqrt(12.0) * sample_rate)  # one over the deviation
    speed = np.gradient(turned, times)
    spline = partial(scipy.interpolate.UnivariateSpline, s=times.size)
    return Rotation(
        times=times,
        revolutions=float(turned[-1]),
        angle=spline(times, turned, w=weight / speed),
        time=spline(turned, times, w=weight),
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
