"""Windows that grow: short ones widen the basin of attraction, long ones sharpen it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.data import JointMotion
from shakerproc.diagnosis.estimation.least_squares import Fit, fit
from shakerproc.diagnosis.estimation.residuals import TAPS, DataSet, Windows
from shakerproc.diagnosis.estimation.windows import windows_of
from shakerproc.diagnosis.hypotheses.hypothesis import Hypothesis

LENGTHS: Final = (2.0, 5.0, 15.0)
"""Lengths of the windows in periods of the joint's motion, each a factor of two to three."""

WINDOWS: Final = (80, 60, 40)
"""Windows of each length: as many as tell the numbers to a few per cent."""

ROUNDS: Final = (6, 4, 4)
"""Steps of the search in each."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Stages:
    """Windows of growing length, and the steps of the search in each."""

    windows: tuple[Windows, ...]
    rounds: tuple[int, ...] = ROUNDS


def dominant_frequency(motions: Sequence[JointMotion]) -> float:
    """Return the frequency of a harmonic motion of this velocity and displacement [Hz]."""
    velocity = sum(float(np.sum(motion.velocity**2)) for motion in motions)
    displacement = sum(float(np.sum(motion.displacement**2)) for motion in motions)
    return float(np.sqrt(velocity / max(displacement, 1e-300)) / (2.0 * np.pi))


def stages_of(data: DataSet, frequency: float) -> Stages:
    """Return the windows of a search.

    Parameters
    ----------
    data : DataSet
        The tests.
    frequency : float
        Of the joint's motion [Hz].
    """
    rate = data.tests[0].sample_rate
    return Stages(
        tuple(
            windows_of(data, TAPS + int(n * rate / frequency), held_out=False, most=most)
            for n, most in zip(LENGTHS, WINDOWS, strict=True)
        )
    )


def grown(
    data: DataSet,
    hypothesis: Hypothesis,
    x: FloatArray,
    stages: Stages,
    channels: tuple[FloatArray, FloatArray] | None = None,
) -> Fit | None:
    """Return a hypothesis fitted through all lengths; None where it runs away in one."""
    found: Fit | None = None
    for windows, rounds in zip(stages.windows, stages.rounds, strict=True):
        found = fit(data, hypothesis, x, windows, rounds=rounds, channels=channels)
        if found is None:
            return None
        x, channels = found.x, (found.gain, found.delay)
    return found
