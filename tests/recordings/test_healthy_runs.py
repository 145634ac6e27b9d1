"""A share of the campaign of healthy runs and dead channels; `make healthy` runs all of it."""

import pytest
from tests.recordings.healthy import FAULTS, found, healthy_run

from shakerproc.recordings import health


@pytest.mark.parametrize("seed", range(30, 50))
def test_a_healthy_run_is_not_flagged(seed):
    recording, _ = healthy_run(seed)
    assert health(recording) == ()


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("fault", FAULTS)
def test_a_dead_channel_is_found_and_no_other(fault, seed):
    assert found(fault, 1000 + seed)
