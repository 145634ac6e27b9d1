"""Excitations: harmonic, swept and stepped sines at every instant; random to a density.

The sines are `Signal`s, functions of time [s] that give the input in its SI unit; what
`simulate` makes of one has no error between the samples. Random excitations are samples.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

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


@final
@dataclass(frozen=True, slots=True)
class NoiseProfile:
    """A power spectral density, straight between its breakpoints on double-log paper.

    Attributes
    ----------
    frequency : tuple of float
        Frequencies of the breakpoints, rising; the density is 0 outside them [Hz].
    density : tuple of float
        Density at each [(m/s^2)^2/Hz or N^2/Hz].
    """

    frequency: tuple[float, ...]
    density: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.frequency) != len(self.density) or len(self.frequency) < 2:
            raise ValueError("a profile needs as many densities as frequencies, at least two")
        if not all(a < b for a, b in zip(self.frequency, self.frequency[1:], strict=False)):
            raise ValueError("the frequencies of a profile must rise")
        for frequency, density in zip(self.frequency, self.density, strict=True):
            checks.positive("frequency", frequency, "Hz")
            checks.positive("density", density, "(m/s^2)^2/Hz")

    def at(self, frequency: FloatArray) -> FloatArray:
        """Return the density at these frequencies [Hz], an array [(m/s^2)^2/Hz]."""
        inside = (frequency >= self.frequency[0]) & (frequency <= self.frequency[-1])
        safe = np.where(inside, frequency, self.frequency[0])
        density = np.exp(np.interp(np.log(safe), np.log(self.frequency), np.log(self.density)))
        result: FloatArray = np.where(inside, density, 0.0)
        return result

    @property
    def rms(self) -> float:
        """Root mean square of the whole profile, by its exact integral [m/s^2 or N]."""
        total = 0.0
        f, d = np.array(self.frequency), np.array(self.density)
        slopes = np.diff(np.log(d)) / np.diff(np.log(f))
        for low, high, density, slope in zip(f[:-1], f[1:], d[:-1], slopes, strict=True):
            ratio, power = high / low, slope + 1.0
            if abs(power) < 1e-9:
                total += density * low * np.log(ratio)
            else:
                total += density * low * (ratio**power - 1.0) / power
        return float(np.sqrt(total))


def flat_profile(low: float, high: float, density: float) -> NoiseProfile:
    """Return the profile of band-limited white noise.

    Parameters
    ----------
    low, high : float
        Limits of the band [Hz].
    density : float
        Density inside [(m/s^2)^2/Hz or N^2/Hz].
    """
    return NoiseProfile((low, high), (density, density))


def random_noise(
    profile: NoiseProfile, duration: float, sample_rate: float, generator: np.random.Generator
) -> FloatArray:
    """Return Gaussian noise of a profile.

    Parameters
    ----------
    profile : NoiseProfile
        Its density; what lies above half the sample rate is left out.
    duration : float
        Length; the noise repeats after it [s].
    sample_rate : float
        Samples per second [Hz].
    generator : numpy.random.Generator
        Where the randomness comes from.

    Returns
    -------
    (n,) array
        Samples from time 0 up to `duration`, the last one left out [m/s^2 or N].
    """
    n, frequency = _lines(duration, sample_rate)
    drawn = generator.standard_normal((2, frequency.size))
    spectrum = (drawn[0] + 1j * drawn[1]) * np.sqrt(0.5)
    return _from_lines(spectrum, profile, frequency, n, sample_rate)


def multisine(
    profile: NoiseProfile,
    period: float,
    sample_rate: float,
    generator: np.random.Generator,
    *,
    periods: int = 1,
    excited: NDArray[np.bool_] | None = None,
) -> FloatArray:
    """Return sines on lines of a profile, with random phases and amplitudes that are not.

    Its density is exactly that of the profile, in every period: on its own lines, or, where
    some are left out, spread over as many as there would be.

    Parameters
    ----------
    profile : NoiseProfile
        Its density.
    period : float
        Time after which it repeats; one over it is the distance of its lines [s].
    sample_rate : float
        Samples per second [Hz].
    generator : numpy.random.Generator
        Where the phases come from.
    periods : int
        How many periods to return.
    excited : (n_lines,) array, optional
        Which multiples of one over the period, from the first, are excited; by default all [-].

    Returns
    -------
    (n,) array
        Samples [m/s^2 or N].
    """
    n, frequency = _lines(period, sample_rate)
    spectrum = np.exp(2j * np.pi * generator.random(frequency.size))
    if excited is not None:
        inside = profile.at(frequency) > 0.0
        excited_lines = inside & excited[: frequency.size]
        spectrum *= np.where(
            excited_lines, np.sqrt(inside.sum() / max(excited_lines.sum(), 1)), 0.0
        )
    one = _from_lines(spectrum, profile, frequency, n, sample_rate)
    return np.tile(one, periods)


def faded(samples: FloatArray, sample_rate: float, ramp: float) -> FloatArray:
    """Return samples led up from 0 and down to 0 by half a cosine at both ends.

    Parameters
    ----------
    samples : (n,) array
        Any signal [any unit].
    sample_rate : float
        Samples per second [Hz].
    ramp : float
        Length of each ramp [s].
    """
    n = min(round(ramp * sample_rate), samples.size // 2)
    window = np.ones(samples.size)
    rise = 0.5 - 0.5 * np.cos(np.pi * (np.arange(n) + 0.5) / max(n, 1))
    window[:n], window[window.size - n :] = rise, rise[::-1]
    return samples * window


def _lines(duration: float, sample_rate: float) -> tuple[int, FloatArray]:
    """Return number of samples, and frequencies of the lines between 0 and half the rate.

    Raises
    ------
    ValueError
        If there are fewer than four samples.
    """
    checks.positive("duration", duration, "s")
    checks.positive("sample_rate", sample_rate, "Hz")
    n = round(duration * sample_rate)
    if n < 4:
        raise ValueError(f"a duration of {duration:g} s holds only {n} samples")
    return n, np.arange(1, (n + 1) // 2) * sample_rate / n


def _from_lines(
    spectrum: FloatArray | np.ndarray[tuple[int, ...], np.dtype[np.complex128]],
    profile: NoiseProfile,
    frequency: FloatArray,
    n: int,
    sample_rate: float,
) -> FloatArray:
    """Return the signal whose lines have a mean square of 1 times that of the profile."""
    amplitude = np.sqrt(2.0 * profile.at(frequency) * sample_rate / n)
    full = np.zeros(n // 2 + 1, dtype=complex)
    full[1 : frequency.size + 1] = 0.5 * n * amplitude * spectrum
    return np.fft.irfft(full, n)
