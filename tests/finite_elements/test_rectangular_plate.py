"""A free plate against published frequencies, its own mass, and what rigid bodies do."""

import numpy as np
from numpy.testing import assert_allclose

from shakerproc.finite_elements.rectangular_plate import Plate, free_plate_modes

SQUARE = Plate(0.4, 0.4, 2e-3, youngs_modulus=70e9, poissons_ratio=0.3, density=2700.0)


def test_a_free_square_plate_has_the_published_frequencies():
    """Omega a^2 sqrt(rho h / D): K. M. Liew, Y. Xiang and S. Kitipornchai, J. Sound and
    Vibration 168, 39-69, 1993, free on all sides, Poisson's ratio 0.3."""
    found, _ = free_plate_modes(SQUARE, [(0.0, 0.0)], 9)
    factor = 2.0 * np.pi * 0.4**2 * np.sqrt(2700.0 * 2e-3 / SQUARE.rigidity)
    assert_allclose(found[:3], 0.0)
    published = [13.468, 19.596, 24.270, 34.801, 34.801, 61.093]
    assert_allclose(found[3:] * factor, published, rtol=1e-3)


def test_rigid_body_modes_carry_the_mass_and_the_moments_of_inertia():
    """A unit force at a point of a free rigid plate moves it by 1/m + x^2/I_y + y^2/I_x."""
    plate = Plate(0.5, 0.3, 5e-3, youngs_modulus=70e9, poissons_ratio=0.33, density=2700.0)
    x, y = 0.47, 0.04
    _, shapes = free_plate_modes(plate, [(x, y)], 3)
    m = 0.5 * 0.3 * 5e-3 * 2700.0
    wanted = (1.0 + 12.0 * ((x - 0.25) / 0.5) ** 2 + 12.0 * ((y - 0.15) / 0.3) ** 2) / m
    assert_allclose(np.sum(shapes**2), wanted, rtol=1e-6)
