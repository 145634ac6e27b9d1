"""Quantiles of chi-square against scipy's."""

import math

import pytest
from numpy.testing import assert_allclose
from scipy import special

from shakerproc.spectra.responses.chi_square import chi_square_quantile


@pytest.mark.parametrize("probability", [1e-4, 0.025, 0.5, 0.975, 0.995])
@pytest.mark.parametrize("freedom", [0.7, 1.0, 2.0, 3.3, 11.0, 250.0, 7213.0, 1e6])
def test_quantiles_are_scipys(probability, freedom):
    theirs = 2.0 * special.gammaincinv(0.5 * freedom, probability)
    assert_allclose(chi_square_quantile(probability, freedom), theirs, rtol=1e-10)


@pytest.mark.parametrize("probability", [0.01, 0.5, 0.99])
def test_two_degrees_of_freedom_are_an_exponential(probability):
    wanted = -2.0 * math.log1p(-probability)
    assert_allclose(chi_square_quantile(probability, 2.0), wanted, rtol=1e-13)
