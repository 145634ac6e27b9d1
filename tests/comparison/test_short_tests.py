"""Short tests are judged by the periods that they hold, whatever the rate."""

import numpy as np
import pytest

from shakerproc.comparison.part import check_periods
from shakerproc.errors import DiagnosisError


@pytest.mark.parametrize("n_samples", [481, 807, 917])
def test_twenty_five_periods_are_enough_at_any_number_of_samples(n_samples):
    turn = 2.0 * np.pi * 25.0 * np.arange(n_samples) / n_samples
    check_periods("run", np.array([5.0 + np.sin(turn)]))  # an offset is no motion


@pytest.mark.parametrize(("periods", "n_samples"), [(4, 100_000), (9, 481)])
def test_few_periods_are_counted_in_the_message(periods, n_samples):
    turn = 2.0 * np.pi * periods * np.arange(n_samples) / n_samples
    noise = 1e-3 * np.random.default_rng(1).standard_normal(n_samples)
    rows = np.array([noise, np.sin(turn + 0.1)])
    with pytest.raises(DiagnosisError, match=r"hold (4|8|9) periods of the motion"):
        check_periods("run", rows)
