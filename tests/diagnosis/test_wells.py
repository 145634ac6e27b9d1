"""Springs between two places to rest, against the conditions of rest written out."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from tests.diagnosis.chains import campaign, chain, identifications, with_effect

from shakerproc.diagnosis.estimation.beginnings import own_start, turned
from shakerproc.diagnosis.hypotheses.hypothesis import addition, hypothesis_of
from shakerproc.diagnosis.screening import screen
from shakerproc.models.effects import CubicStiffness

KINDS = ("cubic_stiffness", "quadratic_stiffness", "coulomb_friction", "gap")
JOINT = ("base", "m1")
STIFFNESS = 1.04e5


@pytest.fixture(scope="module")
def searched():
    model = chain(1, stiffer=1.04)
    tests = campaign(with_effect(chain(1), CubicStiffness(2e10), JOINT))
    known = identifications(model, tests, KINDS)
    return model, known, screen(model, tests, [JOINT], known)


def test_the_joint_rests_in_wells_that_are_as_stiff_as_the_file_says(searched):
    wells = [start for start in searched[2] if start.stiffness[0] < -1.0]
    linear = np.array([STIFFNESS * (1.0 + start.stiffness[0]) for start in wells])
    cubic = np.array([start.values["coefficient"] for start in wells])
    assert np.all(linear < 0.0)
    assert np.all(cubic > 0.0)
    place = np.sqrt(-linear / cubic)
    assert_allclose(linear + 3.0 * cubic * place**2, STIFFNESS)
    assert place.max() / place.min() > 5.0


def test_only_a_law_that_pushes_back_on_both_sides_makes_wells(searched):
    assert {start.kind for start in searched[2] if start.stiffness[0] < -1.0} == {
        "cubic_stiffness"
    }


def test_the_model_of_such_a_start_has_that_stiffness(searched):
    model, known, starts = searched
    start = next(start for start in starts if start.stiffness[0] < -1.0)
    one = addition(start.kind, JOINT, known[JOINT][start.kind], start.values)
    hypothesis = turned(hypothesis_of(model), start).with_added(one)
    x = np.concatenate([own_start(hypothesis, start), one.transformed(start.values)])
    spring, _, cubic = (element.effect for element in hypothesis.model_at(x).elements)
    assert spring.stiffness == pytest.approx(STIFFNESS * (1.0 + start.stiffness[0]))
    assert cubic.coefficient == pytest.approx(start.values["coefficient"])
