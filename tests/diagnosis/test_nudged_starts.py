"""Starts of a race: springs between two places to rest, whose conditions are written out."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from tests.diagnosis.chains import campaign, chain, identifications, with_effect

from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.least_squares import fit
from shakerproc.diagnosis.hypotheses.hypothesis import hypothesis_of
from shakerproc.diagnosis.nudged.ladder import ladder_of
from shakerproc.diagnosis.nudged.starts import own_starts
from shakerproc.models.effects import CubicStiffness

KINDS = ("cubic_stiffness", "quadratic_stiffness", "coulomb_friction", "gap")
JOINT = ("base", "m1")
STIFFNESS = 1.04e5


@pytest.fixture(scope="module")
def turned():
    model = chain(1, stiffer=1.04)
    tests = campaign(with_effect(chain(1), CubicStiffness(2e10), JOINT))
    known = identifications(model, tests, KINDS)
    data, none = DataSet(model, tests), hypothesis_of(model)
    on = fit(data, none, np.zeros(none.size), ladder_of(data)[0].windows, rounds=0)
    starts = own_starts(on, known)
    return [
        (hypothesis, x)
        for tried in starts.values()
        for hypothesis, x in tried
        if any(number.sign < 0.0 for number in hypothesis.own)
    ]


def test_the_joint_rests_in_wells_that_are_as_stiff_as_the_file_says(turned):
    models = [hypothesis.model_at(x) for hypothesis, x in turned]
    linear = np.array([model.elements[0].effect.stiffness for model in models])
    cubic = np.array([model.elements[2].effect.coefficient for model in models])
    assert np.all(linear < 0.0)
    assert np.all(cubic > 0.0)
    place = np.sqrt(-linear / cubic)
    assert_allclose(linear + 3.0 * cubic * place**2, STIFFNESS)
    assert place.max() / place.min() > 5.0


def test_only_a_law_that_pushes_back_on_both_sides_makes_wells(turned):
    assert {hypothesis.kinds for hypothesis, _ in turned} == {("cubic_stiffness",)}
