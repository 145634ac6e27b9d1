"""Lengths of windows and blocks, by hand."""

import pytest
from numpy.testing import assert_allclose

from shakerproc.diagnosis.estimation.parts import Lengths


def test_long_tests_have_windows_of_periods_and_blocks_of_half_a_second():
    of = Lengths(200.0, (20.0, 20.0), (20.0,), 0.01)
    assert_allclose(of.unit_s, 1.0 / 200.0)
    assert_allclose(of.run_in_s(1.0), 2.0 / 200.0)
    assert_allclose([of.block_s, of.cluster_s], [30.0 / 200.0, 0.5])


@pytest.mark.parametrize("seconds", [0.15, 0.6])
def test_short_tests_have_blocks_enough_to_scatter(seconds):
    of = Lengths(3.0, (seconds, seconds), (seconds,), 0.0)
    assert_allclose(of.block_s, seconds / 3)
    assert_allclose(of.cluster_s, 2 * seconds / 12)
    assert_allclose(of.run_in_s(0.1), 0.05)
