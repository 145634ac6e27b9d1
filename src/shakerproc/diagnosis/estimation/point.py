"""Where a search is, and the residual and its slopes there."""

from dataclasses import dataclass
from typing import TypeAlias, final

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.residuals import Predicted

Channels: TypeAlias = tuple[FloatArray, FloatArray, FloatArray]
"""Gain of each sensor [-], its delay [s], and the constant of each input over its rms [-]."""

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
    offset : (n_offsets,) array
        Constant of the input of each test over its rms [-].
    starts : (n_windows, n_motions) array or None
        Motion where windows begin, of the masses and of the modes, and states of the laws.
    """

    x: FloatArray
    gain: FloatArray
    delay: FloatArray
    offset: FloatArray
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
        By coordinates, gains, delays and offsets.
    own : list of (n_members, n_residuals, n_starts) array
        By the window's own start, over its scales.
    """

    residual: list[FloatArray]
    slopes: list[FloatArray]
    own: list[FloatArray]
