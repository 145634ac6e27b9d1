"""First calls of the compiled steppers, on a small joint: they compile them, or load them."""

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models import Element, Excitation, Model
from shakerproc.models.effects import Damper, Gap
from shakerproc.simulation.free_runs import Runs, free_runs
from shakerproc.simulation.inputs import prepare
from shakerproc.simulation.response import simulate

RATE = 500.0
"""Samples per second of the small joint's shaking [Hz]."""


def joint_with_play() -> Model:
    """Return a mass on a damper and a stop to either side."""
    between = ("base", "coupon")
    joint = (Element(Damper(damping=0.6), between), Element(Gap(1000.0, 5e-3), between))
    return Model("joint", {"coupon": 1.0}, joint, Excitation("base acceleration"), {})


def call_simulate() -> None:
    """Simulate a moment, as `simulate` and `rehearse` do at length."""
    simulate(joint_with_play(), _shaking(), RATE, growth=False)


def call_free_runs() -> None:
    """Run a moment from a measured state, as `compare` and `diagnose` do at length."""
    free_runs(joint_with_play(), Runs((prepare(_shaking(), RATE),), np.array([[0, 0, 100]])))


def _shaking() -> FloatArray:
    return np.random.default_rng(1).standard_normal(100)
