"""Runs that are held to a measured motion: against closed forms and a march in tiny steps."""

import numpy as np
import pytest
from scipy.linalg import expm

from shakerproc.models import Element, Excitation, Model, Sensor
from shakerproc.models.effects import (
    BoucWen,
    CoulombFriction,
    CubicStiffness,
    Damper,
    Gap,
    Iwan,
    Jenkins,
    Spring,
)
from shakerproc.simulation import Held, Runs, free_runs, prepare

RATE, COUNT = 2000.0, 600
MASS, STIFFNESS, DAMPING = 0.5, 2e4, 2.0
TIME = np.arange(COUNT) / RATE
DRIVE = 30.0 * np.sin(2 * np.pi * 31.0 * TIME) + 12.0 * np.sin(2 * np.pi * 77.0 * TIME + 1.0)
VELOCITY = 0.15 * np.sin(2 * np.pi * 31.0 * TIME) + 0.05 * np.cos(2 * np.pi * 77.0 * TIME)
SEEN = np.array([[0.0, 1.0]])


def run(*effects, rate, sees=SEEN, measured=VELOCITY[None]):
    own = (Spring(STIFFNESS), Damper(damping=DAMPING), *effects)
    model = Model(
        "one mass",
        {"m": MASS},
        tuple(Element(effect, ("base", "m")) for effect in own),
        Excitation("base acceleration"),
        {"a": Sensor("m"), "z": Sensor("m", "relative displacement")},
    )
    held = Held(rate, (measured,), sees)
    runs = Runs((prepare(DRIVE, RATE),), np.array([[0, 0, COUNT]]), held=held)
    found = free_runs(model, runs, tolerance=1e-9, plain=True)
    assert not found.failed.any()
    return found


def march(force, *, rate, steps=400):
    """Return mean accelerations and displacements: half a step, a kick, half a step."""
    h, pieces = 1.0 / RATE / steps, prepare(DRIVE, RATE).pieces
    share, z, v = 1.0 - np.exp(-rate / RATE), 0.0, 0.0
    means, places = np.zeros(COUNT - 1), np.zeros(COUNT)
    for k in range(COUNT - 1):
        at = (np.arange(steps) + 0.5) / steps
        drive = np.polynomial.polynomial.polyval(at, pieces[k])
        begun = v
        for w in drive:
            z += 0.5 * h * v
            dry, total = force(z, v, h)
            v -= h * (w + (STIFFNESS * z + DAMPING * v + total) / MASS)
            brake = h * dry / MASS
            v -= np.clip(v, -brake, brake)
            z += 0.5 * h * v
        means[k] = (v - begun) * RATE + drive.mean()
        places[k + 1] = z
        v += share * (VELOCITY[k + 1] - v)
    return means, places


class Sliders:
    """Springs with sliders in parallel, as many as given: Jenkins and Iwan elements."""

    def __init__(self, stiffness, slips):
        self.stiffness, self.slips, self.r = stiffness, slips, np.zeros(slips.size)

    def __call__(self, z, v, h):
        self.r = np.clip(self.r + h * v, -self.slips, self.slips)
        return 0.0, self.stiffness * self.r.mean()


class Hysteresis:
    """The Bouc-Wen element."""

    def __init__(self):
        self.r = 0.0

    def __call__(self, z, v, h):
        for _ in range(2):
            middle = self.r + 0.5 * h * v
            share = abs(middle / 8e-4) ** 2.0 if v * middle > 0.0 else 0.0
        self.r += h * v * (1.0 - share)
        return 0.0, 1e4 * self.r


LAWS = {
    "gap": (Gap(4e4, 5e-4), lambda: lambda z, v, h: (0.0, 4e4 * np.sign(z) * max(abs(z) - 5e-4, 0.0))),
    "cubic": (CubicStiffness(2e9), lambda: lambda z, v, h: (0.0, 2e9 * z**3)),
    "coulomb": (CoulombFriction(6.0), lambda: lambda z, v, h: (6.0, 0.0)),
    "jenkins": (Jenkins(1e4, 6.0), lambda: Sliders(1e4, np.array([6e-4]))),
    "iwan": (Iwan(1e4, 1e-3), lambda: Sliders(1e4, 1e-3 * (np.arange(2000) + 0.5) / 2000)),
    "bouc_wen": (BoucWen(1e4, 8e-4, 2.0), Hysteresis),
}  # fmt: skip


@pytest.mark.parametrize("rate", [2 * np.pi * 31.0, 20.0])
@pytest.mark.parametrize("law", LAWS)
def test_a_law_is_held_as_in_a_march_of_tiny_steps(law, rate):
    effect, force = LAWS[law]
    (accelerations, places), = run(effect, rate=rate).outputs
    means, marched = march(force(), rate=rate, steps=100 if law == "iwan" else 200)
    assert np.abs(places - marched).max() < 2e-3 * np.abs(marched).max()
    apart = accelerations[:-1] - means
    assert np.sqrt(np.mean(apart**2)) < 5e-3 * np.sqrt(np.mean(means**2))
