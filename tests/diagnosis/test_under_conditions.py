"""Tests under different conditions, on simulated truths: each with its own model."""

from dataclasses import replace

import numpy as np
import pytest
from tests.diagnosis.component import ROD, component, rod
from tests.diagnosis.one_mass import DAMPING, JOINT, STIFFNESS, arrays_of, one_mass
from tests.few_effects import seek_few

from shakerproc.diagnosis import diagnose_arrays
from shakerproc.diagnosis.adding import add_to_arrays
from shakerproc.diagnosis.data import members_of, models_of, prepared
from shakerproc.diagnosis.differing import scales_between
from shakerproc.diagnosis.estimation.linear import fit_linear
from shakerproc.diagnosis.wanted import Wanted
from shakerproc.errors import DiagnosisError, ModelError
from shakerproc.models import EFFECTS, Conditions, Element, Scale

AT_2V = Scale("voltage", "2 V")
VOLTS = ("0 V", "1000 mV", "3 V")
GAP = {"stiffness": 8e4, "clearance": 1.5e-4}


def with_coil(effect, *, stiffness=STIFFNESS, damping=DAMPING, more=(), scale=AT_2V):
    """Return the mass with an effect that a voltage scales, and others that none does."""
    plain = one_mass(stiffness, damping)
    added = (Element(effect, JOINT, scale), *(Element(one, JOINT) for one in more))
    return replace(plain, elements=(*plain.elements, *added))


def under_volts(truth, levels=(4.0, 4.0, 6.0)):
    found = []
    for number, (said, level) in enumerate(zip(VOLTS, levels, strict=True), 1):
        at = Conditions({"voltage": said}, f"test {number}")
        (one,) = arrays_of(truth.under(at), levels=(level,), seconds=1.5, seed=number - 1)
        found.append(replace(one, name=at.of, conditions=at))
    return found


@pytest.fixture(scope="module")
def damped():
    """Tests of a damper of 20 N s/m at 2 V beside one of 12 N s/m."""
    return prepared(under_volts(with_coil(EFFECTS["damper"](20.0)), levels=(4.0, 4.0, 4.0)))


def test_a_damper_that_is_scaled_is_told_from_one_that_is_not(damped):
    file = with_coil(EFFECTS["damper"](16.0), stiffness=1.05e5, damping=15.0)
    found = fit_linear(file, damped)
    _, own, coil = (element.effect for element in found.model.elements)
    assert own.damping == pytest.approx(DAMPING, rel=0.02)
    assert coil.damping == pytest.approx(20.0, rel=0.02)
    assert max(found.left.values()) < 0.01
    alike = fit_linear(with_coil(EFFECTS["damper"](16.0), scale=None), damped)
    assert max(alike.left.values()) > 0.3


def test_tests_under_like_conditions_share_a_model():
    file = with_coil(EFFECTS["damper"](20.0))
    said = [Conditions({"voltage": one}, one) for one in ("1 V", "4 V", "1000 mV", "0 V")]
    (one,) = prepared(arrays_of(one_mass(), levels=(2.0,), seconds=0.5))
    tests = [replace(one, arrays=replace(one.arrays, conditions=own)) for own in said]
    models = models_of(file, tests)
    assert models[0] is models[2]
    assert [len(model.elements) for model in models] == [3, 3, 3, 2]
    assert [model.elements[-1].effect.damping for model in models] == [10.0, 40.0, 10.0, 12.0]
    table = np.array([(2, 0, 9), (3, 0, 9), (0, 0, 9), (2, 9, 9)])
    rows = {id(model): list(members) for model, members in members_of(models, table)}
    assert rows == {id(models[0]): [0, 2, 3], id(models[3]): [1]}
    assert models_of(one_mass(), tests) == (one_mass(),) * 4


@pytest.mark.parametrize(
    ("values", "found"),
    [
        ([{"voltage": "0 V"}, {"voltage": "1 V"}, {"voltage": "9 V"}], ["{voltage: 1 V}"]),
        ([{"voltage": "2 V"}, {"voltage": "2000 mV"}, {"voltage": "9 V"}], []),
        ([{"voltage": "2 V"}, {"voltage": "3 V"}, {}], []),
        ([{"voltage": "2 V"}, {"voltage": "3 N"}, {"voltage": "1 V"}], []),
        ([{"voltage": "-2 V"}, {"voltage": "3 V"}, {"voltage": "1 V"}], []),
        ([{"v": "1 V", "p": "2 kN"}, {"v": "2 V", "p": "1 kN"}, {"v": "2 V", "p": "0 N"}],
         ["{v: 2 V}", "{p: 2 kN}"]),
    ],
)  # fmt: skip
def test_what_may_scale_an_effect_differs_in_fitted_tests(values, found):
    """The third test is held out: it has to say the condition, and is no scale."""
    (one,) = prepared(arrays_of(one_mass(), levels=(2.0,), seconds=0.5))
    tests = [
        replace(one, arrays=replace(one.arrays, conditions=Conditions(own), hold_out=i == 2))
        for i, own in enumerate(values)
    ]
    assert [str(scale) for scale in scales_between(tests)] == found


@pytest.mark.slow
def test_a_gap_is_fitted_beside_friction_that_a_voltage_scales():
    """Right only if each test has its own friction: with one for all, most is left."""
    friction = EFFECTS["coulomb_friction"]
    tests = under_volts(with_coil(friction(1.0), more=[EFFECTS["gap"](**GAP)]))
    file = with_coil(friction(1.5), stiffness=1.05e5, damping=15.0)
    found = add_to_arrays(Wanted("gap"), file, tests)
    for name, value in GAP.items():
        assert found.parameters[name].value == pytest.approx(value, rel=0.02)
    assert found.linear["sliding_force base-mass"].value == pytest.approx(1.0, rel=0.03)
    assert found.errors.held_out.after < 0.02
    assert found.model.elements[2].scaled_by == AT_2V
    assert found.model.elements[-1].scaled_by is None


@pytest.mark.slow
@pytest.mark.long
def test_friction_that_a_voltage_scales_is_added_as_such():
    tests = under_volts(with_coil(EFFECTS["coulomb_friction"](1.0)))
    found = add_to_arrays(Wanted("coulomb_friction", scaled_by=AT_2V), one_mass(), tests)
    assert found.element.scaled_by == AT_2V
    assert found.parameters["sliding_force"].value == pytest.approx(1.0, rel=0.03)
    alike = add_to_arrays(Wanted("coulomb_friction"), one_mass(), tests, force=True)
    assert found.errors.held_out.after < 0.1 * alike.errors.held_out.after


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.parametrize("scaled", [True, False])
def test_a_diagnosis_tells_whether_a_voltage_scales_what_is_missing(scaled, monkeypatch):
    """Of the same log: friction that is the same at every voltage is not told to be scaled."""
    seek_few(monkeypatch, {"coulomb_friction", "cubic_stiffness", "quadratic_damping"})
    truth = with_coil(EFFECTS["coulomb_friction"](1.0), scale=AT_2V if scaled else None)
    found = diagnose_arrays(one_mass(1.03e5), under_volts(truth))
    assert found.verdict == "effect found"
    (effect,) = found.effects
    assert effect.kind == "coulomb_friction"
    assert (effect.scaled_by == Scale("voltage", "3 V")) if scaled else effect.scaled_by is None
    at = 1.5 if scaled else 1.0
    assert effect.parameters["sliding_force"].value == pytest.approx(at, rel=0.03)
    assert ("scaled by voltage" in found.sentence) == scaled


def test_friction_that_a_voltage_scales_is_found_where_a_motion_is_imposed():
    tests = []
    for number, volts in ((1, 1.0), (3, 4.0)):
        one = component(lambda _, v, volts=volts: 1.5 * volts * np.tanh(v / 1e-4), number)
        at = Conditions({"voltage": f"{volts} V"}, one.name)
        tests.append(replace(one, conditions=at))
    wanted = Wanted("coulomb_friction", ROD, scaled_by=AT_2V)
    found = add_to_arrays(wanted, rod(), tests)
    assert found.parameters["sliding_force"].value == pytest.approx(3.0, rel=0.05)


@pytest.mark.parametrize(
    ("kind", "scale", "error", "says"),
    [
        ("gap", Scale("current", "2 A"), ModelError, "test 1 says no current; add conditions"),
        ("gap", Scale("voltage", "2 N"), ModelError, "voltage of test 1: expected"),
        ("general_bouc_wen", AT_2V, DiagnosisError, "take bouc_wen"),
        ("table", AT_2V, DiagnosisError, "table cannot be scaled by voltage"),
    ],
)
def test_what_cannot_be_scaled_is_said_before_the_long_work(kind, scale, error, says):
    (one,) = arrays_of(one_mass(), levels=(2.0,), seconds=0.5)
    tests = [replace(one, conditions=Conditions({"voltage": "1 V"}, "test 1"))]
    with pytest.raises(error, match=says):
        add_to_arrays(Wanted(kind, scaled_by=scale), one_mass(), tests)
