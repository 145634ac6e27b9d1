"""Regression on many columns whose amplitudes are smooth, how smooth being cross-validated."""

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray

_STRENGTHS: Final = tuple(10.0 ** np.arange(-9.0, 1.0))
"""Strengths of the smoothness that are tried, as shares of what the columns tell [-]."""

_RIDGE: Final = 1e-13
"""Share of the mean square of all columns that keeps the equations solvable [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Smoothed:
    """Smooth amplitudes.

    Attributes
    ----------
    amplitudes : (n,) array
        Of the columns.
    common : (n_common,) array
        Of the common columns.
    covariance : (n, n) array
        Of the amplitudes: their scatter between blocks, and how far smoothness may mislead.
    left : float
        Sum of squares that is left.
    left_out : (n_blocks,) array
        Sum of squares of each block that the others leave of it.
    """

    amplitudes: FloatArray
    common: FloatArray
    covariance: FloatArray
    left: float
    left_out: FloatArray


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Blocks:
    """Products of columns with each other and with the residual, for every block."""

    square: FloatArray
    cross: FloatArray
    power: FloatArray

    def left(self, amplitudes: FloatArray, block: int) -> float:
        """Return the sum of squares that amplitudes leave of a block."""
        shown = 2.0 * self.cross[block] - self.square[block] @ amplitudes
        return float(self.power[block] - amplitudes @ shown)

    def solved(self, weight: FloatArray, without: int | None = None) -> FloatArray:
        """Return the amplitudes, from all blocks or all but one."""
        square, cross = self.square.sum(axis=0), self.cross.sum(axis=0)
        if without is not None:
            square, cross = square - self.square[without], cross - self.cross[without]
        return np.asarray(np.linalg.solve(square + weight, cross))

    def left_out(self, weight: FloatArray) -> FloatArray:
        """Return the sum of squares of each block that the others leave of it."""
        return np.array([self.left(self.solved(weight, b), b) for b in range(self.power.size)])


def smoothed(
    residual: FloatArray,
    columns: FloatArray,
    common: FloatArray,
    *,
    prior: FloatArray,
    penalty: FloatArray,
) -> Smoothed:
    """Return the smooth amplitudes that predict left-out blocks best.

    Parameters
    ----------
    residual : (n_blocks, n_rows) array
        What is to be explained, over the noise [-].
    columns : (n, n_blocks, n_rows) array
        The columns, over the noise [-].
    common : (n_common, n_blocks, n_rows) array
        Columns whose amplitudes need not be smooth, over the noise [-].
    prior : (n_common,) array
        One over the variance of each common amplitude [-].
    penalty : (n, n) array
        Roughness as a quadratic form of the amplitudes [-].
    """
    every, size = _scaled(columns, common)
    blocks = _Blocks(
        square=np.einsum("ibr,jbr->bij", every, every, optimize=True),
        cross=np.einsum("ibr,br->bi", every, residual, optimize=True),
        power=np.sum(residual**2, axis=1),
    )
    n = len(columns)
    fixed = _RIDGE * np.eye(len(every))
    fixed[n:, n:] += np.diag(prior / size[n:] ** 2)
    rough = np.zeros_like(fixed)
    rough[:n, :n] = penalty * (n / np.trace(penalty))
    weights = [fixed + strength * rough for strength in _STRENGTHS]
    costs = [blocks.left_out(weight) for weight in weights]
    best = int(np.argmin([cost.sum() for cost in costs]))
    amplitudes = blocks.solved(weights[best])
    left = sum(blocks.left(amplitudes, b) for b in range(len(residual)))
    inverse = np.linalg.inv(blocks.square.sum(axis=0) + weights[best])
    scores = blocks.cross - blocks.square @ amplitudes
    covariance = inverse @ (scores.T @ scores) @ inverse
    covariance += max(1.0, left / residual.size) * inverse
    return Smoothed(
        amplitudes=amplitudes[:n] / size[:n],
        common=amplitudes[n:] / size[n:],
        covariance=covariance[:n, :n] / np.outer(size[:n], size[:n]),
        left=left,
        left_out=costs[best],
    )


def _scaled(columns: FloatArray, common: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return all columns and their sizes: one for those that are smooth, else one for each."""
    every = np.concatenate([columns, common])
    size = np.sqrt(np.sum(every**2, axis=(1, 2)))
    size[: len(columns)] = np.sqrt(np.mean(size[: len(columns)] ** 2))
    size = np.where(size > 0.0, size, 1.0)
    return every / size[:, None, None], size
