"""Plate modes against Leissa's tables, beam limits, and another program's figures."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.finite_elements.annular_meshes import shell_modes, solid_frequencies
from shakerproc.finite_elements.annular_plate import mindlin_modes, plate_frequency, plate_roots
from shakerproc.finite_elements.coupon import Coupon, Hole, Material

POM_C = Material("POM C", 2.8e9, 0.44, 1410.0)
S355 = Material("S355", 210e9, 0.3, 7850.0)
ROUND = Hole(9.8e-3, 9.8e-3)
THIN = Coupon(POM_C, 50e-3, 8.35e-3, 2.6e-3, ROUND)
STEEL = Coupon(S355, 50e-3, 8.0e-3, 5.0e-3, ROUND)

# MYSTRAN 17, CQUAD4, 1600 elements; n = 1, 0, 2 (measured before the project began)
MYSTRAN = {8.35e-3: (321.77, 368.58, 414.94), 8.00e-3: (314.52, 363.23, 410.28)}


@pytest.mark.parametrize(
    ("ratio", "expected"),
    [
        (0.1, (4.2374, 3.4781, 5.6227)),
        (0.3, (6.6604, 6.5523, 7.9565)),
        (0.5, (13.0243, 13.2898, 14.7038)),
    ],
)
def test_roots_are_those_of_the_tables(ratio, expected):
    found = [plate_roots(ratio, 0.3, n, 1)[0].lambda_squared for n in range(3)]
    assert_allclose(found, expected, rtol=1e-4)


def test_a_narrow_ring_is_a_cantilever():
    narrow = plate_roots(0.99, 0.3, 0, 1)[0].lambda_squared * 0.01**2
    assert_allclose(narrow, 3.5160, rtol=3e-3)  # first root of 1 + cos x cosh x, squared


def test_roots_rise_with_the_number_of_circles():
    roots = [root.lambda_squared for root in plate_roots(0.2, 0.3, 2, 4)]
    assert roots == sorted(roots)
    assert [root.circles for root in plate_roots(0.2, 0.3, 2, 4)] == [0, 1, 2, 3]


def test_a_radius_ratio_outside_0_to_1_is_refused():
    with pytest.raises(ValueError, match=r"radius_ratio must lie between 0 and 1, not 1\.2"):
        plate_roots(1.2, 0.3, 0, 1)


@pytest.mark.parametrize("diameters", [0, 1, 2, 3])
def test_a_very_thin_mindlin_plate_is_a_kirchhoff_plate(diameters):
    thin = replace(THIN, thickness=0.05e-3)
    root = plate_roots(8.35 / 50.0, 0.44, diameters, 2)
    kirchhoff = [plate_frequency(r.lambda_squared, POM_C, 0.05e-3, 50e-3) for r in root]
    assert_allclose(mindlin_modes(thin, diameters, 2).frequencies, kirchhoff, rtol=5e-4)


@pytest.mark.parametrize("clamped", MYSTRAN)
def test_a_shell_mesh_gives_what_another_program_gives(clamped):
    found = shell_modes(replace(THIN, clamped_radius=clamped), 5).frequencies
    assert_allclose(found[[0, 2, 3]], MYSTRAN[clamped], rtol=2e-3)
    assert_allclose(found[[0, 3]], found[[1, 4]], rtol=1e-6)  # modes with diameters are pairs


def test_a_finer_shell_mesh_goes_to_the_plate_along_the_radius():
    exact = [mindlin_modes(THIN, n, 1).frequencies[0] for n in (1, 0)]
    coarse = shell_modes(THIN, 3, radial=12, around=48).frequencies[[0, 2]] - exact
    fine = shell_modes(THIN, 3, radial=24, around=96).frequencies[[0, 2]] - exact
    assert np.all(np.abs(coarse / fine) > 3.5)  # second order: 4


def test_the_thesis_frequencies_of_pom_c_come_out_at_the_inferred_clamp():
    inferred = replace(THIN, clamped_radius=8.00e-3)
    found = shell_modes(inferred, 5).frequencies[[0, 2, 3]]
    assert_allclose(found, (314.0, 364.0, 410.0), rtol=5e-3)


def test_the_thesis_frequency_of_steel_comes_out_with_the_faces_clamped():
    assert_allclose(solid_frequencies(STEEL, 1, 1)[0], 1953.0, rtol=1e-2)


@pytest.mark.parametrize("diameters", [0, 1, 2])
def test_a_solid_held_at_all_nodes_is_close_to_the_plate_and_held_at_its_faces_is_softer(
    diameters,
):
    plate = mindlin_modes(THIN, diameters, 1).frequencies[0]
    held = solid_frequencies(THIN, diameters, 1, clamp="all nodes")[0]
    faces = solid_frequencies(THIN, diameters, 1, clamp="faces")[0]
    assert_allclose(held, plate, rtol=1e-2)
    assert faces < held


def test_the_mass_is_that_of_the_lost_drawings():
    # m = k / (2 pi f)^2 of the thesis' table 6.4: 0.0548 kg at 5 mm
    assert_allclose(
        replace(THIN, thickness=5e-3).mass, 1.931e7 / (2 * np.pi * 2987.0) ** 2, rtol=2e-3
    )
