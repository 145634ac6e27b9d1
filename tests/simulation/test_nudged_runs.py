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

RATE, COUNT = 2000.0, 400
MASS, STIFFNESS, DAMPING = 0.5, 2e4, 2.0
TIME = np.arange(COUNT) / RATE
DRIVE = 30.0 * np.sin(2 * np.pi * 31.0 * TIME) + 12.0 * np.sin(2 * np.pi * 77.0 * TIME + 1.0)
VELOCITY = 0.15 * np.sin(2 * np.pi * 31.0 * TIME) + 0.05 * np.cos(2 * np.pi * 77.0 * TIME)
SEEN = np.array([[0.0, 1.0]])


def model_of(effects):
    return Model(
        "one mass",
        {"m": MASS},
        tuple(Element(effect, ("base", "m")) for effect in effects),
        Excitation("base acceleration"),
        {
            "a": Sensor("m"),
            "z": Sensor("m", "relative displacement"),
            "v": Sensor("m", "relative velocity"),
        },
    )


def run(*effects, rate, sees=SEEN, measured=VELOCITY[None], lead=None):
    model = model_of((Spring(STIFFNESS), Damper(damping=DAMPING), *effects))
    held = Held(rate, (measured,), sees, lead)
    runs = Runs((prepare(DRIVE, RATE),), np.array([[0, 0, COUNT]]), held=held)
    found = free_runs(model, runs, tolerance=1e-9, plain=True)
    assert not found.failed.any()
    return found


def march(force, *, rate, steps=40):
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
            dry, total = force(z)
            v -= h * (w + (STIFFNESS * z + DAMPING * v + total) / MASS)
            brake = h * dry / MASS
            v -= min(max(v, -brake), brake)
            z += 0.5 * h * v
        means[k] = (v - begun) * RATE + drive.mean()
        places[k + 1] = z
        v += share * (VELOCITY[k + 1] - v)
    return means, places


class Sliders:
    """Springs with sliders in parallel, as many as given: Jenkins and Iwan elements."""

    def __init__(self, stiffness, slips):
        self.stiffness, self.slips = stiffness, slips
        self.z, self.r = 0.0, np.zeros(slips.size)

    def __call__(self, z):
        self.r = np.clip(self.r + z - self.z, -self.slips, self.slips)
        self.z = z
        return 0.0, self.stiffness * self.r.mean()


class Hysteresis:
    """The Bouc-Wen element, by the midpoint rule."""

    z, r = 0.0, 0.0

    def __call__(self, z):
        moved, middle = z - self.z, self.r
        for _ in range(3):
            share = (middle / 8e-4) ** 2 if moved * middle > 0.0 else 0.0
            middle = self.r + 0.5 * moved * (1.0 - share)
        self.z, self.r = z, 2.0 * middle - self.r
        return 0.0, 1e4 * self.r


def gap(z):
    return 0.0, 4e4 * np.sign(z) * max(abs(z) - 5e-4, 0.0)


def cubic(z):
    return 0.0, 2e9 * z**3


def dry(z):
    del z
    return 6.0, 0.0


LAWS = {
    "gap": (Gap(4e4, 5e-4), lambda: gap),
    "cubic": (CubicStiffness(2e9), lambda: cubic),
    "jenkins": (Jenkins(1e4, 6.0), lambda: Sliders(1e4, np.array([6e-4]))),
    "iwan": (Iwan(1e4, 1e-3), lambda: Sliders(1e4, 1e-3 * (np.arange(500) + 0.5) / 500)),
    "bouc_wen": (BoucWen(1e4, 8e-4, 2.0), Hysteresis),
}


@pytest.mark.parametrize("rate", [2 * np.pi * 31.0, 20.0])
@pytest.mark.parametrize("law", LAWS)
def test_a_law_is_held_as_in_a_march_of_tiny_steps(law, rate):
    effect, force = LAWS[law]
    (accelerations, places, _), = run(effect, rate=rate).outputs  # fmt: skip
    means, marched = march(force(), rate=rate)
    assert np.abs(places - marched).max() < 1e-3 * np.abs(marched).max()
    apart = accelerations[:-1] - means
    assert np.sqrt(np.mean(apart**2)) < 2e-3 * np.sqrt(np.mean(means**2))


def test_friction_slides_as_in_a_march_of_tiny_steps():
    (accelerations, places, _), = run(CoulombFriction(6.0), rate=5.0).outputs  # fmt: skip
    means, marched = march(dry, rate=5.0)
    assert np.abs(places - marched).max() < 1e-2 * np.abs(marched).max()
    apart = accelerations[:-1] - means
    assert np.sqrt(np.mean(apart**2)) < 2e-2 * np.sqrt(np.mean(means**2))


def test_a_joint_that_sticks_takes_up_what_it_can_carry():
    sticking = run(CoulombFriction(60.0), rate=20.0)
    assert np.all(sticking.outputs[0][1] == 0.0)


@pytest.mark.parametrize("placed", [False, True])
def test_a_linear_mass_is_held_as_the_exact_solution_of_every_sample(placed):
    rate, n = 150.0, 6
    place = 4e-4 * np.sin(2 * np.pi * 31.0 * TIME)
    sees = np.eye(2)[::-1] if placed else SEEN
    measured = np.stack((VELOCITY, place)) if placed else VELOCITY[None]
    found = run(rate=rate, sees=sees, measured=measured)
    pieces = prepare(DRIVE, RATE).pieces
    # displacement, velocity, and the drive with its slopes, over what they are of a polynomial
    system = np.zeros((2 + n, 2 + n))
    system[0, 1] = 1.0
    system[1, :3] = -STIFFNESS / MASS, -DAMPING / MASS, -1.0
    system[np.arange(2, 1 + n), np.arange(3, 2 + n)] = np.arange(1, n) * RATE
    step = expm(system / RATE)
    share, y = 1.0 - np.exp(-rate / RATE), np.zeros(2)
    places, moved = np.zeros(COUNT), np.zeros((2, COUNT))
    for k in range(COUNT - 1):
        y = (step @ np.concatenate([y, pieces[k]]))[:2]
        places[k + 1] = y[0]
        apart = np.array([placed * (place[k + 1] - y[0]), VELOCITY[k + 1] - y[1]])
        moved[:, k + 1] = share * apart
        y = y + share * apart
    assert found.outputs[0][1] == pytest.approx(places, abs=1e-9 * np.abs(places).max())
    assert found.nudged[0] == pytest.approx(moved, abs=1e-8 * np.abs(moved).max())


def test_a_run_that_is_hardly_held_is_free():
    free = run(Gap(4e4, 5e-4), rate=1e-9)
    own = (Spring(STIFFNESS), Damper(damping=DAMPING), Gap(4e4, 5e-4))
    model = model_of(own)
    alone = free_runs(
        model, Runs((prepare(DRIVE, RATE),), np.array([[0, 0, COUNT]])), tolerance=1e-9,
        plain=True,
    )  # fmt: skip
    scale = np.abs(alone.outputs[0]).max(axis=1, keepdims=True)
    assert np.all(np.abs(free.outputs[0] - alone.outputs[0]) < 1e-6 * scale)


def test_a_run_that_is_let_go_is_free_from_where_it_was():
    lead = 100
    found = run(Gap(4e4, 5e-4), rate=100.0, lead=lead)
    held = run(Gap(4e4, 5e-4), rate=100.0)
    assert np.array_equal(found.outputs[0][1, : lead + 1], held.outputs[0][1, : lead + 1])
    assert np.all(found.nudged[0][:, lead + 1 :] == 0.0)
    model = model_of((Spring(STIFFNESS), Damper(damping=DAMPING), Gap(4e4, 5e-4)))
    windows = np.array([[0, lead + 1, COUNT - lead - 1]])
    start = found.outputs[0][1:, lead + 1][None]
    alone = free_runs(model, Runs((prepare(DRIVE, RATE),), windows, start), tolerance=1e-9)
    place = found.outputs[0][1, lead + 1 :]
    assert place == pytest.approx(alone.outputs[0][1], abs=1e-6 * np.abs(place).max())


def test_a_sharp_yield_between_slow_samples_does_not_run_away():
    """An exponent of 20 is next to a Jenkins element, which is carried exactly."""
    rate, time = 200.0, np.arange(110) / 200.0
    drive = 40.0 * np.sin(2 * np.pi * 11.0 * time) + 15.0 * np.sin(2 * np.pi * 23.0 * time)
    held = Held(70.0, (1.5 * np.sin(2 * np.pi * 11.0 * time)[None],), SEEN, None)
    runs = Runs((prepare(drive, rate),), np.array([[0, 0, time.size]]), held=held)
    sharp, exact = (
        free_runs(model_of((Spring(1720.0), Damper(damping=1.4), law)), runs)
        for law in (BoucWen(1345.0, 7.8e-4, 20.0), Jenkins(1345.0, 1345.0 * 7.8e-4))
    )
    assert not sharp.failed.any()
    apart = np.abs(sharp.outputs[0][1:] - exact.outputs[0][1:])
    assert np.all(apart < 0.01 * np.abs(exact.outputs[0][1:]).max(axis=1, keepdims=True))
