"""Regression of one column at a time beside common ones, cross-validated over blocks.

All that is needed are products of columns within blocks, so that leaving a block out costs
next to nothing.
"""

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray

_RIDGE: Final = 1e-12
"""Share of a column's own square that keeps the equations solvable [-]."""

_TINY: Final = 1e-300
"""Least sum of squares that is divided by [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Gains:
    """Explained part of some columns beside the common ones.

    Attributes
    ----------
    amplitude : (n,) array
        Of the column.
    common : (n, n_common) array
        Amplitudes of the common columns beside it.
    explained : (n,) array
        Share of what the common columns leave that it explains [-].
    predicted : (n,) array
        The same for blocks that took no part in the fit [-].
    t : (n,) array
        Mean over standard error of its gains in such blocks [-].
    """

    amplitude: FloatArray
    common: FloatArray
    explained: FloatArray
    predicted: FloatArray
    t: FloatArray


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Products:
    """Products of the common columns, of others and of the residual, for every block.

    Attributes
    ----------
    square, cross : (n_blocks, n_common, n_common) and (n_blocks, n_common) array
        Of the common columns with each other and with the residual.
    own, beside, shown : (n_blocks, n), (n_blocks, n, n_common) and (n_blocks, n) array
        Of each other column with itself, with the common ones and with the residual.
    """

    square: FloatArray
    cross: FloatArray
    own: FloatArray
    beside: FloatArray
    shown: FloatArray

    def some(self, blocks: list[int]) -> "_Products":
        """Return those of some blocks, added."""
        return _Products(
            *(
                part[blocks].sum(axis=0, keepdims=True)
                for part in (self.square, self.cross, self.own, self.beside, self.shown)
            )
        )

    def solved(self, prior: FloatArray, signs: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the amplitude of every column, and those of the common ones beside it."""
        both = np.linalg.solve(
            self.square[0] + prior, np.column_stack([self.cross[0], self.beside[0].T])
        )
        alone, turned = both[:, 0], both[:, 1:]
        left = self.own[0] - np.sum(self.beside[0].T * turned, axis=0)
        amplitude = (self.shown[0] - self.beside[0] @ alone) / np.maximum(left, _RIDGE)
        amplitude = np.where((signs > 0.0) & (amplitude < 0.0), 0.0, amplitude)
        return amplitude, alone - amplitude[:, None] * turned.T

    def lowered(self, amplitude: FloatArray, common: FloatArray) -> FloatArray:
        """Return by how much amplitudes lower the sum of squares, (n,) array."""
        gain = 2.0 * (common @ self.cross[0] + amplitude * self.shown[0])
        gain -= np.einsum("ni,ij,nj->n", common, self.square[0], common, optimize=True)
        gain -= 2.0 * amplitude * np.sum(self.beside[0] * common, axis=1)
        return np.asarray(gain - amplitude**2 * self.own[0])


def surely(gained: FloatArray) -> FloatArray:
    """Return sums of gains over their standard error, (...) array [-].

    0 of one block, whose scatter is not known.

    Parameters
    ----------
    gained : (n_blocks, ...) array
        By block.
    """
    if len(gained) < 2:
        return np.zeros(gained.shape[1:])
    scatter = gained.std(axis=0, ddof=1) * np.sqrt(len(gained))
    return np.asarray(gained.sum(axis=0) / np.maximum(scatter, _TINY))


@final
class Regression:
    """A residual and common columns, ready for more columns.

    Parameters
    ----------
    residual : (n_blocks, n_rows) array
        What is to be explained.
    common : (n_common, n_blocks, n_rows) array
        Columns of every regression.
    prior : (n_common,) array
        One over the variance of each common amplitude; 0 where nothing is known.
    """

    def __init__(self, residual: FloatArray, common: FloatArray, prior: FloatArray) -> None:
        self.common = common
        self.prior = prior
        self._size = _norms(common)
        self._common = common / self._size[:, None, None]
        self._residual = residual
        self._square = np.einsum("ibr,jbr->bij", self._common, self._common, optimize=True)
        self._cross = np.einsum("ibr,br->bi", self._common, residual, optimize=True)
        self._power = np.sum(residual**2, axis=1)
        self._prior = np.diag(prior / self._size**2 + _RIDGE)
        alone = self._alone(list(range(len(residual))))
        self.amplitudes: FloatArray = alone / self._size
        """Amplitudes of the common columns alone."""
        self.left: FloatArray = residual - np.tensordot(alone, self._common, 1)
        """What they leave, (n_blocks, n_rows) array."""

    def _alone(self, blocks: list[int]) -> FloatArray:
        """Return the amplitudes of the common columns, from some blocks."""
        square, cross = self._square[blocks].sum(axis=0), self._cross[blocks].sum(axis=0)
        return np.asarray(np.linalg.solve(square + self._prior, cross))

    @property
    def cost(self) -> float:
        """Sum of squares that the common columns leave."""
        return float(np.sum(self.left**2))

    def left_out(self) -> FloatArray:
        """Return the sum of squares of each block that the others leave of it."""
        blocks = range(len(self._power))
        alone = [self._alone([i for i in blocks if i != b]) for b in blocks]
        return np.array([
            self._power[b] - a @ (2.0 * self._cross[b] - self._square[b] @ a)
            for b, a in zip(blocks, alone, strict=True)
        ])

    def gains(self, columns: FloatArray, signs: FloatArray) -> Gains:
        """Return the explained part of each column, beside the common ones.

        Parameters
        ----------
        columns : (n, n_blocks, n_rows) array
            The columns, over the noise [-].
        signs : (n,) array
            1 where only an amplitude above 0 is physical, 0 where any is [-].
        """
        size = _norms(columns)
        products = _Products(
            square=self._square,
            cross=self._cross,
            own=np.sum(columns**2, axis=2).T / size**2,
            beside=np.einsum("nbr,ibr->bni", columns, self._common, optimize=True)
            / size[:, None],
            shown=np.einsum("nbr,br->bn", columns, self._residual, optimize=True) / size,
        )
        blocks = list(range(len(self._power)))
        whole = products.some(blocks)
        amplitude, common = whole.solved(self._prior, signs)
        left = np.sum(self._power) - whole.lowered(amplitude, common)
        folds = [self._left_out(products, block, signs) for block in blocks]
        gained = np.stack([fold[0] for fold in folds])
        return Gains(
            amplitude=amplitude / size,
            common=common / self._size,
            explained=1.0 - np.maximum(left, 0.0) / max(self.cost, _TINY),
            predicted=gained.sum(axis=0) / max(sum(fold[1] for fold in folds), _TINY),
            t=surely(gained),
        )

    def _left_out(
        self, products: _Products, block: int, signs: FloatArray
    ) -> tuple[FloatArray, float]:
        """Return how much each column lowers a block's sum of squares, and what that was.

        The block takes no part in the regression.
        """
        others = [i for i in range(len(self._power)) if i != block]
        there = products.some([block])
        lowered = there.lowered(*products.some(others).solved(self._prior, signs))
        alone = self._alone(others)
        before = 2.0 * alone @ there.cross[0] - alone @ there.square[0] @ alone
        return lowered - before, float(self._power[block] - before)


def _norms(columns: FloatArray) -> FloatArray:
    """Return the size of each column, 1 for a column of zeros."""
    size = np.sqrt(np.sum(columns**2, axis=(1, 2)))
    return np.asarray(np.where(size > 0.0, size, 1.0))
