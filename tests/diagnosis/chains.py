"""Campaigns in memory: random shaking at three levels."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from shakerproc.diagnosis.data import PreparedTest, TestArrays, prepared
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.models import Element, Excitation, Model, Sensor
from shakerproc.models.effects import EFFECTS, AbstractEffect, Damper, Spring
from shakerproc.models.identification import JointScales
from shakerproc.simulation import simulate

RATE = 2048.0
SECONDS = 5.0
QUIET = 1024
NOISE = 0.05


def chain(n: int, *, stiffer: float = 1.0, sensors: Sequence[int] | None = None) -> Model:
    """Return masses in a row above the base, each with an accelerometer unless said."""
    names = ["base", *(f"m{i + 1}" for i in range(n))]
    elements = []
    for first, second in pairwise(names):
        elements.append(Element(Spring(stiffer * 1e5), (first, second)))
        elements.append(Element(Damper(5.0), (first, second)))
    sensed = range(n) if sensors is None else sensors
    return Model(
        title="chain",
        masses=dict.fromkeys(names[1:], 1.0),
        elements=tuple(elements),
        excitation=Excitation("base acceleration"),
        sensors={f"a{i + 1}": Sensor(names[i + 1]) for i in sensed},
    )


def joints_of(model: Model) -> tuple[tuple[str, str], ...]:
    """Return the joints of a chain, from the base on."""
    names = ["base", *model.masses]
    return tuple(pairwise(names))


def campaign(
    truth: Model, *, levels: Sequence[float] = (3.0, 10.0)
) -> tuple[PreparedTest, ...]:
    """Return noisy tests of a model shaken from 10 to 200 Hz at two rms levels [m/s^2]."""
    rng = np.random.default_rng(7)
    frequency = np.fft.rfftfreq(int(SECONDS * RATE), 1.0 / RATE)
    inside = (frequency > 10.0) & (frequency < 200.0)
    arrays = []
    for number, level in enumerate(levels):
        spectrum = inside * (rng.standard_normal((2, frequency.size)).T @ (1.0, 1j))
        shaken = np.fft.irfft(spectrum)
        shaken = np.concatenate([np.zeros(QUIET), level * shaken / shaken.std()])
        run = simulate(truth, shaken, RATE, growth=False, tolerance=1e-9)
        responses = np.array([run.outputs[name] for name in truth.sensors])
        responses += NOISE * rng.standard_normal(responses.shape)
        controls = shaken + NOISE * rng.standard_normal((1, shaken.size))
        arrays.append(
            TestArrays(f"test {number}", RATE, controls, responses, band=(10.0, 200.0))
        )
    return prepared(arrays)


def scales(model: Model, tests: Sequence[PreparedTest], joint: tuple[str, str]) -> JointScales:
    """Return how a joint moves."""
    moved = DataSet(model, tuple(tests)).across(joint)
    displacement = max(float(np.max(np.abs(m.displacement))) for m in moved)
    velocity = max(float(np.max(np.abs(m.velocity))) for m in moved)
    mass = 1.0 if joint[0] == "base" else 0.5
    return JointScales(displacement, velocity, 1e5 * displacement, 1e5, mass, SECONDS, 2000.0)


def identifications(model: Model, tests: Sequence[PreparedTest], kinds: Sequence[str]):
    """Return how to look for effects in every joint of a chain."""
    return {
        joint: {
            kind: EFFECTS[kind].identification(scales(model, tests, joint)) for kind in kinds
        }
        for joint in joints_of(model)
    }


def with_effect(model: Model, effect: AbstractEffect, joint: tuple[str, str]) -> Model:
    """Return a model with one more effect."""
    elements = (*model.elements, Element(effect, joint))
    return Model(model.title, model.masses, elements, model.excitation, model.sensors)
