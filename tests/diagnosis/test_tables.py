"""The missing force as a table: laws that are known, and what is told of a wrong joint."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from tests.diagnosis.chains import RATE, campaign, chain, joints_of, with_effect

from shakerproc.diagnosis.screening import free_laws
from shakerproc.models.effects import CubicStiffness, PowerLawDamping, QuadraticDamping
from shakerproc.simulation import simulate

ONE = ("base", "m1")
LAWS = {
    "displacement": (CubicStiffness(2e10), (13, 1)),
    "velocity": (QuadraticDamping(150.0), (1, 13)),
    "both": (PowerLawDamping(120.0, 5e-4, 2.0), (9, 9)),
}


@pytest.mark.parametrize("variable", LAWS)
def test_the_table_is_the_hidden_law_within_where_it_moved(variable):
    effect, shape = LAWS[variable]
    tests = campaign(with_effect(chain(1), effect, ONE))
    law = free_laws(chain(1), tests, [ONE])[0]
    assert (len(law.effect.displacement), len(law.effect.velocity)) == shape
    assert law.predicted > 0.99
    z, v = np.array(law.effect.displacement)[:, None], np.array(law.effect.velocity)
    inside = (z / np.max(np.abs(z) + 1e-300)) ** 2 + (v / np.max(np.abs(v) + 1e-300)) ** 2 < 0.9
    true = effect.force_at(z + 0.0 * v, v + 0.0 * z)
    error = np.abs(np.array(law.effect.force) - true)[inside]
    assert np.max(error) < 0.04 * np.max(np.abs(true))


def test_a_table_in_place_of_the_hidden_law_moves_the_model_as_the_truth_moves():
    truth = with_effect(chain(1), CubicStiffness(2e10), ONE)
    tests = campaign(truth)
    law = free_laws(chain(1), tests, [ONE])[0]
    known = tests[0].arrays.controls[0]
    table = simulate(with_effect(chain(1), law.effect, ONE), known, RATE).outputs["a1"]
    linear = simulate(chain(1), known, RATE).outputs["a1"]
    measured = tests[0].arrays.responses[0]
    error, before = np.std(measured - table), np.std(measured - linear)
    assert error < 0.1 * before


def test_the_joint_that_lacks_a_force_predicts_best_and_linear_changes_are_told():
    tests = campaign(with_effect(chain(2), CubicStiffness(2e10), ("m1", "m2")))
    laws = free_laws(chain(2, stiffer=0.96), tests, joints_of(chain(2)))
    assert laws[0].between == ("m1", "m2")
    assert_allclose(laws[0].stiffness[0], 1.0 / 0.96 - 1.0, atol=0.01)


def test_nothing_missing_is_a_table_of_nothing():
    law = free_laws(chain(1), campaign(chain(1)), [ONE])[0]
    assert law.predicted < 0.02
    assert np.max(np.abs(law.effect.force)) < 0.01 * 100.0  # the spring carries 100 N
