"""Two programs that share nothing agree: the truth of the blind trials and the simulation.

A wrong convention of a law (a sign, a factor, Masing's rules, what sticks) in either would show
here, and a blind trial would punish a right answer.
"""

from dataclasses import replace

import numpy as np
import pytest
from blind.excitations import SAMPLE_RATE, Drive, waveform
from blind.ranges import Scale
from blind.truth import move

from blind import assembly, ranges, structures
from shakerproc.models import EFFECTS, Element, Excitation, Model, Sensor
from shakerproc.simulation import simulate

OMEGA, ZETA, MASS = 2.0 * np.pi * 120.0, 0.015, 0.4
JOINT = structures.Joint(-1, 0, MASS * OMEGA**2, 2.0 * ZETA * MASS * OMEGA)
DRIVE = Drive("random", 9.0, 10.0, 1000.0, True, 0.05, 0.05, (7,))
SUBSTEPS = 8


def parameters(kind, drawn):
    """Return the drawn numbers as the model file has them."""
    numbers = dict(drawn)
    if kind == "stop":
        numbers["side"] = "positive" if numbers["side"] > 0.0 else "negative"
    if kind == "hertz_contact":
        numbers["side"] = "both"
    if kind == "lugre_friction":
        numbers["viscous_damping"] = 0.0
    return numbers


def effects_of(kind, hidden):
    """Return what the simulation is given for a class, beside the linear joint."""
    numbers = parameters(kind, hidden.parameters)
    if kind == "series":
        gap = EFFECTS["gap"](numbers["stiffness"], numbers["clearance"])
        return [EFFECTS["series"]((gap, EFFECTS["coulomb_friction"](numbers["sliding_force"])))]
    out = [EFFECTS[hidden.kind or kind](**numbers)]
    if kind == "constant_force":
        (_, (stiffness, clearance, _), _) = hidden.parts[1]
        out.append(EFFECTS["gap"](stiffness, clearance))
    return out


# bistable is a spring and a cubic one, compared as such; from rest it falls either way
@pytest.mark.parametrize("kind", [kind for kind in ranges.EFFECTS if kind != "bistable"])
def test_truth_and_simulation_move_alike(kind):
    """A third of a second, before a disturbance has grown."""
    size = 6e-5 if kind == "quadratic_stiffness" else 3e-5  # else it runs out of its well
    scale = Scale(MASS, JOINT.stiffness, OMEGA, size, OMEGA * size, JOINT.stiffness * 1e-5)
    hidden = ranges.EFFECTS[kind](np.random.default_rng(5), scale)
    hidden = replace(hidden, start=0.0)  # where a simulation begins
    truth, _ = assembly.assemble(structures.Structure((MASS,), (JOINT,)), 0, [hidden])
    wave = waveform(DRIVE, 2 * SUBSTEPS, 2048)
    motion = move(
        truth, wave, np.zeros_like(wave), sample_rate=SAMPLE_RATE, substeps=SUBSTEPS, limit=1.0
    )
    between = ("base", "coupon")
    linear = [EFFECTS["spring"](JOINT.stiffness), EFFECTS["damper"](JOINT.damping)]
    elements = [*linear, *effects_of(kind, hidden)]
    model = Model(
        kind,
        {"coupon": MASS},
        tuple(Element(one, between) for one in elements),
        Excitation("base acceleration"),
        {"ch3": Sensor("coupon")},
    )
    samples = wave[:-1][:: 2 * SUBSTEPS]
    found = simulate(model, samples, SAMPLE_RATE, growth=False)
    for mine, other in (
        (motion.displacement[:, 0], found.displacement[0]),
        (motion.acceleration[::SUBSTEPS, 0], found.outputs["ch3"]),
    ):
        assert np.std(mine - other) < 1e-4 * np.std(mine)
