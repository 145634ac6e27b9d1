"""Short tests are judged by the periods that they hold, whatever the rate."""

import numpy as np
import pytest

from shakerproc.comparison.part import few_periods
from shakerproc.errors import DiagnosisError


@pytest.mark.parametrize("n_samples", [481, 807, 917])
def test_of_twenty_five_periods_nothing_is_said_at_any_number_of_samples(n_samples):
    turn = 2.0 * np.pi * 25.0 * np.arange(n_samples) / n_samples
    assert not few_periods("run", np.array([5.0 + np.sin(turn)]))  # an offset is no motion


@pytest.mark.parametrize(
    ("periods", "n_samples", "known"), [(4, 100_000, "25 %"), (9, 481, "17 %")]
)
def test_few_periods_are_counted_and_what_they_tell_is_said(periods, n_samples, known):
    turn = 2.0 * np.pi * (periods * np.arange(n_samples) / n_samples - 0.25)
    noise = 1e-3 * np.random.default_rng(1).standard_normal(n_samples)
    (note,) = few_periods("run", np.array([noise, np.sin(turn)]))
    assert f"hold {periods} periods of the motion" in note
    assert f"known to {known.replace(' ', '')}" in note


def test_what_does_not_move_is_refused():
    with pytest.raises(DiagnosisError, match="nothing moves in the 500 samples"):
        few_periods("run", np.full((2, 500), 3.0))
