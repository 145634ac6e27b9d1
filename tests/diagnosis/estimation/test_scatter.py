"""Covariance from the scatter between blocks, and between tests: against sums by hand."""

import numpy as np
import pytest

from shakerproc.diagnosis.estimation.scatter import Cluster, covariance, freedom_of, wider_by

TESTS, BLOCKS, SAMPLES = 6, 30, 20


def clusters_of(residual, columns):
    """Return blocks of a straight line's residual, (tests, blocks, samples) and (..., 2)."""
    return [
        Cluster(test, x.T @ x, x.T @ r)
        for test in range(TESTS)
        for x, r in zip(columns[test], residual[test], strict=True)
    ]


def drawn(seed, *, between):
    """Return blocks of a fitted line whose tests differ by so many standard deviations."""
    rng = np.random.default_rng(seed)
    columns = rng.normal(size=(TESTS, BLOCKS, SAMPLES, 2))
    slopes = between * rng.normal(size=(TESTS, 1, 1, 2))
    measured = rng.normal(size=columns.shape[:3]) + np.sum(columns * slopes, axis=-1)
    flat = columns.reshape(-1, 2)
    inverse = np.linalg.inv(flat.T @ flat)
    found = inverse @ flat.T @ measured.ravel()
    return found, inverse, clusters_of(measured - columns @ found, columns)


def share_held(*, between, of_tests=True):
    """Return how often the bounds of 95 % hold the truth, which is 0."""
    held = []
    for seed in range(100):
        found, inverse, clusters = drawn(seed, between=between)
        square, wider = covariance(inverse, clusters)
        bound = (wider if of_tests else 1.0) * np.sqrt(np.diag(square))
        held.append(np.abs(found) < 1.96 * bound)
    return np.mean(held)


def test_bounds_hold_95_percent_where_tests_agree():
    assert 0.92 < share_held(between=0.0) < 0.98


def test_bounds_hold_where_tests_disagree_and_those_of_blocks_alone_do_not():
    """Each test has its own slope about the truth, by 4 standard errors of one test."""
    assert share_held(between=0.16) > 0.87
    assert share_held(between=0.16, of_tests=False) < 0.75


def test_what_one_test_tells_is_as_certain_as_its_blocks_say():
    """No other test was loud enough: there is nothing that they could disagree with."""
    rng = np.random.default_rng(1)
    columns = rng.normal(size=(TESTS, BLOCKS, SAMPLES, 2))
    columns[1:, ..., 1] = 0.0
    measured = rng.normal(size=columns.shape[:3])
    flat = columns.reshape(-1, 2)
    inverse = np.linalg.inv(flat.T @ flat)
    residual = measured - columns @ (inverse @ flat.T @ measured.ravel())
    square, wider = covariance(inverse, clusters_of(residual, columns))
    np.testing.assert_allclose(square[1, 1], inverse[1, 1], rtol=0.7)
    assert wider[1] < 1.5


def test_a_number_that_one_block_tells_is_as_uncertain_as_one_observation():
    blocks = np.array([[1.0, 1.0], [1.0, 1e-6], [1.0, 1e-6]])
    many, one = wider_by(freedom_of(blocks**2))
    assert many == pytest.approx(3.182 / 1.960, rel=1e-3)  # tables of Student's law
    assert one == pytest.approx(12.706 / 1.960, rel=1e-3)


def test_the_scatter_of_numbers_that_no_block_tells_is_that_of_fits_without_each():
    """Oracle: every block left out and all fitted anew, by singular values of the rows.

    The last two numbers tell the same 1e4 times better than a prior of 1 tells each, so that
    only their sum is known, as of stiffnesses in parallel; the first is as small as a delay.
    """
    rng = np.random.default_rng(2)
    columns = rng.normal(size=(TESTS, BLOCKS, SAMPLES, 2)) * np.array([1e8, 1e4])
    columns = np.concatenate([columns, 0.2 * columns[..., 1:]], axis=-1)
    measured = rng.normal(size=columns.shape[:3])
    prior = np.eye(3)

    def fitted(rows, values):
        stacked = np.concatenate([rows.reshape(-1, 3), prior])
        return np.linalg.lstsq(stacked, np.append(values.ravel(), np.zeros(3)))[0]

    found = fitted(columns, measured)
    by_hand = []
    for out in np.ndindex(TESTS, BLOCKS):
        kept = np.ones((TESTS, BLOCKS), bool)
        kept[out] = False
        by_hand.append(found - fitted(columns[kept], measured[kept]))
    steps = np.array(by_hand)
    expected = steps.T @ steps * (len(steps) - 1) / len(steps)
    _, size, turned = np.linalg.svd(np.concatenate([columns.reshape(-1, 3), prior]))
    square, _ = covariance(
        turned.T @ np.diag(size**-2) @ turned, clusters_of(measured - columns @ found, columns)
    )
    np.testing.assert_allclose(square, expected, rtol=5e-3, atol=1e-22)
