"""First calls of the compiled steppers, on a small joint: they compile them, or load them."""

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models import Element, Excitation, Model
from shakerproc.models.effects import (
    AttachedMode,
    Damper,
    Gap,
    GeneralBoucWen,
    Iwan,
    Jenkins,
    LuGreFriction,
    Series,
    Spring,
)
from shakerproc.models.effects.base import AbstractEffect
from shakerproc.simulation.assembly import MOST_LINES, assemble, build_store
from shakerproc.simulation.free_runs import Runs, free_runs, largest_states
from shakerproc.simulation.inputs import prepare

RATE = 500.0
"""Samples per second of the small joint's shaking [Hz]."""


def joint_with_play(stops: int = 1) -> Model:
    """Return a mass on a damper and a stop to either side, or several such stops."""
    return _joint(Damper(damping=0.6), *(Gap(1000.0, 5e-3),) * stops)


def _joint(*effects: AbstractEffect) -> Model:
    elements = tuple(Element(effect, ("base", "coupon")) for effect in effects)
    return Model("joint", {"coupon": 1.0}, elements, Excitation("base acceleration"), {})


def call_propagators() -> None:
    """Make the propagators of a joint with play, as all that runs it does first."""
    build_store(assemble(joint_with_play()).machine, 1.0 / RATE, 1)


def call_free_runs(stops: int = 1) -> None:
    """Run a moment from a measured state, as `compare` and `diagnose` do at length."""
    free_runs(
        joint_with_play(stops), Runs((prepare(_shaking(), RATE),), np.array([[0, 0, 100]]))
    )


def call_free_runs_by_series() -> None:
    """Do as `call_free_runs` with the stepper alone: so many laws have no propagators."""
    call_free_runs(MOST_LINES + 1)


def call_along() -> None:
    """Ask the laws with memory for their force along a motion, as `diagnose` does.

    And for the largest state of one that saturates differently on its way back.
    """
    displacement, saturating = 1e-3 * _shaking(), GeneralBoucWen(500.0, 1e5, 1e6, 1.5)
    for law in (
        LuGreFriction(0.3, 0.45, 0.01, 1e4, 3.0, 0.4), Jenkins(500.0, 0.3), Iwan(500.0, 1e-3),
        saturating, Series((Spring(1000.0), Gap(1000.0, 5e-3))),
        AttachedMode(0.1, 20.0, 0.01),
    ):  # fmt: skip
        law.force_along(displacement, RATE * displacement, RATE)
    largest_states(_joint(saturating))


def _shaking() -> FloatArray:
    return np.random.default_rng(1).standard_normal(100)
