"""A Hertz contact with damping."""

from shakerproc.data import FloatArray
from shakerproc.models.compiled import inlined
from shakerproc.simulation.kernels.polynomials import power, product
from shakerproc.simulation.kernels.table import (
    BASE,
    DISPLACEMENT,
    NONE,
    PLANES,
    VELOCITY,
    Machine,
)


@inlined
def hertz(machine: Machine, row: int, order: int, lines: FloatArray) -> float:
    """Return the coefficient of the force in contact: depth to 1.5, times 1 + c velocity."""
    side = machine.values[row, 2]
    depth = side * lines[row, DISPLACEMENT, order]
    held = machine.values[row, 3] * side * lines[row, VELOCITY, order]
    if order == 0:
        depth -= side * machine.values[row, 1]
        held += 1.0
    lines[row, BASE, order] = depth
    lines[row, PLANES - 1, order] = held
    power(lines, row, 1.5, order)
    return side * machine.values[row, 0] * product(lines, row, BASE + 1, PLANES - 1, order)


@inlined
def event_of_parting(machine: Machine, row: int) -> tuple[int, float, float]:
    """Return when a Hertz contact starts to part faster than it recovers, or ends to."""
    factor = machine.values[row, 3]
    if machine.mode[row, 0] == 0 or factor == 0.0:
        return NONE, 0.0, 0.0
    parts = 1.0 if machine.mode[row, 0] == 1 else -1.0
    return VELOCITY, -parts * machine.values[row, 2], parts / factor


@inlined
def start_in_contact(machine: Machine, row: int, displacement: float, velocity: float) -> int:
    """Return the branch that a motion starts on: open 0, closed 1, parting without force 2."""
    side = machine.values[row, 2]
    if side * (displacement - machine.values[row, 1]) <= 0.0:
        return 0
    return 1 if 1.0 + machine.values[row, 3] * side * velocity > 0.0 else 2
