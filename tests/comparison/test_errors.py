"""Errors, floors and fits against campaigns whose every number is known."""

import json
from dataclasses import replace

import numpy as np
import pytest
from blind.excitations import SAMPLE_RATE, waveform
from blind.ranges import Hidden
from numpy.testing import assert_allclose
from tests.comparison.small_campaigns import (
    JOINT,
    NOISE,
    ONE_MASS,
    TWO_MASSES,
    campaign,
    drive,
    off,
    written,
)

from blind import laws
from shakerproc import comparison
from shakerproc.comparison.free_run_error import edges
from shakerproc.comparison.harmonics import shaken
from shakerproc.comparison.measured import with_repeats
from shakerproc.comparison.noise import Refuted
from shakerproc.model_files import read_model
from shakerproc.models import Element
from shakerproc.models.effects import EFFECTS
from shakerproc.testlog import read_testlog

CLEARANCE, CONTACT = 3e-5, 3.0 * JOINT.stiffness
GAP = Hidden(
    {},
    ((laws.GAP, (CONTACT, CLEARANCE, CLEARANCE), (-CLEARANCE, CLEARANCE)),),
)


def held(made, path, nominal=None, **options):
    log, model = written(made, path, nominal)
    return comparison.compare(read_model(model), read_testlog(log), **options)


@pytest.fixture(scope="module")
def linear(tmp_path_factory):
    made = campaign(
        drives=(drive(), drive(level=15.0, number=2), drive(number=3)), hold_out=(2,)
    )
    return made, tmp_path_factory.mktemp("linear")


@pytest.fixture(scope="module")
def perfect(linear):
    made, path = linear
    return held(made, path)


def test_the_true_model_leaves_the_noise_and_nothing_else(perfect):
    for test in perfect.tests:
        assert test.floor.source == "quiet lead-in"
        in_band = np.sqrt(np.diff(test.measured.error_band) / (0.5 * SAMPLE_RATE))
        assert test.floor.share[0] == pytest.approx(NOISE * in_band[0], rel=0.35)
        assert test.error == pytest.approx(test.noise, rel=0.15)
        assert test.errors[0].psd < NOISE
        assert test.errors[0].h1 < NOISE
    assert "explains every test" in comparison.sentence(perfect)


def test_a_wrong_stiffness_moves_the_peak_by_its_root(linear, tmp_path):
    made, _ = linear
    found = held(made, tmp_path, off(ONE_MASS, stiffness=1.3))
    for test in found.tests:
        errors = test.errors[0]
        assert errors.peak_hz == pytest.approx(120.0, abs=5.0)
        assert errors.peak_model_hz == pytest.approx(136.8, abs=5.0)
        assert errors.error > 0.5
    said = comparison.sentence(found)
    assert "the response peaks at 1" in said
    assert "much the same at every level" in said
    assert "--fit" in said
    share = found.bands.share[0, 0]
    worst = int(np.argmax(share))
    assert found.bands.edges[worst] < 142.0
    assert found.bands.edges[worst + 1] > 115.0
    assert share.sum() == pytest.approx(1.0)


@pytest.mark.slow
def test_a_fit_finds_the_numbers_within_their_intervals(linear, tmp_path):
    made, _ = linear
    found = held(made, tmp_path, off(ONE_MASS, 1.05, 0.75), fit=True)
    assert found.refit.tests == ("1", "2")
    assert found.refit.converged
    true = {"stiffness": JOINT.stiffness, "damping": JOINT.damping}
    for p in found.refit.parameters:
        assert p.value == pytest.approx(true[p.name], rel=2e-3)
        assert abs(p.value - true[p.name]) < 0.75 * (p.high - p.low)  # three deviations
        assert p.high / p.low < 1.01
        assert not p.at_bound
    assert found.held_out == pytest.approx(found.tests[2].noise, rel=0.2)
    assert found.refit.error_before > 50.0 * found.refit.error_after


@pytest.mark.slow
@pytest.mark.long
def test_intervals_of_a_fit_cover_the_truth_about_as_often_as_they_say(tmp_path):
    """40 noises on one motion; 95 % of twice as many intervals, within three deviations."""
    made = campaign(drives=(drive(),), seconds=2.0, noise=0.02)
    log, model = written(made, tmp_path, off(ONE_MASS, 1.01, 0.95))
    shaken_model = read_model(model)
    (test,) = comparison.measured_tests(read_testlog(log), shaken_model)
    rng = np.random.default_rng(9)
    run, inside = made.tests[0], []
    base = waveform(run.drive, 1, run.clean.shape[1])[:-1]
    for _ in range(40):
        noisy, control = (
            x + 0.02 * np.std(x) * rng.standard_normal((n, base.size))
            for x, n in ((run.clean, 1), (base, 2))
        )
        fitted = comparison.refit(
            shaken_model, [replace(test, responses=noisy, controls=control)]
        )
        inside += [
            p.low < t < p.high
            for p, t in zip(fitted.parameters, (JOINT.stiffness, JOINT.damping), strict=True)
        ]
    deviation = np.sqrt(0.95 * 0.05 / len(inside))
    assert np.mean(inside) >= 0.95 - 3.0 * deviation


@pytest.fixture(scope="module")
def with_gap(tmp_path_factory):
    made = campaign(hidden=((0, GAP),), drives=(drive(level=2.0), drive(level=12.0, number=2)))
    return held(made, tmp_path_factory.mktemp("gap"))


def test_a_gap_shows_as_force_missing_beyond_its_clearance(with_gap):
    """The force that lacks is k (|z| - a) beyond a, and none within."""
    motion = with_gap.tests[1].joints[0]
    lack = comparison.by_range(motion, motion.displacement)
    known = np.isfinite(lack.mean)
    z = lack.centre[known]
    expected = CONTACT * np.sign(z) * np.maximum(np.abs(z) - CLEARANCE, 0.0)
    assert np.max(np.abs(z)) > 2.0 * CLEARANCE
    assert_allclose(lack.mean[known], expected, atol=0.08 * np.max(expected))
    said = comparison.sentence(with_gap)
    assert "most beyond a displacement of" in said


def test_an_error_that_grows_with_the_level_is_told(with_gap):
    low, high = with_gap.tests
    assert low.measured.test.level < high.measured.test.level
    assert high.error > low.error


def test_the_missing_gap_put_in_explains_what_was_left(tmp_path):
    made = campaign(hidden=((0, GAP),), drives=(drive("sine sweep", 2.0),))
    log, model = written(made, tmp_path)
    before = read_model(model)
    gap = Element(EFFECTS["gap"](CONTACT, CLEARANCE), ("base", "coupon"))
    after = replace(before, elements=(*before.elements, gap))
    tests = comparison.measured_tests(read_testlog(log), before)
    left = comparison.compare_tests(before, tests).error
    found = comparison.compare_tests(after, tests)
    assert found.error < 0.05 * left


def test_noise_of_the_controls_passes_through_a_contact(tmp_path):
    """The floor of the true model is its error: both hold what the contact makes of noise.

    Single draws of that differ by a factor of three, and the error is one of them.
    """
    made = campaign(hidden=((0, GAP),), drives=(drive(level=4.0),), noise=0.02)
    log, model = written(made, tmp_path)
    true = read_model(model)
    gap = Element(EFFECTS["gap"](CONTACT, CLEARANCE), ("base", "coupon"))
    true = replace(true, elements=(*true.elements, gap))
    (test,) = comparison.compare(true, read_testlog(log)).tests
    assert 0.5 * test.noise < test.error < 2.0 * test.noise


def test_the_joint_that_lacks_force_is_the_one_with_the_gap(tmp_path):
    made = campaign(TWO_MASSES, ((1, GAP),), (drive(level=20.0),))
    found = held(made, tmp_path)
    lacks = {
        j.between: np.std(j.force - j.force_model) / np.std(j.force)
        for j in found.tests[0].joints
    }
    assert lacks["base", "m1"] < 0.03
    assert lacks["m1", "m2"] > 0.3
    assert "Between m1 and m2 the modelled force misses" in comparison.sentence(found)


def test_a_sweep_shows_the_third_harmonic_of_a_cubic_spring(tmp_path):
    cubic = Hidden({}, ((laws.CUBIC, (0.25 * JOINT.stiffness / CLEARANCE**2,), ()),))
    found = held(campaign(hidden=((0, cubic),), drives=(drive("sine sweep", 2.0),)), tmp_path)
    (h,) = found.tests[0].harmonics
    assert h.measured[0] == pytest.approx(1.0)
    assert h.measured[2] > 10.0 * h.predicted[2]
    assert h.measured[2] > 3.0 * h.measured[1]
    assert h.error[2] == pytest.approx(h.measured[2], rel=0.1)


def test_a_drifting_stiffness_shows_in_time(tmp_path):
    drift = Hidden({}, ((laws.DRIFT, (JOINT.stiffness, -0.02, 0.0), ()),))
    found = held(campaign(hidden=((0, drift),), drives=(drive(),)), tmp_path)
    time = found.tests[0].time
    assert time.slope[0] > 0.5
    assert np.nanmean(time.error[0, -6:]) > 2.0 * np.nanmean(time.error[0, 2:6])
    assert "grows" in comparison.sentence(found)


def test_a_force_and_a_displacement_will_do(tmp_path):
    forced = replace(ONE_MASS, force_on=0, measures="displacement")
    made = campaign(forced, drives=(drive(level=2.0),))
    found = held(made, tmp_path, off(forced, 1.3))
    (motion,) = found.tests[0].joints
    slope = np.polyfit(motion.displacement, motion.force, 1)[0]
    assert slope == pytest.approx(JOINT.stiffness, rel=0.03)
    assert held(made, tmp_path / "true").tests[0].error < 3.0 * NOISE


def without_rest(test):
    """The same test as a recorder has it that starts late and stops early."""
    n = test.quiet.stop + 400
    return replace(
        test, controls=test.controls[:, n:-n], responses=test.responses[:, n:-n], quiet=None,
        start=0, stop=test.stop - 2 * n,
    )  # fmt: skip


def test_the_band_above_and_repeats_stand_in_for_rest(linear, tmp_path):
    made, _ = linear
    log, model = written(made, tmp_path)
    shaken_model = read_model(model)
    first, *_ = map(without_rest, comparison.measured_tests(read_testlog(log), shaken_model))
    noise = comparison.noise_of(first.channels)
    assert (noise.source, noise.input_source) == (
        "band above the excitation",
        "disagreement of the controls",
    )
    rng = np.random.default_rng(1)
    again = replace(
        first,
        test=replace(first.test, id=9),
        responses=first.responses + 0.02 * np.std(first.responses) * rng.standard_normal(
            first.responses.shape
        ),
    )  # fmt: skip
    above = ("band above the excitation",)
    pair = with_repeats([first, again], {"1": Refuted(above, above)})
    assert pair[0].noise.source == "repeats"
    expected = (0.02**2 / 2.0) * np.var(first.responses) / (first.sample_rate / 2.0)
    assert np.median(pair[0].noise.responses) == pytest.approx(expected, rel=0.2)


def test_motion_that_cannot_be_predicted_is_scored_in_windows(linear, tmp_path):
    made, _ = linear
    log, model = written(made, tmp_path)
    plain = read_model(model)
    spring, damper = plain.elements
    loose = Element(EFFECTS["gap"](3.0 * JOINT.stiffness, 2e-5), ("base", "coupon"))
    weak = replace(spring, effect=EFFECTS["spring"](0.05 * JOINT.stiffness))
    chaotic = replace(plain, elements=(weak, damper, loose))
    (test, *_) = comparison.measured_tests(read_testlog(log), chaotic)
    found = comparison.compare_tests(chaotic, [test])
    (one,) = found.tests
    assert not one.prediction.predictable
    assert 0.0 < one.prediction.horizon_s < 5.0
    assert one.errors[0].error == pytest.approx(one.error)
    alike, same = comparison.scored_alike(comparison.compare_tests(plain, [test]), found)
    assert same is found
    assert np.array_equal(
        alike.tests[0].prediction.scored.counted, one.prediction.scored.counted
    )
    assert alike.error < 0.02  # the true model, from starts that it finds itself


def test_the_document_is_json_and_the_table_has_its_columns(perfect):
    document = json.loads(json.dumps(comparison.document_of(perfect), allow_nan=False))
    assert document["schema"] == "shakerproc-compare/1"
    sensor = document["tests"][0]["sensors"][0]
    assert len(sensor["by_band"]["error"]) == len(document["bands_hz"])
    rows = comparison.rows_of(perfect)
    assert len(rows) == 3
    assert all(len(row) == len(comparison.COLUMNS) for row in rows)


def test_the_edges_pass_the_band_and_nothing_far_from_it():
    frequency = np.array([1.0, 8.0, 12.0, 50.0, 88.0, 112.0, 200.0])
    gain = edges(frequency, (10.0, 100.0))
    assert_allclose(gain, [0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0])


def test_what_is_shaken_is_found():
    drive_signal = np.zeros(10000)
    drive_signal[3000:8000] = np.sin(np.arange(5000))
    part = shaken(drive_signal, 2000.0)
    assert abs(part.start - 3000) <= 100
    assert abs(part.stop - 8000) <= 100
