"""Levenberg-Marquardt on the free-run residual, with the starts of windows eliminated.

References
----------
.. [1] J. J. More, "The Levenberg-Marquardt algorithm: implementation and theory", Lecture Notes
   in Mathematics 630, Springer, 1978.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import final

import numpy as np

from shakerproc.comparison.noise import EXCESS
from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.normal_equations import NormalEquations
from shakerproc.diagnosis.estimation.of_tests import offsets_in, spreads_of
from shakerproc.diagnosis.estimation.parts import Windows
from shakerproc.diagnosis.estimation.point import Channels, Point, State
from shakerproc.diagnosis.estimation.residual_slopes import RUNAWAY, STEP, Linearisation
from shakerproc.diagnosis.estimation.spread import Spread, axes_of, correlation_of
from shakerproc.diagnosis.estimation.steps import SETTLED, better, by_chords
from shakerproc.diagnosis.estimation.uncertain import Uncertainty
from shakerproc.diagnosis.estimation.window_starts import with_best_starts
from shakerproc.diagnosis.hypotheses.hypothesis import Hypothesis
from shakerproc.errors import ModelError


@final
@dataclass(frozen=True, eq=False)
class Fit:
    """A hypothesis fitted to windows.

    Attributes
    ----------
    data : DataSet
        The tests.
    hypothesis : Hypothesis
        What was fitted.
    x : (n_x,) array
        Its coordinates.
    gain, delay : (n_sensors,) array
        Gain of each sensor [-] and its delay [s].
    of_tests : (n, n_tests) array
        What each test has of its own (see `of_tests.spreads_of`); the mean of the others for
        one that was not fitted to: amplifiers, force sensors and joints drift slowly [-].
    windows : Windows
        What it was fitted to.
    starts : (n_windows, 2 n_masses) array or None
        Motion where windows begin.
    cost : float
        Twice the negative logarithm of likelihood and prior [-].
    rows : (n_blocks,) array
        Mean square of the residual over the noise in every block [-].
    chi_square : float
        Mean square of the residual over the noise [-].
    count : int
        Residuals [-].
    converged : bool
        Whether the last step changed the cost by next to nothing.
    failed : int
        Windows that ran away.
    steps : (n_x,) array
        How far the search moved last: over what slopes are taken if it goes on [-].
    """

    data: DataSet
    hypothesis: Hypothesis
    x: FloatArray
    gain: FloatArray
    delay: FloatArray
    of_tests: FloatArray
    windows: Windows
    starts: FloatArray | None
    cost: float
    rows: FloatArray
    chi_square: float
    count: int
    converged: bool
    failed: int
    steps: FloatArray

    @cached_property
    def settled(self) -> "dict[tuple[DataSet, Windows], Fit | None]":
        """Starts that `with_starts_fitted` has fitted so far."""
        return {}

    @cached_property
    def level(self) -> float:
        """Mean logarithm of 1 + the rows [-].

        What fits of different hypotheses to the same windows are compared by.
        """
        return float(np.mean(np.log1p(self.rows)))

    @property
    def channels(self) -> Channels:
        """Gains, delays and numbers of tests."""
        return self.gain, self.delay, self.of_tests

    @property
    def follows_most(self) -> bool:
        """Whether it leaves no more than noise of most blocks, however much of the rest."""
        return float(np.median(self.rows)) <= EXCESS**2

    @property
    def is_far(self) -> bool:
        """Whether a number of the model is not its own any more (see `Hypothesis.far`)."""
        return bool(np.any(self.hypothesis.far(self.x)))

    @property
    def covariance(self) -> FloatArray:
        """Covariance of x, gains, delays and numbers of tests, (n, n) array.

        See `scatter.covariance`.

        Raises
        ------
        DiagnosisError
            If the motion runs away.
        """
        return self._spread.covariance

    @cached_property
    def uncertainty(self) -> Uncertainty:
        """Standard deviations of these, each with its source (see `Spread.uncertainty`)."""
        return self._spread.uncertainty()

    def numbers_apart(self) -> FloatArray:
        """Return the numbers a standard error away along each axis of their covariance.

        An (n_x, n_x) array, a row for each axis; what no test tells stays as it is.
        """
        low, high = self.hypothesis.bounds()
        return np.clip(
            self.x + axes_of(self._spread.covariance[: self.x.size, : self.x.size]), low, high
        )

    @cached_property
    def _spread(self) -> Spread:
        linearisation = Linearisation(self.data, self.hypothesis, self.windows, fine=True)
        return Spread(
            linearisation, linearisation.point_with(self.x, self.channels, self.starts)
        )


def fit(
    data: DataSet,
    hypothesis: Hypothesis,
    x: FloatArray,
    windows: Windows,
    *,
    rounds: int,
    channels: Channels | None = None,
    starts: FloatArray | None = None,
    step: float | FloatArray = STEP,
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
    channels : Channels, optional
        Gains, delays and numbers of tests to start from; 1, 0 and 0.
    starts : array, optional
        Starts of windows to begin with; the measured ones.
    step : float or (n_x,) array
        Change of the coordinates for slopes at first; later as far as the search moves [-].
    """
    linearisation = Linearisation(data, hypothesis, windows)
    begun = _begun(linearisation, x, channels or perfect(data), starts)
    return None if begun is None else _sought(linearisation, begun, rounds, step)


def gone_on(found: Fit, *, rounds: int) -> Fit:
    """Return a fit that goes on where its steps ended; itself where that runs away.

    Parameters
    ----------
    found : Fit
        Where it begins.
    rounds : int
        Steps at most.
    """
    last = fit(
        found.data, found.hypothesis, found.x, found.windows, rounds=rounds,
        channels=found.channels, starts=found.starts, step=found.steps,
    )  # fmt: skip
    return found if last is None else last


def fit_plainly(found: Fit, *, rounds: int) -> Fit | None:
    """Return a fit that goes on by squares as they are, however large in a few blocks.

    Parameters
    ----------
    found : Fit
        Where it begins.
    rounds : int
        Steps at most.
    """
    linearisation = Linearisation(found.data, found.hypothesis, found.windows, plain=True)
    begun = _begun(linearisation, found.x, found.channels, found.starts)
    return None if begun is None else _sought(linearisation, begun, rounds, STEP)


def _sought(
    linearisation: Linearisation,
    begun: tuple[Point, State],
    rounds: int,
    step: float | FloatArray,
) -> Fit | None:
    """Return where steps from a beginning lead; None where it runs away."""
    here, (residual, predicted, _) = begun
    linearisation.correlation = correlation_of(residual)
    cost = linearisation.cost(residual, here)
    damping, converged = 1e-3, False
    steps = np.broadcast_to(step, here.x.shape)
    for _ in range(rounds):
        slopes = linearisation.linearise(here, (residual, predicted, cost), steps=steps)
        there = better(NormalEquations(linearisation, here, slopes), cost, damping)
        fallen, change = 0.0, np.zeros_like(here.x)
        if there is not None:
            if linearisation.data.model.structures:
                there = by_chords(linearisation, slopes, there)
            change = np.abs(there[0].x - here.x)
            here, (residual, predicted, reached), damping = there
            fallen = cost - reached
            linearisation.correlation = correlation_of(residual)
            cost = linearisation.cost(residual, here)
        settled = fallen < SETTLED
        converged = settled and bool(np.all(steps <= STEP))
        if converged:
            break
        steps = np.full(change.size, STEP) if settled else np.clip(change, STEP, steps)
    count = sum(r.size for r in residual)
    chi_square = sum(float(np.sum(r**2)) for r in residual) / count
    if chi_square > RUNAWAY**2:
        return None
    return Fit(
        linearisation.data,
        linearisation.hypothesis,
        here.x,
        here.gain,
        here.delay,
        _expected(linearisation.data, here.of_tests, linearisation.windows),
        linearisation.windows,
        here.starts,
        cost=cost,
        rows=linearisation.blocks(residual, here),
        chi_square=chi_square,
        count=count,
        converged=converged,
        failed=int(predicted.failed.sum()),
        steps=steps,
    )


def _begun(
    linearisation: Linearisation, x: FloatArray, channels: Channels, starts: FloatArray | None
) -> tuple[Point, State] | None:
    """Return where a fit begins, its windows at the best of their starts; None if it cannot."""
    try:
        here = linearisation.point(x, channels)
    except ModelError:
        return None
    if starts is not None:
        here = replace(here, starts=starts)
    state = linearisation.residual(here)
    return None if state is None else with_best_starts(linearisation, here, state)


def _expected(data: DataSet, of_tests: FloatArray, windows: Windows) -> FloatArray:
    """Return numbers of every test, of those that took no part the mean of the others.

    Not of offsets, which are those of one recording.
    """
    fitted = np.isin(np.arange(of_tests.shape[1]), windows.table[:, 0])
    mean = np.repeat(np.mean(of_tests[:, fitted], axis=1, keepdims=True), fitted.size, axis=1)
    offsets_in(data, mean)[:] = 0.0
    return np.where(fitted, of_tests, mean)


def perfect(data: DataSet) -> Channels:
    """Return the settings of ideal sensors in tests without differences."""
    n = data.n_sensors
    return np.ones(n), np.zeros(n), np.zeros_like(spreads_of(data))
