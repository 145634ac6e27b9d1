"""Starts of windows by the equation of motion: a motion in closed form, its forces with it."""

from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.diagnosis.estimation.starts_by_equation import by_equation
from shakerproc.models import NO_CONDITIONS, Element, Excitation, Model, Sensor
from shakerproc.models.effects import EFFECTS, Damper, Spring

RATE, HZ, MASS = 8192.0, 64.0, 0.1
WELL, AMPLITUDE = 1e-4, 4e-5
STIFFNESS, DAMPING = 1.6e4, 0.8
TABLE = np.array([(0, first, 400) for first in range(300, 7000, 613)])


def bistable(*more, measures="acceleration"):
    """Return a mass between two wells, as stiff in each as `STIFFNESS`."""
    cubic = EFFECTS["cubic_stiffness"](0.5 * STIFFNESS / WELL**2)
    effects = (Spring(-0.5 * STIFFNESS), Damper(DAMPING), cubic, *more)
    return Model(
        title="two wells", masses={"mass": MASS},
        elements=tuple(Element(effect, ("base", "mass")) for effect in effects),
        excitation=Excitation("base acceleration"),
        sensors={"top": Sensor("mass", measures)},
    )  # fmt: skip


def campaign():
    """Return what is recorded of a motion that changes wells, and the motion (2, n)."""
    t = np.arange(8192) / RATE
    w, over = 2.0 * np.pi * HZ, (t - 0.5) / 0.02
    place, omega = WELL * np.tanh(over), AMPLITUDE * w
    z = place + AMPLITUDE * np.sin(w * t)
    v = WELL / 0.02 / np.cosh(over) ** 2 + omega * np.cos(w * t)
    fall = -2.0 * WELL / 0.02**2 * np.tanh(over) / np.cosh(over) ** 2
    curved = fall - omega * w * np.sin(w * t)
    force = -0.5 * STIFFNESS * z + 0.5 * STIFFNESS / WELL**2 * z**3 + DAMPING * v
    absolute = -force / MASS
    test = SimpleNamespace(
        sample_rate=RATE, responses=absolute[np.newaxis], input=absolute - curved,
        conditions=NO_CONDITIONS,
    )  # fmt: skip
    sizes = np.array([AMPLITUDE, AMPLITUDE * w])  # without the mean
    return SimpleNamespace(tests=[test], frequency=HZ, motion_sizes=sizes), np.array([z, v])


def test_the_forces_tell_in_which_well_and_how_fast_each_window_begins():
    data, motion = campaign()
    at = motion[:, TABLE[:, 1]].T
    without = np.column_stack([np.zeros(len(TABLE)), at[:, 1]])
    found = by_equation(data, bistable(), TABLE, without)
    assert_allclose(found[:, 0], at[:, 0], atol=1e-3 * WELL)
    assert_allclose(found[:, 1], at[:, 1], atol=1e-3 * AMPLITUDE * 2.0 * np.pi * HZ)


def test_a_further_mode_stays_as_it_is():
    data, motion = campaign()
    at = motion[:, TABLE[:, 1]].T
    with_mode = np.column_stack([0.0 * at[:, 0], 7.0 + 0.0 * at[:, 0], at[:, 1], at[:, 1]])
    found = by_equation(data, bistable(), TABLE, with_mode)
    assert_allclose(found[:, 0], at[:, 0], atol=1e-3 * WELL)
    assert np.array_equal(found[:, [1, 3]], with_mode[:, [1, 3]])


@pytest.mark.parametrize(
    "model",
    [
        bistable(EFFECTS["jenkins"](STIFFNESS, 0.1)),
        bistable(measures="velocity"),
    ],
    ids=["a law that remembers", "a mass without an accelerometer"],
)
def test_nothing_is_told_where_the_motion_does_not_tell_all_forces(model):
    data, motion = campaign()
    assert by_equation(data, model, TABLE, motion[:, TABLE[:, 1]].T) is None
