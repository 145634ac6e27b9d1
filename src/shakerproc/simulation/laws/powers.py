"""Powers of displacement, odd and even, and of damping."""

import math

from shakerproc.data import FloatArray
from shakerproc.models.compiled import inlined
from shakerproc.simulation.kernels.polynomials import power, product
from shakerproc.simulation.kernels.table import (
    BASE,
    DISPLACEMENT,
    EVEN_POWER,
    LAW,
    ODD_POWER,
    PLANES,
    POWER_DAMPING,
    VELOCITY,
    Machine,
)


@inlined
def signed(law: int, exponent: float) -> bool:
    """Return whether a power law changes its formula with the sign of displacement."""
    if law == ODD_POWER:
        half = 0.5 * (exponent - 1.0)
        return half != math.floor(half)  # a remainder takes as long as all else in an order
    if law == EVEN_POWER or law == POWER_DAMPING:
        half = 0.5 * exponent
        return half != math.floor(half)
    return False


@inlined
def power_law(machine: Machine, row: int, order: int, lines: FloatArray) -> float:
    """Return the coefficient of a power of displacement, times velocity where it damps."""
    law, mode = machine.lines[row, LAW], machine.mode[row, 0]
    exponent = machine.values[row, 2]
    lines[row, BASE, order] = lines[row, DISPLACEMENT, order] / machine.values[row, 1]
    result = power(lines, row, exponent, order)
    if exponent != int(exponent):
        result *= mode if law == ODD_POWER else 1
    elif signed(law, exponent):
        result *= mode
    if law == POWER_DAMPING:
        lines[row, PLANES - 1, order] = result
        result = product(lines, row, PLANES - 1, VELOCITY, order)
    return result
