"""Least-squares fit of several modes to a smeared response function or density.

What Welch's method gives is not the response function but its average over the window's
spectrum. In time that is a product, so the fit compares like with like: the decay of a mode
times the correlation of the window with itself, transformed. Frequencies and damping ratios
are searched; what enters linearly (the residues, and a straight background for the modes far
away) is solved for.
"""

from dataclasses import dataclass
from typing import Final, Literal, TypeAlias, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.spectra.welch.windows import AbstractCorrelation

Kind: TypeAlias = Literal["response", "density"]

RATIOS: Final = (1e-5, 0.7)
"""Damping ratios that the search does not pass [-]."""

MOST_STEPS: Final = 60
"""Evaluations after which a search is given up."""


CLOSE: Final = 1e-4
"""Relative step and relative fall of the squares at which a search ends [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class SmearedModes:
    """Responses of modes in certain bins.

    Attributes
    ----------
    kind : str
        ``response`` (complex values) or ``density`` (real ones).
    bins : (n_bins,) array of int
        Which bins.
    correlation : AbstractCorrelation
        Of the window with itself.
    n_fft : int
        Length of the FFT.
    sample_rate : float
        Samples per second [Hz].
    """

    kind: Kind
    bins: NDArray[np.intp]
    correlation: AbstractCorrelation
    n_fft: int
    sample_rate: float

    def mode(self, frequency: float, ratio: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the two columns of a mode and their slopes along ln f and ln zeta.

        `frequency` is in [Hz], `ratio` without unit [-].
        """
        root = float(np.sqrt(1.0 - ratio * ratio))
        omega = 2.0 * np.pi * frequency / self.sample_rate
        pole = omega * complex(-ratio, root)
        turns = 2j * np.pi / self.n_fft * np.concatenate([self.bins, -self.bins])
        spectrum, along = self.correlation.transform(pole - turns)
        direct, mirrored = spectrum[: self.bins.size], spectrum[self.bins.size :].conj()
        slope, mirrored_slope = along[: self.bins.size], along[self.bins.size :].conj()
        turn = omega * ratio * complex(-1.0, -ratio / root)
        return (
            self._columns(direct, mirrored),
            self._columns(pole * slope, pole.conjugate() * mirrored_slope),
            self._columns(turn * slope, turn.conjugate() * mirrored_slope),
        )

    def background(self) -> FloatArray:
        """Return the columns of the modes far away: level and slope."""
        place = np.linspace(-1.0, 1.0, self.bins.size)
        level, nothing = np.ones(self.bins.size), np.zeros(self.bins.size)
        if self.kind == "density":
            return np.column_stack([level, place])
        pairs = ((level, nothing), (nothing, level), (place, nothing), (nothing, place))
        return np.column_stack([np.concatenate(pair) for pair in pairs])

    def _columns(self, direct: ComplexArray, mirrored: ComplexArray) -> FloatArray:
        """Return the columns of a residue and its conjugate, real above imaginary parts."""
        both, difference = direct + mirrored, 1j * (direct - mirrored)
        if self.kind == "density":
            return np.column_stack([both.real, difference.real])
        return np.column_stack([stacked(both), stacked(difference)])


@final
@dataclass(frozen=True, slots=True, eq=False)
class ModesFit:
    """The modes that fit best.

    Attributes
    ----------
    frequency, ratio : (n_modes,) array
        Natural frequencies [Hz] and damping ratios [-].
    weights : (n_values,) array
        Residue of each mode (two numbers), then the background.
    residual : (n_values,) array
        Fit less values, over the errors, real above imaginary parts [-].
    slopes : (n_values, 2 n_modes) array
        Derivative of the residual along the logarithms of frequencies, then of ratios, with
        the linear coefficients following.
    basis : (n_values, n) array
        Orthonormal columns that span all that the fit can follow.
    misfit : float
        Rms of what is not explained over the largest value [-].
    converged : bool
        Whether the search ended at a minimum inside its limits.
    """

    frequency: FloatArray
    ratio: FloatArray
    weights: FloatArray
    residual: FloatArray
    slopes: FloatArray
    basis: FloatArray
    misfit: float
    converged: bool

    @property
    def squares(self) -> float:
        """Sum of the squared residuals [-]."""
        return float(self.residual @ self.residual)


def fit_modes(
    shape: SmearedModes,
    values: ComplexArray | FloatArray,
    errors: FloatArray,
    frequency: FloatArray,
    ratio: FloatArray,
) -> ModesFit:
    """Return the modes that fit values best in the sense of least squares.

    Parameters
    ----------
    shape : SmearedModes
        What modes look like in these bins.
    values : (n_bins,) array
        Response function or density [any unit].
    errors : (n_bins,) array
        Standard error of each value (of a complex value: of each of its parts)
        [unit of the values].
    frequency, ratio : (n_modes,) array
        Where to start [Hz] [-].

    Returns
    -------
    ModesFit
        Best fit, in the order of the start.
    """
    problem = _FitProblem(shape, values, errors)
    n = frequency.size
    width = shape.sample_rate / shape.n_fft
    start = np.log(np.concatenate([frequency, ratio]))
    span = width * shape.bins.size / frequency  # none leaves for another peak
    lower = np.concatenate([start[:n] - span, np.full(n, np.log(RATIOS[0]))])
    upper = np.concatenate([start[:n] + span, np.full(n, np.log(RATIOS[1]))])
    begin = np.clip(start, lower + 1e-9, upper - 1e-9)
    try:
        with np.errstate(invalid="raise", divide="raise"):
            optimum = scipy.optimize.least_squares(
                problem.residual,
                begin,
                problem.jacobian,
                bounds=(lower, upper),
                x_scale=np.concatenate([ratio, np.ones(n)]),
                max_nfev=MOST_STEPS,
                xtol=CLOSE,
                ftol=CLOSE,
                gtol=None,
            )
    except FloatingPointError:  # no slope at all: a channel that is a multiple of the control
        return problem.solved(begin, converged=False)
    return problem.solved(
        optimum.x, converged=optimum.status > 0 and not optimum.active_mask.any()
    )


def best_ratio(
    shape: SmearedModes,
    values: ComplexArray | FloatArray,
    errors: FloatArray,
    frequency: float,
    ratios: FloatArray,
) -> float:
    """Return which of some damping ratios fits one mode best [-]; arguments as `fit_modes`."""
    problem = _FitProblem(shape, values, errors)
    residuals = [problem.residual(np.log([frequency, ratio])) for ratio in ratios]
    return float(ratios[int(np.argmin([residual @ residual for residual in residuals]))])


def stacked(values: ComplexArray | FloatArray) -> FloatArray:
    """Return real values as they are, complex ones as real above imaginary parts.

    `values` may be in any unit.
    """
    if np.iscomplexobj(values):
        return np.concatenate([values.real, values.imag])
    return np.array(values, dtype=np.float64)


@final
class _FitProblem:
    """Residuals of the fit for any logarithms of frequencies and damping ratios.

    The linear coefficients are solved for at every point (variable projection).
    """

    def __init__(
        self, shape: SmearedModes, values: ComplexArray | FloatArray, errors: FloatArray
    ) -> None:
        self.shape = shape
        self.errors = errors if shape.kind == "density" else np.concatenate([errors, errors])
        self.target = stacked(values) / self.errors
        self.background = shape.background() / self.errors[:, np.newaxis]
        self.height = float(np.abs(values).max())
        self.point: FloatArray = np.zeros(0)
        self.left: FloatArray = self.target
        self.slopes: FloatArray = self.background

    def residual(self, point: FloatArray) -> FloatArray:
        """Return fit less target, over the errors."""
        self._solve(point)
        return self.left

    def jacobian(self, point: FloatArray) -> FloatArray:
        """Return the derivatives of the residual, (n_values, 2 n_modes)."""
        self._solve(point)
        return self.slopes

    def solved(self, point: FloatArray, *, converged: bool) -> ModesFit:
        """Return all that is known at a point."""
        self._solve(point)
        n = point.size // 2
        along = np.linalg.qr(self.slopes)[0]
        missed = self.left * self.errors
        return ModesFit(
            frequency=np.exp(point[:n]),
            ratio=np.exp(point[n:]),
            weights=self.weights,
            residual=self.left,
            slopes=self.slopes,
            basis=np.column_stack([self.basis, along]),
            misfit=float(np.sqrt(np.sum(missed**2) / self.shape.bins.size)) / self.height,
            converged=converged,
        )

    def _solve(self, point: FloatArray) -> None:
        if np.array_equal(point, self.point):
            return
        n = point.size // 2
        shapes = [
            self.shape.mode(float(f), float(z))
            for f, z in zip(np.exp(point[:n]), np.exp(point[n:]), strict=True)
        ]
        below = self.errors[:, np.newaxis]
        columns = np.column_stack([*(mode / below for mode, _, _ in shapes), self.background])
        self.basis, triangle = np.linalg.qr(columns)
        # of shapes that are alike, as those of two equal modes, any share will do
        self.weights = np.linalg.lstsq(triangle, self.basis.T @ self.target, rcond=None)[0]
        self.left = columns @ self.weights - self.target
        parts = self.weights[: 2 * n].reshape(n, 2)
        slopes = np.column_stack([
            mode[k] @ part / self.errors
            for k in (1, 2)
            for mode, part in zip(shapes, parts, strict=True)
        ])
        self.slopes = slopes - self.basis @ (self.basis.T @ slopes)
        self.point = point.copy()
