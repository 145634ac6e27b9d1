"""The inner loops of spectra, notch filters and tracking, compiled once and kept on disk."""

from typing import TypeAlias

import numba
import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray

IndexArray: TypeAlias = NDArray[np.int64]

jit = numba.njit(cache=True, fastmath={"contract", "reassoc", "nsz", "arcp"}, nogil=True)
# not "nnan" and "ninf": a NaN in the samples must come out as a NaN


@jit
def window_segments(  # noqa: PLR0917  (compiled functions have no keyword-only arguments)
    samples: FloatArray,
    first: int,
    step: int,
    window: FloatArray,
    offset: FloatArray,
    segments: FloatArray,
) -> None:
    """Fill (n_segments, n_channels, n_fft) with windowed segments, `step` samples apart."""
    n_segments, n_channels, _ = segments.shape
    length = window.size
    for s in range(n_segments):
        start = first + s * step
        for channel in range(n_channels):
            source = samples[channel, start : start + length]
            target = segments[s, channel]
            shift = offset[channel]
            for k in range(length):
                target[k] = (source[k] - shift) * window[k]


@jit
def add_products(
    spectra: FloatArray,
    real: FloatArray,
    imaginary: FloatArray,
    powers: FloatArray,
    fourth: FloatArray,
) -> None:
    """Add conj(X_i) X_j of every segment and pair i < j to the real and imaginary sums.

    The squares of the magnitudes are added to `powers`, (n_channels, n_frequencies), and their
    fourth powers to `fourth`.

    `spectra` is (n_segments, n_channels, 2 n_frequencies), real and imaginary parts in turn;
    the sums are (n_inputs, n_channels, n_frequencies), for the first channels are the inputs.
    """
    n_inputs = real.shape[0]
    n_segments, n_channels, n_values = spectra.shape
    n_frequencies = n_values // 2
    for s in range(n_segments):
        for i in range(n_channels):
            for k in range(n_frequencies):
                power = spectra[s, i, 2 * k] ** 2 + spectra[s, i, 2 * k + 1] ** 2
                powers[i, k] += power
                fourth[i, k] += power * power
            if i >= n_inputs:
                continue
            for j in range(i + 1, n_channels):
                for k in range(n_frequencies):
                    a_real = spectra[s, i, 2 * k]
                    a_imaginary = spectra[s, i, 2 * k + 1]
                    b_real = spectra[s, j, 2 * k]
                    b_imaginary = spectra[s, j, 2 * k + 1]
                    real[i, j, k] += a_real * b_real + a_imaginary * b_imaginary
                    imaginary[i, j, k] += a_real * b_imaginary - a_imaginary * b_real


@jit
def filter_second_order(
    samples: FloatArray, numerator: FloatArray, denominator: FloatArray
) -> None:
    """Filter samples in place, as if their first value had been there for ever."""
    b_0, b_1, b_2 = numerator
    _, a_1, a_2 = denominator
    gain = (b_0 + b_1 + b_2) / (1.0 + a_1 + a_2)
    second = (b_2 - a_2 * gain) * samples[0]
    first = (b_1 - a_1 * gain) * samples[0] + second
    for k in range(samples.size):
        value = samples[k]
        result = b_0 * value + first
        first = b_1 * value - a_1 * result + second
        second = b_2 * value - a_2 * result
        samples[k] = result


@jit
def phase_of_track(
    knots: FloatArray,
    phase: FloatArray,
    omega: FloatArray,
    position: FloatArray,
    result: FloatArray,
) -> None:
    """Fill in the phase at rising positions from a cubic with given slopes at the knots."""
    knot = 0
    for k in range(position.size):
        while knot < knots.size - 2 and position[k] > knots[knot + 1]:
            knot += 1
        width = knots[knot + 1] - knots[knot]
        share = (position[k] - knots[knot]) / width
        rest = 1.0 - share
        result[k] = (
            phase[knot] * rest * rest * (1.0 + 2.0 * share)
            + phase[knot + 1] * share * share * (3.0 - 2.0 * share)
            + width * share * rest * (omega[knot] * rest - omega[knot + 1] * share)
        )


@jit
def weigh_by_phase(
    phase: FloatArray, centre: float, half: float, bell: FloatArray, weight: FloatArray
) -> float:
    """Fill in a window over the phase, times the phase that passes, and return its sum.

    `bell` holds the window from its middle to its end at equal steps.
    """
    total = 0.0
    scale = (bell.size - 1) / half
    weight[:] = 0.0
    for k in range(1, phase.size - 1):
        place = abs(phase[k] - centre) * scale
        if place < bell.size - 1:
            entry = int(place)
            value = bell[entry] + (place - entry) * (bell[entry + 1] - bell[entry])
            weight[k] = value * (phase[k + 1] - phase[k - 1])
            total += weight[k]
    return total


@jit
def fill_waves(
    cosine: FloatArray, sine: FloatArray, weight: FloatArray, waves: FloatArray
) -> None:
    """Fill (2 n_harmonics, n) with weighted cosines and negative sines of the multiples."""
    for k in range(weight.size):
        waves[0, k] = weight[k] * cosine[k]
        waves[1, k] = -weight[k] * sine[k]
    for row in range(2, waves.shape[0], 2):
        for k in range(weight.size):
            real, imaginary = waves[row - 2, k], waves[row - 1, k]
            waves[row, k] = real * cosine[k] + imaginary * sine[k]
            waves[row + 1, k] = imaginary * cosine[k] - real * sine[k]


@jit
def demodulate(  # noqa: PLR0917  (compiled functions have no keyword-only arguments)
    samples: FloatArray,
    limits: IndexArray,
    phase: FloatArray,
    cosine: FloatArray,
    sine: FloatArray,
    windows: FloatArray,
    bell: FloatArray,
    sums: FloatArray,
    power: FloatArray,
) -> None:
    """Fill (n_windows, n_channels, n_harmonics, 2) with amplitudes against a phase.

    Real and imaginary parts stand in turn. `limits` holds first and last sample of each
    window, `windows` the phase in its middle and the phase to its end.
    """
    n_parts = 2 * sums.shape[2]
    for w in range(sums.shape[0]):
        begin, end = limits[0, w], limits[1, w]
        weight = np.empty(end - begin)
        waves = np.empty((n_parts, end - begin))
        near = phase[begin:end]
        total = weigh_by_phase(near, windows[0, w], windows[1, w], bell, weight)
        if total <= 0.0:
            continue
        fill_waves(cosine[begin:end], sine[begin:end], weight, waves)
        for channel in range(samples.shape[0]):
            row = samples[channel, begin:end]
            square = 0.0
            for k in range(row.size):
                square += weight[k] * row[k] * row[k]
            power[w, channel] = square / total
            for part in range(n_parts):
                wave = waves[part]
                value = 0.0
                for k in range(row.size):
                    value += wave[k] * row[k]
                sums[w, channel, part // 2, part % 2] = 2.0 * value / total
