"""Tests that took no part in a fit, and what each has of its own."""

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.estimation.of_tests import spreads_of
from shakerproc.diagnosis.estimation.parts import Windows
from shakerproc.diagnosis.estimation.point import Point, State
from shakerproc.diagnosis.estimation.residual_slopes import Linearisation
from shakerproc.diagnosis.estimation.steps import SETTLED

ROUNDS: Final = 8
"""Steps at most: few numbers, next to those of the other tests [-]."""


def with_tests_fitted(data: DataSet, found: Fit, fitted: Windows) -> Fit:
    """Return a fit whose numbers stand, with those of tests that took no part in it fitted.

    To the windows that it has. Nothing before a test tells how stiff a joint is then; few
    numbers of so many samples let no law seem better than it is.

    Parameters
    ----------
    data : DataSet
        The tests.
    found : Fit
        With its windows, and their starts.
    fitted : Windows
        What it was fitted to.
    """
    others = np.setdiff1d(found.windows.table[:, 0], fitted.table[:, 0])
    if not others.size:
        return found
    linearisation = Linearisation(data, found.hypothesis, found.windows)
    here = linearisation.point_with(found.x, found.channels, found.starts)
    state = linearisation.residual(here)
    for _ in range(ROUNDS):
        if state is None:
            break
        there = replace(here, of_tests=_stepped(linearisation, here, state, others))
        tried = linearisation.residual(there)
        if tried is None or tried[2] > state[2] - SETTLED:
            break
        here, state = there, tried
    return replace(found, of_tests=here.of_tests)


def _stepped(
    linearisation: Linearisation, at: Point, state: State, others: NDArray[np.int64]
) -> FloatArray:
    """Return the numbers of tests a step of Gauss and Newton further, of some tests."""
    residual, predicted, _ = state
    spread = spreads_of(linearisation.data)
    n_tests = spread.shape[1]
    columns = list(linearisation.by_tests(at, linearisation.evened(at, predicted)))
    stepped = at.of_tests.copy()
    for test in others:
        prior = linearisation.correlation / spread[:, test] ** 2
        normal, score = np.diag(prior), prior * at.of_tests[:, test]
        own = columns[test::n_tests]
        for i, rows in enumerate(residual):
            root = linearisation.weights(rows).ravel()
            slopes = root[:, None] * np.stack([column[i].ravel() for column in own], axis=1)
            normal += slopes.T @ slopes
            score += slopes.T @ (root * rows.ravel())
        stepped[:, test] -= np.linalg.solve(normal, score)
    return stepped
