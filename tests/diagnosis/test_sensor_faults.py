"""Faults of sensors, made by hand on a simulated linear campaign, and joints that held."""

from dataclasses import replace

import numpy as np
import pytest
from tests.diagnosis.one_mass import JOINT, NOISE, RATE, arrays_of, data_of, one_mass

from shakerproc.diagnosis.data import prepared
from shakerproc.diagnosis.data.sensor_faults import clipped, hum_in, hum_of
from shakerproc.diagnosis.estimation.correction import residuals_of, turned
from shakerproc.diagnosis.estimation.linear import fit_linear, signs_and_delays
from shakerproc.diagnosis.rigid import rigid_joints


@pytest.fixture(scope="module")
def campaign():
    return arrays_of(one_mass(1.05e5, 10.0))


def spoiled(campaign, change):
    """Return the tests of a campaign whose responses went through a fault."""
    return prepared([replace(t, responses=change(t.responses)) for t in campaign])


def late(rows, delay):
    """Return rows that arrive later [s]."""
    n = 2 * rows.shape[1]
    turn = np.exp(-2j * np.pi * np.fft.rfftfreq(n, 1.0 / RATE) * delay)
    return np.fft.irfft(np.fft.rfft(rows, n) * turn, n)[:, : rows.shape[1]]


@pytest.mark.parametrize("delay", [3e-3, 9e-3])
def test_a_delay_of_part_of_a_period_is_measured_with_the_stiffness(campaign, delay):
    tests = spoiled(campaign, lambda rows: late(rows, delay))
    signs, delays = signs_and_delays(one_mass(), tests)
    found = fit_linear(one_mass(), turned(tests, signs, delays))
    assert np.all(signs == 1.0)
    assert delays[0] + found.chain.delays[0] == pytest.approx(delay, abs=2e-5)
    assert found.model.elements[0].effect.stiffness == pytest.approx(1.05e5, rel=2e-3)


def test_a_sensor_the_wrong_way_round_is_told_from_a_late_one(campaign):
    tests = spoiled(campaign, lambda rows: -rows)
    signs, delays = signs_and_delays(one_mass(), tests)
    assert np.all(signs == -1.0)
    assert np.all(delays == 0.0)
    found = fit_linear(one_mass(), turned(tests, signs, delays))
    assert found.chain.gains[0] == pytest.approx(1.0, rel=5e-3)


def test_sound_sensors_are_left_as_they_are(campaign):
    signs, delays = signs_and_delays(one_mass(), prepared(campaign))
    assert np.all(signs == 1.0)
    assert np.all(delays == 0.0)


@pytest.mark.parametrize("mains", [50.0, 60.0])
def test_hum_stands_out_of_what_the_linear_model_leaves(campaign, mains):
    size = 0.1 * float(np.std(campaign[0].responses))
    t = np.arange(campaign[0].responses.shape[1]) / RATE
    hum = size * (np.sin(2 * np.pi * mains * t + 1.0) + 0.3 * np.sin(6 * np.pi * mains * t))
    tests = spoiled(campaign, lambda rows: rows + hum)
    left = residuals_of(fit_linear(one_mass(), tests), tests)
    (found,) = hum_of(left, [RATE] * len(tests))
    assert found.frequency == mains
    told = hum_in(left[0][0], RATE, mains)
    assert np.std(told - hum) < 0.2 * np.std(hum)


def test_without_hum_none_is_found(campaign):
    tests = prepared(campaign)
    left = residuals_of(fit_linear(one_mass(), tests), tests)
    assert hum_of(left, [RATE] * len(tests)) == ()


def test_samples_at_a_limit_are_found_and_the_limit(campaign):
    rows = campaign[0].responses
    limit = 0.5 * float(np.max(np.abs(rows)))
    hit, limits = clipped(np.clip(rows, -limit, limit))
    assert np.array_equal(hit, np.abs(rows) >= limit)
    assert limits == pytest.approx([limit])
    _, shifted = clipped(np.clip(rows, -limit, limit) + 0.01 * limit)
    assert shifted == pytest.approx([limit])
    none, unknown = clipped(rows)
    assert not none.any()
    assert np.isnan(unknown).all()


def test_the_crests_of_a_coarsely_quantised_sine_are_no_limit():
    t = np.arange(20_000) / RATE
    rows = (1.0 + 1e-3 * t) * np.sin(2 * np.pi * 13.7 * t)
    step = np.max(np.abs(rows)) / 500.0  # 16 bit, the range 65 times the largest value
    hit, limits = clipped(np.round(rows[np.newaxis] / step) * step)
    assert not hit.any()
    assert np.isnan(limits).all()
    hit, _ = clipped(np.round(np.clip(rows, -0.9, 0.9)[np.newaxis] / step) * step)
    assert hit.any()


def test_a_joint_whose_two_sides_move_alike_held():
    rng = np.random.default_rng(0)
    tests = []
    for test in arrays_of(one_mass()):
        noise = NOISE * np.std(test.controls) * rng.standard_normal(test.controls.shape)
        tests.append(replace(test, responses=test.controls + noise))
    data = replace(data_of(one_mass()), tests=prepared(tests))
    assert rigid_joints(data) == (JOINT,)
    assert rigid_joints(data_of(one_mass())) == ()
