"""The probability of a verdict, against the regression that the blind trials fitted."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from blind import calibrate
from shakerproc.diagnosis.selection import probability

NAMES = ["excess", "t_over_next"]


@pytest.fixture
def fitted(monkeypatch):
    """Store a regression on two scores, and return it."""
    rng = np.random.default_rng(0)
    rows = rng.normal([0.5, 10.0], [0.3, 5.0], (200, 2))
    right = (rng.random(200) < 1.0 / (1.0 + np.exp(3.0 * rows[:, 0] - 2.0))).astype(float)
    found = calibrate.fit(rows, right, 1.0)
    stored = {
        "features": NAMES, "low": found.low.tolist(), "high": found.high.tolist(),
        "mean": found.mean.tolist(), "scale": found.scale.tolist(),
        "coefficients": found.coefficients.tolist(), "intercept": found.intercept,
    }  # fmt: skip
    monkeypatch.setattr(probability, "_calibration", lambda: stored)
    return found


@pytest.mark.parametrize("row", [(0.1, 12.0), (0.9, 3.0), (50.0, -50.0)])
def test_the_probability_is_that_of_the_regression(fitted, row):
    said = probability.probability_of(dict(zip(NAMES, row, strict=True)))
    assert_allclose(said, fitted.probability(np.array([row]))[0], rtol=1e-12)


def test_a_score_that_is_missing_counts_as_its_mean(fitted):
    said = probability.probability_of({"excess": 0.4, "t_over_next": float("nan")})
    assert_allclose(said, fitted.probability(np.array([(0.4, np.nan)]))[0], rtol=1e-12)


def test_nothing_is_said_without_a_calibration(monkeypatch):
    monkeypatch.setattr(probability, "_calibration", lambda: None)
    assert probability.probability_of({"excess": 0.1}) is None
