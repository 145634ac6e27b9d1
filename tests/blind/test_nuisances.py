"""What nuisances do to the channels, each against what it says of itself."""

import numpy as np
import pytest
from blind.excitations import SAMPLE_RATE
from numpy.testing import assert_allclose

from blind import campaigns, classes, nuisances

CLASS = "cubic_stiffness"


@pytest.fixture(scope="module")
def plain():
    return campaigns.draw(3, CLASS)


def with_one(name):
    return campaigns.draw(3, f"{CLASS}@{name}")


def test_a_nuisance_leaves_the_hidden_effect_as_it_was(plain):
    other = with_one("all")
    assert other.truth["effects"] == plain.truth["effects"]
    assert set(other.truth["nuisances"]) >= {"second_mode", "gains", "skews", "rocking"}
    assert other.nominal == plain.nominal


def test_gain_errors_are_of_one_percent(plain):
    other = with_one("gain_error")
    for mine, true in zip(other.tests, plain.tests, strict=True):
        for rows, clean in ((mine.control, true.control), (mine.response, true.response)):
            ratio = np.sum(rows * clean, axis=1) / np.sum(clean**2, axis=1)
            assert_allclose(np.abs(ratio - 1.0), 0.01, rtol=1e-6)


def test_a_response_is_skewed_by_20_us(plain):
    other = with_one("skew")
    f = np.fft.rfftfreq(plain.tests[2].clean.shape[1], 1.0 / SAMPLE_RATE)
    turn = np.fft.rfft(other.tests[2].clean[0]) * np.conj(np.fft.rfft(plain.tests[2].clean[0]))
    slope = np.sum(np.angle(turn) * f * np.abs(turn)) / np.sum(f**2 * np.abs(turn))
    assert abs(slope) / (2.0 * np.pi) == pytest.approx(20e-6, rel=1e-3)


def test_the_controls_of_a_rocking_table_differ_by_two_percent():
    drawn = nuisances.draw(3, CLASS, ("rocking_table",), 1)
    wave = np.random.default_rng(1).standard_normal(20000)
    first, second = nuisances.inputs(drawn, [wave] * 4, forced=False)[1]
    assert np.std(first - second) == pytest.approx(0.02 * np.std(wave), rel=1e-2)
    assert np.std(0.5 * (first + second) - wave) < 0.006 * np.std(wave)


def test_quantisation_has_steps_of_16_bit(plain):
    other = with_one("quantisation")
    factor = other.truth["nuisances"]["quantisation"]
    rows = [test.response[0] for test in other.tests]
    step = np.min(np.diff(np.unique(np.concatenate(rows))))
    top = max(np.max(np.abs(test.response[0])) for test in plain.tests)
    assert step == pytest.approx(factor * top / 2**15, rel=1e-6)


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
    campaign = with_one("second_mode")
    share, factor, _ = campaign.truth["nuisances"]["second_mode"]
    assert 0.01 <= share <= 0.05
    assert 4.0 <= factor <= 8.0


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
