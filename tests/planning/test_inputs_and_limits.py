"""Motion of the table against quadrature, and the shaker's envelope."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.integrate import quad

from shakerproc.planning import RandomInput, ShakerLimits, SineInput, input_of_test
from shakerproc.testlog import Test

frequencies = st.floats(3.0, 3000.0)


def test_the_text_of_the_thesis_at_400_hz_and_1_g():
    """Section 5.2.2: 0.00155 mm, by eq. 5.5; the formula above it would give 0.00488 mm."""
    shaken = SineInput(9.81, 400.0, 400.0)
    assert_allclose(shaken.largest_motion().displacement, 1.55e-6, rtol=3e-3)


def test_the_displacement_of_a_sine_is_its_acceleration_integrated_twice():
    shaken, time = SineInput(30.0, 20.0, 500.0), np.linspace(0.0, 0.05, 20001)
    acceleration = 30.0 * np.cos(2.0 * np.pi * 20.0 * time)
    step = time[1]
    velocity = np.cumsum(acceleration) * step
    displacement = np.cumsum(velocity - np.mean(velocity)) * step
    motion = shaken.largest_motion()
    assert_allclose(np.ptp(velocity) / 2.0, motion.velocity, rtol=1e-3)
    assert_allclose(np.ptp(displacement) / 2.0, motion.displacement, rtol=1e-3)


@pytest.mark.parametrize(("low", "high"), [(5.0, 1000.0), (20.0, 25.0)])
def test_random_motion_is_the_integral_of_its_density(low, high):
    shaken = RandomInput(0.02, low, high)
    for value, power in (
        (shaken.rms, 0),
        (shaken.rms_velocity, 2),
        (shaken.rms_displacement, 4),
    ):
        square, _ = quad(lambda f, p=power: 0.02 / (2.0 * np.pi * f) ** p, low, high)
        assert_allclose(value, np.sqrt(square), rtol=1e-8)


def test_above_the_frequency_that_is_told_random_motion_has_that_displacement_left():
    shaken = RandomInput(0.5, 5.0, 1000.0)
    edge = shaken.frequency_of_displacement(2.5e-5)
    square, _ = quad(lambda f: 0.5 / (2.0 * np.pi * f) ** 4, edge, 1000.0)
    assert_allclose(3.0 * np.sqrt(square), 2.5e-5, rtol=1e-8)


def test_a_random_level_in_rms_is_spread_over_the_band():
    test = Test(
        1, excitation="random", level=3.0, level_unit="m/s^2 rms", from_hz=5.0, to_hz=905.0
    )
    shaken = input_of_test(test)
    assert isinstance(shaken, RandomInput)
    assert_allclose(shaken.rms, 3.0)
    assert_allclose(shaken.density, 0.01)


@pytest.mark.parametrize(
    "test",
    [
        Test(1),
        Test(1, excitation="shock", level=100.0, level_unit="m/s^2"),
        Test(1, excitation="random", level=1.0, level_unit="(m/s^2)^2/Hz"),
    ],
)
def test_what_the_log_does_not_say_is_not_invented(test):
    assert input_of_test(test) is None


@settings(max_examples=40, deadline=None)
@given(frequencies, st.floats(1.0, 1000.0), st.floats(0.05, 5.0), st.floats(1e-3, 0.05))
def test_a_sine_on_the_envelope_is_allowed_and_a_little_more_is_not(f, a, v, d):
    limits = ShakerLimits(a, v, d)
    most = float(limits.largest_acceleration(np.array([f]))[0])
    assert not limits.exceeded_by(SineInput(most, f, f))
    assert limits.exceeded_by(SineInput(1.01 * most, f, f))


@settings(max_examples=40, deadline=None)
@given(st.floats(1.0, 1000.0), st.floats(0.05, 5.0), st.floats(1e-3, 0.05))
def test_at_the_crossovers_two_limits_are_equal(a, v, d):
    for f in ShakerLimits(a, v, d).crossovers():
        omega = 2.0 * np.pi * f
        lowest, second, _ = sorted([a, omega * v, omega**2 * d])
        assert_allclose(lowest, second, rtol=1e-9)


def test_a_sweep_too_far_down_is_told_from_where_it_is_possible():
    limits = ShakerLimits(displacement=10e-3)
    (told,) = limits.exceeded_by(SineInput(9.80665, 2.0, 500.0))
    assert "displacement 62.1 mm (amplitude) is above the shaker's 10 mm" in told
    assert f"possible from {np.sqrt(9.80665 / 10e-3) / (2 * np.pi):.4g} Hz" in told


def test_limits_must_be_above_0():
    with pytest.raises(ValueError, match="velocity must be above 0"):
        ShakerLimits(velocity=0.0)
