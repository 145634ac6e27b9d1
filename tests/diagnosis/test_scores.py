"""Scores of hypotheses, on logarithms made up."""

from types import SimpleNamespace

import numpy as np
import pytest

from shakerproc.diagnosis.selection.scores import (
    Score,
    best_of,
    gain,
    leaves_something,
    ranked,
    simplest_alike,
)


def score(logs, size=2, fitted=None, *, is_far=False):
    """Return a score; what it was fitted to is left as what was held out, or as given."""
    logs = np.array(logs, float)
    rows = np.expm1(logs) if fitted is None else np.array(fitted, float)
    own = SimpleNamespace(hypothesis=SimpleNamespace(size=size), rows=rows, is_far=is_far)
    return Score(own, logs)


def test_where_blocks_speak_both_ways_the_error_is_that_of_their_mean():
    apart = np.random.default_rng(0).standard_normal(40_000) + 0.01
    found = gain(score(np.zeros(apart.size)), score(apart))
    assert found.mean == pytest.approx(np.mean(apart))
    assert found.error == pytest.approx(np.std(apart) / np.sqrt(apart.size), rel=0.05)


def test_a_gain_in_few_blocks_against_which_none_speaks_is_certain():
    few = np.zeros(40)
    few[:4] = 6.0
    assert gain(score(np.zeros(40)), score(few)).t > 6.0
    few[4:8] = -6.0
    assert abs(gain(score(np.zeros(40)), score(few)).t) < 0.1


def test_a_gain_has_the_opposite_sign_the_other_way_round():
    one, other = score([1, 2, 3, 4]), score([2, 4, 4, 8])
    assert gain(other, one).mean == -gain(one, other).mean


def test_one_block_tells_no_gain():
    assert gain(score([1]), score([2])).t == 0.0


def test_the_same_prediction_is_no_gain():
    assert gain(score([1, 2, 3]), score([1, 2, 3])).t == 0.0


def test_the_best_comes_first():
    best, worst = score([1, 1]), score([5, 5])
    assert ranked([worst, best]) == [best, worst]


def scatter(seed, n=50):
    """Return draws whose mean is exactly 0."""
    drawn = np.random.default_rng(seed).standard_normal(n)
    return drawn - drawn.mean()


def test_a_simpler_one_that_predicts_alike_stands_before_the_best():
    rich = score(scatter(1), size=5)
    simple = score(rich.logs + 0.01 + scatter(2), size=3)
    poor = score(rich.logs + 2.0 + 0.1 * scatter(3), size=2)
    assert simplest_alike([poor, rich, simple]) == [simple, rich]


def test_of_equally_many_numbers_the_better_stands_first():
    best = score(scatter(4))
    other = score(best.logs + 0.01 + scatter(5))
    assert simplest_alike([other, best]) == [best, other]


def test_what_was_fitted_to_decides_where_only_noise_of_the_rest_is_left():
    noise = np.full(60, np.log(2.0))
    poor = score(noise, size=2, fitted=np.full(80, 50.0))
    good = score(noise + 0.02, size=5, fitted=np.full(80, 1.1))
    assert gain(good, poor).t > 6.0
    assert best_of([poor, good]) is good
    assert simplest_alike([poor, good]) == [good]


def test_what_was_held_out_decides_where_more_than_noise_of_it_is_left():
    held_out = score(np.full(60, 2.0), fitted=np.full(80, 1.1))
    better = score(np.full(60, 1.5), fitted=np.full(80, 50.0))
    assert gain(better, held_out).mean == pytest.approx(0.5)


def test_noise_is_not_judged_by_what_was_fitted_to_it():
    one = score(np.full(60, np.log(2.0)), fitted=np.full(80, 1.6))
    richer = score(np.full(60, np.log(2.0)), fitted=np.full(80, 0.9))
    assert gain(richer, one).mean == 0.0


def test_some_blocks_of_what_was_fitted_to_tell_where_the_rest_is_noise():
    silent = np.full(60, np.log(1.2))
    some = np.full(80, 0.2)
    some[:4] = 20.0
    assert gain(score(silent, fitted=np.full(80, 0.2)), score(silent, fitted=some)).t > 6.0


def test_one_whose_numbers_are_not_the_models_is_no_simpler():
    far, own = score([1.0, 1.0, 1.0], size=2, is_far=True), score([1.0, 1.0, 1.0], size=4)
    assert simplest_alike([far, own]) == [own, far]


def test_more_than_noise_is_left_where_it_is_of_one_part_of_the_tests():
    assert not leaves_something(score(np.full(60, np.log(2.0))))
    assert leaves_something(score(np.full(60, np.log(2.0)), fitted=np.full(60, 3.0)))
    assert leaves_something(score(np.full(60, np.log(4.0)), fitted=np.full(60, 1.0)))
