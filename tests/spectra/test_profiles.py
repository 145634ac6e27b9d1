"""Lines between breakpoints against their closed forms and a fine sum."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.spectra.profiles import profile_at, profile_rms


@pytest.mark.parametrize("slope", [-6.0, -3.0103, -3.0, 0.0, 3.0, 6.0])
def test_a_slope_in_decibels_per_octave_is_a_straight_line(slope):
    points = np.array([20.0, 640.0])  # five octaves
    levels = np.array([0.01, 0.01 * 10 ** (5 * slope / 10)])
    octaves_up = profile_at(20.0 * 2.0 ** np.arange(6), points, levels)
    assert_allclose(10 * np.log10(octaves_up / 0.01), slope * np.arange(6), atol=1e-9)


def test_there_is_no_level_outside_the_breakpoints():
    found = profile_at(np.array([9.9, 10.0, 20.0, 20.1]), np.array([10.0, 20.0]), np.ones(2))
    assert np.isnan(found).tolist() == [True, False, False, True]


def test_grms_of_the_navmat_profile():
    """NAVMAT P-9492: 0.04 g^2/Hz from 80 to 350 Hz, 3 dB/oct either side: 6.06 g rms."""
    points = np.array([20.0, 80.0, 350.0, 2000.0])
    levels = np.array([0.01, 0.04, 0.04, 0.007])
    assert_allclose(profile_rms(points, levels), 6.06, atol=0.005)


@pytest.mark.parametrize("band", [None, (30.0, 900.0), (1.0, 5000.0)])
def test_grms_is_that_of_a_fine_sum(band):
    points, levels = np.array([20.0, 80.0, 350.0, 2000.0]), np.array([0.01, 0.04, 0.02, 0.02])
    low, high = band or (20.0, 2000.0)
    f = np.linspace(max(low, 20.0), min(high, 2000.0), 2_000_001)
    expected = np.sqrt(np.trapezoid(profile_at(f, points, levels), f))
    assert_allclose(profile_rms(points, levels, band), expected, rtol=1e-9)


def test_a_slope_of_minus_three_decibels_has_a_logarithm_as_area():
    """Where the density falls as 1/f, the area is a constant times the logarithm."""
    assert_allclose(
        profile_rms(np.array([10.0, 1000.0]), np.array([1.0, 0.01])),
        np.sqrt(10.0 * np.log(100.0)),
        rtol=1e-12,
    )
