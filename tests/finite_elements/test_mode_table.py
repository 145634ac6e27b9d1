"""Names of modes, effective masses, the lost drawings, and a plate on a table by quadrature."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad
from scipy.optimize import brentq

from shakerproc.finite_elements.annular_meshes import (
    MODELS,
    named_modes,
    shell_modes,
    solid_frequencies,
)
from shakerproc.finite_elements.annular_plate import mindlin_modes
from shakerproc.finite_elements.coupon import Coupon, Hole, Material, disc_of_inertia
from shakerproc.finite_elements.hole_stiffness import loaded_holes, mesh_convergence

POM_C = Material("POM C", 2.8e9, 0.44, 1410.0)
THIN = Coupon(POM_C, 50e-3, 8.0e-3, 2.6e-3, Hole(9.8e-3, 9.8e-3))


@pytest.mark.slow
def test_every_model_names_the_same_modes_alike():
    found = named_modes(THIN, 4)
    names = [(mode.diameters, mode.circles) for mode in found]
    assert names == [(1, 0), (0, 0), (2, 0), (3, 0)]
    for mode in found:
        assert set(mode.frequencies) == set(MODELS)
        spread = list(mode.frequencies.values())
        assert max(spread) / min(spread) < 1.05
        assert max(mode.frequencies, key=mode.frequencies.get) == "Kirchhoff"  # no shear


def test_shell_modes_with_diameters_come_in_pairs_with_one_name():
    modes = shell_modes(THIN, 10, radial=10, around=40)
    names = list(zip(modes.diameters.tolist(), modes.circles.tolist(), strict=True))
    assert names == [
        (1, 0), (1, 0), (0, 0), (2, 0), (2, 0), (3, 0), (3, 0), (4, 0), (4, 0), (0, 1),
    ]  # fmt: skip


def test_effective_masses_add_up_to_what_is_outside_the_clamp():
    modes = mindlin_modes(THIN, 0, 40)
    outside = 1410.0 * 2.6e-3 * np.pi * (50e-3**2 - 8e-3**2)
    sums = np.cumsum(modes.effective_mass)
    assert np.all(np.diff(sums) >= 0.0)  # twisting about the axis does not push at all
    assert sums[-1] <= outside * (1.0 + 1e-9)
    assert_allclose(sums[-1], outside, rtol=1e-2)  # what is at the clamp itself never moves


def test_modes_with_diameters_do_not_feel_a_table_that_moves_evenly():
    assert not np.any(mindlin_modes(THIN, 1, 3).effective_mass)


def test_the_factors_of_all_modes_add_up_to_following_the_table():
    # a plate that is pushed slowly stays rigid: the participations times shapes sum to 1
    modes = mindlin_modes(THIN, 0, 30)
    total = modes.largest_factor @ modes.shapes
    assert_allclose(total[60:], 1.0, atol=0.05)


def test_a_thin_narrow_ring_has_the_effective_mass_of_a_cantilever():
    narrow = Coupon(POM_C, 50e-3, 49e-3, 0.01e-3, Hole(9.8e-3, 9.8e-3))
    modes = mindlin_modes(narrow, 0, 1)
    outside = 1410.0 * 0.01e-3 * np.pi * (50e-3**2 - 49e-3**2)
    assert_allclose(modes.effective_mass[0] / outside, cantilever_share(), rtol=2e-2)


def cantilever_share():
    root = brentq(lambda x: np.cos(x) * np.cosh(x) + 1.0, 1.5, 2.5)
    c = (np.cos(root) + np.cosh(root)) / (np.sin(root) + np.sinh(root))

    def shape(x):
        x = root * x
        return np.cosh(x) - np.cos(x) - c * (np.sinh(x) - np.sin(x))

    return quad(shape, 0, 1)[0] ** 2 / quad(lambda x: shape(x) ** 2, 0, 1)[0]


def test_the_solid_gives_bending_modes_only():
    # the ring's own stretching lies between these: 6.5 kHz for one diameter
    found = solid_frequencies(THIN, 1, 3)
    plate = mindlin_modes(THIN, 1, 3).frequencies
    assert_allclose(found, plate, rtol=0.03)


def test_the_inertia_of_appendix_a_gives_the_lost_drawings_radius_and_thickness():
    # CONM2 of 1 kg: 633.07, 633.07 and 1265.02 kg mm^2; t = 2.6 mm and R = 50 mm by hand
    outer, thickness = disc_of_inertia(633.07e-6, 1265.02e-6, hole_radius=5.5e-3)
    assert_allclose(thickness, 2.592e-3, rtol=1e-3)
    assert_allclose(outer, 50.0e-3, rtol=1e-3)


def test_the_inertia_of_a_disc_gives_back_the_disc():
    outer, inner, thickness = 40e-3, 6e-3, 3e-3
    polar = 0.5 * (outer**2 + inner**2)
    across = 0.5 * polar + thickness**2 / 12.0
    assert_allclose(
        disc_of_inertia(across, polar, hole_radius=inner), [outer, thickness], rtol=1e-9
    )


def test_an_impossible_inertia_is_refused():
    with pytest.raises(ValueError, match="half of the polar inertia"):
        disc_of_inertia(1e-4, 1e-3, hole_radius=1e-3)


@pytest.mark.slow
def test_load_laws_disagree_and_meshes_do_not():
    static = replace(THIN, thickness=5e-3)
    spread = loaded_holes(static)
    by_assumption = {
        (one.law, round(np.degrees(one.half_angle)), one.plane): one.stiffness for one in spread
    }
    # measured before the project began, another mesh: table 6.4's 1.931e4 N/mm beside
    for key, off in {
        ("traction", 90, "strain"): 3.3,
        ("traction", 85, "strain"): -0.4,
        ("cosine bearing", 90, "strain"): -23.0,
        ("traction", 90, "stress"): -23.1,
    }.items():
        assert_allclose(100 * (by_assumption[key] / 1.931e7 - 1), off, atol=0.15)
    meshes = list(mesh_convergence(static, "length", "traction", np.pi / 2, "strain").values())
    assert abs(meshes[2] / meshes[1] - 1) < abs(meshes[1] / meshes[0] - 1) < 1e-3
    assert_allclose([one.frequency for one in spread[:1]], 2987.0, rtol=0.02)
