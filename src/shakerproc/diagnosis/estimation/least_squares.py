"""Levenberg-Marquardt on the free-run residual, with the starts of windows eliminated.

References
----------
.. [1] H. G. Bock, "Recent advances in parameter identification techniques for ODE", in
   "Numerical Treatment of Inverse Problems in Differential and Integral Equations",
   Birkhaeuser, 1983 (multiple shooting, elimination of local variables).
.. [2] J. J. More, "The Levenberg-Marquardt algorithm: implementation and theory", Lecture Notes
   in Mathematics 630, Springer, 1978.
"""

from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.residuals import (
    TAPS,
    DataSet,
    Predicted,
    Windows,
    difference,
    predict,
    weighted,
)
from shakerproc.diagnosis.estimation.windows import BLOCK_S
from shakerproc.diagnosis.hypotheses.hypothesis import Hypothesis
from shakerproc.errors import ModelError

STEP: Final = 1e-4
"""Difference of a coordinate for slopes: the engine's 1e-6 makes them right to a per cent [-]."""

GAIN_SPREAD: Final = 0.01
"""Standard deviation of the gain of a sensor: the tolerance of data sheets [-]."""

DELAY_SPREAD: Final = 20e-6
"""Standard deviation of the delay of a channel: a tenth of a sample at 5 kHz [s]."""

LONGEST_STEP: Final = 0.7
"""Largest change of a coordinate in one step: a factor of two of a logarithm [-]."""

SETTLED: Final = 0.1
"""Fall of the cost (twice a log likelihood) below which the search has arrived: a coordinate
then moves by less than a third of its standard error [-]."""

START_ROUNDS: Final = 3
"""Steps in which starts are fitted: they are measured already, and nearly linear [-]."""

RUNAWAY: Final = 1e6
"""Residual, in standard deviations, that stands for a window that ran away [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """A hypothesis fitted to windows.

    Attributes
    ----------
    hypothesis : Hypothesis
        What was fitted.
    x : (n_x,) array
        Its coordinates.
    gain, delay : (n_sensors,) array
        Gain of each sensor [-] and its delay [s].
    windows : Windows
        What it was fitted to.
    starts : (n_windows, 2 n_masses) array or None
        Motion where windows begin.
    cost : float
        Twice the negative logarithm of likelihood and prior [-].
    level : float
        Mean logarithm of 1 + mean square of the residual over the noise, block by block: what
        fits of different hypotheses to the same windows are compared by [-].
    chi_square : float
        Mean square of the residual over the noise [-].
    count : int
        Residuals [-].
    information : (n, n) array
        Of x, gains and delays, starts eliminated [-].
    scores : (n, n) array
        Covariance of the slopes of the cost, summed over blocks [-].
    converged : bool
        Whether the last step changed the cost by next to nothing.
    failed : int
        Windows that ran away.
    """

    hypothesis: Hypothesis
    x: FloatArray
    gain: FloatArray
    delay: FloatArray
    windows: Windows
    starts: FloatArray | None
    cost: float
    level: float
    chi_square: float
    count: int
    information: FloatArray
    scores: FloatArray
    converged: bool
    failed: int


@final
@dataclass(frozen=True, slots=True, eq=False)
class Point:
    """Where the search is."""

    x: FloatArray
    gain: FloatArray
    delay: FloatArray
    starts: FloatArray | None


@final
@dataclass(frozen=True, slots=True, eq=False)
class Linearised:
    """Residual of every window and its slopes by coordinates, channels, and own starts."""

    residual: list[FloatArray]
    slopes: list[FloatArray]
    own: list[FloatArray]
    failed: NDArray[np.bool_]


def fit(
    data: DataSet,
    hypothesis: Hypothesis,
    x: FloatArray,
    windows: Windows,
    *,
    rounds: int,
    channels: tuple[FloatArray, FloatArray] | None = None,
    starts: FloatArray | None = None,
) -> Fit | None:
    """Return a hypothesis fitted to windows from where x is; None where it runs away.

    Parameters
    ----------
    data : DataSet
        The tests.
    hypothesis : Hypothesis
        What is fitted.
    x : (n_x,) array
        Where to start.
    windows : Windows
        What it is fitted to.
    rounds : int
        Steps at most.
    channels : pair of (n_sensors,) arrays, optional
        Gains and delays to start from; 1 and 0.
    starts : array, optional
        Starts of windows to begin with; the measured ones.
    """
    n_sensors = data.accelerations.size
    gain, delay = channels or (np.ones(n_sensors), np.zeros(n_sensors))
    here = Point(x, gain, delay, windows.starts if starts is None else starts)
    search = _Search(data, hypothesis, windows)
    state = search.residual(here)
    if state is None:
        return None
    search.correlation = _correlation(state[0])
    residual, predicted, _ = state
    cost = search.cost(residual, here)
    damping, converged = 1e-3, False
    slopes = None
    for _ in range(rounds):
        slopes = search.linearise(here, residual, predicted)
        step = _Step(search, here, slopes)
        for _ in range(6):
            there = step.taken(damping)
            tried = search.residual(there)
            if tried is not None and tried[2] < cost:
                break
            damping *= 10.0
        else:
            converged = True
            break
        fall = cost - tried[2]
        here, (residual, predicted, cost) = there, tried
        search.correlation = _correlation(residual)
        cost = search.cost(residual, here)
        damping = max(damping / 10.0, 1e-9)
        if fall < SETTLED:
            converged = True
            break
    if slopes is None:
        slopes = search.linearise(here, residual, predicted, physics=rounds > 0)
    last = _Step(search, here, slopes)
    count = sum(r.size for r in residual)
    square = sum(float(np.sum(r**2)) for r in residual) / count
    return Fit(
        hypothesis, here.x, here.gain, here.delay, windows, here.starts, cost, search.level(residual), square, count,
        last.information, last.scores(slopes), converged, int(predicted.failed.sum()),
    )  # fmt: skip


def _correlation(rows: list[FloatArray]) -> float:
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


class _Search:
    """Residuals and slopes of one hypothesis on one set of windows."""

    def __init__(self, data: DataSet, hypothesis: Hypothesis, windows: Windows) -> None:
        self.data, self.hypothesis, self.windows = data, hypothesis, windows
        self.low, self.high = hypothesis.bounds()
        self.correlation = 1.0
        rate = data.tests[0].sample_rate
        self.cluster = BLOCK_S * rate * data.accelerations.size
        self.block = BLOCK_S * rate if windows.starts is None else np.inf
        self.spread = np.concatenate([
            hypothesis.prior_spread(),
            np.full(data.accelerations.size, GAIN_SPREAD),
            np.full(data.accelerations.size, DELAY_SPREAD),
        ])

    def predict(self, x: FloatArray, starts: FloatArray | None) -> Predicted | None:
        """Return what the model says; None where no model can have these numbers."""
        try:
            model = self.hypothesis.model_at(x)
            return predict(self.data, model, self.windows, starts)
        except ModelError:
            return None

    def residual(self, at: Point) -> tuple[list[FloatArray], Predicted, float] | None:
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
        n, n_sensors = len(self.windows), at.gain.size
        columns: list[list[FloatArray]] = [[] for _ in range(n)]
        own: list[list[FloatArray]] = [[] for _ in range(n)]
        for k in range(at.x.size if physics else 0):
            step = STEP if at.x[k] + STEP <= self.high[k] else -STEP
            moved = at.x.copy()
            moved[k] += step
            there = self.predict(moved, at.starts)
            for i in range(n):
                columns[i].append(self._slope(at, predicted, there, step, i, residual[i].size))
        for i, outputs in enumerate(predicted.outputs if physics else ()):
            rate = self._rate(i, outputs)
            for rows in (-outputs, at.gain[:, None] * rate):
                for s in range(n_sensors):
                    alone = np.zeros_like(rows)
                    alone[s] = rows[s]
                    columns[i].append(weighted(self.data, self.windows, i, alone))
        if at.starts is not None and self.windows.scales is not None:
            for k, scale in enumerate(self.windows.scales):
                shifted = at.starts.copy()
                shifted[:, k] += STEP * scale
                there = self.predict(at.x, shifted)
                for i in range(n):
                    own[i].append(self._slope(at, predicted, there, STEP, i, residual[i].size))
        return Linearised(
            residual,
            [
                np.array(c).T if c else np.zeros((r.size, self.spread.size))
                for c, r in zip(columns, residual, strict=True)
            ],
            [
                np.array(o).T if o else np.zeros((r.size, 0))
                for o, r in zip(own, residual, strict=True)
            ],
            predicted.failed,
        )

    def _slope(
        self,
        at: Point,
        here: Predicted,
        there: Predicted | None,
        step: float,
        i: int,
        size: int,
    ) -> FloatArray:
        if there is None or here.failed[i] or there.failed[i]:
            return np.zeros(size)
        change = (here.outputs[i] - there.outputs[i]) / step
        return weighted(self.data, self.windows, i, at.gain[:, None] * change)


class _Step:
    """Normal equations of one linearisation, with the starts of windows eliminated."""

    def __init__(self, search: _Search, at: Point, slopes: Linearised) -> None:
        self.search, self.at = search, at
        n = search.spread.size
        finite = np.isfinite(search.spread)
        prior = np.where(finite, search.correlation / search.spread**2, 0.0)
        self.normal = np.diag(prior)
        self.score = prior * search.values(at)
        self.eliminated = np.zeros((n, n))
        self.kept: list[tuple[FloatArray, FloatArray, FloatArray]] = []
        share = np.zeros(n)
        for r, p, s, failed in zip(
            slopes.residual, slopes.slopes, slopes.own, slopes.failed, strict=True
        ):
            if failed:
                self.kept.append((np.zeros((0, 0)), np.zeros((0, n)), np.zeros(0)))
                continue
            root = search.weights(r)
            r, p, s = root * r, root[:, None] * p, root[:, None] * s  # noqa: PLW2901
            self.normal += p.T @ p
            self.score += p.T @ r
            own, mixed, left = s.T @ s, s.T @ p, s.T @ r
            self.kept.append((own, mixed, left))
            if own.size:
                inverse = np.linalg.pinv(own, hermitian=True)
                self.eliminated += mixed.T @ inverse @ mixed
                share += mixed.T @ inverse @ left
        self.reduced = self.score - share
        self.information = self.normal - self.eliminated

    def taken(self, damping: float) -> Point:
        """Return where a damped step leads, within bounds."""
        normal, score = self.normal.copy(), self.score.copy()
        inverses = []
        for own, mixed, left in self.kept:
            if not own.size:
                inverses.append(own)
                continue
            diagonal = np.diag(own)
            held = own + np.diag(damping * diagonal + 1e-12 * (diagonal.max() or 1.0))
            inverse = np.linalg.inv(held)
            inverses.append(inverse)
            normal -= mixed.T @ inverse @ mixed
            score -= mixed.T @ inverse @ left
        step = self._solved(normal, score, damping)
        n_x, n_s = self.at.x.size, self.at.gain.size
        change = np.clip(step[:n_x], -LONGEST_STEP, LONGEST_STEP)
        x = np.clip(self.at.x + change, self.search.low, self.search.high)
        moved = np.concatenate([x - self.at.x, step[n_x:]])
        gain = np.clip(self.at.gain + moved[n_x : n_x + n_s], 0.2, 5.0)
        return Point(x, gain, self.at.delay + moved[n_x + n_s :], self._starts(moved, inverses))

    def scores(self, slopes: Linearised) -> FloatArray:
        """Return the covariance of the slopes of the cost, from their scatter over blocks."""
        out = np.zeros_like(self.information)
        each = zip(slopes.residual, slopes.slopes, self.kept, slopes.own, strict=True)
        for r, p, (own, mixed, _), s in each:
            if (
                not mixed.size
                and own.size == 0
                and mixed.shape[0] == 0
                and not s.size
                and not r.size
            ):
                continue
            root = self.search.weights(r)
            left, columns = root * r, root[:, None] * p
            if own.size:
                columns = (
                    columns - (root[:, None] * s) @ np.linalg.pinv(own, hermitian=True) @ mixed
                )
            parts = max(1, round(r.size / min(self.search.cluster, r.size)))
            first = np.linspace(0, r.size, parts + 1).astype(int)[:-1]
            summed = np.add.reduceat(columns * left[:, None], first, axis=0)
            out += summed.T @ summed
        return out

    def starts_alone(self) -> Point:
        """Return where an undamped step of the starts leads, all else standing."""
        inverses = [
            np.linalg.pinv(own, hermitian=True) if own.size else own for own, _, _ in self.kept
        ]
        still = np.zeros(self.normal.shape[0])
        return replace(self.at, starts=self._starts(still, inverses))

    def _solved(self, normal: FloatArray, score: FloatArray, damping: float) -> FloatArray:
        """Return the damped step; what stands at a bound and is pushed out stays."""
        n_x = self.at.x.size
        free = np.ones(score.size, bool)
        at_low = (self.at.x <= self.search.low) & (score[:n_x] > 0.0)
        at_high = (self.at.x >= self.search.high) & (score[:n_x] < 0.0)
        free[:n_x] = ~(at_low | at_high)
        size = np.sqrt(np.maximum(np.diag(self.normal), 1e-300))
        scaled = normal / np.outer(size, size) + damping * np.eye(size.size)
        step = np.zeros(score.size)
        part = np.ix_(free, free)
        solution = np.linalg.lstsq(scaled[part], -(score / size)[free], rcond=1e-12)[0]
        step[free] = solution / size[free]
        return step

    def _starts(self, moved: FloatArray, inverses: list[FloatArray]) -> FloatArray | None:
        scales = self.search.windows.scales
        if self.at.starts is None or scales is None:
            return None
        starts = self.at.starts.copy()
        for i, (inverse, (own, mixed, left)) in enumerate(
            zip(inverses, self.kept, strict=True)
        ):
            if own.size:
                starts[i] += scales * np.clip(-inverse @ (left + mixed @ moved), -1.0, 1.0)
        return starts


def with_starts_fitted(data: DataSet, found: Fit, windows: Windows) -> Fit | None:
    """Return a fit whose numbers stand, with the starts of these windows fitted.

    Parameters
    ----------
    data : DataSet
        The tests.
    found : Fit
        Its coordinates and channels are kept as they are.
    windows : Windows
        Those of `windows.run_ins`: only what the starts are fitted to counts. Where all begin
        at rest there is nothing to fit.
    """
    if windows.starts is None or windows.run_in is None:
        return replace(found, windows=windows, starts=None)
    short = windows.run_in
    search = _Search(data, found.hypothesis, short)
    here = Point(found.x, found.gain, found.delay, short.starts)
    for _ in range(START_ROUNDS):
        state = search.residual(here)
        if state is None:
            return None
        step = _Step(search, here, search.linearise(here, state[0], state[1], physics=False))
        here = step.starts_alone()
    return replace(found, windows=windows, starts=here.starts)


def predicted_rows(data: DataSet, found: Fit, windows: Windows) -> FloatArray | None:
    """Return the mean square of the residual over the noise in every block [-]."""
    search = _Search(data, found.hypothesis, windows)
    state = search.residual(Point(found.x, found.gain, found.delay, found.starts))
    if state is None:
        return None
    return np.concatenate([search.scales(row) for row in state[0]])
