"""What is proposed for each thing that a diagnosis leaves open."""

from types import SimpleNamespace

import numpy as np
import pytest
from tests.diagnosis.one_mass import JOINT, arrays_of, one_mass

from shakerproc.diagnosis.data import prepared
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.joint_outcomes import Locked
from shakerproc.diagnosis.selection.next_test import Laboratory
from shakerproc.diagnosis.selection.proposing import as_good, proposed, unexercised
from shakerproc.diagnosis.selection.which_joint import alternatives, indistinguishable
from shakerproc.models import EFFECTS
from shakerproc.testlog import Shaker

MODEL = one_mass()
TESTS = prepared(arrays_of(MODEL, levels=(4.0,), seconds=2.0))
LABORATORY = Laboratory(TESTS, MODEL, Shaker(), 0)


def score(*kinds, model=MODEL, size=3):
    """Return a scored hypothesis with these kinds, whose model stands fitted."""
    hypothesis = SimpleNamespace(kinds=kinds, size=size, model_at=lambda _: model)
    return SimpleNamespace(fit=SimpleNamespace(hypothesis=hypothesis, x=None, gain=np.ones(1)))


CUBIC = score("cubic_stiffness", model=one_mass(effect=EFFECTS["cubic_stiffness"](4e10)))
GAP = score("gap", model=one_mass(effect=EFFECTS["gap"](5e4, 1e-4)), size=4)
FOUND = SimpleNamespace(
    data=DataSet(MODEL, TESTS), linear=score(), free=score(model=one_mass(2e5)), effects=(GAP,)
)


def test_richer_hypotheses_and_those_of_the_same_kinds_are_no_ties():
    richer, same = score("gap", "coupling", size=7), score("cubic_stiffness")
    assert as_good([CUBIC, GAP, richer, same]) == []
    assert as_good([GAP, CUBIC, richer, same]) == [CUBIC, same]
    assert as_good([]) == []


def test_what_does_as_well_is_told_with_all_the_effects_that_it_needs():
    """Dry friction and drag, told from friction and drift or from one element alone."""

    def named(*kinds):
        names = frozenset((kind, JOINT) for kind in kinds)
        hypothesis = SimpleNamespace(kinds=kinds, size=5, names=names, added=())
        return SimpleNamespace(fit=SimpleNamespace(hypothesis=hypothesis))

    own = named("coulomb_friction", "quadratic_damping")
    tied = [own, named("coulomb_friction", "stiffness_drift"), named("jenkins")]
    assert alternatives(tied) == ("coulomb_friction with stiffness_drift", "jenkins")
    assert indistinguishable(tied) == ("stiffness_drift", "jenkins")
    assert alternatives([own]) == ()


@pytest.mark.parametrize(
    ("standing", "verdict", "separates"),
    [
        ([GAP, CUBIC], "effect found", ("gap", "cubic_stiffness")),
        ([GAP], "outside library", ("gap",)),
        ([GAP], "cannot tell", ("gap",)),
    ],
)
def test_each_open_question_has_its_test(standing, verdict, separates):
    locked = [Locked(JOINT, 3.0)]
    (found,) = proposed(
        FOUND, standing, LABORATORY, verdict=verdict, locked=locked, unclosed=None
    )
    assert found.separates == separates


def test_where_nothing_is_open_nothing_is_proposed():
    settled = proposed(
        FOUND, [GAP], LABORATORY, verdict="effect found", locked=(), unclosed=None
    )
    assert settled == ()


def test_a_clearance_beyond_the_motion_was_never_closed():
    (motion,) = FOUND.data.across(JOINT)
    reach = float(np.max(np.abs(motion.displacement)))
    assert unexercised(FOUND, [0.5 * reach]) is None
    unclosed = unexercised(FOUND, [3.0 * reach, 2.0 * reach, 0.5 * reach])
    assert unclosed.clearance == 2.0 * reach
    assert unclosed.reach == reach
    (found,) = proposed(
        FOUND, [], LABORATORY, verdict="cannot tell", locked=(), unclosed=unclosed
    )
    assert "close its clearance" in found.reason
