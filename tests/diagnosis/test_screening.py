"""The screening against simulated truths, closed forms and regressions done plainly."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from tests.diagnosis.chains import (
    campaign,
    chain,
    identifications,
    joints_of,
    with_effect,
)

from shakerproc.diagnosis.screening import screen, screen_pairs
from shakerproc.diagnosis.screening.regression import Regression
from shakerproc.diagnosis.screening.shared import screening_of
from shakerproc.diagnosis.screening.transfer import linear_model
from shakerproc.models.effects import (
    AttachedMode,
    CoulombFriction,
    CubicStiffness,
    Gap,
    Jenkins,
    QuadraticDamping,
)

KINDS = (
    "gap", "cubic_stiffness", "quadratic_damping", "coulomb_friction", "jenkins",
    "attached_mode", "stiffness_drift",
)  # fmt: skip
ONE = ("base", "m1")
HIDDEN = {
    "gap": Gap(1.2e5, 1e-4),
    "cubic_stiffness": CubicStiffness(2e10),
    "quadratic_damping": QuadraticDamping(150.0),
    "jenkins": Jenkins(4e4, 4.0),
    "attached_mode": AttachedMode(0.06, 70.0, 0.02),
}


@pytest.fixture(scope="module")
def found():
    """Return the model, the tests and the starts for each hidden effect."""
    model = chain(1, stiffer=1.04)
    result = {}
    for kind, effect in HIDDEN.items():
        tests = campaign(with_effect(chain(1), effect, ONE))
        known = identifications(model, tests, KINDS)
        result[kind] = tests, screen(model, tests, [ONE], known)
    return result


@pytest.mark.parametrize("kind", HIDDEN)
def test_the_hidden_effect_comes_first_with_its_numbers(found, kind):
    start = found[kind][1][0]
    assert start.kind == kind
    assert start.kept
    assert start.explained > 0.98
    for name in {"attached_mode": ("mass", "frequency")}.get(kind, HIDDEN[kind].__slots__):
        assert_allclose(start.values[name], getattr(HIDDEN[kind], name), rtol=0.03)
    assert_allclose(start.stiffness, 1.0 / 1.04 - 1.0, atol=3e-3)


def test_what_nearly_all_explains_rules_the_others_out(found):
    starts = found["cubic_stiffness"][1]
    assert starts[0].left < 2.0
    assert {s.kind for s in starts if s.kept} == {"cubic_stiffness"}


def test_a_linear_joint_leaves_noise_and_shows_how_far_its_stiffness_is_off():
    model = chain(1, stiffer=0.95)
    tests = campaign(chain(1))
    screening = screening_of(model, tests, [ONE])
    regression = screening.regression
    assert_allclose(regression.cost / screening.equations.n_numbers, 1.0, atol=0.3)
    stiffness, damping = screening.relative_changes(regression.amplitudes)
    assert_allclose(stiffness, 1.0 / 0.95 - 1.0, atol=1e-3)
    assert_allclose(damping, 0.0, atol=0.05)
    known = identifications(model, tests, KINDS)
    assert all(start.explained < 0.02 for start in screen(model, tests, [ONE], known))


def test_dry_friction_is_never_ruled_out_where_nothing_explains_the_tests():
    model = chain(1)
    tests = campaign(with_effect(model, CoulombFriction(4.0), ONE), levels=(2.0, 4.0))
    starts = screen(model, tests, [ONE], identifications(model, tests, KINDS))
    friction = [start for start in starts if start.kind == "coulomb_friction"]
    assert all(start.kept for start in friction)
    forces = [start.values["sliding_force"] for start in friction]
    assert min(forces) < 4.0 < max(forces)
    assert "coulomb_friction" in [start.kind for start in starts[:4]]


@pytest.mark.parametrize("sensors", [None, (1, 2)], ids=["all", "without m1"])
def test_the_joint_of_a_chain_is_found(sensors):
    model, joint = chain(3, stiffer=1.03, sensors=sensors), ("m2", "m3")
    tests = campaign(with_effect(chain(3, sensors=sensors), Gap(2e5, 6e-5), joint))
    known = identifications(model, tests, ("gap", "cubic_stiffness", "quadratic_damping"))
    start = screen(model, tests, joints_of(model), known)[0]
    assert (start.kind, start.between) == ("gap", joint)
    assert_allclose(start.values["clearance"], 6e-5, rtol=0.1)


def test_a_second_effect_is_found_beside_the_first():
    model = chain(1, stiffer=1.02)
    both = with_effect(
        with_effect(chain(1), HIDDEN["cubic_stiffness"], ONE), Jenkins(4e4, 4.0), ONE
    )
    tests = campaign(both)
    known = identifications(model, tests, KINDS)
    values = {"coefficient": 1.9e10}
    start = screen_pairs(model, tests, known, ("cubic_stiffness", ONE, values))[0]
    assert start.kind == "jenkins"
    assert_allclose(start.values["stiffness"], 4e4, rtol=0.1)


def test_what_the_model_has_already_is_not_what_is_missing_next():
    """A cubic spring in the file, 5 % off: the damping beside it comes first."""
    truth = with_effect(chain(1), HIDDEN["cubic_stiffness"], ONE)
    tests = campaign(with_effect(truth, HIDDEN["quadratic_damping"], ONE))
    model = with_effect(chain(1), CubicStiffness(2.1e10), ONE)
    first, *_ = screen(model, tests, [ONE], identifications(model, tests, KINDS))
    assert first.kind == "quadratic_damping"
    assert_allclose(first.values["coefficient"], 150.0, rtol=0.05)


def test_a_first_effect_that_no_model_can_have_is_an_error():
    model = chain(1)
    tests = campaign(model, levels=(2.0,))
    known = identifications(model, tests, ("gap",))
    wrong = {"stiffness": -1.0, "clearance": 1e-4}
    with pytest.raises(ValueError, match="cannot have a gap between base and m1"):
        screen_pairs(model, tests, known, ("gap", ONE, wrong))


def test_transfer_is_that_of_one_oscillator():
    linear = linear_model(chain(1))
    frequency = np.array([3.0, 50.0, 300.0])
    s = 2j * np.pi * frequency
    by_force = linear.by_forces(frequency, np.ones((1, 1)))[0, 0]
    assert_allclose(by_force, s**2 / (s**2 + 5.0 * s + 1e5), rtol=1e-12)
    by_base = linear.by_input(frequency)[0]
    assert_allclose(by_base, (5.0 * s + 1e5) / (s**2 + 5.0 * s + 1e5), rtol=1e-12)


def test_free_vibration_from_before_a_block_leaves_nothing():
    rate, n = 2048.0, 1024
    pole = np.roots([1.0, 5.0, 1e5])[0]
    wave = np.real((0.7 + 0.2j) * pole**2 * np.exp(pole * np.arange(n) / rate))
    used = slice(5, 300)
    frequency = np.fft.rfftfreq(n, 1.0 / rate)[used]
    shown = np.fft.rfft(wave)[used]
    basis = linear_model(chain(1)).leftovers(frequency, n, rate)[:, 0]
    rows = np.concatenate([basis.real, basis.imag], axis=1)
    rows = rows / np.linalg.norm(rows, axis=1)[:, None]
    wanted = np.concatenate([shown.real, shown.imag])
    left = wanted - np.linalg.lstsq(rows.T, wanted)[0] @ rows
    assert np.linalg.norm(left) < 1e-9 * np.linalg.norm(wanted)


def test_gains_are_those_of_plain_least_squares_with_blocks_left_out():
    rng = np.random.default_rng(3)
    common, column = rng.standard_normal((2, 4, 30)), rng.standard_normal((1, 4, 30))
    residual = np.tensordot((1.0, -2.0), common, 1) + 3.0 * column[0]
    residual += rng.standard_normal(residual.shape)
    gains = Regression(residual, common, np.zeros(2)).gains(column, np.zeros(1))
    before, after = [], []
    for block in range(4):
        others = np.arange(4) != block
        for columns, costs in ((common, before), (np.concatenate([common, column]), after)):
            fitted = columns[:, others].reshape(len(columns), -1).T
            found = np.linalg.lstsq(fitted, residual[others].ravel())[0]
            costs.append(np.sum((residual[block] - found @ columns[:, block]) ** 2))
    gained = np.array(before) - after
    assert_allclose(gains.predicted, gained.sum() / np.sum(before), rtol=1e-6)
    assert_allclose(gains.t, gained.mean() / (gained.std(ddof=1) / 2.0), rtol=1e-6)
    every = np.concatenate([common, column]).reshape(3, -1).T
    assert_allclose(gains.amplitude, np.linalg.lstsq(every, residual.ravel())[0][2], rtol=1e-6)


def test_a_force_that_may_not_be_turned_round_is_refused():
    rng = np.random.default_rng(4)
    column = rng.standard_normal((1, 4, 30))
    regression = Regression(-column[0], rng.standard_normal((1, 4, 30)), np.zeros(1))
    assert regression.gains(column, np.ones(1)).amplitude == 0.0
    assert_allclose(regression.gains(column, np.zeros(1)).amplitude, -1.0)
