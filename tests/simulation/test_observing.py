"""What a nudge moves, and how soon a start is forgotten, against closed forms."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.diagnosis.nudged.motion import slowest_decay
from shakerproc.models import EFFECTS, Element, Excitation, Model, Sensor
from shakerproc.simulation.free_runs import led_by

MASS = np.array([0.3, 2.0])


def test_a_nudge_is_the_motion_of_least_kinetic_energy_that_the_sensor_sees():
    seen = np.array([0.7, -1.1])
    sees = np.concatenate([np.zeros(2), seen])[None]
    # least v' M v with seen v = 1: Lagrange's multiplier gives M^-1 s / (s' M^-1 s)
    wanted = seen / MASS / np.sum(seen**2 / MASS)
    assert_allclose(led_by(sees, MASS)[:, 0], [0.0, 0.0, *wanted], rtol=1e-12, atol=1e-15)


def test_a_nudge_takes_energy_out_of_an_error_and_puts_none_in():
    rng = np.random.default_rng(2)
    sees = np.hstack([np.zeros((3, 5)), rng.standard_normal((3, 5))])
    mass = np.exp(rng.standard_normal(5))
    power = (np.concatenate([mass, mass])[:, None] * led_by(sees, mass)) @ sees
    assert_allclose(power, power.T, rtol=1e-9, atol=1e-12)
    assert np.linalg.eigvalsh(power)[0] > -1e-12


def two_masses(sensors):
    elements = (
        Element(EFFECTS["spring"](stiffness=1e4), ("base", "a")),
        Element(EFFECTS["spring"](stiffness=3e4), ("base", "b")),
        Element(EFFECTS["damper"](damping=0.8), ("base", "b")),
    )
    masses = {"a": float(MASS[0]), "b": float(MASS[1])}
    placed = {name: Sensor(name) for name in sensors}
    return Model("two", masses, elements, Excitation("base acceleration"), placed)


def test_a_mass_with_a_sensor_forgets_at_half_the_rate_one_without_by_its_damping():
    assert slowest_decay(two_masses(("a",)), 20.0) == pytest.approx(0.8 / (2.0 * MASS[1]))
    assert slowest_decay(two_masses(("a", "b")), 20.0) == pytest.approx(10.0)
