"""Where a model fails, on residuals that are made to stand in one place."""

from itertools import pairwise

import numpy as np
import pytest

from shakerproc.comparison import Scored
from shakerproc.diagnosis.data import RelativeMotion
from shakerproc.diagnosis.result import Where
from shakerproc.diagnosis.selection.where import Failed, where_it_fails

RATE = 1000.0
T = np.arange(8000) / RATE
BAND = (10.0, 200.0)
SWAY = 1e-3 * np.sin(2.0 * np.pi * 0.5 * T)


def failed(name, missed):
    """Return a test whose model explains 30 Hz and misses this."""
    known = np.sin(2.0 * np.pi * 30.0 * T)
    counted = T > 0.5
    scored = Scored((known + missed)[None], known[None], RATE, BAND, counted)
    return Failed(name, scored, RelativeMotion(SWAY, np.gradient(SWAY, 1.0 / RATE)))


def tone(frequency, size):
    return size * np.sin(2.0 * np.pi * frequency * T)


def test_the_band_is_that_of_what_is_missed_and_the_test_where_it_is_more():
    found = where_it_fails([
        failed("quiet", tone(70.0, 0.01)),
        failed("loud", tone(70.0, 0.5)),
    ])
    ((low, high),) = found.bands_hz
    assert low < 70.0 < high
    assert high / low == pytest.approx(2.0 ** (1.0 / 3.0))
    assert found.tests == ("loud",)


def test_bands_that_touch_are_one_and_others_are_not():
    missed = tone(20.0, 0.4) + tone(110.0, 0.4) + tone(130.0, 0.4)
    bands = where_it_fails([failed("one", missed)]).bands_hz
    assert all(a[1] < b[0] for a, b in pairwise(bands))
    assert any(low < 110.0 < high and low < 130.0 < high for low, high in bands)


def test_the_range_is_that_of_the_motion_in_which_it_fails():
    large = np.abs(SWAY) > 0.8e-3
    found = where_it_fails([failed("one", np.where(large, tone(80.0, 0.5), 0.0))])
    low, high = found.displacement_m
    assert low == pytest.approx(0.8e-3, rel=0.1)
    assert high == pytest.approx(1e-3, rel=0.01)
    assert found.velocity_m_per_s[0] == pytest.approx(0.0, abs=1e-4)  # slow where far out
    assert found.velocity_m_per_s[1] < 0.75 * 1e-3 * np.pi


def test_equal_tests_are_all_named_and_nothing_of_no_tests():
    same = [failed(name, tone(50.0, 0.2)) for name in "ab"]
    assert where_it_fails(same).tests == ("a", "b")
    assert where_it_fails([]) == Where()
