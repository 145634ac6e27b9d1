"""The linear model before any effect, against campaigns of an independent truth."""

from dataclasses import replace

import numpy as np
import pytest
from blind.excitations import SAMPLE_RATE
from blind.ranges import Hidden
from blind.structures import Joint, Structure
from tests.comparison.small_campaigns import JOINT, MASS, campaign, drive

from blind import laws
from shakerproc.diagnosis.data import TestArrays, prepared
from shakerproc.diagnosis.estimation.correction import without_driven
from shakerproc.diagnosis.estimation.linear import fit_linear
from shakerproc.diagnosis.estimation.linear_parameters import LinearParameters
from shakerproc.models import EFFECTS, Element, Excitation, Model, Sensor

OMEGA, SHARE, ZETA = 2.0 * np.pi * 600.0, 0.03, 0.01
SECOND = SHARE * MASS
WITH_MODE = Structure(
    (MASS - SECOND, SECOND),
    (JOINT, Joint(0, 1, SECOND * OMEGA**2, 2.0 * ZETA * SECOND * OMEGA)),
)
DRIVES = (drive(), drive(level=15.0, number=2))


def model(stiffness=1.0, damping=1.0):
    joint = (
        Element(EFFECTS["spring"](stiffness * JOINT.stiffness), ("base", "coupon")),
        Element(EFFECTS["damper"](damping * JOINT.damping), ("base", "coupon")),
    )
    return Model(
        "one mass", {"coupon": MASS}, joint, Excitation("base acceleration"),
        {"ch3": Sensor("coupon")},
    )  # fmt: skip


def arrays_of(made):
    return prepared([
        TestArrays(
            str(t.number), SAMPLE_RATE, t.control, t.response[:1],
            excitation="random", band=(20.0, 800.0),
        )
        for t in made.tests
    ])  # fmt: skip


@pytest.fixture(scope="module")
def plain():
    return arrays_of(campaign(drives=DRIVES))


@pytest.fixture(scope="module")
def with_mode():
    return arrays_of(campaign(WITH_MODE, drives=DRIVES))


def stiffness_of(found):
    return found.model.elements[0].effect.stiffness


def test_own_numbers_are_found_and_no_mode(plain):
    found = fit_linear(model(1.15, 0.6), plain)
    assert stiffness_of(found) == pytest.approx(JOINT.stiffness, rel=1e-3)
    assert found.model.elements[1].effect.damping == pytest.approx(JOINT.damping, rel=5e-3)
    assert found.model.modes == ()
    assert max(found.left.values()) < 0.006


def test_a_further_mode_is_found_with_its_numbers(with_mode):
    found = fit_linear(model(), with_mode)
    (mode,) = found.model.modes
    assert mode.frequency == pytest.approx(600.0, rel=2e-3)
    assert mode.damping_ratio == pytest.approx(ZETA, rel=0.1)
    assert mode.mass == pytest.approx(SECOND, rel=0.05)
    assert max(found.left.values()) < 0.006


@pytest.mark.parametrize("heavy", [0.0, 3.3, 12.0])
def test_modes_never_take_all_of_the_mass_of_their_place(heavy):
    """However heavy a fit would have them: with 3.3 each was 54 % of it."""
    parameters = LinearParameters(model(), 1, [("coupon", 2000.0), ("coupon", 3000.0)])
    values = np.zeros(parameters.spreads.size)
    values[[-4, -1]] = heavy
    made = parameters.model_at(values)
    held = sum(mode.mass for mode in made.modes)
    assert 0.0 < held < made.masses["coupon"]
    assert made.rigid_masses["coupon"] + held == pytest.approx(made.masses["coupon"])
    light = 2.0 * 0.02 * np.exp(heavy)  # over what is left
    assert held / made.rigid_masses["coupon"] == pytest.approx(light)
    assert parameters.heaviest(values) == pytest.approx(light)


@pytest.mark.parametrize("share", [-0.25, 0.05])
def test_a_mode_that_the_drive_alone_excites_is_found_and_taken_out(plain, share):
    """As the second mode of a beam at its tip: no mass on the first mass moves like that."""
    s, omega = 2j * np.pi * np.fft.rfftfreq(2 * plain[0].n_samples, 1 / SAMPLE_RATE), 3770.0
    changed = []
    for test in plain:
        drive = np.fft.rfft(test.arrays.controls[0], 2 * test.n_samples)
        answer = -share * s**2 / (s**2 + 2.0 * 0.012 * omega * s + omega**2) * drive
        more = np.fft.irfft(answer, 2 * test.n_samples)[: test.n_samples]
        changed.append(replace(test, responses=test.responses + more))
    found = fit_linear(model(1.15, 0.6), changed)
    (mode,) = found.driven
    assert mode.frequency == pytest.approx(omega / (2.0 * np.pi), rel=1e-3)
    assert mode.damping_ratio == pytest.approx(0.012, rel=0.05)
    assert mode.participation == pytest.approx([share], rel=0.02)
    assert stiffness_of(found) == pytest.approx(JOINT.stiffness, rel=1e-3)
    assert max(found.left.values()) < 0.007
    for test, clean in zip(without_driven(changed, found), plain, strict=True):
        away = np.std(test.responses - clean.responses) / np.std(clean.responses)
        assert away < 0.1 * np.std(more) / np.std(clean.responses)


def test_a_mode_near_the_own_one_is_left_to_the_choice():
    omega = 2.0 * np.pi * 200.0
    near = replace(
        WITH_MODE,
        joints=(JOINT, Joint(0, 1, SECOND * omega**2, 2.0 * ZETA * SECOND * omega)),
    )
    assert fit_linear(model(), arrays_of(campaign(near, drives=DRIVES))).model.modes == ()


def test_gain_delay_and_unequal_controls_are_numbers_of_the_chain(plain):
    rng = np.random.default_rng(4)
    changed = []
    for test in plain:
        n = test.n_samples
        frequency = np.fft.rfftfreq(n, 1.0 / SAMPLE_RATE)
        turn = 1.01 * np.exp(-2j * np.pi * frequency * 2e-5)
        late = np.fft.irfft(np.fft.rfft(test.responses) * turn, n)
        rocking = 0.1 * np.std(test.input) * rng.standard_normal(n)
        controls = test.input + np.array([[0.4 * 2.0], [-0.6 * 2.0]]) * rocking
        changed.append(replace(test.arrays, controls=controls, responses=late))
    found = fit_linear(model(), prepared(changed))
    assert found.chain.gains[0] == pytest.approx(1.01, abs=1e-3)
    assert found.chain.delays[0] == pytest.approx(2e-5, abs=1e-6)
    assert found.chain.weights == pytest.approx([0.6, 0.4], abs=0.02)
    assert found.unusual == ()
    assert max(found.left.values()) < 0.02


def test_a_gain_far_from_its_prior_is_told(plain):
    loud = [replace(t.arrays, responses=1.2 * t.arrays.responses) for t in plain]
    found = fit_linear(model(), prepared(loud))
    assert [number.name for number in found.unusual] == ["gain of ch3"]


def test_a_gap_changes_neither_the_stiffness_much_nor_adds_modes():
    gap = Hidden({}, ((laws.GAP, (3.0 * JOINT.stiffness, 3e-5, 3e-5), (-3e-5, 3e-5)),))
    made = campaign(hidden=((0, gap),), drives=(drive(level=2.0), drive(level=12.0, number=2)))
    found = fit_linear(model(), arrays_of(made))
    assert found.model.modes == ()
    assert stiffness_of(found) == pytest.approx(JOINT.stiffness, rel=0.3)
    assert found.unusual == ()


def test_a_mode_is_found_beside_an_effect_that_the_model_has():
    stiffness, clearance = 0.5 * JOINT.stiffness, 5e-5
    gap = Hidden({}, ((laws.GAP, (stiffness, clearance, clearance), (-clearance, clearance)),))
    made = campaign(WITH_MODE, hidden=((0, gap),), drives=(drive(level=12.0),))
    plain = model()
    effect = Element(EFFECTS["gap"](stiffness, clearance), ("base", "coupon"))
    with_gap = replace(plain, elements=(*plain.elements, effect))
    found = fit_linear(with_gap, arrays_of(made), own_numbers=False)
    (mode,) = found.model.modes
    assert mode.frequency == pytest.approx(600.0, rel=5e-3)
    assert found.model.elements == with_gap.elements
