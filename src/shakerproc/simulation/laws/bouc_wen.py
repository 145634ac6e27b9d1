"""The Bouc-Wen element, by its force or by its way back."""

import math
from typing import Final

from shakerproc.data import FloatArray
from shakerproc.models.compiled import inlined
from shakerproc.models.kernels import on_curve
from shakerproc.simulation.kernels.polynomials import power, product
from shakerproc.simulation.kernels.table import BASE, NO_CURVE, PLANES, STATE, VELOCITY, Machine

CHANGE: Final = 4.0
"""Change of an exponent or a power over a step up to which its series is trusted [-]."""

_RISE: Final = PLANES - 2
_GROWTH: Final = PLANES - 3


@inlined
def bouc_wen(machine: Machine, row: int, order: int, lines: FloatArray) -> tuple[float, float]:
    """Return the force, and the rate of the way back (see `laws.curve_back`).

    BASE holds the force, the last plane its power; where the branch back is a curve, the two
    before hold what that rises by the way back, and the way back by displacement.
    """
    mode, v, state = machine.mode[row, 0], lines[row, VELOCITY, order], lines[row, STATE, order]
    k, slip, exponent = machine.values[row, 0], machine.values[row, 1], machine.values[row, 2]
    share = machine.values[row, 4 if mode == 1 or mode == 2 else 3]
    curved, sign = machine.values[row, 5] != NO_CURVE, 1.0 if mode >= 2 else -1.0
    if not curved:
        if share == 0.0:
            return k * state, v
        lines[row, BASE, order] = sign * state / slip
    else:
        lines[row, BASE, order] = _on_curve(machine, row, order, sign / slip, lines)
    bend = power(lines, row, exponent, order)
    lines[row, PLANES - 1, order] = bend
    if not curved:
        return k * state, v - share * product(lines, row, PLANES - 1, VELOCITY, order)
    back, one = machine.values[row, 4], 1.0 if order == 0 else 0.0
    lines[row, _RISE, order] = one - back * bend
    force = sign * k * slip * lines[row, BASE, order]
    if share == back:
        return force, v
    total = one - share * bend
    for j in range(1, order + 1):
        total -= lines[row, _RISE, j] * lines[row, _GROWTH, order - j]
    lines[row, _GROWTH, order] = total / lines[row, _RISE, 0]
    return force, product(lines, row, _GROWTH, VELOCITY, order)


@inlined
def _on_curve(machine: Machine, row: int, order: int, unit: float, lines: FloatArray) -> float:
    """Return the coefficient of the force that a way back holds, over that of yield."""
    if order == 0:
        start, exponent = int(machine.values[row, 5]), machine.values[row, 2]
        return on_curve(machine.tables, start, unit * lines[row, STATE, 0], exponent)
    total = 0.0
    for j in range(order):
        total += (order - j) * lines[row, _RISE, j] * lines[row, STATE, order - j]
    return unit * total / order


@inlined
def stays_flat(
    machine: Machine, row: int, change: float, negligible: float, lines: FloatArray
) -> bool:
    """Return whether a way back changes so little, or a branch is so flat all the way."""
    unit = machine.values[row, 1] * machine.tables[int(machine.values[row, 5])]
    exponent, least = machine.values[row, 2], abs(lines[row, STATE, 0]) - change
    if exponent * change <= CHANGE * unit:
        return True
    return (
        machine.values[row, 0] * unit * math.exp(exponent * (1.0 - least / unit)) < negligible
    )
