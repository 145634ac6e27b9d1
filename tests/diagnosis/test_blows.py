"""Blows of a hammer on a bracket whose joint is softer than its model, by scipy."""

import numpy as np
import pytest
from scipy.signal import lsim

from shakerproc.diagnosis import diagnose_arrays
from shakerproc.diagnosis.data import TestArrays
from shakerproc.models import EFFECTS, Element, Excitation, Model, Sensor

RATE, SECONDS, MASS, HERTZ, RATIO = 4096.0, 0.3, 1.2, 250.0, 0.01
JOINT = ("base", "bracket")


def bracket(hertz):
    stiffness = MASS * (2.0 * np.pi * hertz) ** 2
    damping = 2.0 * RATIO * np.sqrt(stiffness * MASS)
    effects = EFFECTS["spring"](stiffness), EFFECTS["damper"](damping)
    return Model(
        "bracket", {"bracket": MASS}, tuple(Element(one, JOINT) for one in effects),
        Excitation("force", on="bracket"), {"acc": Sensor("bracket")},
    )  # fmt: skip


def blow(size, seed, *, before=100):
    """Return force and acceleration of a blow, a few dozen samples of rest before it."""
    time = np.arange(int(SECONDS * RATE)) / RATE
    since = time - before / RATE
    force = size * np.sin(np.pi * since / 2e-3) * ((since > 0.0) & (since < 2e-3))
    rate = 2.0 * np.pi * HERTZ
    system = ([1.0 / MASS, 0.0, 0.0], [1.0, 2.0 * RATIO * rate, rate**2])
    rng = np.random.default_rng(seed)
    rows = [force, lsim(system, force, time)[1]]
    noisy = [row + 1e-3 * np.max(np.abs(row)) * rng.standard_normal(row.size) for row in rows]
    return TestArrays(
        f"blow {seed}", RATE, noisy[0][np.newaxis], noisy[1][np.newaxis], band=(20.0, 800.0)
    )


@pytest.fixture(scope="module")
def told():
    return diagnose_arrays(bracket(367.0), [blow(60.0, 1), blow(180.0, 2), blow(400.0, 3)])


def test_a_joint_that_is_softer_lacks_no_effect(told):
    assert told.verdict == "nothing missing", told.sentence
    assert told.errors.held_out.after < 1.5 * told.errors.noise_floor < 0.04


def test_the_frequency_is_told_and_the_force_tells_the_mass(told):
    stiffness = told.linear["stiffness base-bracket"].value
    mass = told.linear["mass bracket"].value if "mass bracket" in told.linear else MASS
    assert np.sqrt(stiffness / mass) / (2.0 * np.pi) == pytest.approx(HERTZ, rel=1e-3)
    assert stiffness == pytest.approx(MASS * (2.0 * np.pi * HERTZ) ** 2, rel=0.03)
