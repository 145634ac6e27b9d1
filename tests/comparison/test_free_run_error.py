"""The one error and its standard error, against sums written out."""

from dataclasses import replace

import numpy as np
import pytest

from shakerproc import comparison
from shakerproc.comparison.held_out import held_out_samples

RATE = 1000.0


def scored(part, n=20000, band=(50.0, 200.0), seed=1):
    """A tone of 100 Hz of amplitude 1 of which the model has all but this part."""
    t = np.arange(n) / RATE
    tone = np.sin(2.0 * np.pi * 100.0 * t)
    far = np.random.default_rng(seed).standard_normal() * np.sin(2.0 * np.pi * 300.0 * t)
    measured = np.array([tone + far])
    return comparison.Scored(measured, (1.0 - part) * tone[None], RATE, band, np.ones(n, bool))


def test_the_error_is_the_root_of_the_mean_square_over_tests_and_sensors():
    two = replace(
        scored(0.4),
        measured=np.concatenate([scored(0.4).measured, scored(0.1).measured]),
        simulated=np.concatenate([scored(0.4).simulated, scored(0.1).simulated]),
    )
    expected = np.sqrt((0.3**2 + 0.4**2 + 0.1**2) / 3.0)
    assert comparison.free_run_error([scored(0.3), two]) == pytest.approx(expected, rel=1e-3)


def test_what_lies_outside_the_band_does_not_count():
    assert comparison.free_run_error([scored(0.0)]) < 1e-3
    assert comparison.free_run_error([scored(0.0, band=(50.0, 400.0))]) > 0.1


def test_only_counted_samples_count():
    test = scored(0.2)
    wrong = np.arange(test.counted.size) < 5000
    spoiled = replace(test, simulated=np.where(wrong, 50.0, test.simulated))
    found = comparison.free_run_error([spoiled.within(~wrong)])
    assert found == pytest.approx(0.2, rel=0.02)


def test_squares_of_the_residuals_sum_to_the_square_of_the_error():
    test = scored(0.25).within(np.arange(20000) > 3000)
    residuals = comparison.relative_residuals(test)
    assert np.sum(residuals**2) == pytest.approx(
        comparison.free_run_error([test]) ** 2, rel=1e-6
    )


def test_a_fall_has_the_scatter_of_repeated_experiments():
    rng = np.random.default_rng(3)
    falls, errors = [], []
    for _ in range(60):
        noise = 0.3 * rng.standard_normal((1, 20000))
        before = scored(0.4)
        before = replace(before, measured=before.measured + noise)
        after = replace(before, simulated=before.simulated / 0.6 * 0.9)
        fall, error = comparison.fall([before], [after])
        falls.append(fall)
        errors.append(error)
    assert np.mean(errors) == pytest.approx(np.std(falls), rel=0.35)


def test_every_third_block_is_held_out_unless_the_log_marks_a_test():
    rng = np.random.default_rng(5)
    drives = [rng.standard_normal(12000) for _ in range(2)]
    judged = [(0, 12000), (0, 12000)]
    blocks = held_out_samples(drives, [d[None] for d in drives], judged, [False, False])
    assert [float(b.mean()) for b in blocks] == pytest.approx([1.0 / 3.0] * 2, abs=1e-3)
    marked = held_out_samples(drives, [d[None] for d in drives], judged, [False, True])
    assert [bool(m.all()) for m in marked] == [False, True]
    assert not marked[0].any()


def test_the_middle_third_of_few_periods_is_held_out_as_one_block():
    time = np.arange(3000) / 100.0
    decay = np.exp(-0.05 * time) * np.cos(2.0 * np.pi * time)  # 30 periods
    (kept,) = held_out_samples([np.zeros(3000)], [decay[None]], [(0, 3000)], [False])
    assert np.flatnonzero(np.diff(kept.astype(int))).tolist() == [999, 1999]


def test_blocks_of_a_periodic_drive_are_never_held_out():
    one = np.random.default_rng(6).standard_normal(1000)
    drives = [np.tile(one, 12)] * 3
    found = held_out_samples(drives, [d[None] for d in drives], [(0, 12000)] * 3, [False] * 3)
    assert [m.any() for m in found] == [False, False, True]
    assert found[2].all()


def test_steps_of_a_converter_are_noise_of_a_twelfth_of_their_square():
    rng = np.random.default_rng(7)
    step, n = 0.02, 40000
    fine = np.cumsum(rng.standard_normal((2, n)), axis=1)
    fine = fine / fine.std(axis=1, keepdims=True)
    coarse = step * np.round(fine / step)
    channels = comparison.Channels(coarse[:1], coarse[1:], RATE, (1.0, 450.0))
    noise = comparison.noise_of(channels)
    assert noise.source == "resolution of the recorder"
    expected = np.var(coarse - fine) / (RATE / 2.0)
    assert noise.responses[0, 0] == pytest.approx(expected, rel=0.1)
    assert noise.input[0] == pytest.approx(expected, rel=0.1)


def test_controls_that_rock_together_are_no_noise():
    rng = np.random.default_rng(8)
    n, sigma = 200000, 0.01
    drive = rng.standard_normal(n)
    controls = np.array([1.02 * drive, 0.98 * drive]) + sigma * rng.standard_normal((2, n))
    channels = comparison.Channels(controls, drive[None], RATE, (1.0, 450.0))
    found = comparison.noise_of(channels)
    assert found.input_source == "disagreement of the controls"
    assert np.median(found.input) == pytest.approx(0.5 * sigma**2 / (RATE / 2.0), rel=0.1)


def test_noise_is_drawn_with_its_density():
    rng = np.random.default_rng(9)
    quiet = 0.05 * rng.standard_normal((2, 4000))
    loud = rng.standard_normal((2, 16000))
    rows = np.concatenate([quiet, loud], axis=1)
    found = comparison.noise_of(comparison.Channels(rows[:1], rows[1:], RATE, (1.0, 450.0)))
    assert found.source == "quiet lead-in"
    assert np.std(found.drawn(50000, RATE, rng)) == pytest.approx(0.05, rel=0.1)


def test_what_is_excited_does_not_leak_into_the_noise_above_it():
    t = np.arange(6000) / RATE
    tone = 22.0 * np.sin(2.0 * np.pi * 30.3 * t)
    rows = np.array([tone, tone + 0.01 * np.random.default_rng(2).standard_normal(t.size)])
    found = comparison.noise_of(comparison.Channels(rows[:1], rows[1:], RATE, (1.0, 40.0)))
    assert np.sqrt(found.responses[0, 0] * RATE / 2.0) == pytest.approx(0.01, rel=0.25)
