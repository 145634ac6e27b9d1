"""Friction that falls with velocity, and the bristles of LuGre."""

import math

from shakerproc.data import FloatArray
from shakerproc.models.compiled import inlined
from shakerproc.simulation.kernels.polynomials import product
from shakerproc.simulation.kernels.table import BASE, STATE, VELOCITY, Machine


@inlined
def stribeck(lines: FloatArray, row: int, scale: float, order: int) -> float:
    """Return the coefficient of exp(-(v / scale)^2); planes BASE and BASE + 1 are used."""
    square = product(lines, row, VELOCITY, VELOCITY, order)
    lines[row, BASE, order] = -square / (scale * scale)
    if order == 0:
        total = math.exp(lines[row, BASE, 0])
    else:
        total = 0.0
        for j in range(1, order + 1):
            total += j * lines[row, BASE, j] * lines[row, BASE + 1, order - j]
        total /= order
    lines[row, BASE + 1, order] = total
    return total


@inlined
def friction_level(machine: Machine, row: int, order: int, lines: FloatArray) -> float:
    """Return the friction level: sliding force and the rest of the breakaway force."""
    sliding, breakaway = machine.values[row, 0], machine.values[row, 1]
    level = sliding if order == 0 else 0.0
    if breakaway > sliding:
        fall = stribeck(lines, row, machine.values[row, 2], order)
        level += (breakaway - sliding) * fall
    return level


@inlined
def lugre(machine: Machine, row: int, order: int, lines: FloatArray) -> tuple[float, float]:
    """Return force and rate; plane BASE + 2 holds the level, BASE + 3 the relaxation."""
    stiffness, v = machine.values[row, 3], lines[row, VELOCITY, order]
    lines[row, BASE + 2, order] = friction_level(machine, row, order, lines)
    total = machine.mode[row, 0] * stiffness * v
    for j in range(1, order + 1):
        total -= lines[row, BASE + 2, j] * lines[row, BASE + 3, order - j]
    lines[row, BASE + 3, order] = total / lines[row, BASE + 2, 0]
    rate = v - product(lines, row, BASE + 3, STATE, order)
    force = stiffness * lines[row, STATE, order] + machine.values[row, 4] * rate
    return force + machine.values[row, 5] * v, rate
