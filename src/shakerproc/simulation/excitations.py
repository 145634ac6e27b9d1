"""Excitations that are known at every instant: harmonic, swept and stepped sines.

Each function returns a `Signal`, a function of time [s] that gives the input in its SI unit;
what `simulate` makes of it has no error between the samples.
"""

import math
from collections.abc import Sequence

import numpy as np

from shakerproc import checks
from shakerproc.data import FloatArray
from shakerproc.simulation.pieces import Chirp, Signal


def rest() -> Signal:
    """Return an input that is 0: for free oscillation from a given start."""
    return np.zeros_like


def harmonic(frequency: float, amplitude: float, phase: float = 0.0) -> Signal:
    """Return a sine.

    Parameters
    ----------
    frequency : float
        Frequency [Hz].
    amplitude : float
        Amplitude, in the SI unit of the input [m/s^2 or N].
    phase : float
        Phase at time 0 [rad]; pi / 2 makes it a cosine.
    """
    checks.positive("frequency", frequency, "Hz")

    return Chirp(frequency, 0.0, amplitude, phase)


def linear_sweep(
    first: float, last: float, duration: float, amplitude: float, phase: float = 0.0
) -> Signal:
    r"""Return a sine whose frequency changes evenly in time.

    .. math:: A \sin\left(2 \pi \left(f_0 t + \frac{f_1 - f_0}{2 T} t^2\right) + \varphi\right)

    The phase is the integral of the frequency; it goes on in the same way beyond `duration`.
    The thesis' generator reaches its last frequency half-way: give half its duration here.

    Parameters
    ----------
    first, last : float
        Frequencies at time 0 and at `duration`; upwards or downwards [Hz].
    duration : float
        Time from one to the other [s].
    amplitude, phase : float
        Amplitude [m/s^2 or N], and phase at time 0 [rad].

    References
    ----------
    .. [1] A. H. Hauglid, "Nonlinear Mechanical Vibrations: The Effect of Gaps", NTNU, 2018,
       eq. 5.1 and appendix B, where t1 = tend / 2.
    """
    checks.positive("duration", duration, "s")
    checks.not_negative("first", first, "Hz")
    checks.not_negative("last", last, "Hz")
    return Chirp(first, (last - first) / duration, amplitude, phase)


def logarithmic_sweep(
    first: float, last: float, rate: float, amplitude: float, phase: float = 0.0
) -> Signal:
    r"""Return a sine whose frequency changes by so many octaves a minute.

    .. math:: A \sin\left(2 \pi f_0 \frac{2^{R t} - 1}{R \ln 2} + \varphi\right)

    Parameters
    ----------
    first, last : float
        Frequencies at the start and at the end, upwards or downwards [Hz].
    rate : float
        Octaves in a minute, above 0 whatever the direction [oct/min].
    amplitude, phase : float
        Amplitude [m/s^2 or N], and phase at time 0 [rad].

    See Also
    --------
    sweep_duration : how long it takes.
    """
    checks.positive("first", first, "Hz")
    checks.positive("last", last, "Hz")
    checks.positive("rate", rate, "oct/min")
    growth = math.copysign(rate / 60.0 * math.log(2.0), last - first)

    def signal(time: FloatArray) -> FloatArray:
        turns = first * np.expm1(growth * time) / growth
        result: FloatArray = amplitude * np.sin(2.0 * np.pi * turns + phase)
        return result

    return signal


def sweep_duration(first: float, last: float, rate: float) -> float:
    """Return how long a logarithmic sweep takes [s].

    Parameters
    ----------
    first, last : float
        Frequencies at both ends [Hz].
    rate : float
        Octaves in a minute [oct/min].
    """
    checks.positive("first", first, "Hz")
    checks.positive("last", last, "Hz")
    checks.positive("rate", rate, "oct/min")
    return abs(math.log2(last / first)) / rate * 60.0


def stepped_sine(frequencies: Sequence[float], cycles: int, amplitude: float) -> Signal:
    """Return sines one after the other, each of so many whole cycles, without a jump.

    After the last one the signal is 0.

    Parameters
    ----------
    frequencies : sequence of float
        Frequency of each step [Hz].
    cycles : int
        Cycles of each step.
    amplitude : float
        Amplitude [m/s^2 or N].

    Raises
    ------
    ValueError
        If there are no frequencies, or no cycles.
    """
    if not frequencies or cycles < 1:
        raise ValueError("a stepped sine needs frequencies, and at least one cycle of each")
    for frequency in frequencies:
        checks.positive("frequency", frequency, "Hz")
    hertz = np.asarray(frequencies, dtype=float)
    ends = np.cumsum(cycles / hertz)
    starts = np.concatenate(([0.0], ends[:-1]))

    def signal(time: FloatArray) -> FloatArray:
        step = np.minimum(np.searchsorted(ends, time, side="right"), hertz.size - 1)
        angle = 2.0 * np.pi * hertz[step] * (time - starts[step])
        result: FloatArray = np.where(time < ends[-1], amplitude * np.sin(angle), 0.0)
        return result

    return signal


def half_sine_shock(amplitude: float, width: float, delay: float = 0.0) -> Signal:
    """Return one half-sine pulse.

    Parameters
    ----------
    amplitude : float
        Peak [m/s^2 or N].
    width : float
        Length of the pulse [s].
    delay : float
        Time at which it begins [s].
    """
    checks.positive("width", width, "s")

    def signal(time: FloatArray) -> FloatArray:
        share = (time - delay) / width
        inside = (share >= 0.0) & (share <= 1.0)
        result: FloatArray = np.where(inside, amplitude * np.sin(np.pi * share), 0.0)
        return result

    return signal


def sum_of_signals(*signals: Signal) -> Signal:
    """Return the sum of signals."""

    def signal(time: FloatArray) -> FloatArray:
        total = np.zeros_like(time)
        for part in signals:
            total = total + part(time)
        return total

    return signal


def sampled(signal: Signal, duration: float, sample_rate: float) -> FloatArray:
    """Return samples of a signal from time 0 to `duration`, both ends included.

    Parameters
    ----------
    duration : float
        Length [s].
    sample_rate : float
        Samples per second [Hz].

    Returns
    -------
    (n,) array
        In the SI unit of the signal.
    """
    return signal(np.arange(round(duration * sample_rate) + 1) / sample_rate)
