"""The diagnosis as a whole, on simulated truths."""

import json
from dataclasses import replace

import numpy as np
import pytest
from tests.diagnosis.component import component, rod
from tests.diagnosis.one_mass import DAMPING, JOINT, arrays_of, one_mass
from tests.few_effects import seek_few

from shakerproc.diagnosis import diagnose_arrays
from shakerproc.errors import DiagnosisError
from shakerproc.models import EFFECTS

GAP = {"stiffness": 8e4, "clearance": 1.5e-4}


@pytest.mark.slow
@pytest.mark.long  # the demo and the tutorial find one in make test, too
def test_a_gap_is_found_with_its_numbers():
    truth = one_mass(effect=EFFECTS["gap"](**GAP))
    found = diagnose_arrays(one_mass(), arrays_of(truth, levels=(6.0,), seconds=4.0))
    assert found.verdict == "effect found"
    (effect,) = found.effects
    assert (effect.kind, set(effect.between)) == ("gap", set(JOINT))
    for name, value in GAP.items():
        assert effect.parameters[name].value == pytest.approx(value, rel=0.02)
    assert found.errors.held_out.after < 0.05 * found.errors.held_out.before
    low, high = found.where.displacement_m
    assert 0.5 * GAP["clearance"] < low < high  # within the play nothing is missing
    assert any(a < 60.0 and b > 40.0 for a, b in found.where.bands_hz)  # the resonance
    assert found.where.tests == ("test 1",)
    assert json.loads(json.dumps(found.as_json()))["verdict"] == "effect found"


@pytest.mark.slow
def test_where_nothing_is_missing_no_effect_is_named():
    found = diagnose_arrays(one_mass(), arrays_of(one_mass(), levels=(4.0,), seconds=1.5))
    assert found.verdict == "nothing missing"
    assert found.effects == ()
    assert found.linear["stiffness base-mass"].value == pytest.approx(1e5, rel=5e-3)
    assert found.errors.held_out.after < 3.0 * found.errors.noise_floor


@pytest.mark.slow
def test_a_number_of_the_file_that_is_another_by_far_is_told_and_no_verdict(few_effects):
    file = one_mass(damping=DAMPING / 40.0)
    found = diagnose_arrays(file, arrays_of(one_mass(), levels=(4.0,), seconds=1.5))
    assert found.verdict == "cannot tell"
    assert "damping base-mass 4" in found.sentence  # some 40 times
    assert "Check the units" in found.sentence
    assert found.linear["damping base-mass"].value == pytest.approx(DAMPING, rel=0.05)


@pytest.mark.slow
def test_a_joint_that_held_is_said_to_hold_and_nothing_is_named(few_effects):
    rng = np.random.default_rng(0)
    tests = [
        replace(
            test,
            responses=test.controls
            + 0.005 * np.std(test.controls) * rng.standard_normal(test.controls.shape),
        )
        for test in arrays_of(one_mass(), levels=(4.0,), seconds=1.5)
    ]
    found = diagnose_arrays(one_mass(), tests)
    assert found.verdict == "cannot tell"
    assert "never slipped and holds at least" in found.sentence
    assert found.effects == ()
    (locked,) = found.locked
    largest = max(np.max(np.abs(test.controls)) for test in tests)
    assert locked.holds == pytest.approx(1.0 * largest, rel=0.1)  # 1 kg


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "kinds"),
    [
        (lambda x, _: 8e4 * np.sign(x) * np.maximum(np.abs(x) - 5e-4, 0.0), ["gap"]),
        (lambda x, _: 0.0 * x, []),
    ],
)
@pytest.mark.parametrize("all_effects", [False, pytest.param(True, marks=pytest.mark.long)])
def test_component_tests_are_judged_by_the_force(law, kinds, all_effects, monkeypatch):
    if not all_effects:
        seek_few(monkeypatch)
    found = diagnose_arrays(rod(), [component(law, 1), component(law, 2)])
    assert found.verdict == ("effect found" if kinds else "nothing missing")
    assert [effect.kind for effect in found.effects] == kinds
    assert found.linear["stiffness base-rod"].value == pytest.approx(3e4, rel=0.005)
    assert found.errors.held_out.after < 0.01 * found.errors.held_out.before


def test_a_drive_that_repeats_itself_is_told_before_the_long_work():
    said = []
    (once,) = arrays_of(one_mass(), levels=(4.0,), seconds=1.2)
    part = once.controls.shape[1] // 4
    again = replace(once, controls=np.tile(once.controls[:, -part:], 4))
    again = replace(again, responses=np.tile(once.responses[:, -part:], 4))
    with pytest.raises(DiagnosisError, match=r"repeats itself .* mark another test hold_out"):
        diagnose_arrays(one_mass(), [again], progress=said.append)
    assert not said
