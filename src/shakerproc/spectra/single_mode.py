"""Least-squares fit of one mode to a smeared response function or density.

What Welch's method gives is not the response function but its average over the window's
spectrum. In time that is a product, so the fit compares like with like: the decay of the mode
times the correlation of the window with itself, transformed. Frequency and damping ratio are
searched; what enters linearly (the residue and a straight background) is solved for.
"""

from dataclasses import dataclass
from typing import Final, Literal, TypeAlias, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray

FIRST_RATIOS: Final = np.geomspace(2e-4, 0.3, 25)
"""Damping ratios tried before the search."""

ITERATIONS: Final = 60
NEIGHBOURS: Final = 8
"""Segment widths of bins beyond which errors are independent."""

BOUNDS: Final = (float(np.log(1e-5)), float(np.log(0.7)))
"""Logarithms of damping ratios that the search does not pass."""

CONVERGED: Final = 1e-7
"""Relative step at which the search ends [-]."""

Kind: TypeAlias = Literal["response", "density"]


@final
@dataclass(frozen=True, slots=True, eq=False)
class ModeShape:
    """What a mode of any frequency and damping looks like in certain bins.

    Attributes
    ----------
    kind : str
        ``response`` (complex values) or ``density`` (real ones).
    bins : (n_bins,) array of int
        Which bins.
    correlation : (n_fft,) array
        Correlation of the window with itself, 1 at no shift (halved, as the response begins
        there), and zeros [-].
    sample_rate : float
        Samples per second [Hz].
    """

    kind: Kind
    bins: NDArray[np.intp]
    correlation: FloatArray
    sample_rate: float

    def columns(self, frequency: float, ratio: float) -> FloatArray:
        """Return the real columns that the values are a sum of.

        Two for the residue of the mode and its conjugate, and constant and slope of the
        background; a response has the real parts above the imaginary parts.
        """
        omega = 2.0 * np.pi * frequency
        pole = omega * complex(-ratio, np.sqrt(1.0 - ratio * ratio))
        time = np.arange(self.correlation.size) / self.sample_rate
        with np.errstate(under="ignore"):
            spectrum = scipy.fft.fft(np.exp(pole * time) * self.correlation)
        direct, mirrored = spectrum[self.bins], spectrum[-self.bins].conj()
        real, imaginary = direct + mirrored, 1j * (direct - mirrored)
        place = np.linspace(-1.0, 1.0, self.bins.size)
        level = np.ones(self.bins.size)
        if self.kind == "density":
            return np.column_stack([real.real, imaginary.real, level, place])
        parts = [real, imaginary, level, 1j * level, place, 1j * place]
        return np.concatenate([
            np.column_stack([part.real for part in parts]),
            np.column_stack([np.imag(part) for part in parts]),
        ])


@final
@dataclass(frozen=True, slots=True, eq=False)
class ModeFit:
    """The mode that fits best.

    Attributes
    ----------
    frequency, ratio : float
        Natural frequency [Hz] and damping ratio [-].
    frequency_error, ratio_error : float
        Standard errors, relative [-], inflated where the fit is worse than chance.
    chi_square : float
        Squared misfit over what chance makes of it.
    misfit : float
        Rms of what is not explained over the largest value [-].
    fitted : (n_bins,) array
        Values of the fit.
    converged : bool
        Whether the search ended at a minimum.
    """

    frequency: float
    ratio: float
    frequency_error: float
    ratio_error: float
    chi_square: float
    misfit: float
    fitted: ComplexArray | FloatArray
    converged: bool


def window_correlation(window: FloatArray, n_fft: int) -> FloatArray:
    """Return the correlation of a window with itself for shifts from 0, halved at 0.

    Parameters
    ----------
    window : (length,) array
        Weights [-].
    n_fft : int
        Length of the result, at least that of the window.

    Returns
    -------
    (n_fft,) array
        Correlation over the power of the window [-].
    """
    spectrum = scipy.fft.rfft(window, 2 * window.size)
    correlation = scipy.fft.irfft(np.abs(spectrum) ** 2)[: window.size]
    correlation /= correlation[0]
    correlation[0] = 0.5
    return np.concatenate([correlation, np.zeros(n_fft - window.size)])


def bin_correlation(window: FloatArray, n_fft: int) -> FloatArray:
    """Return how the random errors of bins are correlated with those of their neighbours.

    Returns
    -------
    (2 n + 1,) array
        Correlations from 0 to 1, that of a bin with itself in the middle [-].
    """
    n_neighbours = min(NEIGHBOURS * -(-n_fft // window.size), n_fft // 2)
    spectrum = np.abs(scipy.fft.fft(window**2, n_fft)[: n_neighbours + 1]) / float(
        window @ window
    )
    return np.concatenate([spectrum[:0:-1], spectrum]) ** 2


def fit_mode(  # noqa: PLR0917  (shape and data, then where to start)
    shape: ModeShape,
    values: ComplexArray | FloatArray,
    errors: FloatArray,
    correlation: FloatArray,
    start: float,
    ratio: float | None = None,
) -> ModeFit:
    """Return the mode that fits values best in the sense of least squares.

    Parameters
    ----------
    shape : ModeShape
        What modes look like in these bins.
    values : (n_bins,) array
        Response function or density.
    errors : (n_bins,) array
        Standard error of each value (of a complex value: of each of its parts).
    correlation : (2 n + 1,) array
        Correlation of the errors, from `bin_correlation` [-].
    start : float
        Frequency to start from [Hz].
    ratio : float, optional
        Damping ratio to start from [-]; by default the best of a wide range.

    Returns
    -------
    ModeFit
        Best fit, with relative standard errors.
    """
    target = _stacked(values) / _weights(shape, errors)
    problem = _Problem(shape, target, _weights(shape, errors))
    ratios = FIRST_RATIOS if ratio is None else (ratio,)
    starts = [np.log([start, candidate]) for candidate in ratios]
    best = min(starts, key=lambda p: float(np.sum(problem.residual(p)[0] ** 2)))
    point, converged = _search(problem, best)
    residual, solution = problem.residual(point)
    freedom = max(1, target.size - solution.size - 2)
    chi_square = float(residual @ residual) / freedom
    spread = _covariance(problem.jacobian(point), correlation, values.size)
    frequency_error, ratio_error = np.sqrt(np.diag(spread) * max(1.0, chi_square))
    weighted = residual * problem.weights
    fitted = _unstacked(shape, _stacked(values) + weighted)
    return ModeFit(
        frequency=float(np.exp(point[0])),
        ratio=float(np.exp(point[1])),
        frequency_error=float(frequency_error),
        ratio_error=float(ratio_error),
        chi_square=chi_square,
        misfit=float(np.sqrt(np.sum(weighted**2) / values.size) / np.abs(values).max()),
        fitted=fitted,
        converged=converged,
    )


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Problem:
    """Residuals of the fit for any logarithms of frequency and damping ratio."""

    shape: ModeShape
    target: FloatArray
    weights: FloatArray

    def residual(self, point: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return fit less target, over the errors, and the linear coefficients."""
        frequency, ratio = np.exp(point)
        columns = self.shape.columns(float(frequency), float(ratio))
        scaled = columns / self.weights[:, np.newaxis]
        solution = np.asarray(
            np.linalg.lstsq(scaled, self.target, rcond=None)[0], dtype=np.float64
        )
        misfit: FloatArray = np.asarray(scaled @ solution - self.target, dtype=np.float64)
        return misfit, solution

    def jacobian(self, point: FloatArray) -> FloatArray:
        """Return the derivatives of the residual, (n_values, 2), by central differences."""
        columns = []
        for step in (np.array([1e-5, 0.0]), np.array([0.0, 1e-4])):
            ahead, behind = self.residual(point + step)[0], self.residual(point - step)[0]
            columns.append((ahead - behind) / (2.0 * step.sum()))
        return np.column_stack(columns)


def _search(problem: _Problem, point: FloatArray) -> tuple[FloatArray, bool]:
    """Return the minimum by Levenberg's and Marquardt's method, and whether it is one."""
    damping = 1e-3
    residual: FloatArray
    residual = problem.residual(point)[0]
    for _ in range(ITERATIONS):
        slope = problem.jacobian(point)
        normal, gradient = slope.T @ slope, slope.T @ residual
        while True:
            scaled = normal + damping * np.diag(np.diag(normal) + 1e-300)
            step = np.clip(-np.linalg.solve(scaled, gradient), [-0.05, -1.0], [0.05, 1.0])
            step[1] = np.clip(point[1] + step[1], *BOUNDS) - point[1]
            trial = problem.residual(point + step)[0]
            if float(trial @ trial) <= float(residual @ residual):
                break
            damping *= 5.0
            if damping > 1e8:
                return point, True
        damping = max(damping / 5.0, 1e-9)
        point, residual = point + step, trial
        if np.abs(step).max() < CONVERGED:
            return point, True
    return point, False


def _covariance(slope: FloatArray, correlation: FloatArray, n_bins: int) -> FloatArray:
    """Return the covariance of the logarithms for errors that are correlated."""
    inverse = np.linalg.pinv(slope.T @ slope)
    middle = correlation.size // 2
    reach = min(middle, n_bins - 1)
    near = correlation[middle - reach : middle + reach + 1]
    parts = slope.reshape(-1, n_bins, 2)
    spread = np.array([
        np.column_stack([np.convolve(part[:, i], near)[reach : reach + n_bins] for i in (0, 1)])
        for part in parts
    ])
    return np.array(inverse @ slope.T @ spread.reshape(-1, 2) @ inverse)


def _weights(shape: ModeShape, errors: FloatArray) -> FloatArray:
    """Return the errors of the real numbers that the values are made of."""
    return errors if shape.kind == "density" else np.concatenate([errors, errors])


def _stacked(values: ComplexArray | FloatArray) -> FloatArray:
    """Return real values as they are, complex ones as real above imaginary parts."""
    if np.iscomplexobj(values):
        return np.concatenate([values.real, values.imag])
    return np.array(values, dtype=np.float64)


def _unstacked(shape: ModeShape, stacked: FloatArray) -> ComplexArray | FloatArray:
    """Return the values that were stacked."""
    if shape.kind == "density":
        return stacked
    half = stacked.size // 2
    return np.array(stacked[:half] + 1j * stacked[half:])
