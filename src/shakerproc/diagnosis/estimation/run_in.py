"""Starts of windows fitted to their run-in, where the numbers of a hypothesis stand."""

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from shakerproc.comparison.noise import EXCESS
from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.estimation.normal_equations import NormalEquations
from shakerproc.diagnosis.estimation.parts import Windows
from shakerproc.diagnosis.estimation.point import Point, State
from shakerproc.diagnosis.estimation.residual_slopes import Linearisation
from shakerproc.diagnosis.estimation.stacks import TAPS
from shakerproc.diagnosis.estimation.steps import SETTLED
from shakerproc.diagnosis.estimation.tests_apart import with_tests_fitted
from shakerproc.diagnosis.estimation.window_starts import moved, with_best_starts

ROUNDS: Final = 12
"""Steps at most: starts of the masses are measured already, and nearly linear; that of a
resonator is not [-]."""

SHARES: Final = (0.125, 0.25, 0.5)
"""Shares of a run-in to which starts are fitted before the whole: each twice the last [-]."""

DAMPED: Final = (0.0, 1e-3, 0.1, 1.0)
"""Damping of steps that are tried, one after the other [-]."""

FEW: Final = 0.1
"""Share of windows that may be lost: the cost is logarithmic, and so few do not rule it [-]."""


def with_starts_fitted(
    data: DataSet, found: Fit, windows: Windows, *, near: FloatArray | None = None
) -> Fit | None:
    """Return a fit whose numbers stand, with the starts of these windows fitted.

    What was fitted from measured starts is not fitted again.

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
    apart = data.differing or bool(data.offsets.sensors)
    if windows.run_in is None and not apart:
        return replace(found, windows=windows, starts=None)
    if near is not None and windows.run_in and (data, windows) not in found.settled:
        return _with_starts(data, found, windows, windows.run_in, near)
    if (data, windows) not in found.settled:
        own: Fit | None
        if windows.run_in is None:
            own = replace(found, windows=windows, starts=None)
        else:
            own = _with_starts(data, found, windows, windows.run_in, None)
        if own is not None and apart:
            own = with_tests_fitted(data, own, found.windows)
            if windows.run_in is not None and data.offsets.sensors:  # starts lie elsewhere now
                own = _with_starts(data, own, windows, windows.run_in, own.starts)
        found.settled[data, windows] = own
    return found.settled[data, windows]


def _with_starts(
    data: DataSet, found: Fit, windows: Windows, run_in: Windows, near: FloatArray | None
) -> Fit | None:
    """Return the fit with starts that were fitted to the run-in."""
    linearisation = Linearisation(data, found.hypothesis, run_in)
    fitted = _fitted(linearisation, found, near)
    if fitted is None:
        return None
    here, state = fitted
    lost = _lost(linearisation, state) if near is None else np.zeros(0, np.int64)
    is_known = found.follows_most or 2 * lost.size < len(windows)
    other = _grown(data, found, run_in.chosen(lost)) if lost.size and is_known else None
    if other is not None and here.starts is not None:
        here, state = _begun_at(linearisation, here, state, lost, other)
        here, _ = _settled(linearisation, here, state)
    return replace(found, windows=windows, starts=here.starts)


def _fitted(
    linearisation: Linearisation, found: Fit, near: FloatArray | None
) -> tuple[Point, State] | None:
    """Return starts fitted from near ones, or from the best of those that were measured."""
    if near is None:
        here = linearisation.point(found.x, found.channels)
    else:
        here = linearisation.point_with(found.x, found.channels, near)
    state = linearisation.residual(here)
    if state is None:
        return None
    if near is None:
        here, state = with_best_starts(linearisation, here, state)
    return _settled(linearisation, here, state)


def _lost(linearisation: Linearisation, state: State) -> NDArray[np.int64]:
    """Return the windows in which more than noise is left."""
    left = np.zeros(len(linearisation.windows))
    for stack, rows in zip(linearisation.stacks, state[0], strict=True):
        left[stack.members] = np.mean(rows**2, axis=1)
    return np.flatnonzero(left > EXCESS**2)


def _begun_at(
    linearisation: Linearisation,
    here: Point,
    state: State,
    which: NDArray[np.int64],
    other: FloatArray,
) -> tuple[Point, State]:
    """Return some windows begun at other starts, each where that leaves less."""
    starts = np.array(here.starts)
    starts[which] = other
    return moved(linearisation, here, state, [starts])


def _settled(linearisation: Linearisation, here: Point, state: State) -> tuple[Point, State]:
    """Return starts moved to where each window leaves least, by Gauss and Newton."""
    for _ in range(ROUNDS):
        left = state[2]
        slopes = linearisation.linearise(here, state, physics=False)
        equations = NormalEquations(linearisation, here, slopes)
        steps = [equations.starts_alone(damping) for damping in DAMPED]
        here, state = moved(linearisation, here, state, [s for s in steps if s is not None])
        if left - state[2] < SETTLED:
            break
    return here, state


def _grown(data: DataSet, found: Fit, run_in: Windows) -> FloatArray | None:
    """Return starts fitted to run-ins that grow: the shorter, the wider its basin."""
    starts: FloatArray | None = None
    for share in SHARES:
        part = run_in.beginning(share, 2 * TAPS)
        fitted = _fitted(Linearisation(data, found.hypothesis, part), found, starts)
        if fitted is None:
            return None
        starts = fitted[0].starts
    return starts
