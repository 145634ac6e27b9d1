"""A fixed small share of the hidden campaigns, from files to verdict."""

import pytest
from blind.judging import exact
from blind.trial import attempt

SHARE = (
    (31, "cubic_stiffness"),
    pytest.param(13, "stop", marks=pytest.mark.long),
    (11, "none"),
    pytest.param(22, "mains_hum", marks=pytest.mark.long),
    pytest.param(21, "sensor_polarity", marks=pytest.mark.long),
    pytest.param(1, "pair:cubic_stiffness+quadratic_damping", marks=pytest.mark.long),
)


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "kind"), SHARE)
def test_what_is_hidden_is_named(seed, kind):
    trial = attempt(seed, kind)
    assert exact(trial), trial.problem or trial.document["sentence"]
    if kind != "none":
        held = trial.document["errors"]["held_out"]
        assert held["after"] < max(2.0 * trial.noise_floor, 0.005)
        assert held["after"] < held["before"]
