"""What nuisances do to the channels, each against what it says of itself."""

import numpy as np
import pytest
from blind.excitations import SAMPLE_RATE
from blind.recorder import Channels
from numpy.testing import assert_allclose

from blind import assembly, campaigns, classes, nuisances, structures

CLASS = "cubic_stiffness"


def channels(**drawn):
    return Channels(0.0, False, 0, lambda x: x, nuisances.Nuisances(**drawn))


def recorded(chain, rng_seed=5):
    """Two tests of two controls and one response, without noise, before and behind a chain."""
    rng = np.random.default_rng(rng_seed)
    control = [level * rng.standard_normal((2, 4000)) for level in (1.0, 3.0)]
    clean = [level * rng.standard_normal((1, 4000)) for level in (1.0, 3.0)]
    return control, clean, chain.record(rng, rng, control, clean)


@pytest.mark.slow
def test_a_nuisance_leaves_the_hidden_effect_as_it_was():
    plain, other = campaigns.draw(3, CLASS), campaigns.draw(3, f"{CLASS}@all")
    assert other.truth["effects"] == plain.truth["effects"]
    assert set(other.truth["nuisances"]) >= {"second_mode", "gains", "skews", "rocking"}
    assert other.nominal == plain.nominal
    apart = other.tests[2].clean - plain.tests[2].clean
    assert 0.005 < np.std(apart) / np.std(plain.tests[2].clean) < 0.5


def test_gain_errors_are_of_one_percent():
    gains = nuisances.draw(3, CLASS, ("gain_error",), 1).gains
    assert_allclose(np.abs(np.array(gains) - 1.0), 0.01, rtol=1e-12)
    control, clean, out = recorded(channels(gains=gains))
    for before, after, kept in (
        (control[1], out[1][0], gains[:2]),
        (clean[1], out[1][1], gains[2:]),
    ):
        assert_allclose(after, before * np.array(kept)[:, None])


def test_a_response_is_skewed_by_20_us():
    drawn = nuisances.draw(3, CLASS, ("skew",), 2)
    assert_allclose(np.abs(drawn.skews), 20e-6)
    t = np.arange(4096) / SAMPLE_RATE
    behind = nuisances.recorded(drawn, np.sin(2500.0 * t), SAMPLE_RATE, 20e-6)
    middle = slice(1000, 3000)
    assert_allclose(behind[middle], np.sin(2500.0 * (t - 20e-6))[middle], atol=2e-3)


def test_quantisation_has_steps_of_16_bit_of_the_loudest_test():
    control, _, out = recorded(channels(quantisation=40.0))
    step = 40.0 * np.max(np.abs(control[1][0])) / 2**15
    for before, (after, _) in zip(control, out, strict=True):
        assert_allclose(after[0] / step, np.round(after[0] / step), atol=1e-6)
        assert np.max(np.abs(after[0] - before[0])) <= 0.5 * step * (1.0 + 1e-9)


def test_the_controls_of_a_rocking_table_differ_by_two_percent():
    drawn = nuisances.draw(3, CLASS, ("rocking_table",), 1)
    wave = np.random.default_rng(1).standard_normal(20000)
    first, second = nuisances.inputs(drawn, [wave] * 4, forced=False)[1]
    assert np.std(first - second) == pytest.approx(0.02 * np.std(wave), rel=1e-2)
    assert np.std(0.5 * (first + second) - wave) < 0.006 * np.std(wave)


def test_flicker_noise_equals_white_noise_at_its_corner():
    drawn = nuisances.Nuisances(flicker_corner=100.0)
    rows = nuisances.flicker(drawn, 0.3, 2**18, np.random.default_rng(2))
    power = np.abs(np.fft.rfft(rows)) ** 2 / rows.size
    f = np.fft.rfftfreq(rows.size, 1.0 / SAMPLE_RATE)
    for low, high in ((5.0, 10.0), (90.0, 110.0), (900.0, 1100.0)):
        inside = (f > low) & (f < high)
        expected = 0.3**2 * np.mean(100.0 / f[inside])
        assert np.mean(power[inside]) == pytest.approx(expected, rel=0.15)


def test_the_filter_is_a_butterworth_filter():
    drawn = nuisances.Nuisances(filter_order=3, filter_corner=2000.0)
    t = np.arange(4096) / (8.0 * SAMPLE_RATE)
    wave = np.sin(2.0 * np.pi * 2000.0 * t)
    behind = nuisances.recorded(drawn, wave, 8.0 * SAMPLE_RATE)[2000:]
    assert np.max(np.abs(behind)) == pytest.approx(np.sqrt(0.5), rel=2e-3)


def test_a_second_mode_hangs_on_a_share_of_the_mass():
    """All masses together weigh what they did; the hung one alone has 4 to 8 times f_n."""
    structure = structures.Structure((0.3,), (structures.Joint(-1, 0, 2e5, 3.0),))
    drawn = nuisances.draw(3, CLASS, ("second_mode",), 1)
    truth, _ = assembly.assemble(structure, 0, [], drawn)
    assert sum(truth.masses) == pytest.approx(0.3)
    assert 0.01 <= truth.masses[1] / 0.3 <= 0.05
    alone = np.sqrt(truth.joints[1][2] / truth.masses[1])
    assert 4.0 <= alone / np.sqrt(2e5 / 0.3) <= 8.0


def test_a_slow_drift_changes_stiffness_by_half_a_percent():
    """In each test, or from the start of the first to the end of the last."""
    for seed in range(6):
        drift = nuisances.draw(seed, CLASS, ("slow_drift",), 1).drift
        ends = [[rate * (t - zero) for t in (0.0, 20.0)] for rate, zero in drift]
        each, through = ends[0][1] - ends[0][0], ends[3][1] - ends[0][0]
        assert min(abs(abs(each) - 0.005), abs(abs(through) - 0.005)) < 1e-12


def test_class_names_are_taken_apart():
    parsed = classes.parse("chain3:gap@second_mode+skew")
    assert (parsed.base, parsed.form, parsed.name) == ("chain3:gap", "chain3", "gap")
    assert parsed.nuisances == ("second_mode", "skew")
    friction = classes.parse("stribeck_friction:locked:sweep")
    assert (friction.regime, friction.drive) == ("locked", "sine sweep")
    with pytest.raises(ValueError, match="no nuisance 'fog'"):
        classes.parse("gap@fog")
    with pytest.raises(ValueError, match="'locked' is no detail of gap"):
        classes.parse("gap:locked")


def test_groups_and_counts_become_tasks():
    wanted = list(classes.expand("none*3,gap", 2))
    assert wanted == [("none", 3), ("gap", 2)]
    assert classes.tasks(wanted, 5) == [
        (5, "none"), (5, "gap"), (6, "none"), (6, "gap"), (7, "none"),
    ]  # fmt: skip
    assert len(classes.friction()) == 18
    assert dict(classes.expand(classes.FROZEN, 1))["none"] == 50
