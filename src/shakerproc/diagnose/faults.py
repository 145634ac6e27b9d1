"""Measurement faults: seen in the raw samples, or guessed here and judged with the physics."""

from dataclasses import dataclass

import numpy as np
from scipy.fft import next_fast_len, rfft, rfftfreq

from shakerproc.data import FloatArray

MAINS = (50.0, 60.0)


@dataclass(frozen=True, slots=True)
class SensorGuess:
    """What one response sensor may do besides measuring, against the input."""

    polarity: float
    gain: float
    delay: float


def clipped(samples: FloatArray) -> tuple[FloatArray, float] | None:
    """Return which samples stand at a limit and the limit, or None where there is none.

    A limit is a largest or smallest value that is repeated: at least eight samples, and some of
    them side by side, within 1e-6 of the range. Noise never repeats its extremes.
    """
    top, low = float(np.max(samples)), float(np.min(samples))
    near = 1e-6 * (top - low)
    if near == 0.0:
        return None
    masks = [samples >= top - near, samples <= low + near]
    hit = np.zeros(samples.size, dtype=bool)
    for mask in masks:
        runs = np.sum(mask[1:] & mask[:-1])
        if np.sum(mask) >= 8 and runs >= 2:
            hit |= mask
    return (hit, max(abs(top), abs(low))) if np.any(hit) else None


def sensor_guess(
    controls: list[FloatArray], responses: list[FloatArray], sample_rate: float,
    omega: float, zeta: float,
) -> SensorGuess | None:  # fmt: skip
    """Return gain, sign and delay of a response against the base, for one mass on a spring.

    The equation of motion, x'' (w² - s² + i c s) = g (w² + i c s) y'' exp(-ist), is solved for
    w², c and both g terms by least squares at every delay t of a grid; what is left decides.
    """
    size = _stretch(min(x.size for x in responses))
    window = np.hanning(size)
    freq = rfftfreq(size, 1.0 / sample_rate)
    xx, yy, xy = np.zeros(freq.size), np.zeros(freq.size), np.zeros(freq.size, complex)
    for y, x in zip(controls, responses, strict=True):
        scale = np.mean(x**2)
        for start in range(0, x.size - size, size // 2):
            fx, fy = (
                rfft(x[start : start + size] * window),
                rfft(y[start : start + size] * window),
            )
            xx += np.abs(fx) ** 2 / scale
            yy += np.abs(fy) ** 2 / scale
            xy += fx * np.conj(fy) / scale
    h = xy / np.maximum(yy, 1e-30)
    coherence = np.abs(xy) ** 2 / np.maximum(xx * yy, 1e-60)
    inside = (
        (freq > min(4.0, 0.1 * omega / (2.0 * np.pi)))
        & (yy > 1e-3 * np.max(yy))
        & (coherence > 0.2)
    )
    inside &= freq < 6.0 * omega / (2.0 * np.pi)
    if np.sum(inside) < 12:
        return None
    s, h = 2.0 * np.pi * freq[inside] / omega, h[inside]
    weight = np.sqrt(
        np.maximum(coherence[inside], 0.0) / np.maximum(1.0 - coherence[inside], 1e-3)
    )
    weight = weight / np.maximum(np.abs(h), 0.05) / np.maximum(1.0, s**2)
    best: tuple[float, FloatArray, float] | None = None
    coarse = np.concatenate([np.arange(-2e-3, 2.2e-2, 0.25 / sample_rate), [0.0]])
    for stage in range(2):
        grid = coarse
        if stage and best is not None:
            grid = best[2] + np.linspace(-0.3, 0.3, 61) / sample_rate
        for delay in grid:
            turned = np.exp(-1j * s * omega * delay)
            columns = np.stack([h, 1j * s * h, -turned, -1j * s * turned])
            right = s**2 * h
            a = np.concatenate([(columns * weight).real, (columns * weight).imag], axis=1).T
            b = np.concatenate([(right * weight).real, (right * weight).imag])
            solved, *_ = np.linalg.lstsq(a, b, rcond=None)
            left = float(np.sum((a @ solved - b) ** 2))
            plausible = 0.5 < solved[0] < 2.0
            if plausible and (best is None or left < best[0]):
                best = (left, solved, float(delay))
    if best is None:
        return None
    gain = float(best[1][2] / best[1][0])
    return SensorGuess(float(np.sign(gain)), abs(gain), best[2])


def _stretch(shortest: int) -> int:
    """Return the samples of a spectrum, such that the shortest test holds several."""
    return int(min(4096, 2 ** np.floor(np.log2(max(shortest / 4, 64)))))


def hum_lines(residual: FloatArray, sample_rate: float) -> tuple[float, float] | None:
    """Return the mains frequency [Hz] and its power over its surroundings, or None.

    Looks at exactly 50 and 60 Hz against what lies 0.4 to 4 Hz beside, and asks for 40 times
    the mean: by chance once in 10^17.
    """
    n = residual.size
    t = np.arange(n) / sample_rate
    window = np.hanning(n)
    length = next_fast_len(n, real=True)
    power = np.abs(rfft(residual * window, length)) ** 2
    frequency = rfftfreq(length, 1.0 / sample_rate)
    best: tuple[float, float] | None = None
    for mains in MAINS:
        line = abs(np.sum(residual * window * np.exp(-2j * np.pi * mains * t))) ** 2
        off = np.abs(frequency - mains)
        side = power[(off > 0.4) & (off < 4.0)]
        ratio = line / max(float(np.mean(side)), 1e-300)
        if ratio > 40.0 and (best is None or ratio > best[1]):
            best = (mains, float(ratio))
    return best
