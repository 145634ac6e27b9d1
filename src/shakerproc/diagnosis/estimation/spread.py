"""How far the numbers of a fit may be from the truth.

A force that jumps, or a motion that parts from its neighbours, gives the cost many least values
side by side. The search ends in one of them, and the slopes there tell how steep the cost is
but not how far the next one lies.
"""

from dataclasses import replace
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.normal_equations import NormalEquations
from shakerproc.diagnosis.estimation.point import Point
from shakerproc.diagnosis.estimation.residual_slopes import Linearisation
from shakerproc.diagnosis.estimation.scatter import covariance
from shakerproc.diagnosis.estimation.uncertain import Uncertainty
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
        equations = NormalEquations(linearisation, at, slopes, known_spread(linearisation))
        inverse = equations.inverted()
        self.covariance, wider = covariance(inverse, equations.clusters(slopes))
        self._student = self.covariance * np.outer(wider, wider)
        louder = equations.pulled_by(slopes, _by_input(linearisation, at))
        self._by_input = inverse @ louder
        self._by_known = inverse * equations.prior

    def uncertainty(self) -> Uncertainty:
        r"""Return standard deviations by source: the tests, the calibration, numbers untested.

        An estimate under the information :math:`A = J^T W J + P`, where :math:`P` holds what
        was known beforehand of gains and numbers, departs from the truth by

        .. math:: \hat x - x = A^{-1} \left(J^T W e + P m
            - J^T W \frac{\partial r}{\partial g} d\right)

        with the noise :math:`e` of the tests, what was known beforehand being off by :math:`m`,
        and the gain of the input, which is taken as it is, by :math:`d`. So a gain that the fit
        tells is not counted again: only as far as its prior holds the numbers. Noise counts by
        Student's law, as far away as the cost can tell.
        """
        linearisation, at = self._linearisation, self._at
        n, n_sensors = at.x.size, at.gain.size
        of_input, of_sensors = linearisation.data.gain_spreads
        off = known_spread(linearisation)
        off[n : n + n_sensors] = of_sensors  # one may have been taken as it is
        moved = self._by_known * off
        beforehand, channels, of_tests = np.split(moved, [n, n + 2 * n_sensors], axis=1)
        channels = np.column_stack([channels, of_input * self._by_input])
        return Uncertainty(
            tests=self._student * self.reach() ** 2 + of_tests @ of_tests.T,
            calibration=channels @ channels.T,
            beforehand=beforehand @ beforehand.T,
        )

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


def known_spread(linearisation: Linearisation) -> FloatArray:
    """Return prior standard deviations of the numbers, (n,) array.

    That of an effect lies anywhere between its bounds.
    """
    spread = linearisation.spread.copy()
    anywhere = (linearisation.high - linearisation.low) / np.sqrt(12.0)
    n = anywhere.size
    spread[:n] = np.where(np.isfinite(spread[:n]), spread[:n], anywhere)
    return spread


def _by_input(linearisation: Linearisation, at: Point) -> list[FloatArray]:
    """Return the slopes of the residual of every stack by one gain of all inputs."""
    step, tests = linearisation.step, linearisation.data.tests
    softer, louder = (
        linearisation.of_tests(replace(test, input=gain * test.input) for test in tests)
        for gain in (1.0 - step, 1.0 + step)
    )
    here, there = (one.predict(at, evened=True) for one in (softer, louder))
    return linearisation.differences(at.gain / (2.0 * step), here, there)


def drawn_steps(covariance: FloatArray, count: int) -> FloatArray:
    """Return steps of a standard error in directions drawn by chance, (count, n) array [-]."""
    axes = axes_of(covariance)
    steps: FloatArray = np.random.default_rng(0).standard_normal((count, len(axes))) @ axes
    return steps


def axes_of(covariance: FloatArray) -> FloatArray:
    """Return a standard error along each axis of a covariance, a row each, (n, n) array [-].

    0 along those that the tests do not tell: far away they would show.
    """
    power, directions = np.linalg.eigh(0.5 * (covariance + covariance.T))
    power = np.where(power < TOLD**2, np.maximum(power, 0.0), 0.0)
    return np.asarray((directions * np.sqrt(power)).T)


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
        size = scipy.fft.next_fast_len(2 * row.shape[1], real=True)
        spectrum = np.abs(scipy.fft.rfft(row, size, axis=1)) ** 2
        squared += 2.0 * float(np.sum(spectrum**2)) / size
        power += float(np.sum(np.sum(row**2, axis=1) ** 2))
    return max(1.0, squared / power) if power > 0.0 else 1.0
