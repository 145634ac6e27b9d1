"""Noise that a model beats on what was held out is no floor."""

from dataclasses import replace

import numpy as np
import pytest
from tests.diagnosis.one_mass import arrays_of, one_mass

from shakerproc.comparison.floor import floor_draws, floor_shares, is_beaten, with_more_refuted
from shakerproc.comparison.free_run_error import Scored
from shakerproc.comparison.noise import LEFT, NOT_REFUTED, UNKNOWN, Refuted
from shakerproc.comparison.noise_sources import ABOVE, DISAGREEMENT, QUIET, REPEATS
from shakerproc.diagnosis.data import prepared
from shakerproc.diagnosis.result import BeforeAfter, Errors


@pytest.mark.parametrize(("moved", "refuted"), [(0.3, True), (0.005, False)])
def test_what_noise_of_the_input_makes_is_refuted_by_a_smaller_error(moved, refuted):
    (test, *_) = prepared(arrays_of(one_mass()))
    measured = test.responses
    rng = np.random.default_rng(5)
    alike = rng.standard_normal((8, *measured.shape)) * measured.std()
    counted = np.ones(measured.shape[1], bool)
    scored = Scored(measured, 1.01 * measured, test.sample_rate, test.arrays.band, counted)
    quiet = prepared(arrays_of(one_mass()))[0].noise_density
    draws = floor_draws(scored, quiet, moved * alike)
    found = with_more_refuted(scored, quiet, draws, NOT_REFUTED)
    assert found.inputs == ((quiet.input_source,) if refuted else ())
    assert found.responses == ()


def test_the_last_noise_of_the_input_makes_no_more_than_the_error_that_was_left():
    (arrays, *_) = arrays_of(one_mass())
    last = Refuted(inputs=(DISAGREEMENT, QUIET, ABOVE))
    (test,) = prepared([arrays], refuted={arrays.name: last})
    assert test.noise_density.input_source == ABOVE
    counted = np.ones(test.n_samples, bool)
    scored = Scored(
        test.responses, 1.1 * test.responses, test.sample_rate, test.arrays.band, counted
    )
    passed = 0.3 * test.responses[np.newaxis] * np.array([1.0, -1.0])[:, None, None]
    draws = floor_draws(scored, test.noise_density, passed)
    found = with_more_refuted(scored, test.noise_density, draws, last)
    assert found.share == pytest.approx((0.1 / 0.3) ** 2, rel=1e-3)
    (less,) = prepared([arrays], refuted={arrays.name: found})
    assert less.noise_density.input_source == LEFT
    ratio = less.noise_density.input / test.noise_density.input
    assert ratio == pytest.approx(found.share)
    scaled = floor_draws(scored, less.noise_density, passed * found.share**0.5)
    assert with_more_refuted(scored, less.noise_density, scaled, found) == found


def test_an_error_that_sensors_alone_explain_leaves_no_room_for_noise_of_the_input():
    (arrays, *_) = arrays_of(one_mass())
    none = Refuted(inputs=(DISAGREEMENT, QUIET, ABOVE), share=0.0)
    (test,) = prepared([arrays], refuted={arrays.name: none})
    assert test.noise_density.input_source == UNKNOWN
    assert not test.noise_density.input.any()


def test_noise_of_an_input_that_is_not_known_is_not_refuted():
    (test, *_) = prepared(arrays_of(one_mass()))
    counted = np.ones(test.n_samples, bool)
    scored = Scored(
        test.responses, 1.01 * test.responses, test.sample_rate, test.arrays.band, counted
    )
    unknown = replace(test.noise_density, input_source=UNKNOWN)
    draws = floor_draws(scored, unknown, 0.3 * test.responses[np.newaxis])
    assert all(is_beaten(scored, one) for one in draws)
    assert with_more_refuted(scored, unknown, draws, NOT_REFUTED) == NOT_REFUTED


def test_noise_that_parts_the_motion_in_a_few_draws_only_is_not_refuted():
    (test, *_) = prepared(arrays_of(one_mass()))
    alike = np.random.default_rng(5).standard_normal((8, *test.responses.shape))
    parted = (
        alike * test.responses.std() * np.where(np.arange(8) < 6, 0.3, 0.005)[:, None, None]
    )
    counted = np.ones(test.n_samples, bool)
    scored = Scored(
        test.responses, 1.01 * test.responses, test.sample_rate, test.arrays.band, counted
    )
    draws = floor_draws(scored, test.noise_density, parted)
    assert is_beaten(scored, floor_shares(scored, test.noise_density, parted))
    assert with_more_refuted(scored, test.noise_density, draws, NOT_REFUTED) == NOT_REFUTED


def test_the_next_estimate_is_taken_where_one_is_refuted():
    arrays = arrays_of(one_mass())
    first = prepared(arrays)[0].noise_density.source
    refuted = {arrays[0].name: Refuted((first,))}
    after = [test.noise_density.source for test in prepared(arrays, refuted=refuted)]
    assert after[0] != first
    assert after[1] == first


def test_the_rest_before_a_test_stays_where_nothing_else_tells_its_noise():
    """The repeat and the band above are gone: one test, excited up to half the sample rate."""
    (arrays, *_) = (replace(one, band=(10.0, 900.0)) for one in arrays_of(one_mass()))
    refuted = {arrays.name: Refuted((QUIET, REPEATS, ABOVE))}
    (test,) = prepared([arrays], refuted=refuted)
    assert test.noise_density.source == QUIET
    (before,) = prepared([arrays])
    np.testing.assert_array_equal(test.noise_density.responses, before.noise_density.responses)


def test_an_unknown_floor_is_null_in_the_document():
    errors = Errors(BeforeAfter(1.0, 0.1), BeforeAfter(1.0, 0.1), float("nan"))
    assert errors.as_json()["noise_floor"] is None
