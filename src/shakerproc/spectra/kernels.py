"""Inner loops of spectra, filters, tracking, oscillators and rainflow, compiled once."""

from typing import TypeAlias

import numba
import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray

IndexArray: TypeAlias = NDArray[np.int64]

jit = numba.njit(cache=True, fastmath={"contract", "reassoc", "nsz", "arcp"}, nogil=True)
# not "nnan" and "ninf": a NaN in the samples must come out as a NaN


@jit
def window_segments(
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
def demodulate(
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


exact_jit = numba.njit(cache=True, nogil=True)
# sums in their order: damage is compared to the last digits


@exact_jit
def follow_oscillators(
    samples: FloatArray,
    steps: FloatArray,
    substeps: NDArray[np.int64],
    damping: float,
    states: FloatArray,
    extremes: FloatArray,
) -> None:
    """Carry oscillators on over a block; widen their extremes.

    `states` (n_channels, n_frequencies, 3) holds displacement, velocity and the last input,
    `extremes` (n_channels, n_frequencies, 3, 2) least and largest displacement, velocity and
    absolute acceleration.
    """
    n_channels, n_samples = samples.shape
    for channel in range(n_channels):
        for j in range(substeps.size):
            a, b, c, d = steps[j, 0, 0], steps[j, 0, 1], steps[j, 1, 0], steps[j, 1, 1]
            p, q, r, s = steps[j, 0, 2], steps[j, 0, 3], steps[j, 1, 2], steps[j, 1, 3]
            y, v, last = states[channel, j, 0], states[channel, j, 1], states[channel, j, 2]
            limits = extremes[channel, j]
            for k in range(n_samples):
                rise = (samples[channel, k] - last) / substeps[j]
                for _ in range(substeps[j]):
                    following = last + rise
                    ahead = a * y + b * v + p * last + q * following
                    v = c * y + d * v + r * last + s * following
                    y, last = ahead, following
                    acceleration = -y - 2.0 * damping * v
                    limits[0, 0] = min(limits[0, 0], y)
                    limits[0, 1] = max(limits[0, 1], y)
                    limits[1, 0] = min(limits[1, 0], v)
                    limits[1, 1] = max(limits[1, 1], v)
                    limits[2, 0] = min(limits[2, 0], acceleration)
                    limits[2, 1] = max(limits[2, 1], acceleration)
                last = samples[channel, k]
            states[channel, j, 0], states[channel, j, 1], states[channel, j, 2] = y, v, last


STACK = 2048
"""Turning points that wait for their partner; they are nested, so that few ever do."""


@exact_jit
def take_closed(stack: FloatArray, count: int, closed: FloatArray) -> int:
    """Take one closed range off a stack of turning points (ASTM E1049-85, 5.4.4).

    `closed` becomes the range and how many cycles it is: 0 if none is closed, a half where it
    holds the first point, else 1. Returns how many points are left.
    """
    closed[1] = 0.0
    if count < 3:
        return count
    newest = abs(stack[count - 1] - stack[count - 2])
    before = abs(stack[count - 2] - stack[count - 3])
    full = count == stack.size
    if newest < before and not full:
        return count
    if count == 3 or full:
        closed[0], closed[1] = abs(stack[1] - stack[0]), 0.5
        for k in range(1, count):
            stack[k - 1] = stack[k]
        return count - 1
    closed[0], closed[1] = before, 1.0
    stack[count - 3] = stack[count - 1]
    return count - 2


@exact_jit
def count_cycles(signal: FloatArray, cycles: FloatArray) -> int:
    """Fill `cycles` (n, 2) with range and count of every cycle; return how many there are."""
    stack, closed = np.empty(STACK), np.zeros(2)
    count = n_found = 0
    for k in range(signal.size):
        inner = 0 < k < signal.size - 1
        if inner and (signal[k] - signal[k - 1]) * (signal[k + 1] - signal[k]) >= 0.0:
            continue
        stack[count] = signal[k]
        count += 1
        left = take_closed(stack, count, closed)
        while left < count:
            cycles[n_found] = closed
            n_found, count = n_found + 1, left
            left = take_closed(stack, count, closed)
    for k in range(1, count):
        cycles[n_found, 0], cycles[n_found, 1] = abs(stack[k] - stack[k - 1]), 0.5
        n_found += 1
    return n_found


def rainflow(signal: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the ranges of the cycles of a signal and how often each occurs.

    Parameters
    ----------
    signal : (n_samples,) array
        Samples [unit]; of several equal ones in a row, one counts.

    Returns
    -------
    ranges, counts : (n_cycles,) arrays
        Largest less least of each cycle [unit], and a half or one.

    References
    ----------
    .. [1] ASTM E1049-85, Standard practices for cycle counting in fatigue analysis, 5.4.4.
    """
    differs = np.diff(signal) != 0.0
    distinct = np.concatenate([signal[:1], signal[1:][differs]]).astype(np.float64)
    cycles = np.empty((distinct.size + 1, 2))
    n_found = count_cycles(distinct, cycles)
    return cycles[:n_found, 0].copy(), cycles[:n_found, 1].copy()


@exact_jit
def follow_damage(
    samples: FloatArray,
    steps: FloatArray,
    substeps: NDArray[np.int64],
    damping: float,
    exponent: float,
    states: FloatArray,
    stacks: FloatArray,
    sums: FloatArray,
) -> None:
    """Carry oscillators on over a block of one channel; add up squares and damage.

    `states` (n_frequencies, 6): displacement, velocity, last input, last displacement that
    differed, direction since, turning points that wait; `stacks` (n_frequencies, STACK) those;
    `sums` (n_frequencies, 3): mean squares of absolute acceleration and displacement times the
    number of samples, and the sum of amplitudes of displacement to the exponent.
    """
    closed = np.zeros(2)
    for j in range(substeps.size):
        a, b, c, d = steps[j, 0, 0], steps[j, 0, 1], steps[j, 1, 0], steps[j, 1, 1]
        p, q, r, s = steps[j, 0, 2], steps[j, 0, 3], steps[j, 1, 2], steps[j, 1, 3]
        y, v, last, before, rising = states[j, :5]
        count, stack = int(states[j, 5]), stacks[j]
        for k in range(samples.size):
            slope = (samples[k] - last) / substeps[j]
            for _ in range(substeps[j]):
                following = last + slope
                ahead = a * y + b * v + p * last + q * following
                v = c * y + d * v + r * last + s * following
                y, last = ahead, following
                acceleration = y + 2.0 * damping * v
                sums[j, 0] += acceleration * acceleration / substeps[j]
                sums[j, 1] += y * y / substeps[j]
                if y == before:
                    continue
                direction = 1.0 if y > before else -1.0
                if direction != rising:  # the last value was a turning point, or the first
                    stack[count] = before
                    count += 1
                    left = take_closed(stack, count, closed)
                    while left < count:
                        sums[j, 2] += closed[1] * (0.5 * closed[0]) ** exponent
                        count = left
                        left = take_closed(stack, count, closed)
                before, rising = y, direction
            last = samples[k]
        states[j, 0], states[j, 1], states[j, 2] = y, v, last
        states[j, 3], states[j, 4], states[j, 5] = before, rising, count


@exact_jit
def finish_damage(
    exponent: float, states: FloatArray, stacks: FloatArray, sums: FloatArray
) -> None:
    """Add the half cycles that are left when the record ends."""
    for j in range(len(sums)):
        count = int(states[j, 5])
        stacks[j, count] = states[j, 3]
        for k in range(1, count + 1):
            half = 0.5 * abs(stacks[j, k] - stacks[j, k - 1])
            sums[j, 2] += 0.5 * half**exponent
