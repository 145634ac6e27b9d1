"""Exact propagators for every combination of branches of a piecewise-linear model."""

from itertools import product

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.errors import SimulationError
from shakerproc.numerals import numeral
from shakerproc.simulation.kernels.branches import set_propagators, set_rates_and_events
from shakerproc.simulation.kernels.table import (
    CONSTANT,
    CONTACT_DAMPING,
    FORCE_TERMS,
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

MOST_LINES = 10
"""More laws than this are left to the Taylor series: each triples the table of slots."""

_WALLS = frozenset({STOP, JUMP, CONTACT_DAMPING})
_THREE = frozenset({JENKINS, FRICTION})
_EMPTY = np.zeros((0, 0, 0))
_TURN = 0.8  # rad of the fastest mode in one part of a sample


def branches_of(machine: Machine) -> tuple[tuple[int, ...], ...] | None:
    """Return the branches that each line can be on, or None where some are not linear."""
    found = _branches(machine)
    return None if found is None or np.any(_carried(machine) >= 0) else found


def _branches(machine: Machine) -> tuple[tuple[int, ...], ...] | None:
    """Return the branches that tell propagators apart; None where there are too many."""
    all_branches: list[tuple[int, ...]] = []
    combinations = 1
    for line in machine.lines:
        branches: tuple[int, ...] = (0,)
        if line[LAW] in _WALLS:
            branches = (0, 1)
        elif line[LAW] in _THREE:
            branches = (-1, 0, 1)
        all_branches.append(branches)
        combinations *= len(branches)
    most = len(all_branches) <= MOST_LINES and combinations <= MOST_COMBINATIONS
    return tuple(all_branches) if most else None


def _carried(machine: Machine) -> NDArray[np.int64]:
    """Return the number of each line among those that are not linear on their branches."""
    law, values = machine.lines[:, LAW], machine.values
    linear = np.isin(law, [*_WALLS, JENKINS, CONSTANT])
    linear |= (law == FRICTION) & (values[:, 0] == values[:, 1])
    numbers: NDArray[np.int64] = np.where(linear, -1, np.cumsum(~linear) - 1)
    return numbers


def _owner(machine: Machine, carried: NDArray[np.int64], n_states: int) -> NDArray[np.int64]:
    """Return whose state each is: the number of a carried line, or -1."""
    owner = np.full(n_states, -1)
    held = machine.lines[:, MEMORY] >= 0
    owner[machine.lines[held, MEMORY]] = carried[held]
    return owner


def no_store() -> Store:
    """Return a store without slots: everything is left to the Taylor series."""
    none, which, empty = np.zeros(0, np.int64), np.zeros((0, 0, 0), np.int64), _EMPTY
    return Store(
        none, none, np.zeros(0), none, which, empty, empty, empty, empty, none, none, empty
    )


def build_store(machine: Machine, sample: float, degree: int, *, carry: bool = False) -> Store:
    """Return the propagators of a machine, or a store without slots if it is not linear.

    Parameters
    ----------
    machine : Machine
        The model.
    sample : float
        Length of a sample [s].
    degree : int
        Degree of the polynomials that the input is made of, at least 1.
    carry : bool
        Whether laws that are not linear on their branches may be carried, as forces that are
        cubics over each part of a sample.
    """
    branches = _branches(machine) if carry else branches_of(machine)
    if branches is None:
        return no_store()
    combinations = np.array(list(product(*branches)), dtype=np.int64)
    count, n_lines = combinations.shape
    slot_of = np.full(3**n_lines, -1)
    slot_of[(combinations + 1) @ 3 ** np.arange(n_lines)[::-1]] = np.arange(count)
    n_states = int(np.sum(machine.lines[:, MEMORY] >= 0))
    n_y, n_events = 2 * machine.mass.size + n_states, 2 * n_lines
    carried = _carried(machine)
    n_forces = int(np.sum(carried >= 0))
    size = n_y + degree + 2 + FORCE_TERMS * n_forces
    store = Store(
        slot_of,
        np.ones(count, np.int64),
        np.empty(count),
        np.zeros(count, np.int64),
        np.zeros((count, n_events, 2), np.int64),
        np.zeros((count, n_y + 1, n_y + 2)),
        np.zeros((count, n_events, n_y + 2 + n_forces)),
        np.zeros((count, n_events, n_y + 2 + n_forces)),
        np.empty((count, n_y, size)),
        carried,
        _owner(machine, carried, n_states),
        np.zeros((count, machine.mass.size + 1, n_forces)),
    )
    free = machine._replace(mode=np.zeros_like(machine.mode))
    series = room_for_series(machine, n_states)
    set_rates_and_events(free, combinations, series, store)
    if n_lines:
        store.parts[:] = _parts(store.system, sample)
    store.part[:] = sample / store.parts
    set_propagators(_units(machine, store.part, n_y), np.empty((4, size, size)), store)
    return store


def _parts(system: FloatArray, sample: float) -> FloatArray:
    """Return into how many parts to cut a sample so that no event hides between its ends.

    Raises
    ------
    SimulationError
        If there are too many of them.
    """
    n_y = system.shape[1] - 1
    fastest = np.max(np.abs(np.linalg.eigvals(system[:, :n_y, :n_y])), axis=1)
    parts: FloatArray = np.maximum(1.0, np.ceil(fastest * sample / _TURN))
    if not np.max(parts) <= MOST_PARTS:
        raise SimulationError(
            f"the fastest rate of the model, {numeral(np.max(fastest))} 1/s, takes "
            f"{numeral(np.max(parts))} steps in a sample of {numeral(sample)} s; at most "
            f"{MOST_PARTS:.0e} are taken. Check the sizes of stiffness, damping and mass."
        )
    return parts


def _units(machine: Machine, part: FloatArray, n_y: int) -> FloatArray:
    """Return units of displacement, velocity and state in which the rates are of one size."""
    n = machine.mass.size
    units = np.ones((part.size, n_y))
    units[:, n : 2 * n] = 1.0 / part[:, None]
    for line, values in zip(machine.lines, machine.values, strict=True):
        if line[LAW] == JENKINS:
            units[:, 2 * n + line[MEMORY]] = values[0]
    return units
