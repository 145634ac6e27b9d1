"""Residuals of a hypothesis over the noise, what they cost, and their slopes."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.residuals import (
    BLOCK_S,
    TAPS,
    DataSet,
    Predicted,
    Windows,
    difference,
    predict,
    weighted,
)
from shakerproc.diagnosis.hypotheses.hypothesis import Hypothesis
from shakerproc.errors import ModelError

STEP: Final = 1e-4
"""Change of a coordinate for slopes: the engine's 1e-6 makes them right to a per cent [-]."""

GAIN_SPREAD: Final = 0.01
"""Standard deviation of the gain of a sensor: the tolerance of data sheets [-]."""

DELAY_SPREAD: Final = 20e-6
"""Standard deviation of the delay of a channel: a tenth of a sample at 5 kHz [s]."""

RUNAWAY: Final = 1e6
"""Residual, in standard deviations, that stands for a window that ran away [-]."""

State: TypeAlias = tuple[list[FloatArray], Predicted, float]
"""Residuals of every window, the prediction, and the cost with the prior."""


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
    starts : (n_windows, 2 n_masses) array or None
        Motion where windows begin.
    """

    x: FloatArray
    gain: FloatArray
    delay: FloatArray
    starts: FloatArray | None


@final
@dataclass(frozen=True, slots=True, eq=False)
class Linearised:
    """Residual of every window and its slopes.

    Attributes
    ----------
    residual : list of (n_residuals,) array
        Over the noise [-].
    slopes : list of (n_residuals, n) array
        By coordinates, gains and delays.
    own : list of (n_residuals, n_starts) array
        By the window's own start, over its scales.
    failed : (n_windows,) array of bool
        Which windows ran away.
    """

    residual: list[FloatArray]
    slopes: list[FloatArray]
    own: list[FloatArray]
    failed: NDArray[np.bool_]


@final
class Linearisation:
    """Residuals of one hypothesis on one set of windows, their cost, and their slopes.

    Parameters
    ----------
    data : DataSet
        The tests.
    hypothesis : Hypothesis
        What is fitted.
    windows : Windows
        What it is fitted to.

    Attributes
    ----------
    low, high : (n_x,) array
        Bounds of the coordinates.
    correlation : float
        How many neighbouring residuals are worth one independent one, at least 1 [-].
    spread : (n,) array
        What coordinates, gains and delays are known to beforehand, as standard deviations.
    """

    def __init__(self, data: DataSet, hypothesis: Hypothesis, windows: Windows) -> None:
        self.data, self.hypothesis, self.windows = data, hypothesis, windows
        self.low, self.high = hypothesis.bounds()
        self.correlation = 1.0
        rate = data.tests[0].sample_rate
        self.cluster = BLOCK_S * rate * data.n_sensors
        self.block = BLOCK_S * rate if windows.starts is None else np.inf
        self.spread = np.concatenate([
            hypothesis.prior_spread(),
            np.full(data.n_sensors, GAIN_SPREAD),
            np.full(data.n_sensors, DELAY_SPREAD),
        ])

    def predict(self, x: FloatArray, starts: FloatArray | None) -> Predicted | None:
        """Return what the model says; None where no model can have these numbers."""
        try:
            model = self.hypothesis.model_at(x)
            return predict(self.data, model, self.windows, starts)
        except ModelError:
            return None

    def residual(self, at: Point) -> State | None:
        """Return residuals of every window, the prediction, and the cost with the prior."""
        predicted = self.predict(at.x, at.starts)
        if predicted is None or predicted.failed.all():
            return None
        rows = []
        for i, outputs in enumerate(predicted.outputs):
            if predicted.failed[i]:
                count = int(self.windows.counted[i][TAPS:].sum()) * len(outputs)
                rows.append(np.full(count, RUNAWAY))
                continue
            recorded = at.gain[:, None] * (outputs - at.delay[:, None] * self._rate(i, outputs))
            left = difference(self.data, self.windows, i, recorded)
            rows.append(weighted(self.data, self.windows, i, left))
        return rows, predicted, self.cost(rows, at)

    def cost(self, rows: list[FloatArray], at: Point) -> float:
        """Return twice the negative logarithm of likelihood and prior, but for a constant.

        What a model leaves is larger than noise, and not of one size, as long as physics is
        missing: every block has a scale of its own, which is estimated with it, so that one
        that cannot be predicted does not rule the sum. n residuals are worth as many as are
        independent.
        """
        each = sum(float(np.sum(np.log1p(self.scales(r)) * self.sizes(r))) for r in rows)
        return each / self.correlation + float(np.sum((self.values(at) / self.spread) ** 2))

    def level(self, rows: list[FloatArray]) -> float:
        """Return the mean logarithm of 1 + mean square, block by block [-]."""
        return float(np.mean(np.concatenate([np.log1p(self.scales(row)) for row in rows])))

    def sizes(self, row: FloatArray) -> FloatArray:
        """Return the number of residuals in each block of a window."""
        count = max(1, round(row.size / self.block))
        edges = np.linspace(0, row.size, count + 1).astype(int)
        return np.diff(edges).astype(float)

    def scales(self, row: FloatArray) -> FloatArray:
        """Return the mean square of each block of a window [-]."""
        sizes = self.sizes(row)
        first = np.concatenate([[0], np.cumsum(sizes)[:-1]]).astype(int)
        return np.add.reduceat(row**2, first) / sizes

    def weights(self, row: FloatArray) -> FloatArray:
        """Return the root of the weight of every residual: the slope of its block's cost."""
        root = 1.0 / np.sqrt(1.0 + self.scales(row))
        return np.repeat(root, self.sizes(row).astype(int))

    def values(self, at: Point) -> FloatArray:
        """Return x, gains and delays, each less what is expected of it."""
        return np.concatenate([at.x, at.gain - 1.0, at.delay])

    def _rate(self, index: int, outputs: FloatArray) -> FloatArray:
        """Return the slope of a window's outputs in time [unit of the sensor/s]."""
        test = int(self.windows.table[index, 0])
        rate: FloatArray = np.gradient(outputs, axis=1) * self.data.tests[test].sample_rate
        return rate

    def linearise(
        self,
        at: Point,
        residual: list[FloatArray],
        predicted: Predicted,
        *,
        physics: bool = True,
    ) -> Linearised:
        """Return the slopes of the residual; without `physics`, by the starts alone."""
        sizes = [row.size for row in residual]
        columns: list[list[FloatArray]] = [[] for _ in sizes]
        if physics:
            for change in self._by_coordinates(at, predicted, sizes):
                _append(columns, change)
            for i, outputs in enumerate(predicted.outputs):
                columns[i] += self._by_channels(at, i, outputs)
        own: list[list[FloatArray]] = [[] for _ in sizes]
        for change in self._by_starts(at, predicted, sizes):
            _append(own, change)
        return Linearised(
            residual,
            [_table(c, n, self.spread.size) for c, n in zip(columns, sizes, strict=True)],
            [_table(c, n, 0) for c, n in zip(own, sizes, strict=True)],
            predicted.failed,
        )

    def _by_coordinates(
        self, at: Point, here: Predicted, sizes: Sequence[int]
    ) -> Iterator[list[FloatArray]]:
        """Yield the slopes of all windows by each coordinate, away from its bound."""
        for k in range(at.x.size):
            step = STEP if at.x[k] + STEP <= self.high[k] else -STEP
            moved = at.x.copy()
            moved[k] += step
            there = self.predict(moved, at.starts)
            yield self._differences(at.gain / step, here, there, sizes)

    def _by_starts(
        self, at: Point, here: Predicted, sizes: Sequence[int]
    ) -> Iterator[list[FloatArray]]:
        """Yield the slopes of all windows by each number of their own start."""
        if at.starts is None or self.windows.scales is None:
            return
        for k, scale in enumerate(self.windows.scales):
            shifted = at.starts.copy()
            shifted[:, k] += STEP * scale
            there = self.predict(at.x, shifted)
            yield self._differences(at.gain / STEP, here, there, sizes)

    def _by_channels(self, at: Point, index: int, outputs: FloatArray) -> list[FloatArray]:
        """Return the slopes of a window by the gain, then by the delay, of each sensor."""
        found = []
        for rows in (-outputs, at.gain[:, None] * self._rate(index, outputs)):
            for s in range(at.gain.size):
                alone = np.zeros_like(rows)
                alone[s] = rows[s]
                found.append(weighted(self.data, self.windows, index, alone))
        return found

    def _differences(
        self,
        factor: FloatArray,
        here: Predicted,
        there: Predicted | None,
        sizes: Sequence[int],
    ) -> list[FloatArray]:
        """Return how the residual changes, times a factor of each sensor; 0 where it cannot."""
        if there is None:
            return [np.zeros(size) for size in sizes]
        found = []
        for i, size in enumerate(sizes):
            if here.failed[i] or there.failed[i]:
                found.append(np.zeros(size))
                continue
            change = factor[:, None] * (here.outputs[i] - there.outputs[i])
            found.append(weighted(self.data, self.windows, i, change))
        return found


def _append(columns: list[list[FloatArray]], one: list[FloatArray]) -> None:
    for own, column in zip(columns, one, strict=True):
        own.append(column)


def _table(columns: list[FloatArray], n_rows: int, n_columns: int) -> FloatArray:
    """Return columns side by side; zeros where there are none."""
    return np.array(columns).T if columns else np.zeros((n_rows, n_columns))


def correlation_of(rows: list[FloatArray]) -> float:
    """Return how many neighbouring residuals are worth one independent one, at least 1.

    References
    ----------
    .. [1] M. S. Bartlett, "On the theoretical specification and sampling properties of
       autocorrelated time-series", Journal of the Royal Statistical Society Supplement 8,
       27-41, 1946: the sum of the squared autocorrelation.
    """
    squared, power = 0.0, 0.0
    for row in rows:
        size = scipy.fft.next_fast_len(2 * row.size, real=True)
        spectrum = np.abs(scipy.fft.rfft(row, size)) ** 2
        squared += 2.0 * float(np.sum(spectrum**2)) / size
        power += float(np.sum(row**2)) ** 2
    return max(1.0, squared / power) if power > 0.0 else 1.0
