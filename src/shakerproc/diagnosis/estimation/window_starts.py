"""Starts of windows, each moved by itself: to where the residual of its window is smaller."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.hidden_motion import elsewhere
from shakerproc.diagnosis.estimation.point import Point, State
from shakerproc.diagnosis.estimation.residual_slopes import Linearisation
from shakerproc.diagnosis.estimation.residuals import Predicted
from shakerproc.simulation import largest_states

LOADED: Final = 0.8
"""Share of its size at which the state of a law may begin: near its limit, but not at it, where
the motion no longer tells it [-]."""


def with_best_starts(
    linearisation: Linearisation, here: Point, state: State
) -> tuple[Point, State]:
    """Return a point whose windows begin where they leave least: no slope leads there.

    Around any place at which the masses may rest, and with laws that begin with no memory or
    loaded to either side.
    """
    if here.starts is None:
        return here, state
    starts = here.starts
    here, state = with_place_told(linearisation, here, state)
    model = linearisation.hypothesis.model_at(here.x)
    sizes = largest_states(model)[:, 0]
    for i, size in enumerate(sizes, start=starts.shape[1] - len(sizes)):
        for side in (1.0, -1.0):
            loaded = np.array(here.starts)
            loaded[:, i] = starts[:, i] + side * LOADED * size
            here, state = moved(linearisation, here, state, [loaded])
    return here, state


def with_place_told(
    linearisation: Linearisation, here: Point, state: State
) -> tuple[Point, State]:
    """Return a point whose windows begin where the forces let them (see `elsewhere`)."""
    if here.starts is None:
        return here, state
    model = linearisation.hypothesis.model_at(here.x)
    for other in elsewhere(linearisation.data, model, linearisation.windows.table, here.starts):
        here, state = moved(linearisation, here, state, [other])
    return here, state


def moved(
    linearisation: Linearisation, here: Point, state: State, tried: Sequence[FloatArray]
) -> tuple[Point, State]:
    """Return a point each of whose windows begins at the first of some starts that is better.

    Parameters
    ----------
    linearisation : Linearisation
        What is fitted to what.
    here : Point
        Windows for which no start is better stay as they are.
    state : State
        Residual there.
    tried : sequence of (n_windows, n_motions) array
        Starts.
    """
    waiting = np.ones(len(linearisation.windows), bool)
    for starts in tried:
        if here.starts is None or not waiting.any():
            break
        there = np.where(waiting[:, None], starts, here.starts)
        found = linearisation.residual(replace(here, starts=there))
        if found is None:
            continue
        better = np.zeros(len(waiting), bool)
        for stack, old, new in zip(linearisation.stacks, state[0], found[0], strict=True):
            better[stack.members] = np.sum(new**2, axis=1) < np.sum(old**2, axis=1)
        here = replace(here, starts=np.where(better[:, None], there, here.starts))
        state = _of_each(linearisation, here, (state, found), better)
        waiting &= ~better
    return here, state


def _of_each(
    linearisation: Linearisation,
    here: Point,
    states: tuple[State, State],
    second: NDArray[np.bool_],
) -> State:
    """Return the state of each window: the first of two, or the second."""
    (rows, one, _), (other_rows, other, _) = states
    chosen = [
        np.where(second[stack.members][:, None], b, a)
        for stack, a, b in zip(linearisation.stacks, rows, other_rows, strict=True)
    ]
    outputs = tuple(
        b if yes else a for a, b, yes in zip(one.outputs, other.outputs, second, strict=True)
    )
    predicted = Predicted(outputs, np.where(second, other.failed, one.failed))
    return chosen, predicted, linearisation.cost(chosen, here)
