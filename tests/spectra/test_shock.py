"""Shock response spectra against closed forms."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.spectra.response_spectra import (
    QUANTITIES,
    logarithmic_frequencies,
    shock_spectra,
)

RATE, DURATION, HEIGHT = 100_000.0, 0.010, 250.0
ONSET = 50  # samples of rest before the shock
T = (np.arange(round(DURATION * RATE) + ONSET + 1) - ONSET) / RATE
HALF_SINE = np.where(T > 0.0, HEIGHT * np.sin(np.pi * np.maximum(T, 0.0) / DURATION), 0.0)
FREQUENCY = logarithmic_frequencies(5.0, 2000.0, 6)


def half_sine_response(frequency):
    """Undamped closed form (Harris, Shock and Vibration Handbook, ch. 8): during and after."""
    ratio = 1.0 / (2.0 * DURATION * frequency)  # pulse frequency over natural frequency
    omega, pulse = 2.0 * np.pi * frequency, np.pi / DURATION
    t = np.linspace(0.0, DURATION, 20_001)
    during = HEIGHT / (1.0 - ratio**2) * (np.sin(pulse * t) - ratio * np.sin(omega * t))
    after = HEIGHT * abs(2.0 * ratio * np.cos(np.pi / (2.0 * ratio)) / (1.0 - ratio**2))
    return during, after


def test_half_sine_without_damping_is_the_closed_form():
    found = shock_spectra([HALF_SINE[np.newaxis]], RATE, FREQUENCY, 0.0).values
    for i, frequency in enumerate(FREQUENCY):
        during, after = half_sine_response(frequency)
        expected = {
            "primary_positive": during.max(),
            "primary_negative": max(0.0, -during.min()),
            "residual_positive": after,
            "residual_negative": after,
            "maximax": max(np.abs(during).max(), after),
        }
        for part, value in expected.items():
            seen = found["absolute_acceleration"][part][0, i]
            assert_allclose(seen, value, rtol=4e-3, atol=2e-3 * HEIGHT, err_msg=part)


def test_without_damping_the_spring_alone_accelerates_the_mass():
    found = shock_spectra([HALF_SINE[np.newaxis]], RATE, FREQUENCY, 0.0).values
    absolute, static = (
        found[name] for name in ("absolute_acceleration", "equivalent_static_acceleration")
    )
    for part in ("primary", "residual"):
        up, down = f"{part}_positive", f"{part}_negative"
        assert_allclose(absolute[up], static[down], rtol=1e-9, atol=1e-9)
        assert_allclose(absolute[down], static[up], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("damping", [0.01, 0.05, 0.3])
def test_limits_of_soft_and_stiff_oscillators(damping):
    """A stiff oscillator follows the base; a soft one stands still while the base moves on."""
    frequency = np.array([0.05, 9_000.0])
    found = shock_spectra([HALF_SINE[np.newaxis]], RATE, frequency, damping).values
    assert_allclose(found["absolute_acceleration"]["maximax"][0, 1], HEIGHT, rtol=0.01)
    velocity = HEIGHT * 2.0 * DURATION / np.pi  # velocity change of a half-sine
    assert_allclose(found["relative_velocity"]["maximax"][0, 0], velocity, rtol=0.01)
    decay = np.exp(-damping / np.sqrt(1 - damping**2) * np.arccos(damping))
    assert_allclose(found["pseudo_velocity"]["maximax"][0, 0], velocity * decay, rtol=0.01)


def test_a_steady_sine_at_resonance_is_amplified_by_q():
    t = np.arange(round(60.0 * 2000.0)) / 2000.0
    base = 3.0 * np.sin(2.0 * np.pi * 20.0 * t)
    found = shock_spectra([base[np.newaxis]], 2000.0, np.array([20.0]), 0.05).values
    zeta = 0.05
    gain = np.sqrt(1.0 + (2 * zeta) ** 2) / (2 * zeta)
    assert_allclose(
        found["absolute_acceleration"]["primary_positive"][0, 0], 3.0 * gain, rtol=5e-3
    )
    displacement = 3.0 / (2 * zeta) / (2.0 * np.pi * 20.0) ** 2
    assert_allclose(found["relative_displacement"]["maximax"][0, 0], displacement, rtol=5e-3)


def test_residual_decays_from_where_the_record_ends():
    """An oscillator let go: the swing back is smaller by the logarithmic decrement."""
    frequency, zeta = np.array([10.0]), 0.1
    step = np.full((1, 200_000), 1.0)  # at rest under a constant acceleration, then let go
    found = shock_spectra([step], 1000.0, frequency, zeta).values["relative_displacement"]
    still = 1.0 / (2.0 * np.pi * 10.0) ** 2
    assert_allclose(found["residual_negative"][0, 0], still, rtol=1e-9)
    back = still * np.exp(-np.pi * zeta / np.sqrt(1.0 - zeta**2))
    assert_allclose(found["residual_positive"][0, 0], back, rtol=1e-9)


@pytest.mark.parametrize("cuts", [[1], [37, 400], [1049]])
def test_blocks_make_no_difference(cuts):
    rows = np.array([HALF_SINE, -0.3 * HALF_SINE])
    whole = shock_spectra([rows], RATE, FREQUENCY, 0.05).values
    parts = shock_spectra(np.split(rows, cuts, axis=1), RATE, FREQUENCY, 0.05).values
    for quantity in QUANTITIES:
        for part, values in whole[quantity].items():
            assert_allclose(parts[quantity][part], values, rtol=1e-12)


def test_turning_the_sensor_round_exchanges_positive_and_negative():
    rows = np.array([HALF_SINE, -HALF_SINE])
    found = shock_spectra([rows], RATE, FREQUENCY, 0.05).values["relative_velocity"]
    assert_allclose(found["primary_positive"][0], found["primary_negative"][1], rtol=1e-12)
    assert_allclose(found["maximax"][0], found["maximax"][1], rtol=1e-12)


@pytest.mark.parametrize(
    ("frequency", "damping", "match"),
    [(10_001.0, 0.05, "up to 10000"), (0.0, 0.05, "above 0"), (10.0, 1.0, "below 1")],
)
def test_what_has_no_spectrum_is_refused(frequency, damping, match):
    with pytest.raises(ValueError, match=match):
        shock_spectra([HALF_SINE[np.newaxis]], RATE, np.array([frequency]), damping)


def test_frequencies_hold_both_ends():
    assert_allclose(logarithmic_frequencies(10.0, 100.0, 1), [10, 20, 40, 80, 100])
    assert_allclose(logarithmic_frequencies(10.0, 80.0, 1), [10, 20, 40, 80])
