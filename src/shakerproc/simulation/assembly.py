"""A model in the numbers that the steppers walk: matrices and a table of laws."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.errors import ModelError
from shakerproc.models.laws import Law, Row, largest_state
from shakerproc.models.model import BASE, Model
from shakerproc.models.parallel_elements import resolved
from shakerproc.simulation.kernels.table import LAW, MEMORY, NOBODY, STACK, Machine

_WITH_STATE = frozenset({Law.LUGRE, Law.JENKINS, Law.IWAN, Law.BOUC_WEN, Law.SERIES})
_POWERS = frozenset({Law.ODD_POWER, Law.EVEN_POWER, Law.POWER_DAMPING, Law.BOUC_WEN})
_HIGHEST_POWER = 63.0

Line = tuple[Row, int, int]
Linear = tuple[dict[int, float], float, float]
"""What moves a spring and damper, in shares of displacements; stiffness and damping."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class System:
    """A model, assembled.

    Attributes
    ----------
    names : tuple of str
        The masses of the model, then ``attached 1``, ... for the modes attached to them and
        ``mode 1``, ... for further modes.
    machine : Machine
        Its numbers.
    """

    names: tuple[str, ...]
    machine: Machine

    @property
    def n_states(self) -> int:
        """How many laws carry a state."""
        return int(np.sum(self.machine.lines[:, MEMORY] >= 0))

    @property
    def largest_states(self) -> FloatArray:
        """Size of each state and what it cannot exceed, (n_states, 2) array."""
        found = [
            largest_state(Law(line[LAW]), values)
            for line, values in zip(self.machine.lines, self.machine.values, strict=True)
            if line[MEMORY] >= 0
        ]
        return np.array(found, float).reshape(-1, 2)

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
    names = list(model.masses)
    masses = list(model.rigid_masses.values())
    linear: list[Linear] = []
    lines: list[Line] = []
    for element in elements:
        first, second = (_index(names, place) for place in element.between)
        for row in element.effect.rows():
            if row.law is Law.LINEAR:
                stiffness, damping = row.values
                linear.append((_apart(first, second), stiffness, damping))
            elif row.law is Law.ATTACHED:
                mass, stiffness, damping = row.values
                names.append(f"attached {len(names) - len(model.masses) + 1}")
                masses.append(mass)
                linear.append((_apart(second, len(names) - 1), stiffness, damping))
            else:
                lines.append((row, first, second))
    for i, mode in enumerate(model.modes):
        held = {names.index(name): -share for name, share in mode.participation.items()}
        linear.append(({len(names): 1.0, **held}, mode.stiffness, mode.damping))
        names.append(f"mode {i + 1}")
        masses.append(mode.mass)
    matrix = _matrix(model, masses, linear)
    machine = _machine(np.array(masses, float), matrix, _merged_friction(model, lines))
    if model.excitation.imposed:
        machine = _imposed(machine, names.index(str(model.excitation.on)))
    return System(tuple(names), machine)


def _index(names: Sequence[str], place: str) -> int:
    return -1 if place == BASE else names.index(place)


def _apart(first: int, second: int) -> dict[int, float]:
    """Return the motion of the second place less that of the first, by their numbers."""
    return {place: sign for place, sign in ((second, 1.0), (first, -1.0)) if place >= 0}


def _matrix(model: Model, masses: Sequence[float], linear: Sequence[Linear]) -> FloatArray:
    """Return the accelerations by springs, dampers and input, (n, 2 n + 1) array."""
    n = len(masses)
    forces = np.zeros((n, 2 * n + 1))
    for motions, stiffness, damping in linear:
        direction = np.zeros(n)
        for place, share in motions.items():
            direction[place] += share
        forces[:, :n] -= stiffness * np.outer(direction, direction)
        forces[:, n : 2 * n] -= damping * np.outer(direction, direction)
    excitation = model.excitation
    if excitation.moves_base:
        forces[:, 2 * n] = -np.array(masses)
    elif excitation.kind == "force":
        forces[list(model.masses).index(str(excitation.on)), 2 * n] = 1.0
    accelerations: FloatArray = forces / np.array(masses)[:, None]
    return accelerations


def _machine(mass: FloatArray, matrix: FloatArray, lines: Sequence[Line]) -> Machine:
    """Return the numbers of a model whose laws start with no memory."""
    values = np.zeros((len(lines), 6))
    tables: list[FloatArray] = []
    table = np.full((len(lines), 4), -1)
    n_states = 0
    for i, (row, first, second) in enumerate(lines):
        start = float(sum(table.size for table in tables))
        numbers = (start, *row.values) if row.law is Law.TABLE else row.values
        values[i, : len(numbers)] = numbers
        tables.append(row.table)
        table[i, :3] = row.law, second, first
        if row.law in _WITH_STATE:
            table[i, MEMORY] = n_states
            n_states += 1
    with_stack = any(row.law is Law.IWAN for row, _, _ in lines)
    stack = np.zeros((len(lines), 2, STACK if with_stack else 0))
    mode = np.zeros((len(lines), 2), np.int64)
    anchor = np.zeros((len(lines), 4))
    numbers_of_tables = np.concatenate([np.zeros(0), *tables])
    return Machine(
        mass, matrix, table, values, mode, anchor, stack, numbers_of_tables, 1.0 / mass,
        NOBODY, np.zeros((0, matrix.shape[1])),
    )  # fmt: skip


def _imposed(machine: Machine, place: int) -> Machine:
    """Return a machine whose input is the acceleration of a mass, for which a force is read."""
    n, mass = machine.mass.size, machine.mass[place]
    reading = -mass * machine.matrix[[place]]
    reading[0, 2 * n] = mass
    matrix, mobility = machine.matrix.copy(), machine.mobility.copy()
    matrix[place], mobility[place] = 0.0, 0.0
    matrix[place, 2 * n] = 1.0
    return machine._replace(matrix=matrix, mobility=mobility, reads=place, reading=reading)


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
    if law is Law.TABLE:
        return False
    if law is Law.IWAN:
        return exponent == 2.0
    return law not in _POWERS or _whole(exponent)


def _whole(exponent: float) -> bool:
    return exponent == round(exponent) and exponent <= _HIGHEST_POWER
