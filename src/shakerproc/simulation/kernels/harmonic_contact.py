r"""Piecewise-linear forces of a periodic motion, integrated exactly between the contacts.

On each stretch between two crossings of a breakpoint the force is :math:`s_j z + c_j`; its
Fourier coefficients are those of :math:`z` folded with those of the stretch: no sampling; the
derivative is the same fold, as the force is continuous at a crossing.
"""

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.models.compiled import compiled
from shakerproc.simulation.kernels.harmonic_fourier import (
    Harmonics,
    multiplication,
    real_of_complex,
    value,
)

Segments: TypeAlias = NDArray[np.int64]


@compiled
def segment_of(position: float, breakpoints: FloatArray) -> int:
    """Return in which stretch of the law a displacement lies."""
    segment = 0
    while segment < breakpoints.size and position > breakpoints[segment]:
        segment += 1
    return segment


@compiled
def _crossing(
    coefficients: ComplexArray, harmonics: Harmonics, level: float, low: float, high: float
) -> float:
    """Return the angle in (low, high) at which the motion crosses a level once."""
    start = value(coefficients, harmonics, low)[0] - level
    angle = 0.5 * (low + high)
    for _ in range(60):
        position, slope, _ = value(coefficients, harmonics, angle)
        if (position > level) == (start > 0.0):
            low = angle
        else:
            high = angle
        step = (position - level) / slope if slope != 0.0 else np.inf
        closer = angle - step
        if not low < closer < high:
            closer = 0.5 * (low + high)
        if abs(closer - angle) <= 4e-15:
            return closer
        angle = closer
    return angle


@compiled
def _turning(
    coefficients: ComplexArray, harmonics: Harmonics, low: float, high: float
) -> float:
    """Return the angle in (low, high) at which the velocity changes sign."""
    start = value(coefficients, harmonics, low)[1]
    angle = 0.5 * (low + high)
    for _ in range(60):
        _, slope, bend = value(coefficients, harmonics, angle)
        if (slope > 0.0) == (start > 0.0):
            low = angle
        else:
            high = angle
        closer = angle - slope / bend if bend != 0.0 else 0.5 * (low + high)
        if not low < closer < high:
            closer = 0.5 * (low + high)
        if abs(closer - angle) <= 1e-12:
            return closer
        angle = closer
    return angle


@compiled
def stretches(
    coefficients: ComplexArray,
    harmonics: Harmonics,
    samples: FloatArray,
    breakpoints: FloatArray,
) -> tuple[FloatArray, Segments]:
    """Return where a motion changes between the stretches of a piecewise-linear law.

    Parameters
    ----------
    coefficients : (n_harmonics,) array
        The motion.
    harmonics : (n_harmonics,) array
        Number of each harmonic.
    samples : (2, n_samples) array
        The motion and its derivative by the angle at equally spaced angles from 0.
    breakpoints : (n_breakpoints,) array
        Displacements at which the law changes, in rising order [m].

    Returns
    -------
    angles : (n,) array
        Angles in rising order within one period [rad].
    segments : (n + 1,) array
        Stretch before the first angle, and after each of them.
    """
    n_samples = samples.shape[1]
    step = 2.0 * np.pi / n_samples
    angles = np.empty(4 * n_samples * max(1, breakpoints.size))
    segments = np.empty(angles.size + 1, np.int64)
    segments[0] = segment_of(samples[0, 0], breakpoints)
    count = 0
    for i in range(n_samples):
        following = i + 1 if i + 1 < n_samples else 0
        position, end = samples[0, i], samples[0, following]
        slope, end_slope = samples[1, i], samples[1, following]
        turns = slope * end_slope < 0.0
        if not turns and segments[count] == segment_of(end, breakpoints):
            continue
        low, high = i * step, (i + 1) * step
        middle = high
        if turns:
            reach = 0.5 * step * max(abs(slope), abs(end_slope))
            floor, ceiling = min(position, end) - reach, max(position, end) + reach
            if segment_of(floor, breakpoints) != segment_of(ceiling, breakpoints):
                middle = _turning(coefficients, harmonics, low, high)
        if middle < high:
            extreme = value(coefficients, harmonics, middle)[0]
            count = _pass(
                coefficients,
                harmonics,
                breakpoints,
                (low, middle),
                extreme,
                (angles, segments),
                count,
            )
            low = middle
        count = _pass(
            coefficients, harmonics, breakpoints, (low, high), end, (angles, segments), count
        )
    return angles[:count], segments[: count + 1]


@compiled
def _pass(
    coefficients: ComplexArray,
    harmonics: Harmonics,
    breakpoints: FloatArray,
    span: tuple[float, float],
    end: float,
    found: tuple[FloatArray, Segments],
    count: int,
) -> int:
    """Note every crossing on a span on which the motion rises or falls throughout."""
    angles, segments = found
    target = segment_of(end, breakpoints)
    current = segments[count]
    while current != target:
        following = current + 1 if target > current else current - 1
        level = breakpoints[min(current, following)]
        angles[count] = _crossing(coefficients, harmonics, level, span[0], span[1])
        count += 1
        segments[count] = following
        current = following
    return count


@compiled
def window(angles: FloatArray, heights: FloatArray, highest: int) -> ComplexArray:
    r"""Return the Fourier coefficients of a periodic step function.

    Parameters
    ----------
    angles : (n,) array
        Where it steps, in rising order [rad].
    heights : (n + 1,) array
        Height before the first step and after each; the last equals the first.
    highest : int
        Highest coefficient.

    Returns
    -------
    (highest + 1,) array
        :math:`\frac{1}{2\pi} \int g(\tau) e^{-ip\tau} d\tau`.
    """
    result = np.zeros(highest + 1, np.complex128)
    mean = heights[0]
    for i in range(angles.size):
        jump = heights[i + 1] - heights[i]
        mean += jump * (2.0 * np.pi - angles[i]) / (2.0 * np.pi)
        step = complex(np.cos(angles[i]), -np.sin(angles[i]))
        turn = complex(1.0, 0.0)
        for p in range(1, highest + 1):
            turn *= step
            result[p] += jump * turn / (2j * np.pi * p)
    result[0] = mean
    return result


@compiled
def piecewise_linear_balance(
    coefficients: ComplexArray,
    harmonics: Harmonics,
    samples: FloatArray,
    law: tuple[FloatArray, FloatArray, FloatArray],
) -> tuple[FloatArray, FloatArray]:
    """Return the force of a piecewise-linear law and its derivative, both in the real form.

    Parameters
    ----------
    coefficients : (n_harmonics,) array
        Displacement [m].
    harmonics : (n_harmonics,) array
        Number of each harmonic.
    samples : (2, n_samples) array
        The displacement and its derivative by the angle at equally spaced angles from 0.
    law : (n,), (n + 1,) and (n + 1,) arrays
        Displacements at which the law changes [m], stiffness on each stretch [N/m] and the
        force that each stretch has at 0 [N].

    Returns
    -------
    force : (n_real,) array
        Coefficients of the force [N].
    jacobian : (n_real, n_real) array
        Derivative by the coefficients of the displacement [N/m].
    """
    breakpoints, slopes, intercepts = law
    angles, segments = stretches(coefficients, harmonics, samples, breakpoints)
    highest = harmonics[-1]
    jacobian = multiplication(window(angles, slopes[segments], 2 * highest), harmonics)
    constant = window(angles, intercepts[segments], highest)
    offset = np.empty(harmonics.size, np.complex128)
    for i in range(harmonics.size):
        n = harmonics[i]
        offset[i] = constant[n] * (1.0 if n == 0 else 2.0)
    force = jacobian @ real_of_complex(coefficients, harmonics)
    return force + real_of_complex(offset, harmonics), jacobian
