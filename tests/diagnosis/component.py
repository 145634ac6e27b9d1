"""Component tests in memory: a displacement is imposed, the force on it is measured."""

import numpy as np

from shakerproc.diagnosis import TestArrays
from shakerproc.models import EFFECTS, Element, Excitation, Model, Sensor

ROD = ("base", "rod")


def component(law, seed):
    """Return a component test: 1 kg imposed on, with this force beside spring and damper."""
    rng = np.random.default_rng(seed)
    t = np.arange(6000) / 1000.0
    frequency = np.arange(3.0, 30.0, 1.0 / 6.0)[:, None]
    angle = 2.0 * np.pi * frequency * t + rng.uniform(0.0, 2.0 * np.pi, frequency.shape)
    size = 1e-3 / np.sqrt(frequency.size)
    x = size * np.sin(angle).sum(axis=0)
    v = size * (2.0 * np.pi * frequency * np.cos(angle)).sum(axis=0)
    force = 3e4 * x + 50.0 * v + law(x, v) + 0.05 * rng.standard_normal(t.size)
    return TestArrays(f"test {seed}", 1000.0, x[None], force[None], seed == 2, band=(2.0, 40.0))


def rod():
    """Return the model of a component test, its spring 20 % too soft."""
    elements = (Element(EFFECTS["spring"](2.4e4), ROD), Element(EFFECTS["damper"](50.0), ROD))
    return Model(
        "component", {"rod": 1e-6}, elements, Excitation("imposed displacement", "rod"),
        {"force": Sensor("rod", "force")},
    )  # fmt: skip
