"""A structure of two modes struck by half-sine pulses, solved in closed form."""

from collections.abc import Sequence

import numpy as np

RATE = 2048.0
MASS = 2.0
MODES = ((62.0, 0.008, 1.0, 0.8), (143.0, 0.015, 0.7, -0.9))
"""Natural frequency [Hz], damping ratio, shape at hammer and first sensor, at the second."""

PULSE = 0.004
"""Length of a half-sine [s]."""


def accelerance(frequency, sensor):
    """Acceleration of a sensor over the force [1/kg], in closed form."""
    s = 2j * np.pi * frequency
    total = np.zeros(frequency.size, dtype=complex)
    for natural, zeta, at_hammer, second in MODES:
        omega = 2.0 * np.pi * natural
        shape = at_hammer if sensor == 0 else second
        total += s**2 * at_hammer * shape / (s**2 + 2.0 * zeta * omega * s + omega**2)
    return total / MASS


def struck(blows: Sequence[tuple[float, float]], duration: float, noise=(0.0, 0.0), seed=1):
    """Force [N] and accelerations [m/s²] of a structure that is struck.

    Parameters
    ----------
    blows : sequence of (float, float)
        Start [s] and largest force [N] of each half-sine.
    duration : float
        Of the recording [s].
    noise : (float, float)
        Standard deviation on the force [N] and on the accelerations [m/s²].

    Returns
    -------
    (3, n) array
        The force's spectrum is that of the half-sines in closed form, cut off at half the
        sample rate; the time is doubled, so that nothing runs round its end.
    """
    n = round(duration * RATE)
    frequency = np.fft.rfftfreq(2 * n, 1.0 / RATE)
    spectrum = np.zeros(frequency.size, dtype=complex)
    for start, peak in blows:
        spectrum += peak * half_sine(frequency, start)
    rows = [spectrum, *(spectrum * accelerance(frequency, sensor) for sensor in (0, 1))]
    samples = np.fft.irfft(np.array(rows) * RATE, 2 * n)[:, :n]
    rng = np.random.default_rng(seed)
    samples[0] += noise[0] * rng.standard_normal(n)
    samples[1:] += noise[1] * rng.standard_normal((2, n))
    return samples


def half_sine(frequency, start):
    """Fourier transform of a half-sine pulse of height 1 [s], low-passed as recorders do."""
    centre = start + 0.5 * PULSE
    x = 2.0 * frequency * PULSE
    near = np.isclose(x, 1.0)
    ratio = np.cos(0.5 * np.pi * x) / np.where(near, 1.0, 1.0 - x**2)
    shape = np.where(near, np.pi / 4.0, ratio)
    low_pass = 1.0 / (1.0 + (frequency / (0.35 * RATE)) ** 16)
    return 2.0 * PULSE / np.pi * shape * np.exp(-2j * np.pi * frequency * centre) * low_pass
