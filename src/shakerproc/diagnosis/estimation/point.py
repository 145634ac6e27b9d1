"""Where a search is, and the residual and its slopes there."""

from dataclasses import dataclass
from typing import TypeAlias, final

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.residuals import Predicted

Channels: TypeAlias = tuple[FloatArray, FloatArray, FloatArray]
"""Gain of each sensor [-], its delay [s], and the numbers of each test (see `of_tests`) [-]."""

State: TypeAlias = tuple[list[FloatArray], Predicted, float]
"""Residuals of every stack of windows, (n_members, n_residuals) arrays over the noise, the
prediction, and the cost with the prior."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Point:
    """Where the search is.

    Attributes
    ----------
    x : (n_x,) array
        Coordinates of the hypothesis.
    gain, delay : (n_sensors,) array
        Gain of each sensor [-] and its delay [s].
    of_tests : (n, n_tests) array
        What each test has of its own (see `of_tests.spreads_of`) [-].
    starts : (n_windows, n_motions) array or None
        Motion where windows begin, of the masses and of the modes, and states of the laws.
    """

    x: FloatArray
    gain: FloatArray
    delay: FloatArray
    of_tests: FloatArray
    starts: FloatArray | None


@final
@dataclass(frozen=True, slots=True, eq=False)
class Linearised:
    """Residual of every stack of windows and its slopes; all 0 for windows that ran away.

    Attributes
    ----------
    residual : list of (n_members, n_residuals) array
        Over the noise [-].
    slopes : list of (n_members, n_residuals, n) array
        By coordinates, gains, delays and numbers of tests.
    own : list of (n_members, n_residuals, n_starts) array
        By the window's own start, over its scales.
    """

    residual: list[FloatArray]
    slopes: list[FloatArray]
    own: list[FloatArray]
