"""A model in the numbers that the steppers walk: matrices, table of laws, propagators."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.errors import ModelError, SimulationError
from shakerproc.models.coordinates import Coordinates, coordinates_of, resolved
from shakerproc.models.laws import WITH_STATE, Law, Row, curve_back, largest_state
from shakerproc.models.model import Model
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
    NO_CURVE,
    NOBODY,
    STACK,
    STOP,
    Machine,
    Store,
    room_for_series,
)

_POWERS = frozenset({Law.ODD_POWER, Law.EVEN_POWER, Law.POWER_DAMPING, Law.BOUC_WEN})
_HIGHEST_POWER = 63.0

Line = tuple[Row, str, str]
"""A law, and its first and second place."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class System:
    """A model, assembled.

    Attributes
    ----------
    names : tuple of str
        Its coordinates; see `Coordinates`.
    places : mapping of str to (n,) array
        Displacement of each place by unit coordinates [-].
    machine : Machine
        Its numbers.
    """

    names: tuple[str, ...]
    places: Mapping[str, FloatArray]
    machine: Machine

    def displacements(self, coordinates: FloatArray) -> FloatArray:
        """Return the displacement of every place, (n_places, n) array [m].

        Parameters
        ----------
        coordinates : (n, n_coordinates) array
            Displacements of the coordinates; velocities give velocities, and so on [m].
        """
        if tuple(self.places) == self.names:
            return coordinates.T
        directions: FloatArray = np.array(list(self.places.values()))
        return directions @ coordinates.T

    def along(self, place: str, coordinates: FloatArray) -> FloatArray:
        """Return the displacement of one place, (n,) array; see `displacements` [m]."""
        direction = self.places[place]
        moved = np.flatnonzero(direction)
        values: FloatArray = coordinates[:, moved] @ direction[moved]
        return values

    @property
    def n_states(self) -> int:
        """How many laws carry a state."""
        return int(np.sum(self.machine.lines[:, MEMORY] >= 0))

    @property
    def largest_states(self) -> FloatArray:
        """Size of each state and its limit, (n_states, 2) array."""
        states = [
            largest_state(Law(line[LAW]), values)
            for line, values in zip(self.machine.lines, self.machine.values, strict=True)
            if line[MEMORY] >= 0
        ]
        return np.array(states, float).reshape(-1, 2)

    @property
    def n_motions(self) -> int:
        """Number of displacements, velocities and states together."""
        return 2 * len(self.names) + self.n_states

    @property
    def analytic(self) -> bool:
        """Whether every branch of every law has a Taylor series everywhere."""
        return all(
            _analytic(Law(line[LAW]), float(values[2]))
            for line, values in zip(self.machine.lines, self.machine.values, strict=True)
        )


def assemble(model: Model) -> System:
    """Return the numbers of a model.

    Raises
    ------
    ModelError
        If two frictions between the same places cannot be told apart where both stick.
    """
    elements = resolved(model)
    linear = coordinates_of(model, elements)
    lines = [
        (row, *element.between)
        for element in elements
        for row in element.effect.rows()
        if row.law not in {Law.LINEAR, Law.ATTACHED}
    ]
    machine = _machine(linear, _merged_friction(model, lines))
    if model.excitation.imposed:
        machine = _imposed(machine, linear.names.index(str(model.excitation.on)))
    return System(linear.names, linear.places, machine)


def _machine(linear: Coordinates, lines: Sequence[Line]) -> Machine:
    """Return the numbers of a model whose laws start with no memory."""
    n, mass = linear.mass.size, linear.mass
    forces = np.column_stack([-linear.stiffness, -linear.damping, linear.load])
    values = np.zeros((len(lines), 6))
    tables: list[FloatArray] = []
    table, joints = np.full((len(lines), 2), -1), np.zeros((len(lines), n))
    n_states = 0
    for i, (row, *between) in enumerate(lines):
        start = float(sum(table.size for table in tables))
        numbers, more = row.values, row.table
        if row.law is Law.TABLE:
            numbers = (start, *numbers)
        elif row.law is Law.BOUC_WEN:
            more = curve_back(numbers)
            numbers = (*numbers, start if more.size else NO_CURVE)
        values[i, : len(numbers)] = numbers
        tables.append(more)
        table[i, LAW], joints[i] = row.law, linear.across((between[0], between[1]))
        if row.law in WITH_STATE:
            table[i, MEMORY] = n_states
            n_states += 1
    with_stack = any(row.law is Law.IWAN for row, _, _ in lines)
    stack = np.zeros((len(lines), 2, STACK if with_stack else 0))
    mode = np.zeros((len(lines), 2), np.int64)
    anchor = np.zeros((len(lines), 4))
    numbers_of_tables = np.concatenate([np.zeros(0), *tables])
    return Machine(
        mass, forces / mass[:, None], table, joints, joints / mass, values, mode, anchor,
        stack, numbers_of_tables, NOBODY, np.zeros((0, 2 * n + 1)),
    )  # fmt: skip


def _imposed(machine: Machine, place: int) -> Machine:
    """Return a machine whose input is the acceleration of a mass, for which a force is read."""
    n, mass = machine.mass.size, machine.mass[place]
    reading = -mass * machine.matrix[[place]]
    reading[0, 2 * n] = mass
    matrix, pushes = machine.matrix.copy(), machine.pushes.copy()
    matrix[place], pushes[:, place] = 0.0, 0.0
    matrix[place, 2 * n] = 1.0
    return machine._replace(matrix=matrix, pushes=pushes, reads=place, reading=reading)


def _merged_friction(model: Model, lines: Sequence[Line]) -> list[Line]:
    """Return the lines with one friction at most between two places.

    Where two stick in parallel, how they share the load is not determined.
    """
    kept: list[Line] = []
    for line in lines:
        row, first, second = line
        twins = [
            i
            for i, (other, *ends) in enumerate(kept)
            if row.law is other.law is Law.FRICTION and set(ends) == {first, second}
        ]
        if not twins:
            kept.append(line)
            continue
        kept[twins[0]] = (_sum_of_frictions(model, row, kept[twins[0]][0]), first, second)
    return kept


def _sum_of_frictions(model: Model, one: Row, other: Row) -> Row:
    """Return two frictions in parallel as one.

    Raises
    ------
    ModelError
        If both fall from breaking away to sliding, each over its own velocity.
    """
    scales = {row.values[2] for row in (one, other) if row.values[0] != row.values[1]}
    if len(scales) > 1:
        raise ModelError(
            f"{model.title}: two Stribeck frictions between the same places, with different "
            f"Stribeck velocities. Keep one of them."
        )
    sliding, breakaway = (one.values[i] + other.values[i] for i in range(2))
    return Row(Law.FRICTION, (sliding, breakaway, *(scales or {1.0})))


def _analytic(law: Law, exponent: float) -> bool:
    """Return whether a law whose third number this is has a Taylor series everywhere."""
    if law in (Law.TABLE, Law.HERTZ):
        return False
    if law is Law.IWAN:
        return exponent == 2.0
    return law not in _POWERS or _whole(exponent)


def _whole(exponent: float) -> bool:
    return exponent == round(exponent) and exponent <= _HIGHEST_POWER


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
    branches = _branches(machine)
    return None if branches is None or np.any(_nonlinear_numbers(machine) >= 0) else branches


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


def _nonlinear_numbers(machine: Machine) -> NDArray[np.int64]:
    """Return the number of each line among those that are not linear on their branches."""
    law, values = machine.lines[:, LAW], machine.values
    linear = np.isin(law, [*_WALLS, JENKINS, CONSTANT])
    linear |= (law == FRICTION) & (values[:, 0] == values[:, 1])
    numbers: NDArray[np.int64] = np.where(linear, -1, np.cumsum(~linear) - 1)
    return numbers


def _owner(
    machine: Machine, force_numbers: NDArray[np.int64], n_states: int
) -> NDArray[np.int64]:
    """Return whose state each is: the number of a carried line, or -1."""
    owner = np.full(n_states, -1)
    held = machine.lines[:, MEMORY] >= 0
    owner[machine.lines[held, MEMORY]] = force_numbers[held]
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
    force_numbers = _nonlinear_numbers(machine)
    n_forces = int(np.sum(force_numbers >= 0))
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
        force_numbers,
        _owner(machine, force_numbers, n_states),
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
