"""Frequency, damping and amplitude of a stretch of a decay, each with its limits."""

from dataclasses import dataclass
from typing import final

from shakerproc.data import FloatArray


@final
@dataclass(frozen=True, slots=True)
class Reading:
    """Frequency and damping of a mode over a stretch of its decay; limits are those of 95 %.

    Attributes
    ----------
    time : float
        At which they hold, from the start of the decay [s].
    amplitude : float
        Of the motion then [unit of the channel].
    frequency : float
        Natural frequency, the distance of the pole from 0 [Hz].
    frequency_error : float
        Half the width of its interval [Hz].
    damping : float
        Ratio [-].
    damping_error : float
        Half the width of its interval [-].
    noise : float
        Rms of what the fit leaves, over the amplitude [-].
    """

    time: float
    amplitude: float
    frequency: float
    frequency_error: float
    damping: float
    damping_error: float
    noise: float


def reading_of(
    pole: complex, errors: tuple[float, float], time: float, amplitude: float, noise: float
) -> Reading:
    r"""Return the reading of a pole :math:`-\sigma + i \omega_d`.

    Parameters
    ----------
    pole : complex
        Real and imaginary part [rad/s].
    errors : (float, float)
        Half the widths of their intervals [rad/s].
    time, amplitude, noise : float
        As in `Reading` [s, unit of the motion].
    """
    tau = 6.283185307179586
    size = abs(pole)
    return Reading(
        time=time,
        amplitude=amplitude,
        frequency=size / tau,
        frequency_error=errors[1] / tau,
        damping=-pole.real / size,
        damping_error=errors[0] / size,
        noise=noise,
    )


def within_stretch(rate: float, bend: float) -> float:
    r"""Return the slope that a change within a stretch may add at its middle [rad/s].

    A parabola leaves the cubic part :math:`a_3 t^3`, which adds :math:`3/5\, a_3 T^2` to the
    slope of a stretch from -T to T. Where the slope changes as amplitude to the power n, and
    amplitude as :math:`e^{-\sigma t}`, that is :math:`n/5\, \sigma q T^2` with the square part
    q; n is taken for 2, which is that of a cubic spring.

    Parameters
    ----------
    rate : float
        Of the decay, :math:`\sigma` [1/s].
    bend : float
        Logarithm or phase that the square part makes at an end, :math:`q T^2` [rad].
    """
    return 0.4 * abs(rate * bend)


def weighted_middle(time: FloatArray, weights: FloatArray) -> float:
    """Return the mean of times with weights [s]."""
    return float(weights @ time / weights.sum())
