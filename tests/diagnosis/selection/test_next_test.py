"""The test that is proposed next: levels as a log says them, limits, and what it would show."""

import numpy as np
import pytest
from tests.diagnosis.one_mass import JOINT, RATE, arrays_of, one_mass

from shakerproc.data import STANDARD_GRAVITY as G
from shakerproc.diagnosis.data import prepared
from shakerproc.diagnosis.joint_outcomes import Locked
from shakerproc.diagnosis.selection.excitations import level_text, most_of
from shakerproc.diagnosis.selection.next_test import (
    Alternative,
    Laboratory,
    closing,
    slipping,
    telling_apart,
)
from shakerproc.models import EFFECTS
from shakerproc.simulation import simulate
from shakerproc.testlog import Shaker
from shakerproc.testlog.excitation import level_of

ONE = np.ones(1)
LINEAR = one_mass()
TESTS = prepared(arrays_of(LINEAR, levels=(2.0, 6.0), seconds=3.0))
LOUDEST = TESTS[1]


def laboratory(**limits):
    return Laboratory(TESTS, LINEAR, Shaker(**limits), 0)


def rms_of(proposed):
    """Return the rms of a proposed drive [m/s^2]."""
    level, unit = level_of(proposed.level, proposed.excitation)
    if unit.endswith("/Hz"):
        return np.sqrt(level * (proposed.band_hz[1] - proposed.band_hz[0]))
    return level if unit.endswith("rms") else level / np.sqrt(2.0)


@pytest.mark.parametrize(
    ("level", "unit", "kind"),
    [
        (0.013 * G**2, "(m/s^2)^2/Hz", "random"),
        (1.5 * G, "m/s^2", "sine sweep"),
        (2.0 * G, "m/s^2 rms", "random"),
        (3.0, "N", "sine"),
    ],
)
def test_a_level_is_written_as_a_log_reads_it(level, unit, kind):
    read, its_unit = level_of(level_text(level, unit), kind)
    assert read == pytest.approx(level, rel=1e-2)
    assert its_unit == unit


@pytest.mark.parametrize(
    ("shaker", "most"),
    [
        (Shaker(), np.inf),
        (Shaker(acceleration=11.0), 1.1),
        (Shaker(velocity=0.9 * 10.0 / (40.0 * np.pi)), 0.9),
        (Shaker(stroke=3.0 * 10.0 / (40.0 * np.pi) ** 2), 1.5),
        (Shaker(force=50.0, moving_mass=4.0), 1.25),
    ],
)
def test_a_sine_is_held_against_each_limit(shaker, most):
    """10 m/s^2 at 20 Hz: velocity over omega, displacement over its square."""
    t = np.arange(5000) / RATE
    found = most_of(shaker, 10.0 * np.sin(40.0 * np.pi * t), RATE)
    assert found == pytest.approx(most, rel=1e-6)


def test_a_cubic_spring_is_told_from_none_by_a_louder_test():
    """Its share of the force grows with the square of the motion."""
    cubic = one_mass(effect=EFFECTS["cubic_stiffness"](4e10))
    alternatives = [Alternative((), LINEAR, ONE), Alternative(("cubic_stiffness",), cubic, ONE)]
    (found,) = telling_apart(laboratory(), alternatives[0], alternatives[1:])
    assert found.separates == ("cubic_stiffness",)
    assert rms_of(found) > 1.9 * rms_of_loudest()
    limit = 0.8 * np.sqrt(2.0) * rms_of(found)
    (held,) = telling_apart(laboratory(acceleration=limit), alternatives[0], alternatives[1:])
    assert rms_of(held) <= limit / (1.0 if held.excitation == "random" else np.sqrt(2.0)) * 1.01


def rms_of_loudest():
    return float(np.std(LOUDEST.input[LOUDEST.start :]))


def test_the_same_law_under_two_names_is_said_not_to_be_told_apart():
    same = [Alternative((name,), LINEAR, ONE) for name in ("gap", "stop")]
    (found,) = telling_apart(laboratory(), same[0], same[1:])
    assert found.separates == ("gap", "stop")
    assert "too little to tell them apart" in found.reason


def test_a_locked_joint_is_loaded_as_far_as_the_shaker_goes():
    locked = [Locked(JOINT, 3.0)]
    (found,) = slipping(laboratory(), locked, ("coulomb_friction",))
    assert rms_of(found) == pytest.approx(3.0 * rms_of_loudest(), rel=0.01)
    assert "9 N" in found.reason
    peak = float(np.max(np.abs(LOUDEST.input)))
    (held,) = slipping(laboratory(acceleration=1.3 * peak), locked, ())
    assert rms_of(held) == pytest.approx(1.3 * rms_of_loudest(), rel=0.02)
    assert slipping(laboratory(acceleration=0.9 * peak), locked, ()) == ()


def test_a_clearance_is_closed_by_the_level_that_is_proposed():
    """The linear motion of the proposed test passes the clearance."""
    moved = simulate(LINEAR, LOUDEST.input, RATE, growth=False).displacement[0]
    reach = float(np.max(np.abs(moved)))
    clearance = 1.4 * reach
    contact = one_mass(effect=EFFECTS["gap"](1e5, clearance))
    alternatives = [Alternative((), LINEAR, ONE), Alternative(("gap",), contact, ONE)]
    (found,) = closing(laboratory(), *alternatives, clearance, reach)
    louder = rms_of(found) / rms_of_loudest()
    shaken = simulate(LINEAR, louder * LOUDEST.input, RATE, growth=False).displacement[0]
    assert np.max(np.abs(shaken)) > 1.2 * clearance
    assert louder < 3.1 * 1.4
