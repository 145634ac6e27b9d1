"""Offsets of displacements that a short test does not tell, against motions by scipy."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from shakerproc.comparison.noise_sources import offset_errors
from shakerproc.diagnosis.api import diagnose_arrays
from shakerproc.diagnosis.data import TestArrays
from shakerproc.models import Element, Excitation, Model, Sensor
from shakerproc.models.effects import Damper, Spring

RATE, SECONDS = 1000.0, 1.2
MASS, OMEGA, RATIO = 0.5, 2.0 * np.pi * 10.0, 0.04
STIFFNESS, CLEARANCE, OFFSET = 2.5e3, 3e-3, 1.1e-3


def test_the_error_of_a_mean_is_that_of_white_noise():
    rows = np.random.default_rng(0).standard_normal((400, 4000))
    assert np.mean(offset_errors(rows) ** 2) == pytest.approx(1.0 / 4000.0, rel=0.1)


def test_a_whole_number_of_periods_has_no_mean_to_be_wrong_about():
    turns = np.sin(2.0 * np.pi * np.arange(1600) / 20.0)
    assert offset_errors(np.array([turns, turns + 3.0])) == pytest.approx(0.0, abs=1e-12)


def pushed(t):
    return 6.0 * np.sin(2.0 * np.pi * (2.0 * t + 5.0 * t**2)) * np.minimum(t * 50.0, 1.0)


def push():
    """Return force and displacement of a mass in a gap, read from a wrong zero."""
    t = np.arange(round(SECONDS * RATE)) / RATE

    def slope(time, y):
        over = y[0] - np.clip(y[0], -CLEARANCE, CLEARANCE)
        linear = OMEGA**2 * y[0] + 2.0 * RATIO * OMEGA * y[1]
        return [y[1], (pushed(time) - STIFFNESS * over) / MASS - linear]

    moved = solve_ivp(
        slope, (0.0, t[-1]), [0.0, 0.0], t_eval=t, rtol=1e-9, atol=1e-12, max_step=1e-3
    ).y[0]
    noise = np.random.default_rng(1).standard_normal((2, t.size))
    return pushed(t) + 0.01 * noise[0], moved + OFFSET + 1e-5 * noise[1]


@pytest.mark.slow
def test_a_gap_around_a_wrong_zero_is_a_gap_with_its_clearance():
    force, seen = push()
    joint = ("base", "slider")
    elements = (
        Element(Spring(1.05 * MASS * OMEGA**2), joint),
        Element(Damper(1.6 * RATIO * MASS * OMEGA), joint),
    )
    model = Model(
        "a slider", {"slider": MASS}, elements, Excitation("force", "slider"),
        {"x": Sensor("slider", "displacement")},
    )  # fmt: skip
    test = TestArrays(
        "a push", RATE, force[None], seen[None], excitation="random", band=(1.0, 30.0)
    )
    found = diagnose_arrays(model, [test])
    assert [one.kind for one in found.effects] == ["gap"]
    clearance = found.effects[0].parameters["clearance"]
    assert clearance.value == pytest.approx(CLEARANCE, rel=0.01)


DAMPING = 2.0 * RATIO * MASS * OMEGA


def seen_by(motion, stiffness, seconds):
    """Return force and velocity or acceleration of a linear slider, by a sensor as it reads."""
    t = np.arange(round(seconds * RATE)) / RATE

    def slope(time, y):
        return [y[1], (pushed(time) - DAMPING * y[1] - stiffness * y[0]) / MASS]

    moved = solve_ivp(
        slope, (0.0, t[-1]), [0.0, 0.0], t_eval=t, rtol=1e-9, atol=1e-12, max_step=1e-3
    ).y
    seen = moved[1] if motion == "velocity" else slope(t, moved)[1]
    noise = 0.003 * np.random.default_rng(4).standard_normal((2, t.size))
    force = pushed(t)
    return force + noise[0] * force.std(), seen + (0.02 + noise[1]) * seen.std()


@pytest.mark.parametrize(
    ("motion", "stiffness", "seconds"),
    [
        ("velocity", MASS * OMEGA**2, 0.7),
        pytest.param("acceleration", 0.0, 0.45, marks=[pytest.mark.slow, pytest.mark.long]),
    ],
)
def test_of_a_motion_that_has_a_mean_only_damping_is_off(motion, stiffness, seconds):
    force, seen = seen_by(motion, stiffness, seconds)
    joint = ("base", "slider")
    elements = (Element(Damper(1.25 * DAMPING), joint),)
    if stiffness:
        elements += (Element(Spring(1.05 * stiffness), joint),)
    model = Model(
        "a slider", {"slider": MASS}, elements, Excitation("force", "slider"),
        {"v": Sensor("slider", motion)},
    )  # fmt: skip
    test = TestArrays(
        "a push", RATE, force[None], seen[None], excitation="random", band=(1.0, 30.0)
    )
    found = diagnose_arrays(model, [test])
    assert found.verdict == "nothing missing"
    assert found.errors.held_out.after < 0.01
    (told,) = [value for name, value in found.linear.items() if "damping" in name]
    assert told.value == pytest.approx(DAMPING, rel=0.03)
