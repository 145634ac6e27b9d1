"""The search of a few unknowns within limits, against scipy's."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy import optimize

from shakerproc.spectra.peaks.bounded_squares import least_squares

TIME = np.linspace(0.0, 4.0, 50)


def decay(point):
    """An oscillation that dies away: logarithms of frequency and of damping ratio."""
    omega, ratio = np.exp(point)
    return np.exp(-ratio * omega * TIME) * np.cos(omega * TIME)


def slopes_of(residual):
    def jacobian(point):
        steps = 1e-6 * np.eye(point.size)
        return np.column_stack([
            (residual(point + step) - residual(point - step)) / 2e-6 for step in steps
        ])

    return jacobian


@settings(max_examples=40, deadline=None)
@given(
    shift=st.floats(-0.15, 0.15),
    ratio=st.floats(0.01, 0.3),
    times=st.floats(0.3, 3.0),
    seed=st.integers(0, 1000),
)
def test_finds_scipys_minimum(shift, ratio, times, seed):
    truth = np.log([5.0, ratio])
    values = decay(truth) + 0.01 * np.random.default_rng(seed).standard_normal(TIME.size)
    start, apart = truth + np.array([shift, np.log(times)]), np.array([1.0, 4.0])
    lower, upper = truth - apart, truth + apart

    def residual(point):
        return decay(point) - values

    theirs = optimize.least_squares(
        residual, start, slopes_of(residual), bounds=(lower, upper), xtol=1e-12, ftol=1e-12
    )
    ours = least_squares(residual, slopes_of(residual), start, lower, upper, 60, 1e-8)
    assert ours.converged
    assert_allclose(ours.point, theirs.x, rtol=0, atol=1e-5)


@pytest.mark.parametrize("limit", [-0.5, 0.25])
def test_a_minimum_outside_the_limits_is_sought_on_them_and_told(limit):
    def residual(point):  # Rosenbrock's valley, least at (1, 1)
        return np.array([10.0 * (point[1] - point[0] ** 2), 1.0 - point[0]])

    lower, upper = np.array([-2.0, -2.0]), np.array([limit, 2.0])
    start = np.array([-1.2, 1.0])
    theirs = optimize.least_squares(residual, start, bounds=(lower, upper), xtol=1e-14)
    ours = least_squares(residual, slopes_of(residual), start, lower, upper, 200, 1e-10)
    assert not ours.converged
    assert_allclose(ours.point, theirs.x, rtol=0, atol=1e-4)
    assert ours.point[0] == limit


def test_a_residual_without_slope_does_not_converge():
    ends = np.array([-1.0]), np.array([1.0])
    found = least_squares(
        lambda _: np.ones(3), lambda _: np.zeros((3, 1)), np.zeros(1), *ends, 60, 1e-4
    )
    assert not found.converged


def test_it_gives_up_after_as_many_steps_as_it_may_take():
    def residual(point):
        return np.array([10.0 * (point[1] - point[0] ** 2), 1.0 - point[0]])

    ends = np.full(2, -5.0), np.full(2, 5.0)
    found = least_squares(residual, slopes_of(residual), np.full(2, -2.0), *ends, 3, 1e-10)
    assert not found.converged
