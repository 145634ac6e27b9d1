"""Windows that grow: short ones widen the basin of attraction, long ones sharpen it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.least_squares import Fit, fit, level_at
from shakerproc.diagnosis.estimation.residuals import DataSet, Windows
from shakerproc.diagnosis.estimation.stacks import TAPS
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


def stages_of(data: DataSet) -> Stages:
    """Return the windows of a search."""
    rate, frequency = data.tests[0].sample_rate, data.frequency
    return Stages(
        tuple(
            windows_of(data, TAPS + int(n * rate / frequency), held_out=False, most=most)
            for n, most in zip(LENGTHS, WINDOWS, strict=True)
        )
    )


def grown(
    data: DataSet,
    hypothesis: Hypothesis,
    starts: Sequence[FloatArray],
    stages: Stages,
    channels: tuple[FloatArray, FloatArray],
) -> Fit | None:
    """Return a hypothesis fitted through all lengths; None where it runs away in one.

    Parameters
    ----------
    data : DataSet
        The tests.
    hypothesis : Hypothesis
        What is fitted.
    starts : sequence of (n_x,) array
        Where to start: every length begins at the best of these and of where the length
        before ended.
    stages : Stages
        The windows.
    channels : pair of (n_sensors,) arrays
        Gains and delays to start from.
    """
    found: Fit | None = None
    for windows, rounds in zip(stages.windows, stages.rounds, strict=True):
        tried = [(x, channels) for x in starts]
        if found is not None:
            tried.append((found.x, (found.gain, found.delay)))
        levels = [level_at(data, hypothesis, x, windows, own) for x, own in tried]
        x, own = tried[int(np.argmin(levels))]
        found = fit(data, hypothesis, x, windows, rounds=rounds, channels=own)
        if found is None:
            return None
    return found
