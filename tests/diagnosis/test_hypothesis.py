"""Hypotheses: coordinates, bounds, and the model that they stand for."""

from dataclasses import replace

import numpy as np
import pytest
from tests.diagnosis.one_mass import JOINT, one_mass

from shakerproc.diagnosis.hypotheses.hypothesis import OWN_REACH, addition, hypothesis_of
from shakerproc.diagnosis.hypotheses.joints import identifications, linear_parts
from shakerproc.errors import ModelError
from shakerproc.models import EFFECTS, Element, Excitation, Model, Sensor
from shakerproc.models.effects import Damper, Spring
from shakerproc.models.identification import JointScales

AT = JointScales(1e-3, 0.3, 100.0, 1e5, 1.0, 4.0, 500.0)
KNOWN = identifications(AT)
STARTS = [
    pytest.param(kind, start, id=f"{kind} {i}")
    for kind, one in sorted(KNOWN.items())
    for i, start in enumerate(one.starts[:2])
]


def test_a_hypothesis_without_effects_frees_the_own_numbers():
    hypothesis = hypothesis_of(one_mass())
    assert [number.name for number in hypothesis.own] == ["stiffness", "damping"]
    model = hypothesis.model_at(np.log([1.2, 0.5]))
    assert model.elements[0].effect.stiffness == pytest.approx(1.2e5)
    assert model.elements[1].effect.damping == pytest.approx(6.0)
    assert model.masses == {"mass": 1.0}


def test_masses_are_free_where_a_force_drives():
    driven = Model(
        "driven",
        {"mass": 2.0},
        (Element(EFFECTS["spring"](1e5), JOINT),),
        Excitation("force", "mass"),
        {"top": Sensor("mass")},
    )
    hypothesis = hypothesis_of(driven)
    assert hypothesis.model_at(np.log([1.0, 1.5])).masses["mass"] == pytest.approx(3.0)


@pytest.mark.parametrize(("kind", "start"), STARTS)
def test_coordinates_come_back(kind, start):
    one = addition(kind, JOINT, KNOWN[kind], start)
    x = one.transformed(start)
    low, high = one.bounds()
    assert np.all(low <= x)
    assert np.all(x <= high)
    for name, value in one.values(x).items():
        assert value == pytest.approx(start[name], rel=1e-9, abs=1e-12)
    assert {**one.fixed, **one.values(x)}.keys() == start.keys()
    hypothesis = hypothesis_of(one_mass()).with_added(one)
    assert hypothesis.kinds == (kind,)
    last = hypothesis.model_at(np.concatenate([np.zeros(2), x])).elements[-1]
    assert last.effect.kind == kind
    assert last.between == JOINT


def test_x_is_split_into_its_parts():
    gap = addition("gap", JOINT, KNOWN["gap"], KNOWN["gap"].starts[0])
    twice = hypothesis_of(one_mass()).with_added(gap).with_added(gap)
    assert twice.size == 6
    assert [part.tolist() for part in twice.parts(np.arange(6.0))] == [[0, 1], [2, 3], [4, 5]]
    low, high = twice.bounds()
    assert low[:2].tolist() == [-OWN_REACH] * 2
    assert low.shape == high.shape == (6,)
    spread = twice.prior_spread()
    assert np.all(np.isfinite(spread[:2]))
    assert np.all(np.isinf(spread[2:]))


def test_numbers_beyond_the_bounds_are_taken_into_them():
    gap = addition("gap", JOINT, KNOWN["gap"], KNOWN["gap"].starts[0])
    x = gap.transformed({"stiffness": 1e30, "clearance": 1e-30})
    low, high = gap.bounds()
    assert x == pytest.approx([high[0], low[1]])
    assert gap.values(x + np.array([5.0, -5.0])) == pytest.approx(gap.values(x))


def test_numbers_that_no_model_can_have_are_told_with_the_model():
    hypothesis = hypothesis_of(one_mass())
    with pytest.raises(ModelError, match="one mass: "):
        hypothesis.model_at(np.array([np.nan, 0.0]))


@pytest.mark.parametrize("kind", ["spring", "damper"])
def test_what_every_joint_has_is_not_looked_for(kind):
    assert kind not in KNOWN


def test_a_damping_ratio_of_the_file_is_free_and_known_where_it_stands():
    elements = (
        Element(Spring(2e4), ("base", "coupon")),
        Element(Damper(damping_ratio=0.02), ("base", "coupon")),
    )
    sensors = {"a": Sensor("coupon")}
    model = Model("ratio", {"coupon": 0.5}, elements, Excitation("base acceleration"), sensors)
    hypothesis = hypothesis_of(model)
    assert [number.name for number in hypothesis.own] == ["stiffness", "damping_ratio"]
    damper = hypothesis.model_at(np.log([1.0, 1.5])).elements[1].effect
    assert damper.damping == pytest.approx(2.0 * 0.03 * np.sqrt(2e4 * 0.5))
    assert linear_parts(model, ("base", "coupon")) == pytest.approx((2e4, 4.0))


def test_of_many_numbers_as_few_models_are_far_off_as_of_one():
    """Numbers drawn as they are known beforehand: 0.27 % of models, whatever they hold."""
    rng, hypothesis = np.random.default_rng(3), hypothesis_of(one_mass())
    many = replace(hypothesis, own=hypothesis.own * 12)
    for one in (hypothesis, many):
        drawn = one.prior_spread() * rng.standard_normal((4000, one.size))
        assert np.mean([one.far(x).any() for x in drawn]) < 0.006
        assert one.far(np.eye(one.size)[0] * one.prior_spread()[0] * 4.5)[0]
