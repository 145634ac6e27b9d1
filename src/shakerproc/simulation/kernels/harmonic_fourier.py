r"""Trigonometric polynomials in compiled loops.

A motion is :math:`z(\tau) = \mathrm{Re} \sum_n X_n e^{i n \tau}` with :math:`\tau = \omega t`.
Its real form lists for each harmonic :math:`(a_n, b_n)` with :math:`X_n = a_n - i b_n`, so that
:math:`z = \sum a_n \cos n\tau + b_n \sin n\tau`; harmonic 0 has no :math:`b`.
"""

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.models.compiled import compiled

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
