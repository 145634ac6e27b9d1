"""Where play is used up: closed forms of one mass, and the simulation with its gap."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.errors import ModelError
from shakerproc.models import Element, Excitation, Model
from shakerproc.models.effects.coulomb_friction import CoulombFriction
from shakerproc.models.effects.damper import Damper
from shakerproc.models.effects.gap import Gap
from shakerproc.models.effects.jenkins import Jenkins
from shakerproc.models.effects.offset_gap import OffsetGap
from shakerproc.models.effects.spring import Spring
from shakerproc.planning import (
    FreeJoint,
    RandomInput,
    ShakerLimits,
    SineInput,
    Walls,
    bands_within_limits,
    curve,
    joint_of_model,
    reach,
)
from shakerproc.simulation import simulate
from shakerproc.simulation.excitations import harmonic

MASS, NATURAL, RATIO = 0.05, 100.0, 0.02
OMEGA = 2.0 * np.pi * NATURAL
PLAY = 2.0e-5
BETWEEN = ("base", "coupon")


def one_mass(*effects, excitation=None):
    linear = (Spring(MASS * OMEGA**2), Damper(2.0 * RATIO * OMEGA * MASS))
    return Model(
        "one mass",
        {"coupon": MASS},
        tuple(Element(effect, BETWEEN) for effect in (*linear, *effects)),
        excitation or Excitation("base acceleration"),
    )


def closed_form(frequency):
    omega = 2.0 * np.pi * frequency
    return 1.0 / np.hypot(OMEGA**2 - omega**2, 2.0 * RATIO * OMEGA * omega)


def edges_in_closed_form(ratio):
    """Return where |z / a0| is a ratio [s²], from the quadratic in omega squared."""
    middle = OMEGA**2 * (1.0 - 2.0 * RATIO**2)
    apart = np.sqrt(middle**2 - OMEGA**4 + ratio**-2)
    return np.sqrt([middle - apart, middle + apart]) / (2.0 * np.pi)


def test_the_gain_of_one_mass_is_its_closed_form():
    frequency = np.geomspace(1.0, 1000.0, 200)
    gain = joint_of_model(one_mass()).gain(frequency)
    assert_allclose(np.abs(gain), closed_form(frequency), rtol=1e-12)


def test_a_force_drives_it_by_its_mass():
    shaken = joint_of_model(one_mass(excitation=Excitation("force", "coupon")))
    frequency = np.array([30.0, 150.0])
    assert_allclose(np.abs(shaken.gain(frequency)), closed_form(frequency) / MASS, rtol=1e-12)


def test_the_modes_of_one_mass():
    (mode,) = joint_of_model(one_mass(Gap(1e5, PLAY))).modes()
    assert_allclose((mode.frequency, mode.damping_ratio), (NATURAL, RATIO), rtol=1e-12)


def test_a_gap_without_play_is_a_spring():
    (mode,) = joint_of_model(one_mass(Gap(3.0 * MASS * OMEGA**2, 0.0))).modes()
    assert_allclose(mode.frequency, 2.0 * NATURAL, rtol=1e-12)


def test_a_joint_that_slips_is_stiff_at_rest():
    (mode,) = joint_of_model(one_mass(Jenkins(3.0 * MASS * OMEGA**2, 1.0))).modes()
    assert_allclose(mode.frequency, 2.0 * NATURAL, rtol=1e-12)


def test_friction_that_is_left_out_is_told():
    joint = joint_of_model(one_mass(CoulombFriction(1.0)))
    assert "coulomb_friction between base and coupon is left out" in joint.notes[0]


def test_a_sweep_touches_between_the_roots_of_a_quadratic():
    level = 2.0
    joint = joint_of_model(one_mass())
    found = reach(joint, SineInput(level, 10.0, 1000.0), Walls(PLAY, PLAY))
    (band,) = found.both_sides_hz
    assert_allclose(band, edges_in_closed_form(PLAY / level), rtol=1e-9)
    peak = 1.0 / (2.0 * RATIO * OMEGA**2 * np.sqrt(1.0 - RATIO**2))
    assert_allclose(found.displacement, level * peak, rtol=1e-9)
    assert_allclose(found.at_hz, NATURAL * np.sqrt(1.0 - 2.0 * RATIO**2), rtol=1e-6)
    assert_allclose(found.factor_both_sides, PLAY / (level * peak), rtol=1e-9)


def test_a_narrow_resonance_is_not_missed():
    stiff = Model(
        "sharp",
        {"coupon": MASS},
        (
            Element(Spring(MASS * OMEGA**2), BETWEEN),
            Element(Damper(2e-5 * OMEGA * MASS), BETWEEN),
        ),
        Excitation("base acceleration"),
    )
    found = reach(joint_of_model(stiff), SineInput(1.0, 1.0, 5000.0), Walls(PLAY, PLAY))
    assert_allclose(found.displacement, 1.0 / (2e-5 * OMEGA**2), rtol=1e-6)


@pytest.mark.parametrize(("share", "touches"), [(0.99, False), (1.01, True)])
def test_the_level_that_just_touches_is_that_of_the_simulated_gap(share, touches):
    model = one_mass(Gap(1e5, PLAY))
    joint = joint_of_model(model)
    found = reach(joint, SineInput(1.0, 50.0, 200.0), joint.walls())
    level = share * found.factor_both_sides
    signal = harmonic(found.at_hz, level)
    run = simulate(model, signal, 5000.0, duration=1.5, growth=False)
    assert (run.switchings > 0) is touches


def test_an_uneven_gap_is_touched_on_one_side_first():
    joint = joint_of_model(one_mass(OffsetGap(1e5, PLAY, 3.0 * PLAY)))
    peak = 1.0 / (2.0 * RATIO * OMEGA**2)
    walls = joint.walls()
    assert (walls.near, walls.far) == (PLAY, 3.0 * PLAY)
    for level, contact in ((0.5, "none"), (2.0, "one side"), (3.5, "both sides")):
        shaken = SineInput(level * PLAY / peak, 10.0, 500.0)
        found = reach(joint, shaken, walls)
        assert found.contact == contact
        assert bool(found.one_side_hz) is (contact != "none")
        assert bool(found.both_sides_hz) is (contact == "both sides")


def test_the_walls_turn_round_with_the_places():
    gap = Element(OffsetGap(1e5, PLAY, 3.0 * PLAY), ("coupon", "base"))
    model = one_mass()
    turned = Model("turned", model.masses, (*model.elements, gap), model.excitation)
    walls = joint_of_model(turned, ("base", "coupon")).walls()
    # Its places are those of the element that is named first: base, coupon.
    assert (walls.positive, walls.negative) == (3.0 * PLAY, PLAY)


def test_a_part_that_only_a_gap_holds_moves_against_the_table_as_eq_5_5_says():
    alone = Model(
        "alone",
        {"coupon": MASS},
        (Element(Gap(1e5, PLAY), BETWEEN),),
        Excitation("base acceleration"),
    )
    frequency = np.array([5.0, 50.0, 500.0])
    assert_allclose(
        np.abs(joint_of_model(alone).gain(frequency)), FreeJoint().gain(frequency).real
    )
    shaken = SineInput(20.0, 5.0, 500.0)
    found = reach(FreeJoint(), shaken, Walls(PLAY, PLAY))
    ((low, high),) = found.both_sides_hz
    assert_allclose((low, high), (5.0, np.sqrt(20.0 / PLAY) / (2.0 * np.pi)), rtol=1e-9)


def test_random_motion_of_one_mass_under_white_noise():
    """Mean square G / (8 zeta omega^3) for a one-sided density G by Hz; zeros at f_n (Rice)."""
    joint = joint_of_model(one_mass())
    density = 0.3
    found = reach(joint, RandomInput(density, 0.01, 50000.0), Walls(PLAY, PLAY))
    sigma = np.sqrt(density / (8.0 * RATIO * OMEGA**3))
    assert_allclose(found.displacement, 3.0 * sigma, rtol=1e-5)
    expected = 2.0 * NATURAL * np.exp(-0.5 * (PLAY / sigma) ** 2)
    assert_allclose(found.contacts_per_second, expected, rtol=2e-3)


def test_how_often_random_motion_touches_is_counted_in_a_simulated_history():
    joint = joint_of_model(one_mass())
    density, rate, n = 0.3, 8000.0, 2**21
    rng = np.random.default_rng(20240607)
    frequency = np.fft.rfftfreq(n, 1.0 / rate)
    inside = (frequency >= 20.0) & (frequency <= 400.0)
    spectrum = np.zeros(frequency.size, complex)
    drawn = rng.standard_normal((2, inside.sum()))
    lines = np.sqrt(density * rate * n / 4.0) * (drawn[0] + 1j * drawn[1])
    spectrum[inside] = lines * joint.gain(frequency[inside])
    z = np.fft.irfft(spectrum, n)
    found = reach(joint, RandomInput(density, 20.0, 400.0), Walls(PLAY, PLAY))
    assert_allclose(3.0 * np.std(z), found.displacement, rtol=0.02)
    counted = np.sum((np.abs(z[1:]) > PLAY) & (np.abs(z[:-1]) <= PLAY)) / (n / rate)
    assert_allclose(counted, found.contacts_per_second, rtol=0.06)


def test_the_curve_of_random_motion_begins_with_all_of_it():
    joint = joint_of_model(one_mass())
    shaken = RandomInput(0.3, 20.0, 400.0)
    found = reach(joint, shaken, Walls(PLAY, PLAY))
    height = curve(joint, shaken, np.array([20.0, 99.0, 101.0, 400.0]))
    assert_allclose(height[[0, -1]], [found.displacement, 0.0], atol=1e-12 * height[0])
    # Shares of a resonance 4 Hz wide above 1 Hz below and above its middle.
    shares = 0.5 + np.arctan([0.5, -0.5]) / np.pi
    assert_allclose(height[1] / height[2], np.sqrt(shares[0] / shares[1]), rtol=0.03)


def test_where_the_shaker_at_its_limit_uses_up_the_play():
    limits = ShakerLimits(acceleration=2.0)
    (band,) = bands_within_limits(joint_of_model(one_mass()), limits, (5.0, 900.0), PLAY)
    assert_allclose(band, edges_in_closed_form(PLAY / 2.0), rtol=1e-9)


def test_a_joint_that_is_not_there():
    with pytest.raises(
        ModelError, match="nothing stands between base and rim; the joints are base,coupon"
    ):
        joint_of_model(one_mass(), ("base", "rim"))
