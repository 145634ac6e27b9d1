"""The balance itself: contact integrals, derivatives, and solutions that are known."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from tests.closed_forms import oracles
from tests.harmonic_balance.oscillators import duffing, gap, model

from shakerproc.errors import ModelError
from shakerproc.models import EFFECTS, Element, Excitation, Model
from shakerproc.simulation import closed_forms
from shakerproc.simulation.harmonic_balance import fourier
from shakerproc.simulation.harmonic_balance.balance import HarmonicBalance
from shakerproc.simulation.harmonic_balance.curves import newton, solve_at
from shakerproc.simulation.harmonic_balance.laws import HarmonicMotion
from shakerproc.simulation.harmonic_balance.response import (
    balance_of_system,
    frequency_response,
)
from shakerproc.simulation.harmonic_balance.system import system_of_model

EXAMPLES = {
    "gap": EFFECTS["gap"](stiffness=1000.0, clearance=0.3),
    "offset_gap": EFFECTS["offset_gap"](
        stiffness=1000.0, clearance_positive=0.4, clearance_negative=0.1
    ),
    "stop": EFFECTS["stop"](stiffness=1000.0, clearance=0.2, side="negative"),
    "jump_gap": EFFECTS["jump_gap"](stiffness=1000.0, clearance=0.3),
    "contact_damping": EFFECTS["contact_damping"](damping=3.0, clearance=0.3),
    "hertz_contact": EFFECTS["hertz_contact"](
        stiffness=1000.0, clearance=0.3, restitution_loss=0.3, side="both"
    ),
    "cubic_stiffness": EFFECTS["cubic_stiffness"](coefficient=1000.0),
    "quadratic_stiffness": EFFECTS["quadratic_stiffness"](coefficient=1000.0),
    "power_law": EFFECTS["power_law"](force=10.0, reference_displacement=0.5, exponent=5.0),
    "power_law_damping": EFFECTS["power_law_damping"](
        damping=2.0, reference_displacement=0.5, exponent=2.0
    ),
    "quadratic_damping": EFFECTS["quadratic_damping"](coefficient=2.0),
    "jenkins": EFFECTS["jenkins"](stiffness=100.0, slip_force=20.0),
    "iwan": EFFECTS["iwan"](stiffness=100.0, slip_displacement=0.5),
    "bouc_wen": EFFECTS["bouc_wen"](stiffness=100.0, yield_displacement=0.3, exponent=2.0),
    "lugre_friction": EFFECTS["lugre_friction"](
        sliding_force=1.0,
        breakaway_force=1.5,
        stribeck_velocity=0.1,
        bristle_stiffness=100.0,
        bristle_damping=0.1,
        viscous_damping=0.2,
    ),
}
HYSTERETIC = {"jenkins", "iwan", "bouc_wen", "lugre_friction"}
every_effect = pytest.mark.parametrize("kind", EXAMPLES)


def motion_of(harmonics, seed=3, omega=2.0):
    rng = np.random.default_rng(seed)
    random = rng.standard_normal((2, harmonics.size)) / (1.0 + harmonics) ** 2
    coefficients = 1.2 * (random[0] + 1j * random[1])
    if harmonics[0] == 0:
        coefficients[0] = coefficients[0].real
    return HarmonicMotion(coefficients, harmonics, omega)


def law_of(kind):
    spring = EFFECTS["spring"](stiffness=1e5)
    system = system_of_model(model(EXAMPLES[kind], spring), 1.0)
    return system.couplings[0].law


@every_effect
@pytest.mark.parametrize("harmonics", [np.arange(8), np.arange(1, 12, 2)])
def test_force_is_that_of_the_effect_along_the_motion(kind, harmonics):
    """Against a Riemann sum over the force that the effect itself gives along the motion."""
    motion, n_samples = motion_of(harmonics), 2**15
    displacement, slope = motion.sampled(n_samples)
    rate = n_samples * motion.omega / (2.0 * np.pi)
    lead = displacement[0] * np.linspace(0.0, 1.0, 1001)[:-1] if kind in HYSTERETIC else []
    along = np.concatenate([lead, *[displacement] * 3])
    velocity = motion.omega * np.concatenate([0.0 * np.array(lead), *[slope] * 3])
    force = EXAMPLES[kind].force_along(along, velocity, rate)[-n_samples:]
    expected = fourier.real_of_complex(
        fourier.coefficients_of_values(force, harmonics), harmonics
    )
    found = law_of(kind).balance(motion).force
    rough = {"lugre_friction": 2e-3, "jenkins": 1e-4, "iwan": 1e-4, "bouc_wen": 1e-4}
    loose = rough.get(kind, 1e-4 if kind in {"jump_gap", "contact_damping"} else 3e-8)
    if kind in {"quadratic_damping", "hertz_contact"}:
        loose = 1e-5  # no polynomial: the sum over samples has a limit
    assert_allclose(found, expected, atol=loose * np.sqrt(np.mean(force**2)))


@every_effect
def test_derivatives_are_those_of_the_force(kind):
    harmonics, law = np.arange(6), law_of(kind)
    motion = motion_of(harmonics)
    real = fourier.real_of_complex(motion.coefficients, harmonics)
    found, step = law.balance(motion), 1e-6

    def force(unknowns, omega):
        coefficients = fourier.complex_of_real(unknowns, harmonics)
        return law.balance(HarmonicMotion(coefficients, harmonics, omega)).force

    for i in range(real.size):
        change = np.zeros(real.size)
        change[i] = step
        expected = (force(real + change, 2.0) - force(real - change, 2.0)) / (2.0 * step)
        size = np.max(np.abs(found.jacobian))
        assert_allclose(found.jacobian[:, i], expected, atol=2e-3 * size)
    expected = (force(real, 2.0 + step) - force(real, 2.0 - step)) / (2.0 * step)
    by_omega = np.zeros(real.size) if found.by_omega is None else found.by_omega
    assert_allclose(by_omega, expected, atol=1e-4 * (1.0 + np.max(np.abs(expected))))


@given(st.floats(0.05, 2.0), st.integers(0, 10_000))
@settings(max_examples=50)
def test_grazing_contacts_are_never_missed(clearance, seed):
    """Every sample of a fine grid lies on the stretch that the crossings say."""
    motion = motion_of(np.arange(10), seed)
    walls = np.array([-clearance, clearance])
    angles, segments = motion.stretches(walls)
    grid = np.arange(20_000) * (2.0 * np.pi / 20_000)
    displacement = motion.sampled(20_000)[0]
    expected = np.searchsorted(walls, displacement)
    found = segments[np.searchsorted(angles, grid)]
    near = np.min(np.abs(np.abs(displacement)[:, None] - clearance), axis=1) < 1e-4
    assert np.all((found == expected) | near)


def test_one_harmonic_is_eq_3_47():
    amplitude, natural, cubic, force = 1.7, 0.4, 2.0, 1.1
    frequency = oracles.duffing_harmonic_frequency(np.array(amplitude), natural, cubic, force)
    stiffness = (2.0 * np.pi * natural) ** 2
    system = system_of_model(duffing(cubic, stiffness, 0.0), force)
    balance = HarmonicBalance(system, np.array([1]))
    found = newton(balance, np.array([1.02 * amplitude, 0.0]), 2.0 * np.pi * float(frequency))
    assert_allclose(found, [amplitude, 0.0], rtol=1e-12, atol=1e-14)


def test_fifteen_harmonics_differ_by_two_percent_at_an_amplitude_of_three():
    natural, cubic, force = 1.0 / (2.0 * np.pi), 1.0, 1.0
    one = oracles.duffing_harmonic_frequency(np.array(3.0), natural, cubic, force)
    system = system_of_model(duffing(cubic, 1.0, 0.0), force)
    balance = HarmonicBalance(system, np.arange(1, 16, 2))
    found = newton(balance, np.r_[3.0, np.zeros(15)], 2.0 * np.pi * float(one))
    peak = np.max(balance.coefficients(found)[0].real.sum())
    assert 0.005 < abs(peak / 3.0 - 1.0) < 0.05


def two_masses(*more, base=True):
    elements = (
        Element(EFFECTS["spring"](stiffness=3000.0), ("base", "a")),
        Element(EFFECTS["damper"](damping=2.0), ("base", "a")),
        Element(EFFECTS["spring"](stiffness=800.0), ("a", "b")),
        Element(EFFECTS["damper"](damping=0.7), ("a", "b")),
        *more,
    )
    excitation = Excitation("base acceleration") if base else Excitation("force", "b")
    return Model("two", {"a": 1.0, "b": 0.4}, elements, excitation)


@pytest.mark.parametrize("base", [True, False])
@pytest.mark.parametrize("frequency", [3.0, 7.1, 20.0])
def test_linear_masses_have_their_complex_response(base, frequency):
    system = system_of_model(two_masses(base=base), 2.5)
    balance = balance_of_system(system, 5)
    omega = 2.0 * np.pi * frequency
    mass = np.diag([1.0, 0.4])
    stiffness = np.array([[3800.0, -800.0], [-800.0, 800.0]])
    damping = np.array([[2.7, -0.7], [-0.7, 0.7]])
    load = -2.5 * np.array([1.0, 0.4]) if base else np.array([0.0, 2.5])
    expected = np.linalg.solve(stiffness + 1j * omega * damping - omega**2 * mass, load)
    found = balance.coefficients(solve_at(balance, frequency))
    assert_allclose(found[:, 0], expected, rtol=1e-12)
    assert_allclose(found[:, 1:], 0.0, atol=1e-15)


def test_attached_mode_is_one_more_mass():
    attached = Element(
        EFFECTS["attached_mode"](mass=0.2, frequency=9.0, damping_ratio=0.03), ("base", "b")
    )
    system = system_of_model(two_masses(attached), 1.0)
    stiffness = 0.2 * (2.0 * np.pi * 9.0) ** 2
    damping = 2.0 * 0.03 * np.sqrt(stiffness * 0.2)
    explicit = Model(
        "three",
        {"a": 1.0, "b": 0.4, "c": 0.2},
        (
            *two_masses().elements,
            Element(EFFECTS["spring"](stiffness=stiffness), ("b", "c")),
            Element(EFFECTS["damper"](damping=damping), ("b", "c")),
        ),
        Excitation("base acceleration"),
    )
    expected = system_of_model(explicit, 1.0)
    assert_allclose(system.mass, expected.mass)
    assert_allclose(system.stiffness, expected.stiffness, rtol=1e-13)
    assert_allclose(system.damping, expected.damping, rtol=1e-13)
    assert_allclose(system.load, expected.load)


@pytest.mark.parametrize("friction", [0.2, 0.5])
@pytest.mark.parametrize("ratio", [0.6, 0.8, 1.3, 2.0])
def test_dry_friction_comes_near_den_hartog(ratio, friction):
    """Harmonics resolve the corner at reversal slowly: 2 % at 31, half of it at 63."""
    system = system_of_model(
        model(
            EFFECTS["spring"](stiffness=1.0),
            EFFECTS["coulomb_friction"](sliding_force=friction),
        ),
        1.0,
    )
    expected = closed_forms.coulomb_amplitude(np.array(ratio), friction)
    errors = []
    for harmonics in (31, 63):
        balance = balance_of_system(system, harmonics)
        found = solve_at(balance, ratio / (2.0 * np.pi))
        peak = np.max(fourier.values(balance.coefficients(found), balance.harmonics, 4096))
        errors.append(abs(peak / expected - 1.0))
    assert errors[0] < 0.02
    assert errors[1] < 0.7 * errors[0]


def test_friction_that_is_never_overcome_holds_the_mass():
    stuck = model(
        EFFECTS["spring"](stiffness=1.0), EFFECTS["coulomb_friction"](sliding_force=1.5)
    )
    with pytest.raises(ModelError, match="the friction holds the masses still at this level"):
        frequency_response(stuck, 1.4, from_hz=0.01, to_hz=1.0)
    balance = balance_of_system(system_of_model(stuck, 1.4), 15)
    assert_allclose(balance.residual(np.zeros(balance.n_unknowns), 0.5).force, 0.0, atol=1e-14)


def test_stribeck_friction_without_a_fall_is_coulomb_friction():
    def motion(*friction):
        spring = EFFECTS["spring"](stiffness=1.0)
        balance = balance_of_system(system_of_model(model(spring, *friction), 1.0), 31)
        return solve_at(balance, 0.8 / (2.0 * np.pi))

    coulomb = motion(EFFECTS["coulomb_friction"](sliding_force=0.5))
    stribeck = EFFECTS["stribeck_friction"](
        sliding_force=0.5, breakaway_force=0.5 + 1e-9, stribeck_velocity=0.1
    )
    assert_allclose(motion(stribeck), coulomb, atol=2e-3)


def test_odd_forces_need_odd_harmonics_only():
    symmetric = system_of_model(gap(5e-3), 5.0)
    assert np.all(balance_of_system(symmetric, 9).harmonics % 2 == 1)
    one_sided = system_of_model(model(EXAMPLES["stop"], EFFECTS["spring"](stiffness=1.0)), 5.0)
    assert_allclose(balance_of_system(one_sided, 3).harmonics, [0, 1, 2, 3])
    odd = balance_of_system(symmetric, 9)
    every = HarmonicBalance(symmetric, np.arange(10))
    found = newton(every, _spread(odd, every, solve_at(odd, 4.0)), 8.0 * np.pi)
    assert_allclose(every.coefficients(found)[:, ::2], 0.0, atol=1e-12)


def _spread(few, many, unknowns):
    coefficients = np.zeros((1, many.harmonics.size), np.complex128)
    coefficients[:, np.isin(many.harmonics, few.harmonics)] = few.coefficients(unknowns)
    return many.real(coefficients)
