"""Steps of least squares: damped until the cost falls enough, several along the same slopes."""

from dataclasses import replace
from typing import Final

import numpy as np

from shakerproc.diagnosis.estimation.normal_equations import NormalEquations
from shakerproc.diagnosis.estimation.point import Linearised, Point, State
from shakerproc.diagnosis.estimation.residual_slopes import Linearisation
from shakerproc.diagnosis.estimation.window_starts import moved

SETTLED: Final = 0.1
"""Fall of the cost (twice a log likelihood) below which the search has arrived: a coordinate
then moves by less than a third of its standard error [-]."""

TRIALS: Final = 6
"""Steps that are tried from one point, each damped ten times more [-]."""

CHORDS: Final = 6
"""Steps along the same slopes at most, where these take long [-]."""

WORTH: Final = 0.1
"""Share of the fall of the step before below which new slopes are worth more [-]."""

LEAST_DAMPING: Final = 1e-9
"""Least damping over the diagonal: next to the rounding of the equations [-]."""


def by_chords(
    linearisation: Linearisation, slopes: Linearised, here: tuple[Point, State, float]
) -> tuple[Point, State, float]:
    """Return where further steps along the same slopes lead, each worth a tenth of the last.

    A structure has so many numbers that one set of slopes takes as long as forty residuals.
    `here` is where they were taken, with its state and the damping [-].
    """
    gained = np.inf
    for _ in range(CHORDS):
        at, state, damping = here
        equations = NormalEquations(linearisation, at, replace(slopes, residual=state[0]))
        there = better(equations, state[2], damping)
        if there is None:
            break
        here, last = there, gained
        gained = state[2] - there[1][2]
        if gained < max(SETTLED, WORTH * last if np.isfinite(last) else 0.0):
            break
    return here


def better(
    equations: NormalEquations, cost: float, damping: float
) -> tuple[Point, State, float] | None:
    """Return where a step gains, its state, and the next damping [-]; None if none does.

    One that gains next to nothing, though more is foretold, was too long: it is taken if no
    damped one gains more.
    """
    best: tuple[Point, State, float] | None = None
    least = cost
    for _ in range(TRIALS):
        there, fall = equations.taken(damping)
        tried = equations.linearisation.residual(there)
        if tried is not None and tried[2] >= cost and equations.at.starts is not None:
            there, tried = moved(equations.linearisation, there, tried, [equations.at.starts])
        if tried is not None and tried[2] < least:
            best, least = (there, tried, max(damping / 10.0, LEAST_DAMPING)), tried[2]
        if fall < SETTLED or cost - least >= SETTLED:
            break
        damping *= 10.0
    return best
