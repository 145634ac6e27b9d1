"""A verdict holds on every test: on tests in memory of which one alone leaves more."""

from types import SimpleNamespace

import numpy as np
import pytest
from tests.diagnosis.one_mass import NOISE, arrays_of, one_mass

from shakerproc.comparison.free_run_error import Scored
from shakerproc.diagnosis import headline
from shakerproc.diagnosis.data import prepared
from shakerproc.diagnosis.estimate import Estimate
from shakerproc.diagnosis.estimation.uncertain import Number, Parts, Uncertainty, known_together
from shakerproc.diagnosis.selection import each_test
from shakerproc.diagnosis.selection.each_test import (
    shown_by_one,
    simulated_by,
    unexplained_tests,
)

TESTS = prepared(arrays_of(one_mass(), levels=(1.0, 2.0, 4.0), seconds=2.0))


def scored_of(left, seed=1):
    """Return the tests, simulated such that a share of each response is left beside noise."""
    rng = np.random.default_rng(seed)
    found = {}
    for i, (test, share) in enumerate(zip(TESTS, left, strict=True)):
        white = rng.standard_normal(test.responses.shape)
        simulated = test.responses * (1.0 + share) + NOISE * test.responses.std() * white
        counted = np.ones(test.n_samples, bool)
        counted[: test.start] = False
        found[i] = Scored(
            test.responses, simulated, test.sample_rate, test.arrays.band, counted
        )
    return found


@pytest.fixture
def found(monkeypatch):
    """Return what was found, of fits that are the shares that they leave of each test."""
    monkeypatch.setattr(each_test, "scored_tests", lambda _data, fit, _windows: scored_of(fit))
    still = {i: np.full((8, 1), NOISE) for i in range(3)}
    monkeypatch.setattr(each_test, "floors_of", lambda *_: still)
    monkeypatch.setattr(each_test, "bare", lambda found: found.linear)
    return SimpleNamespace(
        data=SimpleNamespace(tests=TESTS),
        form=SimpleNamespace(scored_fitted="fitted", held_out="held out"),
        floors_under=lambda _: still,
        linear=SimpleNamespace(fit=(0.0, 0.0, 0.3)),
    )


def score(*left):
    return SimpleNamespace(fit=left)


def unexplained(found, one):
    return unexplained_tests(found, one, simulated_by(found.data, found.form, one.fit))


def test_the_one_test_that_leaves_many_times_its_noise_is_named(found):
    (one, _) = unexplained(found, found.linear)
    assert one.name == "test 3"
    assert one.error == pytest.approx(0.3, rel=0.02)
    assert headline.unexplained_sentence(one).startswith(
        "Of test 3, which was fitted, 0.3 is left, 60 times its noise: repeat it"
    )


def test_noise_alone_leaves_no_test_unexplained(found):
    assert unexplained(found, score(0.0, 0.0, 0.0)) == []


def test_an_effect_that_one_test_shows_is_told_with_what_to_hold_out(found):
    one = shown_by_one(found, simulated_by(found.data, found.form, (0.0, 0.0, 0.0)))
    assert one.name == "test 3"
    assert "test 3 alone shows it" in headline.shown_by_one_sentence(one)


def test_an_effect_that_two_tests_show_is_not_that_of_one(found):
    found.linear = score(0.0, 0.2, 0.3)
    assert shown_by_one(found, simulated_by(found.data, found.form, (0.0, 0.0, 0.0))) is None


def test_a_test_that_may_show_an_effect_leaves_no_other_alone_with_it(found, monkeypatch):
    """A fall that is half of what it may be off by says neither yes nor no."""
    found.linear = score(0.0, 0.05, 0.3)
    unsure = iter([(0.0, 1e-4), (0.05, 0.1), (0.3, 1e-3)] * 2)
    monkeypatch.setattr(each_test, "fall", lambda *_: next(unsure))
    assert shown_by_one(found, simulated_by(found.data, found.form, (0.0, 0.0, 0.0))) is None


def test_old_and_new_of_what_was_off_are_told():
    stiffness = Estimate(6.89e5, 6.8e5, 7.0e5, "N/m", 0.01, 0.0)
    assert headline.off_sentences({"stiffness base-top": (5.96e5, stiffness)}) == [
        "Numbers of the model were off: stiffness base-top 596000 N/m in the file, "
        "fitted 689000 N/m +- 1 % by these tests."
    ]
    assert headline.off_sentences({}) == []


def test_of_two_numbers_of_which_only_the_product_is_told_it_is_said():
    """Both logarithms are open by 1, one against the other; their sum is told to 0.1 %."""
    apart = np.array([[1.0, -1.0], [-1.0, 1.0]])
    uncertainty = Uncertainty(1e-6 * np.eye(2), np.zeros((2, 2)), apart)
    numbers = {
        name: Number(value, row, unit)
        for name, value, row, unit in zip(
            ("stiffness", "length"), (2.0, 3.0), np.eye(2), ("N/m", "m"), strict=True
        )
    }
    (one,) = known_together(uncertainty, numbers)
    assert (one.combination, one.estimate.value) == ("product", 6.0)
    assert one.estimate.by_tests == pytest.approx(1.96e-3 * np.sqrt(2.0))
    assert headline.known_sentences([one]) == [
        "These tests do not tell stiffness and length one by one, only their product, "
        "6 N/m m +- 0.28 % by these tests."
    ]


def test_bounds_hold_both_parts_and_are_open_where_only_the_prior_holds_a_number():
    number = Parts(0.003, 0.004, 0.0).interval(2.0, "m")
    assert np.log(number.high / 2.0) == pytest.approx(1.96 * 0.005)
    open_one = Parts(0.2, 0.0, 0.5).interval(2.0, "m")
    assert (open_one.low, open_one.high, open_one.by_tests) == (None, None, None)
