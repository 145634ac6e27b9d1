r"""Periodic motion in compiled loops: trigonometric polynomials, contacts, monodromy.

A motion is :math:`z(\tau) = \mathrm{Re} \sum_n X_n e^{i n \tau}` with :math:`\tau = \omega t`.
Its real form lists for each harmonic :math:`(a_n, b_n)` with :math:`X_n = a_n - i b_n`, so that
:math:`z = \sum a_n \cos n\tau + b_n \sin n\tau`; harmonic 0 has no :math:`b`.

On each stretch between two crossings of a breakpoint the force is :math:`s_j z + c_j`; its
Fourier coefficients are those of :math:`z` folded with those of the stretch: no sampling; the
derivative is the same fold, as the force is continuous at a crossing.
"""

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.models.compiled import compiled, inner

Harmonics: TypeAlias = NDArray[np.int64]


@compiled
def complex_of_real(real: FloatArray, harmonics: Harmonics) -> ComplexArray:
    """Return the complex coefficients, (n_harmonics,) array, of a real form."""
    coefficients = np.empty(harmonics.size, np.complex128)
    place = 0
    for i in range(harmonics.size):
        if harmonics[i] == 0:
            coefficients[i] = real[place]
            place += 1
        else:
            coefficients[i] = complex(real[place], -real[place + 1])
            place += 2
    return coefficients


@compiled
def real_of_complex(coefficients: ComplexArray, harmonics: Harmonics) -> FloatArray:
    """Return the real form, (n_real,) array, of complex coefficients."""
    real = np.empty(2 * harmonics.size - (1 if harmonics[0] == 0 else 0))
    place = 0
    for i in range(harmonics.size):
        real[place] = coefficients[i].real
        place += 1
        if harmonics[i] != 0:
            real[place] = -coefficients[i].imag
            place += 1
    return real


@compiled
def value(
    coefficients: ComplexArray, harmonics: Harmonics, angle: float
) -> tuple[float, float, float]:
    """Return a motion and its first two derivatives by the angle, at one angle [rad]."""
    position = slope = bend = 0.0
    step = complex(np.cos(angle), np.sin(angle))
    turn = complex(1.0, 0.0)
    at = 0
    for i in range(harmonics.size):
        n = harmonics[i]
        while at < n:
            turn *= step
            at += 1
        term = coefficients[i] * turn
        position += term.real
        slope -= n * term.imag
        bend -= n * n * term.real
    return position, slope, bend


@compiled
def multiplication(factor: ComplexArray, harmonics: Harmonics) -> FloatArray:
    r"""Return the matrix that multiplies a motion by a periodic factor, in the real form.

    Parameters
    ----------
    factor : (2 highest harmonic + 1,) array
        :math:`G_p = \frac{1}{2\pi} \int g(\tau) e^{-ip\tau} d\tau`.
    harmonics : (n_harmonics,) array
        Number of each harmonic.

    Returns
    -------
    (n_real, n_real) array
        Matrix of the truncated product.
    """
    size = 2 * harmonics.size - (1 if harmonics[0] == 0 else 0)
    matrix = np.empty((size, size))
    row = 0
    for i in range(harmonics.size):
        m = harmonics[i]
        weight = 0.5 if m == 0 else 1.0
        column = 0
        for j in range(harmonics.size):
            n = harmonics[j]
            below = factor[m - n] if m >= n else np.conj(factor[n - m])
            above = factor[m + n]
            if n == 0:
                cosine = 2.0 * weight * factor[m]
                matrix[row, column] = cosine.real
                if m > 0:
                    matrix[row + 1, column] = -cosine.imag
                column += 1
                continue
            cosine = weight * (below + above)
            sine = weight * 1j * (above - below)
            matrix[row, column] = cosine.real
            matrix[row, column + 1] = sine.real
            if m > 0:
                matrix[row + 1, column] = -cosine.imag
                matrix[row + 1, column + 1] = -sine.imag
            column += 2
        row += 1 if m == 0 else 2
    return matrix


@compiled
def rate_of_rows(array: FloatArray, harmonics: Harmonics) -> FloatArray:
    r"""Return :math:`d/d\tau` applied to the rows of a (n_real, n) array in the real form."""
    result = np.zeros_like(array)
    row = 0
    for i in range(harmonics.size):
        n = harmonics[i]
        if n == 0:
            row += 1
            continue
        for j in range(array.shape[1]):
            result[row, j] = n * array[row + 1, j]
            result[row + 1, j] = -n * array[row, j]
        row += 2
    return result


@compiled
def rate_of_columns(array: FloatArray, harmonics: Harmonics) -> FloatArray:
    r"""Return a (n, n_real) matrix times :math:`d/d\tau`: it then acts on the velocity."""
    result = np.zeros_like(array)
    column = 0
    for i in range(harmonics.size):
        n = harmonics[i]
        if n == 0:
            column += 1
            continue
        for j in range(array.shape[0]):
            result[j, column] = -n * array[j, column + 1]
            result[j, column + 1] = n * array[j, column]
        column += 2
    return result


@compiled
def values_at(
    coefficients: ComplexArray, harmonics: Harmonics, omega: float, angles: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return values and rates of a motion at any angles.

    Parameters
    ----------
    coefficients : (n_harmonics,) array
        The motion [m].
    harmonics : (n_harmonics,) array
        Number of each harmonic.
    omega : float
        Rate of the angle [rad/s].
    angles : (n,) array
        Angles [rad].

    Returns
    -------
    two (n,) arrays
        Displacement [m] and velocity [m/s].
    """
    position, rate = np.empty(angles.size), np.empty(angles.size)
    for i in range(angles.size):
        position[i], slope, _ = value(coefficients, harmonics, angles[i])
        rate[i] = omega * slope
    return position, rate


Segments: TypeAlias = NDArray[np.int64]


@compiled
def segment_of(position: float, breakpoints: FloatArray) -> int:
    """Return in which stretch of the law a displacement lies."""
    segment = 0
    while segment < breakpoints.size and position > breakpoints[segment]:
        segment += 1
    return segment


@inner
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
        # Newton, and bisection where its step leaves the bracket
        step = (position - level) / slope if slope != 0.0 else np.inf
        closer = angle - step
        if not low < closer < high:
            closer = 0.5 * (low + high)
        if abs(closer - angle) <= 4e-15:
            return closer
        angle = closer
    return angle


@inner
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


@inner
def _pass(
    coefficients: ComplexArray,
    harmonics: Harmonics,
    breakpoints: FloatArray,
    span: tuple[float, float],
    end: float,
    crossings: tuple[FloatArray, Segments],
    count: int,
) -> int:
    """Note every crossing on a span on which the motion rises or falls throughout."""
    angles, segments = crossings
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


TERMS = 16


@compiled
def multiply(left: FloatArray, right: FloatArray, out: FloatArray) -> None:
    """Set `out` to the product of two small square matrices."""
    size = left.shape[0]
    for i in range(size):
        for k in range(size):
            total = 0.0
            for j in range(size):
                total += left[i, j] * right[j, k]
            out[i, k] = total


@compiled
def exponential(matrix: FloatArray, rooms: FloatArray) -> FloatArray:
    """Return the exponential of a small matrix, by its series after halving.

    The matrix is overwritten; `rooms` is a (3, size, size) array to work in, and the result is
    one of its parts.
    """
    size = matrix.shape[0]
    norm = 0.0
    for i in range(size):
        row = 0.0
        for j in range(size):
            row += abs(matrix[i, j])
        norm = max(norm, row)
    halvings, scale = 0, 1.0
    while norm * scale > 0.5:
        scale *= 0.5
        halvings += 1
    matrix *= scale
    result, term, other = rooms[0], rooms[1], rooms[2]
    for i in range(size):
        for j in range(size):
            result[i, j] = term[i, j] = 1.0 if i == j else 0.0
    bound = 1.0
    for n in range(1, TERMS):
        multiply(term, matrix, other)
        term, other = other, term
        term /= n
        result += term
        # a term below 1e-18 changes no sum that begins at 1, rounded to 1.1e-16
        bound *= norm * scale / n
        if bound < 1e-18:
            break
    for _ in range(halvings):
        multiply(result, result, other)
        result, other = other, result
    return result


@compiled
def propagate(
    durations: FloatArray, early: FloatArray, late: FloatArray, jumps: FloatArray
) -> FloatArray:
    r"""Return the product of the propagators of all spans (Magnus, fourth order).

    .. math:: \Omega = \tfrac{h}{2} (A_1 + A_2) + \tfrac{\sqrt3 h^2}{12} [A_2, A_1]

    Where the two matrices are the same it is exact. The commutator has no trace, so that the
    determinant is that of the flow whatever the step.

    Parameters
    ----------
    durations : (n_spans,) array
        Length of each span [s].
    early, late : (n_spans, size, size) array
        Rate of change of a disturbance at the two Gauss points of each span [1/s].
    jumps : (n_spans, size, size) array
        What happens to the disturbance at the end of each span.

    Returns
    -------
    (size, size) array
        Disturbance after over disturbance before.

    References
    ----------
    .. [1] A. Iserles and S. P. Nørsett, "On the solution of linear differential equations in
       Lie groups", Philosophical Transactions A 357, 983-1019, 1999.
    """
    size = early.shape[1]
    result, other, twist = np.eye(size), np.empty((size, size)), np.empty((size, size))
    rooms = np.empty((3, size, size))
    for i in range(durations.size):
        h = durations[i]
        multiply(late[i], early[i], twist)
        multiply(early[i], late[i], other)
        for j in range(size):
            for k in range(size):
                turn = np.sqrt(3.0) / 12.0 * h * h * (twist[j, k] - other[j, k])
                twist[j, k] = 0.5 * h * (early[i, j, k] + late[i, j, k]) + turn
        step = exponential(twist, rooms)
        multiply(step, result, other)
        multiply(jumps[i], other, result)
    return result
