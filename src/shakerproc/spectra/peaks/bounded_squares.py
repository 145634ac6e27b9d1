"""Least squares of a few unknowns within limits: scipy.optimize loads for 0.4 s."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray

Function: TypeAlias = Callable[[FloatArray], FloatArray]

FIRST_DAMPING: Final = 1e-3
"""Of the first step, as a share of the squares of the slopes [-]."""

MOST_DAMPING: Final = 1e12
"""Where no step of any size falls any more [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Minimum:
    """Where a search ended.

    Attributes
    ----------
    point : (n,) array
        The unknowns [-].
    converged : bool
        Whether it is a minimum, and inside the limits.
    """

    point: FloatArray
    converged: bool


def least_squares(  # noqa: PLR0917  (as scipy's)
    residual: Function,
    jacobian: Function,
    start: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
    most: int,
    close: float,
) -> Minimum:
    """Return where the sum of the squared residuals is least, by Levenberg-Marquardt steps.

    A step that leaves the limits ends on them; an unknown on its limit is held there while
    the sum falls outwards.

    Parameters
    ----------
    residual : function
        Of the (n,) unknowns, (m,) residuals [-].
    jacobian : function
        Of the unknowns, (m, n) derivatives [-].
    start, lower, upper : (n,) array
        Where to begin, and the limits [-].
    most : int
        Steps after which the search is given up.
    close : float
        Relative fall of the sum at which it ends [-].

    Returns
    -------
    Minimum
        The best point.

    References
    ----------
    .. [1] K. Madsen, H. B. Nielsen and O. Tingleff, "Methods for non-linear least squares
       problems", 2nd ed., Technical University of Denmark, 2004, section 3.2.
    """
    point, left, slopes = start, residual(start), jacobian(start)
    squares, damping, growth = float(left @ left), FIRST_DAMPING, 2.0
    for _ in range(most):
        gradient = slopes.T @ left
        held = ((point <= lower) & (gradient > 0.0)) | ((point >= upper) & (gradient < 0.0))
        step = _step(slopes, gradient, ~held, damping)
        trial = np.clip(point + step, lower, upper)
        along = slopes @ (trial - point)
        promised = -float(along @ (2.0 * left + along))
        if not step.any() or damping > MOST_DAMPING:
            return Minimum(point, bool(slopes.any() and not held.any()))
        there = residual(trial) if promised > 0.0 else left  # limits may turn a step uphill
        fall = squares - float(there @ there)
        if fall > 0.0:
            ended = max(fall, promised) <= close * squares
            point, left, squares, slopes = trial, there, squares - fall, jacobian(trial)
            damping *= max(1.0 / 3.0, 1.0 - (2.0 * fall / promised - 1.0) ** 3)
            growth = 2.0
        else:
            ended = 0.0 < promised <= close**2 * squares  # nothing to gain but rounding
            damping, growth = damping * growth, 2.0 * growth
        if ended:
            return Minimum(point, bool(np.all((point > lower) & (point < upper))))
    return Minimum(point, converged=False)


def _step(
    slopes: FloatArray, gradient: FloatArray, free: NDArray[np.bool_], damping: float
) -> FloatArray:
    """Return a damped step of the free unknowns; an unknown without slope stays."""
    scale = np.sqrt(np.einsum("ij,ij->j", slopes, slopes))
    free = free & (scale > 0.0)
    scaled = slopes[:, free] / scale[free]
    normal = scaled.T @ scaled + damping * np.eye(scaled.shape[1])
    step = np.zeros(gradient.size)
    step[free] = np.linalg.solve(normal, -gradient[free] / scale[free]) / scale[free]
    return step
