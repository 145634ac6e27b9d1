"""How far the numbers of a fit may be from the truth.

A force that jumps, or a motion that parts from its neighbours, gives the cost many least values
side by side. The search ends in one of them, and the slopes there tell how steep the cost is
but not how far the next one lies.
"""

from dataclasses import replace
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.correlation import correlation_of
from shakerproc.diagnosis.estimation.normal_equations import NormalEquations
from shakerproc.diagnosis.estimation.point import Point
from shakerproc.diagnosis.estimation.residual_slopes import (
    AS_IT_IS,
    GAIN_SPREAD,
    STEP,
    Linearisation,
)
from shakerproc.diagnosis.estimation.residuals import Predicted, predict
from shakerproc.diagnosis.estimation.scatter import covariance, wider_by
from shakerproc.errors import DiagnosisError

PAIRS: Final = 4
"""Steps, each forth and back, that tell how the cost rises: its scatter to a quarter [-]."""

TOLD: Final = 1.0
"""Standard deviation of a coordinate, the logarithm of most numbers, from which the tests do
not tell it: a factor of e [-]."""

AT_BOUND: Final = 1e-6
"""Distance from a bound within which a coordinate stands at it [-]."""

WIDEST: Final = 32.0
"""Largest reach that is looked for [-]."""


@final
class Spread:
    """How far the numbers of a fit may be from the truth.

    Parameters
    ----------
    linearisation : Linearisation
        What is fitted to what.
    at : Point
        Where the search ended.

    Attributes
    ----------
    covariance : (n, n) array
        Covariance of x, gains, delays and numbers of tests (see `scatter.covariance`).

    Raises
    ------
    DiagnosisError
        If the motion runs away there.
    """

    def __init__(self, linearisation: Linearisation, at: Point) -> None:
        state = linearisation.residual(at)
        if state is None:
            kinds = "+".join(linearisation.hypothesis.kinds)
            raise DiagnosisError(f"{kinds}: its motion runs away.")
        linearisation.correlation = correlation_of(state[0])
        self._linearisation, self._at = linearisation, at
        self._here = linearisation.cost(state[0], at)
        slopes = linearisation.linearise(at, state)
        equations = NormalEquations(linearisation, at, slopes)
        inverse = equations.inverted()
        self.covariance, wider = covariance(inverse, equations.clusters(slopes))
        self._student = self.covariance * np.outer(wider, wider)
        self._by_input = equations.moved_by(slopes, _by_input(linearisation, at, state[1]))

    def widened(self) -> FloatArray:
        """Return the covariance, 1.96 of whose standard deviations are the bound, (n, n) array.

        That of Student's law, as far as the cost can tell, and what the calibration of the
        input leaves open. Nothing tells its gain; but its sensor may be off by as much as
        those of the responses are beside it.
        """
        moved = self._by_input
        calibration = self._calibration() ** 2 * np.outer(moved, moved)
        return self._student * self.reach() ** 2 + calibration

    def _calibration(self) -> float:
        """Return how far the gain of the input may be from 1, as a standard deviation [-].

        As those of the responses are, but for their errors: of few sensors Student's law says
        how much further, up to the tolerance of sensors. One that is taken as it is tells
        nothing.
        """
        gain, n = self._at.gain, self._at.x.size
        rows = slice(n, n + gain.size)
        told = self._linearisation.spread[rows] > AS_IT_IS
        if not np.any(told):
            return 0.0
        errors = np.diag(self.covariance)[rows]
        square = float(np.mean(((gain - 1.0) ** 2 - errors)[told]))
        seen = float(np.sqrt(max(square, 0.0)))
        return min(seen * float(wider_by(float(np.sum(told)))), max(seen, GAIN_SPREAD))

    def reach(self) -> float:
        """Return how many standard errors away the cost is surely higher, 1 at least [-].

        Of steps of so many, in directions drawn by chance, the mean rise exceeds the scatter
        between forth and back. Next to the least value of a smooth cost it does at once.
        """
        steps, reach = self._steps(), 1.0
        while reach < WIDEST and not self._rises(reach, steps):
            reach *= 2.0
        return reach

    def _steps(self) -> FloatArray:
        """Return steps of a standard error of what stands at no bound, (PAIRS, n_x) array."""
        x, low, high = self._at.x, self._linearisation.low, self._linearisation.high
        free = (x > low + AT_BOUND) & (x < high - AT_BOUND)
        return drawn_steps(self._student[: x.size, : x.size] * np.outer(free, free), PAIRS)

    def _rises(self, reach: float, steps: FloatArray) -> bool:
        """Return whether the cost is surely higher so many standard errors away."""
        pairs = [(self._cost(reach * step), self._cost(-reach * step)) for step in steps]
        costs = np.array([pair for pair in pairs if np.all(np.isfinite(pair))])
        if not costs.size:
            return True
        scatter = np.sqrt(0.5 * np.mean((costs[:, 0] - costs[:, 1]) ** 2))
        return bool(np.mean(costs) - self._here > scatter)

    def _cost(self, step: FloatArray) -> float:
        """Return the cost a step away; infinite where the motion runs away."""
        linearisation, at = self._linearisation, self._at
        x = np.clip(at.x + step, linearisation.low, linearisation.high)
        state = linearisation.residual(replace(at, x=x))
        return np.inf if state is None else state[2]


def _by_input(
    linearisation: Linearisation, at: Point, predicted: Predicted
) -> list[FloatArray]:
    """Return the slopes of the residual of every stack by one gain of all inputs."""
    data = linearisation.data
    tests = [replace(test, input=(1.0 + STEP) * test.input) for test in data.tests]
    louder, model = replace(data, tests=tuple(tests)), linearisation.hypothesis.model_at(at.x)
    here = linearisation.evened(at, predicted)
    there = predict(louder, model, linearisation.windows, at.starts, at.of_tests, evened=True)
    return linearisation.differences(at.gain / STEP, here, there)


def drawn_steps(covariance: FloatArray, count: int, *, least: float = 0.0) -> FloatArray:
    """Return steps of a standard error in directions drawn by chance, (count, n) array [-].

    What the tests do not tell stays as it is: far away it would show.

    Parameters
    ----------
    covariance : (n, n) array
        Of the coordinates.
    count : int
        How many.
    least : float
        Standard deviation that each direction has besides [-].
    """
    power, directions = np.linalg.eigh(0.5 * (covariance + covariance.T))
    power = np.where(power < TOLD**2, np.maximum(power, 0.0) + least**2, 0.0)
    normal = np.random.default_rng(0).standard_normal((count, power.size))
    steps: FloatArray = (normal * np.sqrt(power)) @ directions.T
    return steps
