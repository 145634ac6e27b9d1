"""Exact propagators for every combination of branches of a piecewise-linear model."""

from itertools import product

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.errors import SimulationError
from shakerproc.simulate.kernels.branches import set_propagators, set_rates_and_events
from shakerproc.simulate.kernels.table import (
    CONTACT_DAMPING,
    FRICTION,
    JENKINS,
    JUMP,
    LAW,
    MEMORY,
    STOP,
    Machine,
    Store,
    room_for_series,
)

MOST_PARTS = 1e5
"""Steps in a sample."""

MOST_COMBINATIONS = 64
"""More combinations of branches than this are left to the Taylor series."""

_WALLS = frozenset({STOP, JUMP, CONTACT_DAMPING})
_TURN = 0.8  # rad of the fastest mode in one part of a sample


def branches_of(machine: Machine) -> tuple[tuple[int, ...], ...] | None:
    """Return the branches that each line can be on, or None where some are not linear."""
    all_branches: list[tuple[int, ...]] = []
    combinations = 1
    for line, values in zip(machine.lines, machine.values, strict=True):
        if line[LAW] in _WALLS:
            all_branches.append((0, 1))
        elif line[LAW] == JENKINS or (line[LAW] == FRICTION and values[0] == values[1]):
            all_branches.append((-1, 0, 1))
        else:
            return None
        combinations *= len(all_branches[-1])
    return tuple(all_branches) if combinations <= MOST_COMBINATIONS else None


def no_store() -> Store:
    """Return a store without slots: everything is left to the Taylor series."""
    none = np.zeros(0, np.int64)
    which, empty = np.zeros((0, 0, 0), np.int64), np.zeros((0, 0, 0))
    return Store(none, none, np.zeros(0), none, which, *[empty] * 4)


def build_store(machine: Machine, sample: float, degree: int) -> Store:
    """Return the propagators of a machine, or a store without slots if it is not linear.

    Parameters
    ----------
    machine : Machine
        The model.
    sample : float
        Length of a sample [s].
    degree : int
        Degree of the polynomials that the input is made of, at least 1.
    """
    branches = branches_of(machine)
    if branches is None:
        return no_store()
    combinations = np.array(list(product(*branches)), dtype=np.int64)
    count, n_lines = combinations.shape
    slot_of = np.full(3**n_lines, -1)
    slot_of[(combinations + 1) @ 3 ** np.arange(n_lines)[::-1]] = np.arange(count)
    n_states = int(np.sum(machine.lines[:, MEMORY] >= 0))
    n_y, n_events = 2 * machine.mass.size + n_states, 2 * n_lines
    store = Store(
        slot_of,
        np.ones(count, np.int64),
        np.empty(count),
        np.zeros(count, np.int64),
        np.zeros((count, n_events, 2), np.int64),
        np.zeros((count, n_y, n_y + 2)),
        np.zeros((count, n_events, n_y + 2)),
        np.zeros((count, n_events, n_y + 2)),
        np.empty((count, n_y, n_y + degree + 2)),
    )
    free = machine._replace(mode=np.zeros_like(machine.mode))
    series = room_for_series(machine.mass.size, n_states, n_lines)
    set_rates_and_events(free, combinations, series, store)
    if n_lines:
        store.parts[:] = _parts(store.system, sample)
    store.part[:] = sample / store.parts
    size = n_y + degree + 2
    set_propagators(_units(machine, store.part, n_y), np.empty((4, size, size)), store)
    return store


def _parts(system: FloatArray, sample: float) -> FloatArray:
    """Return into how many parts to cut a sample so that no event hides between its ends.

    Raises
    ------
    SimulationError
        If there are too many of them.
    """
    n_y = system.shape[1]
    fastest = np.max(np.abs(np.linalg.eigvals(system[:, :, :n_y])), axis=1)
    parts: FloatArray = np.maximum(1.0, np.ceil(fastest * sample / _TURN))
    if not np.max(parts) <= MOST_PARTS:
        raise SimulationError(
            f"the fastest rate of the model, {np.max(fastest):.3g} 1/s, takes "
            f"{np.max(parts):.3g} steps in a sample of {sample:.3g} s; at most "
            f"{MOST_PARTS:.0e} are taken. Check the sizes of stiffness, damping and mass."
        )
    return parts


def _units(machine: Machine, part: FloatArray, n_y: int) -> FloatArray:
    """Return units of displacement, velocity and state in which the rates are of one size."""
    n = machine.mass.size
    units = np.ones((part.size, n_y))
    units[:, n : 2 * n] = 1.0 / part[:, None]
    for line, values in zip(machine.lines, machine.values, strict=True):
        if line[MEMORY] >= 0:
            units[:, 2 * n + line[MEMORY]] = values[0]
    return units
