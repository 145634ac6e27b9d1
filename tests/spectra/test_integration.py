"""Integrals of accelerations against closed forms."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.spectra import integration
from shakerproc.spectra.integration import high_pass_gain, integrated, straight_baseline

RATE = 1000.0


def integrals(rows, part=None, corner=None):
    rows = np.atleast_2d(rows)

    def read(start, stop):
        assert 0 <= start < stop <= rows.shape[1]
        return rows[:, start:stop]

    n = rows.shape[1]
    parts = integrated(read, n, RATE, part or (0, n), corner=corner)
    return np.concatenate(list(parts), axis=2)


@pytest.mark.parametrize("frequency", [7.0, 40.0, 333.0])
def test_a_tone_is_divided_by_its_angular_frequency_and_turned(frequency):
    t = np.arange(60_000) / RATE
    omega, corner = 2.0 * np.pi * frequency, 5.0
    gain = 1.0 / (1.0 + (corner / frequency) ** 8)
    velocity, displacement = integrals(2.0 * np.cos(omega * t), (20_000, 40_000), corner)[:, 0]
    middle = t[20_000:40_000]
    assert_allclose(velocity, gain * 2.0 / omega * np.sin(omega * middle), atol=2e-4 / omega)
    expected = -gain * 2.0 / omega**2 * np.cos(omega * middle)
    assert_allclose(displacement, expected, atol=2e-4 / omega**2)


def test_an_offset_and_a_drift_do_not_pass():
    t = np.arange(100_000) / RATE
    velocity, displacement = integrals(5.0 + 0.2 * t, (40_000, 60_000), 5.0)[:, 0]
    assert np.abs(velocity).max() < 1e-4
    assert np.abs(displacement).max() < 1e-5


def test_half_is_left_at_the_corner():
    assert_allclose(high_pass_gain(np.array([0.0, 5.0, 10.0]), 5.0), [0.0, 0.5, 256.0 / 257.0])


def test_from_rest_a_half_sine_leaves_its_velocity_change():
    n, height = 101, 300.0  # 0.1 s
    pulse = height * np.sin(np.pi * np.arange(n) / (n - 1))
    velocity, displacement = integrals(np.append(pulse, np.zeros(900)))[:, 0]
    duration = (n - 1) / RATE
    assert_allclose(velocity[-1], 2.0 * height * duration / np.pi, rtol=1e-4)
    during = height * duration**2 / np.pi  # displacement when the pulse ends
    assert_allclose(displacement[n - 1], during, rtol=1e-4)
    assert_allclose(displacement[-1], during + velocity[-1] * 0.9, rtol=1e-4)


def test_from_rest_a_ramp_is_exact():
    t = np.arange(5000) / RATE
    velocity, displacement = integrals(6.0 * t)[:, 0]
    assert_allclose(velocity, 3.0 * t**2, rtol=1e-9, atol=1e-12)
    assert_allclose(displacement, t**3, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("corner", [None, 4.0])
def test_blocks_make_no_difference(monkeypatch, corner):
    noise = np.random.default_rng(5).standard_normal((2, 30_000))
    rows = noise + np.roll(noise, 1, axis=1)  # nothing at half the sample rate, as recorded
    whole = integrals(rows, (500, 29_000), corner)
    monkeypatch.setattr(integration, "BLOCK", 7000)
    parts = integrals(rows, (500, 29_000), corner)
    assert_allclose(parts, whole, rtol=0.0, atol=3e-5 * np.abs(whole).max())


def test_the_baseline_is_the_best_line():
    rng = np.random.default_rng(6)
    rows = np.array([3.0 + 0.01 * np.arange(9000), np.full(9000, -2.0)])
    rows += 0.1 * rng.standard_normal(rows.shape)
    middle, slope = straight_baseline(lambda a, b: rows[:, a:b], (1000, 8000), sloped=True)
    for row, m, s in zip(rows, middle[:, 0], slope[:, 0], strict=True):
        fit = np.polyfit(np.arange(1000, 8000) - 4499.5, row[1000:8000], 1)
        assert_allclose([s, m], fit, rtol=1e-9, atol=1e-12)
    middle, slope = straight_baseline(lambda a, b: rows[:, a:b], (0, 9000), sloped=False)
    assert_allclose(middle[:, 0], rows.mean(axis=1))
    assert not slope.any()
