"""Residuals of a hypothesis over the noise, what they cost, and their slopes."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.data import PreparedTest
from shakerproc.diagnosis.estimation.columns import (
    DELAY_SPREAD,
    FINE,
    FINE_STEP,
    append,
    by_channels,
    flat,
    table,
)
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.hidden_motion import completed, sizes
from shakerproc.diagnosis.estimation.of_tests import as_free, spreads_of
from shakerproc.diagnosis.estimation.parts import Windows
from shakerproc.diagnosis.estimation.point import Channels, Linearised, Point, State
from shakerproc.diagnosis.estimation.residuals import (
    TOLERANCE,
    Predicted,
    at_once,
    predict,
    shown,
)
from shakerproc.diagnosis.hypotheses.hypothesis import Hypothesis
from shakerproc.errors import ModelError

STEP: Final = 3e-4
"""Least change of a coordinate for slopes: the engine's 1e-5 makes them right to 3 % [-]."""

FARTHEST_STEP: Final = 1e-2
"""Change of a coordinate for slopes where nothing is known of how far it will move: where a
force jumps, those of a small change are spikes beside it, which a step passes by far [-]."""

AS_IT_IS: Final = 1e-6
"""The same of the first sensor where masses are free: with all other numbers these take any
gain that all sensors share, and nothing tells the one from the other [-]."""

RUNAWAY: Final = 1e6
"""Residual, in standard deviations, that stands for a window that ran away [-]."""


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
    plain : bool
        Whether squares count as they are, however large in a few blocks.
    fine : bool
        Whether slopes are those of a small change forth and back, as intervals need.

    Attributes
    ----------
    low, high : (n_x,) array
        Bounds of the coordinates.
    step : float
        Change of numbers for slopes [-].
    correlation : float
        How many neighbouring residuals are worth one independent one, at least 1 [-].
    spread : (n,) array
        What coordinates, gains, delays and numbers of tests are known to beforehand, as
        standard deviations.
    """

    def __init__(
        self,
        data: DataSet,
        hypothesis: Hypothesis,
        windows: Windows,
        *,
        plain: bool = False,
        fine: bool = False,
    ) -> None:
        self.data, self.hypothesis, self.windows = data, hypothesis, windows
        self._plain = plain
        self._fine, self.step = fine, FINE_STEP if fine else STEP
        self._tolerance = FINE if fine else TOLERANCE
        self.stacks = data.stacks(windows)
        self.low, self.high = hypothesis.bounds()
        self.correlation = 1.0
        self._sizes: FloatArray | None = None
        rate = data.tests[0].sample_rate
        self.cluster = data.lengths.cluster_s * rate * data.n_sensors
        self.block = data.lengths.block_s * rate
        gains = data.gain_spreads[1].copy()
        if hypothesis.frees_masses:
            gains[0] = AS_IT_IS
        self.spread = np.concatenate([
            hypothesis.prior_spread(),
            gains,
            np.full(data.n_sensors, DELAY_SPREAD),
            spreads_of(data).ravel(),
        ])

    def of_tests(self, tests: Iterable[PreparedTest]) -> "Linearisation":
        """Return the slopes of other tests, which differ in their excitation alone."""
        own, at = replace(self.data, tests=tuple(tests), near=self.data.inputs), self.windows
        return Linearisation(own, self.hypothesis, at, plain=self._plain, fine=self._fine)

    def point(self, x: FloatArray, channels: Channels) -> Point:
        """Return a point at which windows begin as was measured."""
        starts, table = None, self.windows.table
        if not self.windows.from_rest:
            starts = completed(self.data, self.hypothesis.model_at(x), table, channels[2])
        return self.point_with(x, channels, starts)

    def point_with(self, x: FloatArray, channels: Channels, starts: FloatArray | None) -> Point:
        """Return a point at which windows begin so."""
        gain, delay, of_tests = channels
        return Point(x, gain, delay, as_free(self.data, of_tests), starts)

    def sizes_of_starts(self, at: Point) -> FloatArray:
        """Return scales of changes of the numbers of a start [m], [m/s], [unit]."""
        if at.starts is None:
            return np.zeros(0)
        if self._sizes is None:
            self._sizes = sizes(self.data, self.hypothesis.model_at(at.x))
        return self._sizes

    def predict(self, at: Point, *, evened: bool = False) -> Predicted | None:
        """Return the prediction; None where no model can have these numbers."""
        try:
            model = self.hypothesis.model_at(at.x)
            return predict(
                self.data, model, self.windows, at.starts, at.of_tests,
                evened=evened, tolerance=self._tolerance,
            )  # fmt: skip
        except ModelError:
            return None

    def residual(self, at: Point) -> State | None:
        """Return residuals of every window, the prediction, and the cost with the prior."""
        predicted = self.predict(at)
        if predicted is None or predicted.failed.all():
            return None
        rows = []
        for stack in self.stacks:
            outputs = stack.of(predicted.outputs)
            late = at.delay[:, None] * stack.slope_in_time(outputs)
            recorded = at.gain[:, None] * (outputs - late)
            left = flat(stack.weighted(stack.measured - recorded))
            left[predicted.failed[stack.members]] = RUNAWAY
            rows.append(left)
        return rows, predicted, self.cost(rows, at)

    def cost(self, rows: list[FloatArray], at: Point) -> float:
        """Return twice the negative logarithm of likelihood and prior, but for a constant.

        What a model leaves is larger than noise, and not of one size, as long as physics is
        missing: every block has a scale of its own, which is estimated with it, so that one
        that cannot be predicted does not rule the sum. n residuals are worth as many as are
        independent.
        """
        if self._plain:
            each = sum(float(np.sum(r**2)) for r in rows)
        else:
            each = sum(float(np.sum(np.log1p(self.scales(r)) * self.sizes(r))) for r in rows)
        return each / self.correlation + float(np.sum((self.values(at) / self.spread) ** 2))

    def level(self, rows: list[FloatArray], at: Point) -> float:
        """Return the mean logarithm of 1 + mean square, block by block [-]."""
        return float(np.mean(np.log1p(self.blocks(rows, at))))

    def blocks(self, rows: list[FloatArray], at: Point) -> FloatArray:
        """Return the mean square of every block of every window [-].

        Over its degrees of freedom: where windows tell their own starts, a hypothesis with
        more that moves leaves less of any.
        """
        told = at.starts if self.windows.run_in is None else None
        n_starts = 0 if told is None else told.shape[1]
        return np.concatenate([
            self.scales(row).ravel() * row.shape[1] / max(1, row.shape[1] - n_starts)
            for row in rows
        ])

    def sizes(self, rows: FloatArray) -> FloatArray:
        """Return the number of residuals in each block of the windows of a stack."""
        count = max(1, round(rows.shape[1] / self.block))
        edges = np.linspace(0, rows.shape[1], count + 1).astype(int)
        return np.diff(edges).astype(float)

    def scales(self, rows: FloatArray) -> FloatArray:
        """Return the mean square of each block, (n_members, n_blocks) array [-]."""
        sizes = self.sizes(rows)
        first = np.concatenate([[0], np.cumsum(sizes)[:-1]]).astype(int)
        return np.add.reduceat(rows**2, first, axis=1) / sizes

    def weights(self, rows: FloatArray) -> FloatArray:
        """Return the root of the weight of every residual: the slope of its block's cost."""
        if self._plain:
            return np.ones_like(rows)
        root = 1.0 / np.sqrt(1.0 + self.scales(rows))
        return np.repeat(root, self.sizes(rows).astype(int), axis=1)

    def values(self, at: Point) -> FloatArray:
        """Return x, gains, delays and numbers of tests, less what is expected of each."""
        return np.concatenate([at.x, at.gain - 1.0, at.delay, at.of_tests.ravel()])

    def linearise(
        self, at: Point, state: State, *, physics: bool = True, steps: FloatArray | None = None
    ) -> Linearised:
        """Return the slopes of the residual; without `physics`, by the starts alone.

        They are those of chords over steps of the coordinates, `step` by default.
        """
        residual, predicted, _ = state
        here = self.evened(at, predicted)
        slopes: list[list[FloatArray]] = [[] for _ in self.stacks]
        if physics:
            for change in self._by_coordinates(at, here, steps):
                append(slopes, change)
            for columns, stack in zip(slopes, self.stacks, strict=True):
                columns.extend(by_channels(at, stack, stack.of(predicted.outputs)))
            for change in self.by_tests(at, here):
                append(slopes, change)
        own: list[list[FloatArray]] = [[] for _ in self.stacks]
        for change in self._by_starts(at, here):
            append(own, change)
        return Linearised(
            residual,
            [table(c, r, self.spread.size) for c, r in zip(slopes, residual, strict=True)],
            [table(c, r, 0) for c, r in zip(own, residual, strict=True)],
        )

    def evened(self, at: Point, predicted: Predicted) -> Predicted:
        """Return values that have slopes: expected means in place of values that jump."""
        if not self.data.points:
            return predicted
        return self.predict(at, evened=True) or predicted

    def _by_coordinates(
        self, at: Point, here: Predicted, steps: FloatArray | None
    ) -> Iterator[list[FloatArray]]:
        """Yield the slopes of all windows by each coordinate, away from its bound."""
        sizes = np.full(at.x.size, self.step) if steps is None else steps
        changes = np.where(at.x + sizes <= self.high, sizes, -sizes)
        points = (replace(at, x=at.x + row) for row in np.diag(changes))
        inside = self._fine & (at.x - sizes >= self.low) & (changes > 0.0)
        others = self._at_once(replace(at, x=at.x - row) for row in np.diag(changes)[inside])
        for step, both, there in zip(changes, inside, self._at_once(points), strict=True):
            width, other = (2.0 * step, next(others)) if both else (step, here)
            yield self.differences(at.gain / width, other, there)

    def _at_once(self, points: Iterable[Point]) -> Iterator[Predicted | None]:
        n_samples = int(self.windows.table[:, 2].sum())
        return at_once(lambda at: self.predict(at, evened=True), points, n_samples)

    def by_tests(self, at: Point, here: Predicted) -> Iterator[list[FloatArray]]:
        """Yield the slopes of all windows by the numbers of each test."""
        of_test = [self.windows.table[stack.members[0], 0] for stack in self.stacks]
        for k in range(len(at.of_tests)):
            shifted = at.of_tests.copy()
            shifted[k] += self.step
            seen = shown(self.data, self.windows, here, k, self.step)
            there = seen or self.predict(replace(at, of_tests=shifted), evened=True)
            change = self.differences(at.gain / self.step, here, there)
            for test in range(shifted.shape[1]):
                yield [
                    rows if own == test else np.zeros_like(rows)
                    for rows, own in zip(change, of_test, strict=True)
                ]

    def _by_starts(self, at: Point, here: Predicted) -> Iterator[list[FloatArray]]:
        """Yield the slopes of all windows by each number of their own start."""
        if at.starts is None:
            return
        steps = np.diag(self.step * self.sizes_of_starts(at))
        points = (replace(at, starts=at.starts + step) for step in steps)
        for there in self._at_once(points):
            yield self.differences(at.gain / self.step, here, there)

    def differences(
        self, factor: FloatArray, here: Predicted | None, there: Predicted | None
    ) -> list[FloatArray]:
        """Return how the residual changes, times a factor of each sensor; 0 where it cannot."""
        if here is None or there is None:
            return [np.zeros((s.members.size, s.size)) for s in self.stacks]
        found = []
        for stack in self.stacks:
            change = stack.of(here.outputs) - stack.of(there.outputs)
            rows = flat(stack.weighted(factor[:, None] * change))
            rows[(here.failed | there.failed)[stack.members]] = 0.0
            found.append(rows)
        return found
