"""Starts of windows fitted to their run-in, where the numbers of a hypothesis stand."""

from dataclasses import replace
from typing import Final

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.data_set import DataSet, Windows
from shakerproc.diagnosis.estimation.least_squares import SETTLED, Fit
from shakerproc.diagnosis.estimation.normal_equations import NormalEquations
from shakerproc.diagnosis.estimation.point import Point
from shakerproc.diagnosis.estimation.residual_slopes import Linearisation
from shakerproc.diagnosis.estimation.window_starts import moved, with_best_starts

ROUNDS: Final = 12
"""Steps at most: starts of the masses are measured already, and nearly linear; that of a
resonator is not [-]."""

DAMPED: Final = (0.0, 1e-3, 0.1, 1.0)
"""Damping of steps that are tried, one after the other [-]."""


def with_starts_fitted(
    data: DataSet, found: Fit, windows: Windows, *, near: FloatArray | None = None
) -> Fit | None:
    """Return a fit whose numbers stand, with the starts of these windows fitted.

    Parameters
    ----------
    data : DataSet
        The tests.
    found : Fit
        Its coordinates and channels are kept as they are.
    windows : Windows
        Starts are fitted to their run-in alone. Where all begin at rest there is nothing to
        fit.
    near : (n_windows, n_motions) array, optional
        Starts that are off by no more than noise, to begin with; the measured ones.
    """
    if windows.run_in is None:
        return replace(found, windows=windows, starts=None)
    linearisation = Linearisation(data, found.hypothesis, windows.run_in)
    if near is None:
        here = linearisation.point(found.x, found.channels)
    else:
        here = Point(found.x, *found.channels, near)
    state = linearisation.residual(here)
    if state is None:
        return None
    if near is None:
        here, state = with_best_starts(linearisation, here, state)
    for _ in range(ROUNDS):
        left = state[2]
        slopes = linearisation.linearise(here, state, physics=False)
        equations = NormalEquations(linearisation, here, slopes)
        steps = [equations.starts_alone(damping) for damping in DAMPED]
        here, state = moved(linearisation, here, state, [s for s in steps if s is not None])
        if left - state[2] < SETTLED:
            break
    return replace(found, windows=windows, starts=here.starts)
