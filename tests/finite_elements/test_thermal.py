"""Clearance over temperature against expansion by hand, symmetry, and its own inverse."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.finite_elements.coupon import ThermalFit, clearances_at, temperature_change_for

PLASTIC_ON_STEEL = ThermalFit(9.85e-3, 9.80e-3, 110e-6, 12e-6)


def test_no_change_of_temperature_leaves_the_drawing():
    found = clearances_at(PLASTIC_ON_STEEL, 0.0)
    assert_allclose([found.positive, found.negative], 25e-6, rtol=1e-9)
    assert_allclose(found.play, 50e-6, rtol=1e-9)


def test_one_material_scales_the_play_with_everything_else():
    steel = ThermalFit(9.85e-3, 9.80e-3, 12e-6, 12e-6)
    assert_allclose(clearances_at(steel, 1000.0).play / 50e-6, 1.012, rtol=1e-9)


def test_plastic_around_steel_closes_in_the_cold():
    # by hand: 9.85 mm shrinks by 110e-6 * 50 = 54.2 um, 9.80 mm by 5.9 um
    assert_allclose(
        clearances_at(PLASTIC_ON_STEEL, -50.0).play, 50e-6 - 54.175e-6 + 5.88e-6, rtol=1e-9
    )
    assert clearances_at(PLASTIC_ON_STEEL, -100.0).play < 0.0


def test_a_part_held_elsewhere_moves_along_its_slot_and_keeps_its_play():
    still = clearances_at(PLASTIC_ON_STEEL, 30.0)
    moved = clearances_at(PLASTIC_ON_STEEL, 30.0, span=0.1, span_expansion=98e-6)
    assert_allclose(moved.play, still.play)
    assert_allclose(moved.positive - still.positive, 0.1 * 98e-6 * 30.0)
    mirrored = clearances_at(PLASTIC_ON_STEEL, 30.0, span=-0.1, span_expansion=98e-6)
    assert_allclose([mirrored.positive, mirrored.negative], [moved.negative, moved.positive])


@pytest.mark.parametrize("play", [0.0, 20e-6, 200e-6])
def test_the_temperature_of_a_play_gives_that_play(play):
    change = temperature_change_for(PLASTIC_ON_STEEL, play)
    assert_allclose(clearances_at(PLASTIC_ON_STEEL, change).play, play, atol=1e-15)


def test_parts_that_grow_alike_have_no_such_temperature():
    with pytest.raises(ValueError, match="opening and insert expand alike"):
        temperature_change_for(ThermalFit(10e-3, 10e-3, 12e-6, 12e-6), 1e-6)


def test_an_opening_of_nothing_is_refused():
    with pytest.raises(ValueError, match="opening must be above 0 m, not 0"):
        ThermalFit(0.0, 9.8e-3, 1e-5, 1e-5)
    with pytest.raises(ValueError, match="opening_expansion must be a finite number"):
        ThermalFit(9.8e-3, 9.8e-3, np.nan, 1e-5)
