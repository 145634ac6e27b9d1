"""Whether the control kept its limits, on controls whose departure is known."""

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.small_campaign import write_campaign

from shakerproc.runs import process_test
from shakerproc.runs.flags import EDGE_OF_SWEEP, control_density, control_sweep
from shakerproc.runs.levels import BEYOND_ALARM, control_text, mismatch
from shakerproc.runs.summary import ControlSummary
from shakerproc.runs.tracking import Tracking
from shakerproc.spectra import Sweep
from shakerproc.testlog import read_testlog

GRAVITY = 9.80665


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    log = read_testlog(write_campaign(tmp_path_factory.mktemp("control"), 1))
    return process_test(log, log.tests[0])


def swept(run, decibels, level=5.0):
    """The run as a sweep of 5 g whose control departs so much along the way [dB]."""
    n = decibels.size
    sweep = Sweep(
        "up",
        np.arange(float(n)),
        np.linspace(10.0, 500.0, n),
        np.full(n, 4.0),
        level * GRAVITY * 10.0 ** (decibels / 20.0),
        np.ones(n),
        np.ones((4, 5, n), dtype=complex),
    )
    test = replace(run.test, excitation="sine sweep", level=level * GRAVITY, level_unit="m/s^2")
    return tracked(replace(run, test=test), Tracking(sweeps=(sweep,)))


def tracked(run, tracking):
    return replace(run, over_time=replace(run.over_time, tracking=tracking))


def test_a_control_that_drifts_evenly_is_beyond_for_the_part_it_is(run):
    """From -4 to 4 dB, the ends left out: beyond 3 dB for what is left above 3 of the reach."""
    seen = control_sweep(swept(run, np.linspace(-4.0, 4.0, 1001)))
    reach = 4.0 * (1.0 - 2.0 * EDGE_OF_SWEEP)
    assert seen.beyond_alarm == pytest.approx((reach - 3.0) / reach, abs=0.005)
    assert abs(seen.worst_db) == pytest.approx(reach, abs=0.02)
    assert seen.demanded == pytest.approx(5.0)
    assert not seen.kept


@pytest.mark.parametrize(("departure", "kept"), [(0.0, True), (2.9, True), (-3.1, False)])
def test_a_steady_departure_is_kept_up_to_the_alarm_limit(run, departure, kept):
    assert control_sweep(swept(run, np.full(500, departure))).kept is kept


def test_coming_up_and_going_down_do_not_count_but_a_trip_does(run):
    level = np.zeros(1000)
    level[:15] = level[-15:] = -20.0
    assert control_sweep(swept(run, level)).kept
    level[500] = -6.5
    seen = control_sweep(swept(run, level))
    assert not seen.kept
    assert seen.worst_hz == pytest.approx(10.0 + 490.0 * 500 / 999)


def test_random_runs_and_runs_without_a_level_are_no_sweeps(run):
    assert control_sweep(run) is None
    assert control_density(run).kept
    assert control_sweep(tracked(swept(run, np.zeros(9)), Tracking())) is None
    silent = swept(run, np.zeros(9))
    nothing = replace(silent, test=replace(silent.test, level=None))
    assert control_sweep(nothing) is None


NUMBER = r"([+-]\d+\.\d+) dB at"
finite = st.floats(-9.0, 9.0)


@given(
    worst=finite | st.floats(2.9, 3.1) | st.floats(5.9, 6.1),
    beyond=st.floats(0.0, 1.0) | st.floats(0.049, 0.051) | st.just(0.0),
    chance=st.floats(0.0, 2.0),
    limits=st.sampled_from([(3.0, 6.0), (1.5, 3.0), (2.95, 6.0)]),
)
def test_no_rounding_lets_the_sentence_contradict_the_verdict(worst, beyond, chance, limits):
    alarm, abort = limits
    sure = max(abs(worst) - chance, 0.0)
    share = beyond if sure > alarm else 0.0
    kept = sure <= abort and share <= BEYOND_ALARM
    told = control_text(ControlSummary(1.0, alarm, abort, share, worst, 50.0, kept), "band")
    shown = abs(float(re.search(NUMBER, told).group(1)))
    limit = float(re.search(r"±([\d.]+) dB", told).group(1))
    assert ("NOT KEPT" in told) is not kept
    assert told.startswith("within") is (shown <= limit)
    assert "within" not in told or kept
    part = re.search(r"in ([\d.]+) % of the band, where ([\d.]+) %", told)
    if part:
        assert (float(part.group(1)) <= float(part.group(2))) is kept
    if not kept and not part:
        assert "abort limit" in told


def test_a_departure_within_chance_is_told_as_that():
    seen = ControlSummary(1.0, 3.0, 6.0, 0.0, -3.2, 148.0, kept=True)
    assert control_text(seen, "band") == (
        "beyond ±3 dB of the demanded level by no more than chance: kept, "
        "at worst -3.2 dB at 148 Hz"
    )


@pytest.mark.parametrize("factor", [1.0001, 1.004, 0.996, 1.5])
def test_a_level_outside_its_tolerance_is_not_printed_inside(run, factor):
    off = 10.0 ** (3.0 / 10.0) * factor
    level = replace(run.averages.measured_level, value=run.test.level * off)
    told = mismatch(run.test, level)
    assert bool(told) is (factor > 1.0)
    if told:
        assert float(re.search(r"([+-][\d.]+) dB from", told).group(1)) > 3.0
