"""Effects with memory along prescribed motions, against what is known of them exactly."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from shakerproc.models.effects import (
    AttachedMode,
    BoucWen,
    Iwan,
    Jenkins,
    LuGreFriction,
    StiffnessDrift,
)

moves = st.lists(st.floats(-3.0, 3.0, allow_subnormal=False), min_size=1, max_size=12)


def path_through(points, per_leg=50):
    """Straight legs from 0 through these points, each corner a sample."""
    legs = np.concatenate(([0.0], points))
    return np.concatenate(
        [np.linspace(a, b, per_leg, endpoint=False) for a, b in pairwise(legs)] + [[legs[-1]]]
    )


@given(moves)
def test_iwan_is_the_limit_of_many_sliders(points):
    """400 Jenkins elements whose slip displacements are spread evenly."""
    z = path_through(np.array(points))
    iwan = Iwan(2.0, 1.0).force_along(z, 0.0 * z, 1.0)
    count = 400
    slips = (np.arange(count) + 0.5) / count
    sliders = sum(
        Jenkins(2.0 / count, 2.0 / count * slip).force_along(z, 0.0 * z, 1.0) for slip in slips
    )
    assert_allclose(iwan, sliders, atol=2.0 / count**2)


@given(moves)
def test_hysteresis_does_not_depend_on_the_rate(points):
    z = path_through(np.array(points))
    slow = path_through(np.array(points), 200)[::4]
    for effect in (Jenkins(2.0, 1.0), Iwan(2.0, 1.0), BoucWen(2.0, 1.0, 2.0)):
        one = effect.force_along(z, 0.0 * z, 1.0)
        assert_allclose(effect.force_along(slow, 0.0 * z, 99.0), one, atol=1e-5)


@given(moves)
def test_hysteresis_is_odd_and_starts_anywhere(points):
    z = path_through(np.array(points))
    for effect in (Jenkins(2.0, 1.0), Iwan(2.0, 1.0), BoucWen(2.0, 1.0, 1.5)):
        one = effect.force_along(z, 0.0 * z, 1.0)
        assert_allclose(effect.force_along(-z, 0.0 * z, 1.0), -one, atol=1e-12)
        assert_allclose(effect.force_along(z + 5.0, 0.0 * z, 1.0), one, atol=1e-5)


def test_iwan_first_loading_is_its_closed_form():
    z = np.linspace(0.0, 2.0, 101)
    expected = np.where(z < 1.0, 3.0 * z * (1.0 - z / 2.0), 1.5)
    assert_allclose(Iwan(3.0, 1.0).force_along(z, 0.0 * z, 1.0), expected, atol=1e-14)


@pytest.mark.parametrize("exponent", [1.0, 2.0, 3.5])
def test_bouc_wen_first_loading_against_an_ode_solver(exponent):
    z = np.linspace(0.0, 3.0, 301)
    reference = solve_ivp(
        lambda _, h: 1.0 - np.abs(h) ** exponent, (0.0, 3.0), [0.0], t_eval=z, rtol=1e-10,
        atol=1e-12,
    ).y[0]  # fmt: skip
    force = BoucWen(5.0, 1.0, exponent).force_along(z, 0.0 * z, 1.0)
    assert_allclose(force, 5.0 * reference, atol=1e-7)


def test_bouc_wen_of_exponent_two_is_a_hyperbolic_tangent():
    z = np.linspace(0.0, 3.0, 31)
    force = BoucWen(5.0, 1.0, 2.0).force_along(z, 0.0 * z, 1.0)
    assert_allclose(force, 5.0 * np.tanh(z), atol=1e-7)


def test_lugre_in_steady_sliding_is_its_stribeck_curve():
    for velocity in (-0.2, 1e-3, 0.01, 0.5):
        v = np.full(20000, velocity)
        z = velocity * np.arange(20000) / 1e4
        force = LuGreFriction(1.0, 1.5, 0.01, 1e5, 30.0, 2.0).force_along(z, v, 1e4)
        level = 1.0 + 0.5 * np.exp(-((velocity / 0.01) ** 2))
        assert_allclose(force[-1], np.sign(velocity) * level + 2.0 * velocity, rtol=1e-6)


def test_lugre_below_breakaway_is_a_spring_and_a_damper():
    time = np.arange(4001) / 1e5
    z, v = 1e-9 * np.sin(500.0 * time), 5e-7 * np.cos(500.0 * time)
    force = LuGreFriction(1.0, 1.5, 0.01, 1e5, 30.0, 2.0).force_along(z, v, 1e5)
    assert_allclose(force, 1e5 * z + 32.0 * v, atol=3e-4 * np.max(np.abs(force)))


def test_lugre_converges_with_the_sample_rate():
    effect = LuGreFriction(1.0, 1.5, 0.01, 1e5, 30.0, 2.0)

    def final(n):
        time = np.arange(n + 1) / n * 0.02
        z, v = 1e-4 * np.sin(314.0 * time), 0.0314 * np.cos(314.0 * time)
        return effect.force_along(z, v, n / 0.02)[:: n // 100]

    errors = [np.max(np.abs(final(n) - final(102400))) for n in (1600, 3200, 6400)]
    assert np.log2(errors[0] / errors[1]) > 1.5
    assert np.log2(errors[1] / errors[2]) > 1.5


@pytest.mark.parametrize("frequency", [30.0, 190.0, 700.0])
def test_an_attached_mode_pulls_with_its_apparent_mass(frequency):
    """A steady sine, against force over acceleration in the frequency domain."""
    mode, rate = AttachedMode(0.01, 200.0, 0.05), 50000.0
    time = np.arange(25000) / rate
    omega = 2.0 * np.pi * frequency
    x, v = np.sin(omega * time), omega * np.cos(omega * time)
    force = mode.force_along(x, v, rate)[-10000:]
    apparent = mode.apparent_mass(np.array([frequency]))[0]
    expected = -(omega**2) * np.imag(apparent * np.exp(1j * omega * time[-10000:]))
    assert_allclose(force, expected, atol=1e-3 * np.max(np.abs(expected)))


def test_an_attached_mode_is_a_rigid_mass_at_low_frequency():
    assert_allclose(
        AttachedMode(0.01, 200.0, 0.05).apparent_mass(np.array([0.1])), 0.01, rtol=1e-5
    )


def test_a_stiffness_drifts_with_time():
    z = np.full(101, 2.0)
    force = StiffnessDrift(-0.1, 3.0, 50.0).force_along(z, 0.0 * z, 10.0)
    assert_allclose(force, 50.0 * -0.1 * (np.arange(101) / 10.0 - 3.0) * 2.0)
