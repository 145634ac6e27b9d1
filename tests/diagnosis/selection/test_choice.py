"""Which hypothesis is named: what each leaves is given, in blocks and as an error."""

from types import SimpleNamespace

import numpy as np
import pytest

from shakerproc.diagnosis.selection import choice
from shakerproc.diagnosis.selection.scores import Score

JOINT = ("base", "mass")
FLOOR = 0.01


def hypothesis(left, *kinds, is_far=False, numbers=1):
    """Return a hypothesis that leaves this error in each of twenty blocks.

    `is_far` says that its model's own numbers are not the file's any more; each effect has so
    many `numbers`.
    """
    added = tuple(SimpleNamespace(kind=kind, between=JOINT) for kind in kinds)
    names = frozenset((kind, JOINT) for kind in kinds)
    of = SimpleNamespace(added=added, kinds=kinds, names=names, size=2 + numbers * len(kinds))
    rows = (left / FLOOR) ** 2 * np.ones(20)
    fit = SimpleNamespace(hypothesis=of, left=left, is_far=is_far, rows=rows)
    return Score(fit, np.log1p(rows))


@pytest.fixture
def found():
    """Return what a search found: the errors of hypotheses, by kinds.

    In windows where `whole` is given, the errors in whole tests.
    """

    def of(linear, errors, free=None, as_it_is=None, numbers=None, whole=None):
        effects = tuple(
            hypothesis(left, *kinds, numbers=(numbers or {}).get(kinds[0], 1))
            for kinds, left in errors.items()
        )
        bare = hypothesis(linear, is_far=as_it_is is not None and as_it_is > linear)
        return SimpleNamespace(
            as_it_is=None if as_it_is is None else hypothesis(as_it_is),
            linear=bare, effects=effects, floor=FLOOR,
            best=min((bare, *effects), key=lambda s: s.mean), rigid=(),
            free=None if free is None else hypothesis(free, "table"),
            left_by=lambda score: score.fit.left,
            is_explained_by=lambda score: score.fit.left <= 1.5 * FLOOR,
            form=SimpleNamespace(horizon=0.5 if whole else None),
            free_run=lambda score: hypothesis(whole[score.fit.hypothesis.kinds]),
        )  # fmt: skip

    return of


def named(found):
    standing = choice.standing_of(found)
    return standing[0].fit.hypothesis.kinds if standing else ()


def test_an_effect_that_explains_most_is_named_though_more_is_left_than_noise(found):
    of = found(0.5, {("coulomb_friction",): 0.17})
    assert named(of) == ("coulomb_friction",)
    assert not choice.is_outside(of)


@pytest.mark.parametrize(("left", "kinds"), [(0.573, ("bouc_wen",)), (0.574, ())])
def test_where_none_explains_most_one_is_named_that_takes_a_tenth_away(found, left, kinds):
    """0.637 with the model alone: a tenth less is 0.5733."""
    of = found(0.637, {("bouc_wen",): left})
    assert named(of) == kinds
    assert choice.leaves_more(of, of.linear)
    assert not choice.is_outside(of)


def test_of_those_that_take_a_tenth_away_the_simplest_of_the_best_is_named(found):
    errors = {("cubic_stiffness",): 0.4, ("gap",): 0.32, ("gap", "jenkins"): 0.319}
    assert named(found(0.5, errors)) == ("gap",)


def test_a_tenth_is_taken_of_the_model_as_it_is_too(found):
    assert named(found(0.6, {("gap",): 0.5}, as_it_is=0.52)) == ()


def test_a_law_that_is_no_surer_than_three_standard_errors_is_not_named(found):
    of = found(0.5, {("gap",): 0.3})
    apart = of.linear.logs - of.effects[0].logs
    uneven = np.where(np.arange(20) % 2, 1.0, -0.6) * 3.0 * apart  # by chance: as often worse
    unsure = Score(of.effects[0].fit, of.linear.logs - uneven)
    of.effects, of.best = (unsure,), of.linear
    assert named(of) == ()


@pytest.mark.parametrize(("in_whole_tests", "kinds"), [(0.9, ()), (0.4, ("jenkins",))])
def test_what_wins_in_windows_and_loses_in_whole_tests_is_not_named(
    found, in_whole_tests, kinds
):
    whole = {(): 0.5, ("jenkins",): in_whole_tests}
    assert named(found(0.5, {("jenkins",): 0.3}, whole=whole)) == kinds


@pytest.mark.parametrize("floor", [FLOOR, 0.1 * FLOOR])
def test_nothing_is_named_where_noise_or_what_sensors_cannot_tell_is_left(found, floor):
    of = found(0.99 * choice.NEGLIGIBLE, {("gap",): 0.85 * choice.NEGLIGIBLE})
    of.floor = 0.1 * FLOOR
    of.is_explained_by = lambda score: score.fit.left <= floor
    assert named(of) == ()
    assert not choice.leaves_more(of, of.linear)


@pytest.mark.parametrize(("in_whole_tests", "kinds"), [(0.3, 1), (0.03, 2)])
def test_two_effects_are_named_where_one_does_not_predict_whole_tests_better(
    found, in_whole_tests, kinds
):
    both = ("coulomb_friction", "jenkins")
    of = found(
        0.5, {both: 0.02, both[:1]: 0.06},
        whole={both: in_whole_tests, both[:1]: 0.1},
    )  # fmt: skip
    assert named(of) == both[:kinds]


@pytest.mark.parametrize(("without", "named_kinds"), [(0.05, ()), (0.5, ("attached_mode",))])
def test_one_effect_is_no_force_that_windows_choose_where_none_predicts_whole_tests(
    found, without, named_kinds
):
    """Where the model without it predicts little, motions may part from the right law."""
    of = found(without, {("attached_mode",): 0.02}, whole={(): 0.1, ("attached_mode",): 0.3})
    assert named(of) == named_kinds


def test_a_second_effect_that_helps_a_little_is_told_as_the_next(found):
    of = found(0.5, {("cubic_stiffness",): 0.06, ("cubic_stiffness", "gap"): 0.05})
    assert named(of) == ("cubic_stiffness",)
    more = choice.further(of, choice.standing_of(of)[0])
    assert more.fit.hypothesis.kinds == ("cubic_stiffness", "gap")


def test_a_first_effect_that_helps_a_little_is_told_as_the_next(found):
    """What is missing is too little to be named, as of a model that has its effect already."""
    of = found(0.008, {("cubic_stiffness",): 0.0079, ("contact_damping",): 0.006})
    of.floor = 0.0005
    assert named(of) == ()
    assert choice.further(of, choice.bare(of)).fit.hypothesis.kinds == ("contact_damping",)


def test_a_second_effect_that_explains_most_of_the_rest_is_named(found):
    of = found(0.5, {("cubic_stiffness",): 0.06, ("cubic_stiffness", "gap"): 0.02})
    assert named(of) == ("cubic_stiffness", "gap")


def test_the_noise_takes_no_part_in_what_is_left(found):
    of = found(2.0 * FLOOR, {("gap",): 1.2 * FLOOR})
    assert named(of) == ("gap",)


def test_a_force_without_a_name_that_predicts_better_is_outside_the_library(found):
    of = found(0.5, {("stop",): 0.1}, free=0.03)
    assert choice.is_outside(of)


@pytest.mark.parametrize(("free", "outside"), [(0.26, True), (0.28, False)])
def test_it_has_to_take_a_tenth_of_what_the_best_effect_leaves(found, free, outside):
    of = found(0.5, {("stop",): 0.3}, free=free)
    assert choice.is_outside(of) == outside
    assert named(of) == ("stop",)


def test_what_a_sensor_is_calibrated_to_is_not_outside_the_library(found):
    of = found(0.5, {("stop",): 0.0099}, free=0.0060)
    assert not choice.is_outside(of)


def test_an_effect_stands_beside_numbers_that_are_not_the_models_any_more(found):
    """Damping a thousand times the file's predicts a stuck joint as well as friction does."""
    friction = {("coulomb_friction",): 0.0100}
    assert named(found(0.0101, friction)) == ()
    searched = found(0.0101, friction, as_it_is=4.0)
    assert named(searched) == ("coulomb_friction",)


def test_no_effect_stands_that_predicts_worse_than_such_numbers(found):
    searched = found(0.0100, {("coulomb_friction",): 0.02}, as_it_is=4.0)
    assert named(searched) == ()


@pytest.mark.parametrize(("numbers", "kinds"), [(3, "general_bouc_wen"), (4, "gap")])
def test_a_law_of_many_numbers_has_to_explain_more(found, numbers, kinds):
    errors = {("general_bouc_wen",): 0.15, ("gap",): 0.24}
    assert named(found(0.5, errors, numbers={"general_bouc_wen": numbers})) == (kinds,)


def test_no_effect_is_named_that_leaves_more_than_the_model_as_it_is(found):
    assert named(found(0.9, {("stop",): 0.3}, as_it_is=0.2)) == ()


def test_the_model_as_it_is_stands_where_its_fitted_numbers_leave_more(found):
    of = found(0.9, {("stop",): 0.8}, as_it_is=0.4)
    assert choice.bare(of) is of.as_it_is
    within_noise = found(1.1 * FLOOR, {}, as_it_is=FLOOR)
    assert choice.bare(within_noise) is within_noise.linear
