"""Stiffness of holes against Lame's cylinder, symmetry, and the thesis' table 6.4."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.finite_elements.coupon import Coupon, Hole, Material
from shakerproc.finite_elements.hole_stiffness import (
    LOAD_LAWS,
    edge_radius,
    hole_stiffness,
    pressed_displacement,
)

POM_C = Coupon(
    Material("POM C", 2.8e9, 0.44, 1410.0), 50e-3, 8.35e-3, 5e-3, Hole(9.8e-3, 9.8e-3)
)
S355 = replace(POM_C, material=Material("S355", 210e9, 0.3, 7850.0))
SLOT = Hole(13.82e-3, 8.83e-3)


def lame_displacement(coupon, pressure):
    """Displacement of the hole's edge, pressure inside and the rim fixed, plane strain."""
    a, b = coupon.hole.width / 2.0, coupon.outer_radius
    nu = coupon.material.poissons_ratio
    shear = coupon.material.youngs_modulus / (2.0 * (1.0 + nu))
    # u = A r + B / r with u(b) = 0 and radial stress -p at a
    ratio = b**2 / a**2
    constant = pressure / (2.0 * shear * (1.0 / (1.0 - 2.0 * nu) + ratio))
    return constant * (b**2 / a - a)


@pytest.mark.parametrize("coupon", [POM_C, S355], ids=["POM C", "S355"])
def test_pressure_all_around_is_lames_cylinder_to_second_order(coupon):
    exact = lame_displacement(coupon, 1e6)
    errors = [
        abs(pressed_displacement(coupon, 1e6, refinement=n) / exact - 1.0) for n in (1, 2)
    ]
    assert errors[0] < 1.5e-3
    assert errors[1] < errors[0] / 3.5


@pytest.mark.parametrize(("coupon", "thesis"), [(POM_C, 1.931e7), (S355, 1.174e9)])
def test_the_round_hole_is_as_stiff_as_the_thesis_found(coupon, thesis):
    assert_allclose(hole_stiffness(coupon).stiffness, thesis, rtol=0.05)


@pytest.mark.parametrize(
    ("coupon", "axis", "thesis"),
    [
        (POM_C, "length", 1.553e7),
        (POM_C, "width", 1.718e7),
        (S355, "length", 1.071e9),
        (S355, "width", 1.129e9),
    ],
)
def test_the_slot_under_pressure_is_as_stiff_as_the_thesis_found(coupon, axis, thesis):
    slotted = replace(coupon, hole=SLOT)
    found = hole_stiffness(slotted, law="pressure", axis=axis).stiffness
    assert_allclose(found, thesis, rtol=0.06)


@pytest.mark.parametrize("law", LOAD_LAWS)
def test_stiffness_is_proportional_to_thickness_and_modulus(law):
    double = replace(
        POM_C, thickness=10e-3, material=replace(POM_C.material, youngs_modulus=5.6e9)
    )
    ratio = hole_stiffness(double, law=law).stiffness / hole_stiffness(POM_C, law=law).stiffness
    assert_allclose(ratio, 4.0, rtol=1e-9)


def test_a_round_hole_has_no_preferred_axis():
    along, across = (hole_stiffness(POM_C, axis=axis).stiffness for axis in ("length", "width"))
    assert_allclose(along, across, rtol=1e-6)


def test_the_edge_of_a_slot_has_its_length_and_width():
    assert_allclose(edge_radius(SLOT, np.array([0.0, np.pi / 2.0])), [6.91e-3, 4.415e-3])


def test_an_unknown_load_law_is_refused():
    with pytest.raises(ValueError, match="law must be one of traction, pressure"):
        hole_stiffness(POM_C, law="glue")
