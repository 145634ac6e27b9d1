"""Rainflow counting of cycles, compiled, one turning point after the other."""

import numba
import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray

STACK = 2048
"""Turning points that wait for their partner; they are nested, so that few ever do."""

jit = numba.njit(cache=True, nogil=True)


@jit
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


@jit
def count_cycles(signal: FloatArray, found: FloatArray) -> int:
    """Fill `found` (n, 2) with range and count of every cycle; return how many there are."""
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
            found[n_found] = closed
            n_found, count = n_found + 1, left
            left = take_closed(stack, count, closed)
    for k in range(1, count):
        found[n_found, 0], found[n_found, 1] = abs(stack[k] - stack[k - 1]), 0.5
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
    found = np.empty((distinct.size + 1, 2))
    n_found = count_cycles(distinct, found)
    return found[:n_found, 0].copy(), found[:n_found, 1].copy()


@jit
def follow_damage(  # noqa: PLR0917  (compiled functions have no keyword-only arguments)
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


@jit
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
