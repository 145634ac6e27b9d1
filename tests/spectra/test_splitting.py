"""A long record split: shocks and steps of the level at known times, against closed forms."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.data import STANDARD_GRAVITY, Channel, recording_of_arrays
from shakerproc.runs import process_recording
from shakerproc.spectra.splitting import (
    ShockRule,
    arrangements,
    cells_of,
    changes,
    has_trend,
    shocks_of,
)
from shakerproc.testlog import Processing, Test
from shakerproc.testlog.processing import Splitting

RATE, SECONDS, WIDTH, HEIGHT = 2000.0, 120.0, 0.011, 80.0
SHOCKS = (20.3, 55.017, 81.5, 82.9)
STEPS = (40.011, 70.007)  # within a cell
LEVELS = (1.0, 4.0, 1.5)


def transport(seed):
    """Return noise of three levels on 1 g with half-sines, and a quieter channel beside it."""
    rng = np.random.default_rng(seed)
    t = np.arange(round(RATE * SECONDS)) / RATE
    level = np.array(LEVELS)[np.searchsorted(STEPS, t, side="right")]
    rows = level * rng.standard_normal((2, t.size)) * [[0.3], [1.0]] + STANDARD_GRAVITY
    for start in SHOCKS:
        inside = (t >= start) & (t < start + WIDTH)
        rows[1, inside] += HEIGHT * np.sin(np.pi * (t[inside] - start) / WIDTH)
    return rows


def parts_of(rows, wanted=Splitting()):  # noqa: B008 - frozen
    channels = (
        Channel("control", "m/s^2", "control", "m/s^2", "control"),
        Channel("ch3", "m/s^2", "ch3", "m/s^2", "response"),
    )
    test = Test(
        1,
        excitation="random",
        from_hz=5.0,
        to_hz=900.0,
        processing=Processing(crop=None, splitting=wanted),
    )
    result = process_recording(recording_of_arrays("run", channels, rows, RATE), test)
    (found,) = [one for one in result.analyses if one.kind == "splitting"]
    return found


@pytest.fixture(scope="module")
def found():
    return parts_of(transport(3))


def test_shocks_are_where_they_were_put_and_as_high(found):
    rows = [row for row in found.summary if row["kind"] == "shock"]
    assert len(rows) == len(SHOCKS)
    for row, start in zip(rows, SHOCKS, strict=True):
        assert row["start_s"] <= start <= row["start_s"] + 0.05
        assert start + WIDTH <= row["stop_s"] <= start + WIDTH + 0.05
        assert_allclose(row["peak_ch3_g"], HEIGHT / STANDARD_GRAVITY, rtol=0.12)


def test_parts_begin_where_the_level_changes_and_have_the_level_that_they_were_given(found):
    rows = [row for row in found.summary if row["kind"] != "shock"]
    assert [row["kind"] for row in rows] == ["stationary"] * 3
    assert_allclose([row["start_s"] for row in rows], (0.0, *STEPS), atol=0.04)
    assert rows[-1]["stop_s"] == pytest.approx(SECONDS)
    levels = np.array([[0.3 * level, level] for level in LEVELS]) / STANDARD_GRAVITY
    seen = [[row["rms_control_g"], row["rms_ch3_g"]] for row in rows]
    assert_allclose(seen, levels, rtol=0.02)
    assert [row["shocks"] for row in rows] == [1.0, 1.0, 2.0]


def test_density_of_a_part_is_that_of_its_noise_without_the_shocks(found):
    columns = found.columns
    for number, level in zip((1.0, 3.0, 5.0), LEVELS, strict=True):
        seen = (columns["part"] == number) & (columns["frequency_hz"] > 20.0)
        density = columns["psd_ch3_g2_per_hz"][seen] * STANDARD_GRAVITY**2
        assert_allclose(density.mean(), level**2 / (0.5 * RATE), rtol=0.05)
        assert np.isnan(columns["shock_maximax_ch3_g"][seen]).all()


def test_shock_spectrum_of_a_half_sine_rises_with_its_velocity_change(found):
    """Far below the shock an undamped oscillator answers with ω times the velocity change."""
    columns = found.columns
    seen = (columns["part"] == 2.0) & (columns["frequency_hz"] < 6.0)
    change = 2.0 * HEIGHT * WIDTH / np.pi
    wanted = 2.0 * np.pi * columns["frequency_hz"][seen] * change / STANDARD_GRAVITY
    damped = np.exp(-0.05 * np.arccos(0.05) / np.sqrt(1.0 - 0.05**2))  # of a step in velocity
    assert_allclose(columns["shock_maximax_ch3_g"][seen], damped * wanted, rtol=0.1)


def test_noise_alone_is_one_stationary_part():
    for seed in range(5):
        rows = np.random.default_rng(seed).standard_normal((2, 120_000))
        (row,) = parts_of(rows).summary
        assert row["kind"] == "stationary"


def test_a_level_that_rises_slowly_is_not_stationary_and_what_is_short_a_transient():
    rng = np.random.default_rng(4)
    t = np.arange(240_000) / RATE
    rising = np.exp(0.25 * t / 120.0) * rng.standard_normal((2, t.size))
    assert [row["kind"] for row in parts_of(rising).summary] == ["not stationary"]
    burst = np.where((t > 60.0) & (t < 63.0), 6.0, 1.0) * rng.standard_normal((2, t.size))
    rows = parts_of(burst).summary
    assert [row["kind"] for row in rows] == ["stationary", "transient", "stationary"]
    assert_allclose([rows[1]["start_s"], rows[1]["stop_s"]], (60.0, 63.0), atol=0.04)


def test_the_rule_of_a_shock_is_the_users():
    assert all(
        row["kind"] != "shock" for row in parts_of(transport(3), Splitting(crest=200.0)).summary
    )
    assert all(
        row["kind"] != "shock" for row in parts_of(transport(3), Splitting(least=200.0)).summary
    )


def test_a_dead_channel_and_silence_have_neither_shocks_nor_changes():
    cells = cells_of([np.zeros((2, 10_000))], 1000.0, 20)
    assert shocks_of(cells, ShockRule(6.0, 0.0, 1.0)) == []
    assert [row["kind"] for row in parts_of(np.zeros((2, 40_000))).summary] == ["stationary"]


@pytest.mark.parametrize("size", [1, 7, 4096])
def test_cells_do_not_depend_on_the_blocks(size):
    rows = np.random.default_rng(1).standard_normal((3, 5003))
    blocks = [rows[:, a : a + size] for a in range(0, 5003, size)]
    seen = cells_of(blocks, 1000.0, 20)
    whole = rows[:, :5000].reshape(3, 250, 20)
    assert_allclose(seen.mean_square, (whole**2).mean(axis=2), rtol=1e-12)
    assert_allclose(seen.peak, np.abs(whole).max(axis=2), rtol=0)


def test_reverse_arrangements_are_those_of_the_books_example():
    """Bendat and Piersol, Random Data, example 4.4: 86 of 20 observations."""
    seen = [5.2, 6.2, 3.7, 6.4, 3.9, 4.0, 3.9, 5.3, 4.0, 4.6, 5.9, 6.5, 4.3, 5.7, 3.1, 5.6, 5.2,
            3.9, 6.2, 5.0]  # fmt: skip
    assert arrangements(np.array(seen)) == 86


def test_a_trend_is_told_in_one_of_a_hundred_steady_parts():
    rng = np.random.default_rng(5)
    known = np.ones(400, dtype=bool)
    told = [has_trend(rng.chisquare(20.0, (2, 400)), known) for _ in range(2000)]
    assert 0.002 < np.mean(told) < 0.018


def test_a_change_of_level_is_found_and_noise_has_none():
    rng = np.random.default_rng(6)
    level = rng.standard_normal((2, 300))
    assert changes(level, 3.0) == [0, 300]
    level[:, 120:] += 6.0
    assert changes(level, 3.0) == [0, 120, 300]
    assert changes(level, 9.0) == [0, 300]
