"""Intervals that allow for the scatter over records hold the truth as often as they say."""

import numpy as np
import pytest

from shakerproc.modal.identification import widening

DRAWS = 20_000


@pytest.mark.parametrize("n_records", [4, 6, 8])
@pytest.mark.parametrize("true_ratio", [1.0, 1.5, 4.0])
def test_intervals_of_a_mean_hold_it_whatever_records_scatter(n_records, true_ratio):
    """Normal records that scatter `true_ratio` times what each says of itself."""
    rng = np.random.default_rng(n_records)
    errors = np.tile(rng.uniform(0.5, 2.0, n_records)[:, None], DRAWS)
    values = true_ratio * errors * rng.standard_normal(errors.shape)
    weight = errors**-2.0
    mean, error = (weight * values).sum(axis=0) / weight.sum(axis=0), weight.sum(axis=0) ** -0.5
    _, wider = widening(values, errors)
    held = np.mean(np.abs(mean) < 1.959964 * error * wider)
    assert 0.94 < held < 0.98  # three standard deviations of the draws are 0.005


def test_a_record_that_says_nothing_does_not_count():
    values, errors = np.array([[1.0], [np.nan], [3.0]]), np.full((3, 1), 0.5)
    ratio, wider = widening(values, errors)
    np.testing.assert_allclose(ratio, 2.0 * np.sqrt(2.0))  # chi square of 8, one degree
    np.testing.assert_allclose(wider, ratio * 12.7062 / 1.959964, rtol=1e-5)  # tables of t
    assert widening(values[:1], errors[:1])[1] == 1.0
