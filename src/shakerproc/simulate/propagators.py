"""Exact propagators for every combination of branches of a piecewise-linear model."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from math import factorial
from typing import Any, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.simulate.kernels.table import (
    CONTACT_DAMPING,
    FIRST,
    FRICTION,
    JENKINS,
    JUMP,
    LAW,
    MEMORY,
    SECOND,
    STOP,
    Machine,
    Store,
)

IntArray: TypeAlias = NDArray[np.int64]

MOST_COMBINATIONS = 64
"""More combinations of branches than this are left to the Taylor series."""

_WALLS = frozenset({STOP, JUMP, CONTACT_DAMPING})
_TURN = 0.8  # rad of the fastest mode in one part of a sample


def branches_of(machine: Machine) -> tuple[tuple[int, ...], ...] | None:
    """Return the branches that each line can be on, or None where some are not linear."""
    all_branches: list[tuple[int, ...]] = []
    for line, values in zip(machine.lines, machine.values, strict=True):
        if line[LAW] in _WALLS:
            all_branches.append((0, 1))
        elif line[LAW] == JENKINS or (line[LAW] == FRICTION and values[0] == values[1]):
            all_branches.append((-1, 0, 1))
        else:
            return None
    combinations = np.prod([len(branches) for branches in all_branches], dtype=float)
    return tuple(all_branches) if combinations <= MOST_COMBINATIONS else None


def no_store() -> Store:
    """Return a store without slots: everything is left to the Taylor series."""
    none = np.zeros(0, np.int64)
    which, empty = np.zeros((0, 0, 0), np.int64), np.zeros((0, 0, 0))
    return Store(none, none, np.zeros(0), none, which, *[empty] * 6)


def build_stores(machines: Sequence[Machine], sample: float, degree: int) -> list[Store]:
    """Return the store of each of some machines that differ in their numbers alone.

    Parameters
    ----------
    machines : sequence of Machine
        Models with the same laws in the same places.
    sample : float
        Length of a sample [s].
    degree : int
        Degree of the polynomials that the input is made of, at least 1.
    """
    lines, branches = machines[0].lines, branches_of(machines[0])
    if branches is None:
        return [no_store() for _ in machines]
    combinations = np.array(list(product(*branches)), dtype=np.int64)
    count, n_lines = combinations.shape[0], len(branches)
    slot_of = np.full(3**n_lines, -1)
    slot_of[(combinations + 1) @ 3 ** np.arange(n_lines)[::-1]] = np.arange(count)
    mass = np.stack([machine.mass for machine in machines]).repeat(count, axis=0)
    matrix = np.stack([machine.matrix for machine in machines]).repeat(count, axis=0)
    values = np.stack([machine.values for machine in machines]).repeat(count, axis=0)
    batch = _Batch(lines, mass, matrix, values, np.tile(combinations, (len(machines), 1)))
    which, n_events, order = _numbered(lines, combinations)
    system, hold = _system(batch)
    events = _events(batch, hold)
    events = np.take_along_axis(events, np.tile(order, (len(machines), 1))[:, :, None], axis=1)
    parts = _parts(system, sample) if n_lines else np.ones(len(system), np.int64)
    part = sample / parts
    by_x = _over_a_part(batch, system, events, part, degree)
    return [
        Store(
            slot_of,
            parts[one],
            part[one],
            n_events,
            which,
            system[one],
            events[one],
            *(rows[one] for rows in by_x),
        )
        for one in (slice(count * i, count * (i + 1)) for i in range(len(machines)))
    ]


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Batch:
    """Every machine on every combination of branches, one after the other in the first axis."""

    lines: IntArray
    mass: FloatArray
    matrix: FloatArray
    values: FloatArray
    mode: IntArray

    @property
    def n_masses(self) -> int:
        return int(self.mass.shape[1])

    @property
    def n_motions(self) -> int:
        return 2 * self.n_masses + int(np.sum(self.lines[:, MEMORY] >= 0))

    def direction(self, row: int | np.integer[Any]) -> FloatArray:
        """Return +1 at the second place of a line and -1 at the first, (n,) array."""
        direction = np.zeros(self.n_masses)
        for column, sign in ((SECOND, 1.0), (FIRST, -1.0)):
            if self.lines[row, column] >= 0:
                direction[self.lines[row, column]] = sign
        return direction


def _numbered(lines: IntArray, combinations: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Return line and number of each event, how many there are, and where they stand.

    Returns
    -------
    (s, 2 r, 2), (s,), (s, 2 r) array
        Events that a combination does not have come last.
    """
    n_lines = len(lines)
    walls = np.isin(lines[:, LAW], list(_WALLS))
    both = np.ones((len(combinations), n_lines, 2), bool)
    both[:, :, 1] = (combinations == 0) & ~walls
    has = both.reshape(len(combinations), 2 * n_lines)
    order = np.argsort(~has, axis=1, kind="stable")
    all_events = np.stack(np.divmod(np.arange(2 * n_lines), 2), axis=1)
    return all_events[order], np.sum(has, axis=1), order


def _over_a_part(
    batch: _Batch, system: FloatArray, events: FloatArray, part: FloatArray, degree: int
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return the fields `step`, `accelerate`, `starts` and `ends` of a store, for all."""
    n = batch.n_masses
    step = _step(batch, system, part, degree)
    accelerate = _after(_at(system[:, n : 2 * n], degree)[:, :, 1], step)
    watched = np.stack((_at(events, degree), _slope_at(events, system, part, degree)), axis=2)
    size = (len(system), 2 * events.shape[1], batch.n_motions + degree + 2)
    starts, ends = (watched[:, :, :, i].reshape(size) for i in range(2))
    return step, accelerate, starts, _after(ends, step)


def _at(rows: FloatArray, degree: int) -> FloatArray:
    """Return (b, m, 2, n_x) rows by x at the start and at the end, from rows by (y, w, 1).

    Those for the end still want the motion at the end; see `_after`.
    """
    n_y = rows.shape[2] - 2
    by_x = np.zeros((*rows.shape[:2], 2, n_y + degree + 2))
    by_x[..., :n_y] = rows[:, :, None, :n_y]
    by_x[:, :, 0, n_y] = rows[:, :, n_y]
    by_x[:, :, 1, n_y : n_y + degree + 1] = rows[:, :, n_y, None]
    by_x[..., n_y + degree + 1] = rows[:, :, None, n_y + 1]
    return by_x


def _slope_at(
    events: FloatArray, system: FloatArray, part: FloatArray, degree: int
) -> FloatArray:
    """Return the slopes of events over a part, as `_at` does the events."""
    n_y = system.shape[1]
    by_x = _at(events[:, :, :n_y] @ system * part[:, None, None], degree)
    by_x[:, :, 0, n_y + 1] += events[:, :, n_y]
    by_x[:, :, 1, n_y : n_y + degree + 1] += events[:, :, n_y, None] * np.arange(degree + 1)
    return by_x


def _after(rows: FloatArray, step: FloatArray) -> FloatArray:
    """Return rows by x from rows by the motion after a part and the rest of x."""
    by_x: FloatArray = rows + rows[:, :, : step.shape[1]] @ step
    return by_x


def _system(batch: _Batch) -> tuple[FloatArray, FloatArray]:
    """Return the matrices that take (y, w, 1) to the rates of y, and to the holding forces.

    Returns
    -------
    (b, n_y, n_y + 2), (b, r, n_y + 2) array
        For the whole batch.
    """
    n, n_y = batch.n_masses, batch.n_motions
    system = np.zeros((len(batch.mass), n_y, n_y + 2))
    system[:, range(n), range(n, 2 * n)] = 1.0
    a = system[:, n : 2 * n]
    a[:, :, : 2 * n] = batch.matrix[:, :, : 2 * n]
    a[:, :, n_y] = batch.matrix[:, :, 2 * n]
    for row in range(len(batch.lines)):
        _add_force(batch, row, system)
    hold = np.zeros((len(batch.mass), len(batch.lines), n_y + 2))
    stuck = (batch.mode == 0) & (batch.lines[:, LAW] == FRICTION)
    for pattern in np.unique(stuck[stuck.any(axis=1)], axis=0):
        alike = np.flatnonzero(np.all(stuck == pattern, axis=1))
        held = np.flatnonzero(pattern)
        across = np.stack([batch.direction(row) for row in held])
        pushes = across.T / batch.mass[alike, :, None]
        load = np.linalg.solve(across @ pushes, across @ a[alike])
        hold[alike[:, None], held] = load
        a[alike] -= pushes @ load
    return system, hold


def _add_force(batch: _Batch, row: int, system: FloatArray) -> None:
    """Take the force of one line off the accelerations of a system."""
    law, n, n_y = batch.lines[row, LAW], batch.n_masses, batch.n_motions
    direction, values = batch.direction(row), batch.values[:, row]
    scaled = batch.mode[:, row] * values[:, 0]
    force = np.zeros((len(batch.mass), n_y + 2))
    if law == JENKINS:
        state = 2 * n + batch.lines[row, MEMORY]
        force[:, state] = 1.0
        sticks = (batch.mode[:, row] == 0) * values[:, 0]
        system[:, state, n : 2 * n] = sticks[:, None] * direction
    elif law == FRICTION:
        force[:, n_y + 1] = scaled
    elif law == CONTACT_DAMPING:
        force[:, n : 2 * n] = scaled[:, None] * direction
    else:
        force[:, :n] = scaled[:, None] * direction
        if law == STOP:
            force[:, n_y + 1] = -scaled * values[:, 1]
    system[:, n : 2 * n] -= (direction / batch.mass)[:, :, None] * force[:, None, :]


def _parts(system: FloatArray, sample: float) -> IntArray:
    """Return into how many parts to cut a sample so that no event hides between its ends."""
    n_y = system.shape[1]
    fastest = np.max(np.abs(np.linalg.eigvals(system[:, :, :n_y])), axis=1)
    parts: IntArray = np.maximum(1, np.ceil(fastest * sample / _TURN)).astype(np.int64)
    return parts


def _step(batch: _Batch, system: FloatArray, part: FloatArray, degree: int) -> FloatArray:
    """Return the (b, n_y, n_y + degree + 2) propagators over a part of a sample, less 1.

    By x they give what is added to y, so that their rounding is that of the small change.
    exp of [[A, b, 0], [0, J, 0]] holds the integrals of exp(A (1 - x)) b x^k / k! in its
    columns, where J shifts (Al-Mohy and Higham, SIAM J. Sci. Comput. 33, 488-511, 2011).
    """
    n_y, size = batch.n_motions, batch.n_motions + degree + 2
    unit = _units(batch, part)
    scaled = system * part[:, None, None] / unit[:, :, None]
    scaled[:, :, :n_y] *= unit[:, None, :]
    big = np.zeros((len(system), size, size))
    big[:, :n_y, : n_y + 1] = scaled[:, :, : n_y + 1]
    big[:, :n_y, size - 1] = scaled[:, :, n_y + 1]
    big[:, range(n_y, size - 2), range(n_y + 1, size - 1)] = 1.0
    over = exponential_less_one(big)[:, :n_y] * unit[:, :, None]
    over[:, :, :n_y] /= unit[:, None, :]
    over[:, :, n_y : size - 1] *= [factorial(k) for k in range(degree + 1)]
    return over


def _units(batch: _Batch, part: FloatArray) -> FloatArray:
    """Return units of displacement, velocity and state in which the rates are of one size."""
    n = batch.n_masses
    unit = np.ones((len(part), batch.n_motions))
    unit[:, n : 2 * n] = 1.0 / part[:, None]
    for row in np.flatnonzero(batch.lines[:, MEMORY] >= 0):
        unit[:, 2 * n + batch.lines[row, MEMORY]] = batch.values[:, row, 0]
    return unit


def exponential_less_one(matrices: FloatArray) -> FloatArray:
    """Return exp(A) - 1 of (b, n, n) matrices, by series, scaling and doubling [-]."""
    norm = np.max(np.sum(np.abs(matrices), axis=2), axis=1)
    doublings = np.maximum(0, np.ceil(np.log2(np.maximum(norm, 1e-300) / 0.25))).astype(int)
    small = matrices / 2.0 ** doublings[:, None, None]
    total: FloatArray = small
    term = small
    for k in range(2, 15):
        term = term @ small / k
        total = total + term
    for doubling in range(int(np.max(doublings, initial=0))):
        due = doublings > doubling
        total[due] = 2.0 * total[due] + total[due] @ total[due]
    return np.asarray(total)


def _events(batch: _Batch, hold: FloatArray) -> FloatArray:
    """Return the (b, 2 r, n_y + 2) events of all lines; an event that is not there is -1.

    The compiled counterpart is `modes.event`.
    """
    n, n_y, n_lines = batch.n_masses, batch.n_motions, len(batch.lines)
    events = np.zeros((len(batch.mass), n_lines, 2, n_y + 2))
    for row in range(n_lines):
        law, mode, direction = batch.lines[row, LAW], batch.mode[:, row], batch.direction(row)
        values, first, second = batch.values[:, row], events[:, row, 0], events[:, row, 1]
        second[:, n_y + 1] = -1.0
        if law in _WALLS:
            side = values[:, 2] * (1.0 - 2.0 * mode)
            first[:, :n] = side[:, None] * direction
            first[:, n_y + 1] = -side * values[:, 1]
            continue
        sticks = mode == 0
        first[:, n : 2 * n] = -mode[:, None] * direction
        for event, sign in ((first, 1.0), (second, -1.0)):
            if law == FRICTION:
                event[sticks] = sign * hold[sticks, row]
            else:
                event[sticks, 2 * n + batch.lines[row, MEMORY]] = sign
            event[sticks, n_y + 1] -= values[sticks, 1]
        if law == JENKINS:
            second[sticks, n_y + 1] += 1.0
    return events.reshape(len(batch.mass), 2 * n_lines, n_y + 2)
