"""Rainflow, vibration response and fatigue damage against standards and closed forms."""

from math import gamma

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.spectra.kernels import rainflow
from shakerproc.spectra.response_spectra import fatigue_spectra


def counted(signal):
    ranges, counts = rainflow(np.array(signal, dtype=float))
    return {r: float(counts[ranges == r].sum()) for r in sorted(set(ranges.tolist()))}


def test_the_example_of_the_standard():
    """ASTM E1049-85, figure 6."""
    found = counted([-2, 1, -3, 5, -1, 3, -4, 4, -2])
    assert found == {3.0: 0.5, 4.0: 1.5, 6.0: 0.5, 8.0: 1.0, 9.0: 0.5}


def test_what_lies_between_turning_points_does_not_count():
    points = [-2, 1, -3, 5, -1, 3, -4, 4, -2]
    fine = np.interp(np.arange(0, 8.01, 0.125), np.arange(9), points)
    assert counted(np.repeat(fine, 3)) == counted(points)


def test_a_sine_of_ten_periods_is_ten_cycles():
    ranges, counts = rainflow(2.5 * np.cos(2.0 * np.pi * np.arange(10_001) / 1000.0))
    assert_allclose(ranges, 5.0)
    assert counts.sum() == 10.0


@pytest.mark.parametrize("signal", [[], [1.0], [2.0, 2.0, 2.0]])
def test_what_does_not_move_has_no_cycles(signal):
    assert counted(signal) == {}


@pytest.mark.parametrize("exponent", [4.0, 8.0])
def test_a_steady_sine_does_the_damage_of_its_cycles(exponent):
    rate, seconds, zeta = 4000.0, 40.0, 0.05
    t = np.arange(round(rate * seconds)) / rate
    base = 3.0 * np.sin(2.0 * np.pi * 50.0 * t)[np.newaxis]
    found = fatigue_spectra(
        [base], rate, np.array([50.0, 400.0]), damping=zeta, exponent=exponent
    )
    omega = 2.0 * np.pi * np.array([50.0, 400.0])
    r = np.array([1.0, 50.0 / 400.0])
    z = 3.0 / omega**2 / np.sqrt((1 - r**2) ** 2 + (2 * zeta * r) ** 2)
    wanted = 50.0 * seconds * (omega * z) ** exponent
    assert_allclose(found.damage[0], wanted, rtol=0.02)
    assert_allclose(found.displacement[0], z / np.sqrt(2.0), rtol=0.01)


def test_white_noise_agrees_with_miles_and_with_a_narrow_band():
    """Miles: pi f S (1 + 4 zeta^2) / (4 zeta); damage f T (sqrt 2 sigma)^b Gamma(1 + b/2)."""
    rate, seconds, zeta, b, density = 4000.0, 600.0, 0.02, 4.0, 0.5
    rng = np.random.default_rng(8)
    noise = rng.standard_normal((1, round(rate * seconds))) * np.sqrt(density * rate / 2.0)
    frequency = np.array([40.0, 80.0])
    blocks = np.split(noise, [7, 100_000, 1_500_000], axis=1)
    found = fatigue_spectra(blocks, rate, frequency, damping=zeta, exponent=b)
    omega = 2.0 * np.pi * frequency
    miles = np.sqrt(np.pi * frequency * density * (1 + 4 * zeta**2) / (4 * zeta))
    assert_allclose(found.acceleration[0], miles, rtol=0.03)
    sigma = np.sqrt(np.pi * frequency * density / (4 * zeta)) / omega**2
    assert_allclose(found.displacement[0], sigma, rtol=0.03)
    narrow = frequency * seconds * (np.sqrt(2.0) * omega * sigma) ** b * gamma(1 + b / 2)
    assert_allclose(found.damage[0], narrow, rtol=0.12)  # chance of the fourth power: 5 %


def test_blocks_make_no_difference_and_channels_do_not_mix():
    noise = np.random.default_rng(9).standard_normal((2, 5000))
    how = {"damping": 0.05, "exponent": 6.0}
    frequency = np.array([3.0, 30.0, 100.0])
    whole = fatigue_spectra([noise], 1000.0, frequency, **how)
    parts = fatigue_spectra(np.split(noise, [1, 2, 999], axis=1), 1000.0, frequency, **how)
    alone = fatigue_spectra([noise[1:]], 1000.0, frequency, **how)
    for name in ("acceleration", "displacement", "damage"):
        assert_allclose(getattr(parts, name), getattr(whole, name), rtol=1e-12)
        assert_allclose(getattr(alone, name)[0], getattr(whole, name)[1], rtol=1e-12)


@pytest.mark.parametrize(("frequency", "damping"), [(101.0, 0.05), (10.0, 0.0), (10.0, 1.0)])
def test_what_has_no_damage_is_refused(frequency, damping):
    with pytest.raises(ValueError, match=r"frequencies|no damage"):
        fatigue_spectra(
            [np.zeros((1, 9))], 1000.0, np.array([frequency]), damping=damping, exponent=4.0
        )
