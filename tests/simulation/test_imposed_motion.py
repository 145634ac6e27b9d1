"""Component tests: the displacement of a mass is imposed, the force that does it is read."""

import numpy as np
import pytest

from shakerproc.errors import ModelError
from shakerproc.model_files import model_text, read_model
from shakerproc.models import Element, Excitation, Model, Sensor
from shakerproc.models.effects import (
    CoulombFriction,
    CubicStiffness,
    Damper,
    Gap,
    Iwan,
    Jenkins,
    Series,
    Spring,
)
from shakerproc.simulation import Runs, free_runs, prepare_displacement, simulate

RATE, SECONDS, SIZE, OMEGA = 2000.0, 0.5, 1e-3, 2.0 * np.pi * 12.0
TIME = np.arange(round(RATE * SECONDS)) / RATE
X, V = SIZE * np.sin(OMEGA * TIME), SIZE * OMEGA * np.cos(OMEGA * TIME)
A = -(OMEGA**2) * X
MASS, STIFFNESS, DAMPING = 2.0, 3e4, 50.0
WITHIN = slice(40, -40)  # interpolation rests on predictions near the ends
SENSORS = {"force": Sensor("rod", "force"), "stroke": Sensor("rod", "relative displacement")}


def rig(*effects, reverse=False):
    places = ("rod", "base") if reverse else ("base", "rod")
    elements = (Spring(STIFFNESS), Damper(damping=DAMPING), *effects)
    joined = tuple(Element(effect, places) for effect in elements)
    imposed = Excitation("imposed displacement", "rod")
    return Model("rig", {"rod": MASS}, joined, imposed, SENSORS)


def gap(z):
    return 1e5 * (z - np.clip(z, -4e-4, 4e-4))


LAWS = {
    "linear": ((), np.zeros_like(X)),
    "cubic": ((CubicStiffness(1e10),), 1e10 * X**3),
    "gap": ((Gap(1e5, 4e-4),), gap(X)),
    "coulomb": ((CoulombFriction(7.0),), 7.0 * np.sign(V)),
}


@pytest.mark.parametrize("reverse", [False, True])
@pytest.mark.parametrize("law", LAWS)
def test_force_is_that_of_the_laws_and_of_inertia(law, reverse):
    effects, nonlinear = LAWS[law]
    model = rig(*effects, reverse=reverse)
    wanted = MASS * A + DAMPING * V + STIFFNESS * X + nonlinear
    fine = simulate(model, X, RATE, growth=False)
    given = prepare_displacement(X, RATE)
    windows = np.array([[0, 0, X.size], [0, 333, 300]])
    quick = free_runs(model, Runs((given,), windows))
    smooth = np.abs(V) > 1e-3 * np.max(V)  # at a turn, the sign is a matter of rounding
    for found, first in (
        (fine.outputs["force"], 0),
        (quick.outputs[0][0], 0),
        (quick.outputs[1][0], 333),
    ):
        apart = found - wanted[first : first + found.size]
        kept = smooth[first : first + found.size].copy()
        kept[:40] &= first > 0
        kept[-40:] = False
        assert np.max(np.abs(apart[kept])) < 1e-6 * np.max(np.abs(wanted))
    np.testing.assert_allclose(fine.outputs["stroke"], X, rtol=0.0, atol=1e-9 * SIZE)


@pytest.mark.parametrize(
    "law",
    [
        Jenkins(1e5, 30.0),
        Iwan(1e5, 6e-4),
        pytest.param(
            Series((Gap(1e5, 2e-4), CoulombFriction(30.0))), id="play before a slider"
        ),
    ],
)
def test_hysteresis_is_that_of_the_effect_along_the_same_motion(law):
    model = rig(law)
    force = simulate(model, X, RATE, growth=False).outputs["force"]
    found = force - (MASS * A + DAMPING * V + STIFFNESS * X)
    wanted = law.force_along(X, V, RATE)
    assert np.max(np.abs(found - wanted)[WITHIN]) < 2e-3 * np.max(np.abs(wanted))


def test_a_mass_beyond_moves_as_on_a_base_that_moves():
    elements = (
        Element(Damper(damping=5.0), ("base", "rod")),
        Element(Spring(2e4), ("rod", "head")),
        Element(Damper(damping=3.0), ("rod", "head")),
        Element(CubicStiffness(1e10), ("rod", "head")),
    )
    sensors = {"head": Sensor("head", "relative displacement"), **SENSORS}
    imposed = Excitation("imposed displacement", "rod")
    model = Model("two", {"rod": 1.0, "head": 0.3}, elements, imposed, sensors)
    found = simulate(model, X, RATE, growth=False)
    alone = Model(
        "one", {"head": 0.3},
        tuple(Element(e.effect, ("base", "head")) for e in elements[1:]),
        Excitation("base acceleration"),
    )  # fmt: skip
    start = {"head": (0.0, -V[0])}
    other = simulate(alone, A, RATE, growth=False, start=start)
    apart = found.outputs["head"] - X - other.displacement[0]
    size = np.max(np.abs(other.displacement))
    assert np.max(np.abs(apart)) < 2e-5 * size
    inertia = X * 0.0 + A + 5.0 * V + 0.3 * found.acceleration[1]
    force = found.outputs["force"]
    assert np.max(np.abs(force - inertia)[WITHIN]) < 1e-6 * np.max(np.abs(force))


@pytest.mark.parametrize("kind", ["imposed displacement", "free decay", "force"])
def test_excitations_are_read_as_they_are_written(kind, tmp_path):
    on = None if kind == "free decay" else "rod"
    sensors = SENSORS if kind == "imposed displacement" else {}
    element = Element(Spring(STIFFNESS), ("base", "rod"))
    model = Model("rig", {"rod": MASS}, (element,), Excitation(kind, on), sensors)
    path = tmp_path / "model.yaml"
    path.write_text(model_text(model), encoding="utf-8")
    assert read_model(path) == model


def test_a_free_decay_needs_only_a_start():
    element = Element(Spring(MASS * OMEGA**2), ("base", "rod"))
    model = Model("free", {"rod": MASS}, (element,), Excitation("free decay"))
    found = simulate(model, np.zeros(TIME.size), RATE, growth=False, start={"rod": (SIZE, 0.0)})
    np.testing.assert_allclose(found.displacement[0], SIZE * np.cos(OMEGA * TIME), atol=1e-12)


def test_a_force_is_read_only_where_the_displacement_is_imposed():
    element = Element(Spring(STIFFNESS), ("base", "rod"))
    with pytest.raises(ModelError, match="only where the displacement is imposed"):
        Model("rig", {"rod": MASS}, (element,), Excitation("force", "rod"), SENSORS)
