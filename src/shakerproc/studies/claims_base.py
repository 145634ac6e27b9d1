"""What the checks of the thesis' statements share: its models, its runs, its estimators."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal, final

import numpy as np

from shakerproc.models import EFFECTS, Element, Excitation, Model
from shakerproc.models.effects.base import AbstractEffect
from shakerproc.studies.estimators import omega_e, spectrum
from shakerproc.studies.simulated import ensemble, simulated
from shakerproc.studies.study import Measure, Run

PERIODOGRAM: Final = Measure()
WELCH: Final = Measure(estimator="welch", segment=2048)
SWEEP: Final = Run("sine sweep", level=5.0, from_hz=0.0, to_hz=30.0, duration=30.0)
STIFFNESS: Final = 1000.0
DAMPING_RATIO: Final = 0.01
NEIGHBOURS: Final = 24
"""Neighbouring runs of one that is chaotic."""


@final
@dataclass(frozen=True, slots=True)
class Found:
    """Our number, and whether the statement held."""

    number: str
    held: Literal["held", "held in part", "did not hold"]


def model(*effects: AbstractEffect) -> Model:
    """Return the thesis' model: 1 kg, held by these effects, a force on the mass."""
    elements = tuple(Element(effect, ("base", "mass")) for effect in effects)
    return Model("thesis", {"mass": 1.0}, elements, Excitation("force", "mass"))


def gap(
    clearance: float, stiffness: float = STIFFNESS, damping_ratio: float = DAMPING_RATIO
) -> Model:
    """Return free play between elastic walls (a spring without play), with damping."""
    wall = EFFECTS["spring"](stiffness=stiffness)  # type: ignore[call-arg]
    if clearance > 0.0:
        wall = EFFECTS["gap"](stiffness=stiffness, clearance=clearance)  # type: ignore[call-arg]
    return model(wall, EFFECTS["damper"](damping_ratio=damping_ratio))  # type: ignore[call-arg]


def jump_gap(clearance: float) -> Model:
    """Return the literal eq. 3.14, whose force jumps at the wall."""
    return model(
        EFFECTS["jump_gap"](stiffness=STIFFNESS, clearance=clearance),  # type: ignore[call-arg]
        EFFECTS["damper"](damping_ratio=DAMPING_RATIO),  # type: ignore[call-arg]
    )


def power_law(
    exponent: float, wall: float = 1e-3, relaxation: float = 1e-5, force: float = 10.0
) -> Model:
    """Return the power law of the listing, with its relaxation spring and its damping."""
    return model(
        EFFECTS["power_law"](  # type: ignore[call-arg]
            force=force, reference_displacement=wall, exponent=exponent
        ),
        EFFECTS["spring"](stiffness=relaxation),  # type: ignore[call-arg]
        EFFECTS["damper"](damping=2.0 * np.sqrt(force) * 0.01),  # type: ignore[call-arg]
    )


def peak(shaken: Model, run: Run, measure: Measure = PERIODOGRAM) -> float:
    """Return omega_e of one run [Hz]; where it is chaotic, the median of neighbouring runs."""
    motion = simulated(shaken, run)
    runs = [motion, *(ensemble(shaken, run, NEIGHBOURS) if motion.chaotic else ())]
    peaks = [omega_e(spectrum(m.of(measure.of), m.sample_rate, measure), measure) for m in runs]
    return float(np.median(peaks))


def falls(values: Sequence[float], slack: float = 1.0 / 30.0) -> bool:
    """Return whether values never rise by more than a bin, and fall in all."""
    change = np.diff(values)
    return bool(np.all(change <= slack) and np.sum(change) < -slack)


def series(values: Sequence[float], digits: int = 3) -> str:
    """Return values as text: ``5.03, 4.97, 4.93``."""
    return ", ".join(f"{value:.{digits}f}" for value in values)
