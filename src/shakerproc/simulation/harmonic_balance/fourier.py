"""Trigonometric polynomials: coefficients to values and back, products with a factor.

`simulate.kernels.harmonic_fourier` says what the coefficients and the real form are.
"""

from functools import lru_cache

import numpy as np

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.simulation.kernels.harmonic import (
    Harmonics,
    complex_of_real,
    multiplication,
    rate_of_columns,
    rate_of_rows,
    real_of_complex,
    value,
    values_at,
)

__all__ = [
    "Harmonics",
    "coefficients_of_values",
    "complex_of_real",
    "impulses",
    "multiplication",
    "n_real",
    "rate_of_columns",
    "rate_of_rows",
    "real_of_complex",
    "sample_table",
    "value",
    "values",
    "values_at",
]


def n_real(harmonics: Harmonics) -> int:
    """Return how many real numbers the coefficients of one motion are."""
    return 2 * harmonics.size - int(harmonics[0] == 0)


def sample_table(harmonics: Harmonics, n_samples: int) -> FloatArray:
    """Return the matrix from a real form to values and slopes at equally spaced angles.

    Parameters
    ----------
    harmonics : (n_harmonics,) array
        Number of each harmonic.
    n_samples : int
        Samples per period.

    Returns
    -------
    (2 n_samples, n_real) array
        First the rows that give the values, then those that give the derivatives by the angle.
    """
    return _sample_table(harmonics.tobytes(), n_samples)


@lru_cache(maxsize=32)
def _sample_table(harmonics: bytes, n_samples: int) -> FloatArray:
    numbers = np.frombuffer(harmonics, np.int64)
    angles = np.arange(n_samples) * (2.0 * np.pi / n_samples)
    shape = np.empty((n_samples, n_real(numbers)))
    basis = np.exp(1j * np.outer(angles, numbers))
    shift = int(numbers[0] == 0)
    shape[:, :shift] = 1.0
    shape[:, shift::2] = basis.real[:, shift:]
    shape[:, shift + 1 :: 2] = basis.imag[:, shift:]
    return np.vstack([shape, rate_of_columns(shape, numbers)])


def values(coefficients: ComplexArray, harmonics: Harmonics, n_samples: int) -> FloatArray:
    """Return motions at equally spaced angles from 0.

    Parameters
    ----------
    coefficients : (..., n_harmonics) array
        Complex coefficients [any unit].
    harmonics : (n_harmonics,) array
        Number of each harmonic.
    n_samples : int
        Samples per period; fewer than twice the highest harmonic are exact as well.

    Returns
    -------
    (..., n_samples) array
        Values.
    """
    every = 1 + 2 * int(harmonics[-1]) // n_samples
    size = every * n_samples
    spectrum = np.zeros((*coefficients.shape[:-1], size // 2 + 1), np.complex128)
    spectrum[..., harmonics] = coefficients * (0.5 * size)
    spectrum[..., 0] *= 2.0
    return np.fft.irfft(spectrum, size)[..., ::every]


def coefficients_of_values(samples: FloatArray, harmonics: Harmonics) -> ComplexArray:
    """Return the complex coefficients of equally spaced samples of one period.

    Parameters
    ----------
    samples : (..., n_samples) array
        One period from angle 0 [any unit].
    harmonics : (n_harmonics,) array
        Harmonics wanted, below half the number of samples.

    Returns
    -------
    (..., n_harmonics) array
        Coefficients.
    """
    n_samples = samples.shape[-1]
    spectrum = np.fft.rfft(samples)[..., harmonics] * (2.0 / n_samples)
    spectrum[..., harmonics == 0] *= 0.5
    return np.asarray(spectrum)


def impulses(angles: FloatArray, sizes: FloatArray, harmonics: Harmonics) -> FloatArray:
    """Return the matrix of a factor that is zero but for impulses, in the real form.

    Parameters
    ----------
    angles : (n,) array
        Where the impulses stand [rad].
    sizes : (n,) array
        Their integrals over the angle [unit of the factor times rad].
    harmonics : (n_harmonics,) array
        Number of each harmonic.

    Returns
    -------
    (n_real, n_real) array
        Matrix of the truncated product.
    """
    factor = np.zeros(2 * int(harmonics[-1]) + 1, np.complex128)
    orders = np.arange(factor.size)
    for angle, size in zip(angles, sizes, strict=True):
        factor += size * np.exp(-1j * orders * angle) / (2.0 * np.pi)
    return multiplication(factor, harmonics)
