"""A tabulated law, by the cubic polynomials of its cells.

Of the line of a tabulated law, `values` are where its numbers start in `Machine.tables`, the
number of cells along displacement and along velocity, the number of surfaces on which the law
jumps or bends, and along which axis they lie (0 displacement, 1 velocity). In `tables` stand,
from there on: the origin of each cell along displacement, along velocity, the surfaces, the
first cell of each region between them, and the 16 coefficients of every cell
(`models.tabulated` packs them).
"""

from shakerproc.data import FloatArray
from shakerproc.models.compiled import inlined, inner
from shakerproc.simulation.kernels.polynomials import product
from shakerproc.simulation.kernels.table import BASE, DISPLACEMENT, NONE, VELOCITY, Machine


@inlined
def tabulated(machine: Machine, row: int, order: int, lines: FloatArray) -> float:
    """Return the force by the polynomial of the cell that the motion is in at order 0.

    The planes from BASE on hold displacement and velocity from the origin of the cell, their
    squares and cubes, and what the powers of displacement are multiplied by.
    """
    i = _cell(machine, row, 0, lines[row, DISPLACEMENT, 0])
    j = _cell(machine, row, 1, lines[row, VELOCITY, 0])
    for kind in range(2):
        first = BASE + 3 * kind
        lines[row, first, order] = lines[row, DISPLACEMENT + kind, order]
        if order == 0:
            lines[row, first, 0] -= _origin(machine, row, kind, j if kind == 1 else i)
        lines[row, first + 1, order] = product(lines, row, first, first, order)
        lines[row, first + 2, order] = product(lines, row, first, first + 1, order)
    total = 0.0
    for p in range(4):
        along = _coefficient(machine, row, i, j, p, 0) if order == 0 else 0.0
        for q in range(1, 4):
            along += _coefficient(machine, row, i, j, p, q) * lines[row, BASE + 2 + q, order]
        lines[row, BASE + 6 + p, order] = along
        if p == 0:
            total += along
        else:
            total += product(lines, row, BASE + p - 1, BASE + 6 + p, order)
    return total


@inlined
def table_event(machine: Machine, row: int, which: int) -> tuple[int, float, float]:
    """Return quantity, sign and level of an event, as `modes.event` does."""
    mode, n_surfaces = machine.mode[row, 0], int(machine.values[row, 3])
    kind = DISPLACEMENT if machine.values[row, 4] == 0.0 else VELOCITY
    surfaces = _surfaces(machine, row)
    if which == 0 and mode < n_surfaces:
        return kind, 1.0, machine.tables[surfaces + mode]
    if mode > 0 and which == (1 if mode < n_surfaces else 0):
        return kind, -1.0, -machine.tables[surfaces + mode - 1]
    return NONE, 0.0, 0.0


@inlined
def region_of(machine: Machine, row: int, displacement: float, velocity: float) -> int:
    """Return the region that a motion is in: how many surfaces lie below it."""
    at = displacement if machine.values[row, 4] == 0.0 else velocity
    surfaces, count = _surfaces(machine, row), 0
    for k in range(int(machine.values[row, 3])):
        if at >= machine.tables[surfaces + k]:
            count += 1
    return count


@inlined
def _ends(machine: Machine, row: int, axis: int) -> tuple[int, int]:
    """Return the first and the last cell along an axis of the region that a line is in."""
    count = int(machine.values[row, 1 + axis])
    n_surfaces = int(machine.values[row, 3])
    if n_surfaces == 0 or axis != int(machine.values[row, 4]):
        return 0, count - 1
    mode, tables = machine.mode[row, 0], machine.tables
    firsts = _surfaces(machine, row) + n_surfaces
    first = int(tables[firsts + mode])
    return first, (int(tables[firsts + mode + 1]) if mode < n_surfaces else count) - 1


@inlined
def _surfaces(machine: Machine, row: int) -> int:
    """Return where the surfaces of a line stand among the numbers of all tables."""
    return int(machine.values[row, 0] + machine.values[row, 1] + machine.values[row, 2])


@inner
def _cell(machine: Machine, row: int, axis: int, at: float) -> int:
    """Return the cell along an axis: the last whose origin is not above a place.

    The first cell of a region has no lower end, and the same origin as the next one.
    """
    low, high = _ends(machine, row, axis)
    origins = int(machine.values[row, 0])
    if axis == 1:
        origins += int(machine.values[row, 1])
    while low < high:
        middle = (low + high + 1) // 2
        if machine.tables[origins + middle] <= at:
            low = middle
        else:
            high = middle - 1
    return low


@inlined
def _origin(machine: Machine, row: int, axis: int, number: int) -> float:
    """Return where the polynomial of a cell is 0 along an axis [m] or [m/s]."""
    first = int(machine.values[row, 0])
    if axis == 1:
        first += int(machine.values[row, 1])
    return machine.tables[first + number]


@inlined
def _coefficient(machine: Machine, row: int, i: int, j: int, p: int, q: int) -> float:
    """Return a coefficient of a cell, by powers of displacement and velocity."""
    n_v, n_surfaces = int(machine.values[row, 2]), int(machine.values[row, 3])
    first = _surfaces(machine, row) + 2 * n_surfaces + 1
    return machine.tables[first + 16 * (i * n_v + j) + 4 * p + q]
