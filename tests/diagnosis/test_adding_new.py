"""`add`, on simulated truths whose every number is known."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.diagnosis.component import component, rod
from tests.diagnosis.one_mass import JOINT, QUIET, RATE, STIFFNESS, added, arrays_of, one_mass
from tests.few_effects import FEW, seek_few

from shakerproc.diagnosis import TestArrays, diagnose_arrays
from shakerproc.diagnosis.adding import add_to_arrays, worse_whole
from shakerproc.diagnosis.data import prepared
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.form import usable_forms
from shakerproc.diagnosis.estimation.least_squares import fit
from shakerproc.diagnosis.hypotheses.hypothesis import hypothesis_of
from shakerproc.diagnosis.one_effect import Fitted
from shakerproc.diagnosis.selection.scores import Score
from shakerproc.diagnosis.wanted import Wanted
from shakerproc.errors import DiagnosisError
from shakerproc.model_files import effect_files, load_effects
from shakerproc.models import EFFECTS, Element, Excitation, Model, Sensor
from shakerproc.simulation import simulate

GAP = {"stiffness": 8e4, "clearance": 1.5e-4}
CUBIC = 2e11
OWN = Path(__file__).parents[2] / "examples" / "my_effects.py"
SHORT = {"levels": (3.0, 6.0), "seconds": 1.5}
LONGER = {"levels": (3.0, 6.0), "seconds": 2.5}


@pytest.fixture(scope="module")
def gap():
    """The tests of a joint with play."""
    return arrays_of(one_mass(effect=EFFECTS["gap"](**GAP)), **SHORT)


def test_an_effect_is_fitted_with_the_model_s_own_numbers(gap):
    said = []
    found = add_to_arrays(
        Wanted("gap"), one_mass(stiffness=1.1 * STIFFNESS), gap, progress=said.append
    )
    assert "a further mode beside the effect" not in said  # noise alone is left
    assert found.element.between == JOINT
    for name, value in GAP.items():
        one = found.parameters[name]
        assert one.value == pytest.approx(value, rel=0.02)
        assert one.low < one.value < one.high
        assert getattr(found.element.effect, name) == pytest.approx(one.value, rel=1e-4)
    assert found.linear["stiffness base-mass"].value == pytest.approx(STIFFNESS, rel=0.01)
    spring = found.model.elements[0].effect
    assert spring.stiffness == pytest.approx(STIFFNESS, rel=0.01)
    assert found.model.elements[-1] == found.element
    assert found.errors.held_out.after < 0.1 * found.errors.held_out.before
    assert found.errors.fitted.before > 0.5
    assert found.worse == ""
    assert found.modes == found.notes == ()


@pytest.mark.parametrize(("kind", "said"), [("cubic_stiffness", 1), ("gap", 0)])
def test_an_effect_with_which_whole_tests_are_predicted_worse_is_told(gap, kind, said):
    """The truth is a gap; before stands the linear model, whose peak is elsewhere."""
    data = DataSet(one_mass(), prepared(gap))
    values = GAP if kind == "gap" else {"coefficient": 1e13}  # a wall
    form = usable_forms(data)[0]
    tried = (hypothesis_of(data.model), np.zeros(2)), added(data, kind, **values)
    fits = [fit(data, *one, form.fitted, rounds=0) for one in tried]
    scores = [Score(one, np.zeros(3)) for one in fits]
    notes = worse_whole(Fitted(data, form, fits[0], *scores))
    assert len(notes) == said
    assert all(f"Parts of {form.horizon:.3g} s" in note for note in notes)


def test_what_is_no_gain_is_refused_unless_it_is_forced(fitted_once):
    tests = arrays_of(one_mass(), levels=(3.0,), seconds=2.0)
    with pytest.raises(DiagnosisError, match="base and mass: the held-out error"):
        add_to_arrays(Wanted("cubic_stiffness"), one_mass(), tests)
    found = add_to_arrays(Wanted("cubic_stiffness"), one_mass(), tests, force=True)
    assert found.worse.startswith("the held-out error ")
    assert found.element.effect.kind == "cubic_stiffness"


def test_a_second_effect_is_fitted_beside_the_first():
    """The file has the gap already, 5 % off; the cubic spring is missing."""
    first = Element(EFFECTS["gap"](GAP["stiffness"], 1.05 * GAP["clearance"]), JOINT)
    hidden = Element(EFFECTS["gap"](**GAP), JOINT)
    truth = one_mass(effect=EFFECTS["cubic_stiffness"](CUBIC))
    tests = arrays_of(replace(truth, elements=(*truth.elements, hidden)), **SHORT)
    known = replace(one_mass(), elements=(*one_mass().elements, first))
    found = add_to_arrays(Wanted("cubic_stiffness"), known, tests)
    assert found.parameters["coefficient"].value == pytest.approx(CUBIC, rel=0.05)
    assert found.model.elements[2].effect.clearance == pytest.approx(1.5e-4, rel=0.02)
    assert {"stiffness base-mass", "gap.stiffness base-mass"} <= set(found.linear)


def test_a_table_is_the_force_of_the_hidden_law(gap):
    """Outside the play the hidden force is stiffness times what is beyond it."""
    found = add_to_arrays(Wanted("table"), one_mass(), gap)
    table = found.element.effect
    assert found.parameters == {}
    assert found.errors.held_out.after < 0.5 * found.errors.held_out.before
    force = dict(zip(table.displacement, (row[0] for row in table.force), strict=True))
    furthest = max(force)
    slope = found.model.elements[0].effect.stiffness - STIFFNESS
    missing = force[furthest] + slope * furthest
    assert missing == pytest.approx(8e4 * (furthest - 1.5e-4), rel=0.1)


@pytest.mark.parametrize(
    ("kind", "more", "says"),
    [
        ("gapp", {}, "no effect 'gapp'"),
        ("gap", {"between": ("base", "nowhere")}, "no place 'nowhere'"),
        ("gap", {"between": ("mass", "mass")}, "stands between two of base, mass"),
        ("spring", {}, "is not fitted"),
        ("gap", {"start": {"size": 1.0}}, "has no number 'size' to start from"),
    ],
)
def test_what_cannot_be_is_said_before_the_long_work(gap, kind, more, says):
    with pytest.raises(DiagnosisError, match=says):
        add_to_arrays(Wanted(kind, **more), one_mass(), gap)


def test_wrong_numbers_to_start_from_do_no_harm_nor_does_a_joint_named_the_other_way_round(gap):
    start = {"clearance": 1e-6}
    found = add_to_arrays(Wanted("gap", JOINT[::-1], start), one_mass(), gap)
    assert set(found.element.between) == set(JOINT)
    assert found.parameters["clearance"].value == pytest.approx(1.5e-4, rel=0.02)


@pytest.mark.parametrize(
    ("kind", "law", "numbers"),
    [
        ("coulomb_friction", lambda _, v: 7.0 * np.sign(v), {"sliding_force": 7.0}),
        (
            "gap",
            lambda x, _: 8e4 * np.sign(x) * np.maximum(np.abs(x) - 5e-4, 0.0),
            {"stiffness": 8e4, "clearance": 5e-4},
        ),
        ("cubic_stiffness", lambda x, _: 1e10 * x**3, {"coefficient": 1e10}),
    ],
)
def test_the_force_over_an_imposed_motion_tells_a_law(kind, law, numbers):
    found = add_to_arrays(Wanted(kind), rod(), [component(law, 1), component(law, 2)])
    for name, value in numbers.items():
        assert found.parameters[name].value == pytest.approx(value, rel=0.005)
    assert found.linear["stiffness base-rod"].value == pytest.approx(3e4, rel=0.002)
    assert found.errors.held_out.after < 0.01 * found.errors.held_out.before


def test_a_free_law_of_an_imposed_motion_is_refused():
    with pytest.raises(DiagnosisError, match="cannot be fitted to tests with an imposed"):
        add_to_arrays(Wanted("table"), rod(), [component(lambda x, _: 1e10 * x**3, 1)])


def test_an_effect_of_the_user_s_own_is_added_like_any_other():
    load_effects(OWN)
    try:
        tests = arrays_of(one_mass(effect=EFFECTS["detent"](3.0, 8e-4)), **LONGER)
        found = add_to_arrays(Wanted("detent"), one_mass(), tests)
    finally:
        effect_files.forget_effects()
    assert found.parameters["force"].value == pytest.approx(3.0, rel=0.03)
    assert found.parameters["pitch"].value == pytest.approx(8e-4, rel=0.03)


@pytest.mark.slow
def test_an_effect_of_the_user_s_own_is_diagnosed_like_any_other(monkeypatch):
    seek_few(monkeypatch, {*FEW, "detent"})
    load_effects(OWN)
    try:
        tests = arrays_of(one_mass(effect=EFFECTS["detent"](3.0, 8e-4)), **LONGER)
        found = diagnose_arrays(one_mass(), tests)
    finally:
        effect_files.forget_effects()
    (detent,) = found.effects
    assert detent.kind == "detent"
    assert detent.parameters["force"].value == pytest.approx(3.0, rel=0.01)


def chain(*more):
    """Return two masses in a row, with more elements."""
    made = [
        (EFFECTS["spring"](1e5), ("base", "a")), (EFFECTS["damper"](12.0), ("base", "a")),
        (EFFECTS["spring"](3e5), ("a", "b")), (EFFECTS["damper"](10.0), ("a", "b")),
    ]  # fmt: skip
    return Model(
        "chain", {"a": 1.0, "b": 0.5}, tuple(Element(*one) for one in [*made, *more]),
        Excitation("base acceleration"), {"top": Sensor("a"), "tip": Sensor("b")},
    )  # fmt: skip


def shaken(truth, level, number):
    """Return a test of a chain at an rms level [m/s^2]."""
    rng = np.random.default_rng(number)
    frequency = np.fft.rfftfreq(3000, 1.0 / RATE)
    inside = (frequency > 10.0) & (frequency < 300.0)
    drive = np.fft.irfft(inside * (rng.standard_normal((2, frequency.size)).T @ (1.0, 1j)))
    drive = np.concatenate([np.zeros(QUIET), level * drive / drive.std()])
    run = simulate(truth, drive, RATE, growth=False, tolerance=1e-8)
    noisy = [
        rows + 0.005 * rows.std() * rng.standard_normal(rows.shape)
        for rows in (drive[None], np.array([run.outputs[name] for name in ("top", "tip")]))
    ]
    return TestArrays(f"test {number}", RATE, *noisy, band=(10.0, 300.0))


@pytest.mark.slow
@pytest.mark.long
def test_an_effect_may_stand_where_the_model_has_nothing():
    """Friction between the base and the far mass, which no element joins."""
    truth = chain((EFFECTS["coulomb_friction"](2.0), ("base", "b")))
    tests = [shaken(truth, 3.0, 1), shaken(truth, 6.0, 2)]
    found = add_to_arrays(Wanted("coulomb_friction", ("b", "base")), chain(), tests)
    assert found.element.between == ("b", "base")
    assert found.parameters["sliding_force"].value == pytest.approx(2.0, rel=0.02)
