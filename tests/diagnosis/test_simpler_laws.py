"""The simpler hypotheses that a fitted one contains, begun where it ended."""

import numpy as np
from numpy.testing import assert_allclose
from tests.diagnosis.one_mass import JOINT, added, data_of, one_mass

from shakerproc.diagnosis.campaign import campaign_of
from shakerproc.diagnosis.estimation.least_squares import fit
from shakerproc.diagnosis.estimation.windows import whole_tests, windows_of
from shakerproc.diagnosis.simpler_laws import simpler_laws
from shakerproc.models import EFFECTS

JENKINS = {"stiffness": 4e4, "slip_force": 0.5}


def test_play_of_next_to_nothing_before_friction_becomes_a_jenkins_element():
    data = data_of(one_mass(effect=EFFECTS["jenkins"](**JENKINS)), seconds=1.5)
    values = {"stiffness": 4e4, "clearance": 1e-8, "sliding_force": 0.5}
    hypothesis, x = added(data, "series", **values)
    series = fit(data, hypothesis, x, whole_tests(data, held_out=False), rounds=5)
    known = campaign_of(data.model, data.tests).known
    found = {one.hypothesis.kinds[0]: one for one in simpler_laws(data, series, known)}
    assert set(found) == {"jenkins"}  # a gap is far behind
    jenkins = found["jenkins"]
    assert jenkins.x.size == series.x.size - 1
    assert jenkins.level < series.level + 0.01
    effect = jenkins.hypothesis.model_at(jenkins.x).elements[-1].effect
    assert_allclose(effect.stiffness, JENKINS["stiffness"], rtol=0.05)
    assert_allclose(effect.slip_force, JENKINS["slip_force"], rtol=0.05)
    assert jenkins.hypothesis.added[0].between == JOINT


def test_each_effect_of_two_makes_room_for_what_it_contains_beside_the_other():
    data = data_of(one_mass(effect=EFFECTS["cubic_stiffness"](coefficient=3e11)), seconds=1.0)
    cubic, at = added(data, "cubic_stiffness", coefficient=3e11)
    friction = {"breakaway_force": 0.11, "excess": 0.1, "stribeck_velocity": 5e-3}
    stribeck, x = added(data, "stribeck_friction", **friction)
    both = cubic.with_added(stribeck.added[0])
    begun = np.concatenate([at, x[len(both.own) :]])
    pair = fit(data, both, begun, whole_tests(data, held_out=False), rounds=1)
    known = campaign_of(data.model, data.tests).known
    found = {one.hypothesis.kinds: one for one in simpler_laws(data, pair, known)}
    assert set(found) == {("cubic_stiffness", "coulomb_friction"), ("cubic_stiffness",)}
    alone = found["cubic_stiffness",]
    effect = alone.hypothesis.model_at(alone.x).elements[-1].effect
    assert_allclose(effect.coefficient, 3e11, rtol=0.05)


def test_without_an_attached_mass_windows_begin_as_the_other_mass_did():
    data = data_of(one_mass(effect=EFFECTS["cubic_stiffness"](coefficient=3e11)), seconds=1.0)
    cubic, at = added(data, "cubic_stiffness", coefficient=3e11)
    mode, x = added(data, "attached_mode", mass=1e-4, frequency=300.0, damping_ratio=0.02)
    both = cubic.with_added(mode.added[0])
    begun = np.concatenate([at, x[len(both.own) :]])
    windows = windows_of(data, 300, held_out=False, most=4)
    pair = fit(data, both, begun, windows, rounds=1)
    known = campaign_of(data.model, data.tests).known
    found = {one.hypothesis.kinds: one for one in simpler_laws(data, pair, known)}
    alone = found["cubic_stiffness",]
    assert pair.starts.shape == (4, 4)
    assert alone.starts.shape == (4, 2)
    assert alone.level < pair.level + 0.1
