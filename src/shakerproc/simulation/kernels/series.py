"""Taylor coefficients of the laws, order by order: the only list of their formulas.

Order 0 is the law itself, so the steppers that need no series call it too.
"""

import math
from typing import Final

from shakerproc.data import FloatArray
from shakerproc.models.compiled import inlined
from shakerproc.models.kernels import on_curve
from shakerproc.simulation.kernels.modes import iwan_slip, signed
from shakerproc.simulation.kernels.polynomials import cell, coefficient, origin
from shakerproc.simulation.kernels.table import (
    BASE,
    BOUC_WEN,
    CONSTANT,
    CONTACT_DAMPING,
    DISPLACEMENT,
    DRIFT,
    EVEN_POWER,
    FRICTION,
    HERTZ,
    IWAN,
    JENKINS,
    JUMP,
    LAW,
    LUGRE,
    NO_CURVE,
    ODD_POWER,
    PLANES,
    POWER_DAMPING,
    QUADRATIC_DAMPING,
    SERIES,
    STATE,
    STOP,
    TABLE,
    VELOCITY,
    Machine,
)

_CHANGE: Final = 4.0
_RISE: Final = PLANES - 2
_GROWTH: Final = PLANES - 3


@inlined
def product(lines: FloatArray, row: int, x: int, y: int, order: int) -> float:
    """Return the coefficient of this order of the product of two series of a line."""
    total = 0.0
    for j in range(order + 1):
        total += lines[row, x, j] * lines[row, y, order - j]
    return total


@inlined
def power(lines: FloatArray, row: int, exponent: float, order: int) -> float:
    """Return the coefficient of a power of the series in plane BASE of a line.

    Whole powers by squaring and multiplying; the planes after BASE hold what comes in
    between. Other powers, of the absolute value, by the recurrence of x y' = p x' y, which
    ends at 0.
    """
    whole = int(exponent)
    if exponent != whole:
        total = 0.0
        if order == 0:
            total = abs(lines[row, BASE, 0]) ** exponent
        else:
            for j in range(1, order + 1):
                share = (exponent + 1.0) * j - order
                total += share * lines[row, BASE, j] * lines[row, BASE + 1, order - j]
            total /= order * lines[row, BASE, 0]
        lines[row, BASE + 1, order] = total
        return total
    bit = 1
    while 2 * bit <= whole:
        bit *= 2
    plane = BASE
    bit //= 2
    while bit > 0:
        lines[row, plane + 1, order] = product(lines, row, plane, plane, order)
        plane += 1
        if whole & bit:
            lines[row, plane + 1, order] = product(lines, row, plane, BASE, order)
            plane += 1
        bit //= 2
    return lines[row, plane, order]


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
def law_series(
    machine: Machine, row: int, order: int, time: float, step: float, lines: FloatArray
) -> tuple[float, float]:
    """Return the coefficients of a line's force and of the rate of its state.

    The formula of the branch is used wherever the motion is: a stop that counts as closed
    pulls where it would have opened, until the stepper has found the instant of opening.

    Parameters
    ----------
    time, step : float
        Start and length of the step [s].
    lines : (r, PLANES, orders) array
        Series of displacement, velocity and state of the line, known up to this order; the
        planes from BASE on are written to.
    """
    law, mode = machine.lines[row, LAW], machine.mode[row, 0]
    k = machine.values[row, 0]
    z, v = lines[row, DISPLACEMENT, order], lines[row, VELOCITY, order]
    if law == STOP:
        shift = machine.values[row, 1] if order == 0 else 0.0
        return k * (z - shift) * mode, 0.0
    if law == FRICTION:
        return mode * _level(machine, row, order, lines), 0.0
    if law == JENKINS:
        return lines[row, STATE, order], (k * v if mode == 0 else 0.0)
    if law == JUMP:
        return k * z * mode, 0.0
    if law == CONTACT_DAMPING:
        return k * v * mode, 0.0
    if law == ODD_POWER or law == EVEN_POWER or law == POWER_DAMPING:
        return k * _power_law(machine, row, order, lines), 0.0
    if law == QUADRATIC_DAMPING:
        return k * mode * product(lines, row, VELOCITY, VELOCITY, order), 0.0
    if law == DRIFT:
        earlier = lines[row, DISPLACEMENT, order - 1] * step if order > 0 else 0.0
        return k * ((time - machine.values[row, 1]) * z + earlier), 0.0
    if law == IWAN:
        return _iwan(machine, row, order, lines), 0.0
    if law == LUGRE:
        return _lugre(machine, row, order, lines)
    if law == BOUC_WEN:
        return _bouc_wen(machine, row, order, lines)
    if law == CONSTANT:
        return (k if order == 0 else 0.0), 0.0
    if law == SERIES:
        return _elements_in_series(machine, row, order, lines)
    if law == HERTZ:
        return (_hertz(machine, row, order, lines) if mode == 1 else 0.0), 0.0
    if law == TABLE:
        return _tabulated(machine, row, order, lines), 0.0
    return math.nan, 0.0


@inlined
def _level(machine: Machine, row: int, order: int, lines: FloatArray) -> float:
    """Return the friction level: sliding force and the rest of the breakaway force."""
    sliding, breakaway = machine.values[row, 0], machine.values[row, 1]
    level = sliding if order == 0 else 0.0
    if breakaway > sliding:
        fall = stribeck(lines, row, machine.values[row, 2], order)
        level += (breakaway - sliding) * fall
    return level


@inlined
def _power_law(machine: Machine, row: int, order: int, lines: FloatArray) -> float:
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


@inlined
def _hertz(machine: Machine, row: int, order: int, lines: FloatArray) -> float:
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
def _elements_in_series(
    machine: Machine, row: int, order: int, lines: FloatArray
) -> tuple[float, float]:
    """Return the force, and the rate of the extension of spring and play together."""
    mode, v = machine.mode[row, 0], lines[row, VELOCITY, order]
    if mode == 0:
        return 0.0, v
    if mode == 2 or mode == -2:
        return (0.5 * mode * machine.values[row, 3] if order == 0 else 0.0), 0.0
    beyond = lines[row, STATE, order]
    if order == 0:
        beyond -= machine.values[row, 1] if mode == 1 else -machine.values[row, 2]
    force = machine.values[row, 0] * beyond
    return force, v - machine.values[row, 4] * force


@inlined
def _iwan(machine: Machine, row: int, order: int, lines: FloatArray) -> float:
    stiffness, mode = machine.values[row, 0], machine.mode[row, 0]
    direction = 1.0 if mode > 0 else -1.0
    if mode == 2 or mode == -2:
        return iwan_slip(machine, row, direction) if order == 0 else 0.0
    if machine.values[row, 2] != 2.0:
        return _power_iwan(machine, row, order, direction, lines)
    way = lines[row, DISPLACEMENT, order]
    force = 0.0
    if order == 0:
        way -= machine.anchor[row, 0]
        force = machine.anchor[row, 1]
    lines[row, BASE, order] = way
    square = product(lines, row, BASE, BASE, order)
    return force + stiffness * (way - direction * square / machine.anchor[row, 3])


@inlined
def _power_iwan(
    machine: Machine, row: int, order: int, direction: float, lines: FloatArray
) -> float:
    """Return the force of a branch that bends as a power: it has no series where it starts."""
    exponent, reach = machine.values[row, 2] - 1.0, 0.5 * machine.anchor[row, 3]
    share = lines[row, DISPLACEMENT, order]
    force = 0.0
    if order == 0:
        share -= machine.anchor[row, 0]
        force = machine.anchor[row, 1]
    lines[row, BASE, order] = direction * share / reach
    lines[row, PLANES - 1, order] = power(lines, row, exponent, order)
    slipped = product(lines, row, BASE, PLANES - 1, order) / (exponent + 1.0)
    scale = direction * machine.values[row, 0] * reach
    return force + scale * (lines[row, BASE, order] - slipped)


@inlined
def _tabulated(machine: Machine, row: int, order: int, lines: FloatArray) -> float:
    """Return the force by the polynomial of the cell that the motion is in at order 0.

    The planes from BASE on hold displacement and velocity from the origin of the cell, their
    squares and cubes, and what the powers of displacement are multiplied by.
    """
    i = cell(machine, row, 0, lines[row, DISPLACEMENT, 0])
    j = cell(machine, row, 1, lines[row, VELOCITY, 0])
    for kind in range(2):
        first = BASE + 3 * kind
        lines[row, first, order] = lines[row, DISPLACEMENT + kind, order]
        if order == 0:
            lines[row, first, 0] -= origin(machine, row, kind, j if kind == 1 else i)
        lines[row, first + 1, order] = product(lines, row, first, first, order)
        lines[row, first + 2, order] = product(lines, row, first, first + 1, order)
    total = 0.0
    for p in range(4):
        along = coefficient(machine, row, i, j, p, 0) if order == 0 else 0.0
        for q in range(1, 4):
            along += coefficient(machine, row, i, j, p, q) * lines[row, BASE + 2 + q, order]
        lines[row, BASE + 6 + p, order] = along
        if p == 0:
            total += along
        else:
            total += product(lines, row, BASE + p - 1, BASE + 6 + p, order)
    return total


@inlined
def _lugre(machine: Machine, row: int, order: int, lines: FloatArray) -> tuple[float, float]:
    """Return force and rate; plane BASE + 2 holds the level, BASE + 3 the relaxation."""
    stiffness, v = machine.values[row, 3], lines[row, VELOCITY, order]
    lines[row, BASE + 2, order] = _level(machine, row, order, lines)
    total = machine.mode[row, 0] * stiffness * v
    for j in range(1, order + 1):
        total -= lines[row, BASE + 2, j] * lines[row, BASE + 3, order - j]
    lines[row, BASE + 3, order] = total / lines[row, BASE + 2, 0]
    rate = v - product(lines, row, BASE + 3, STATE, order)
    force = stiffness * lines[row, STATE, order] + machine.values[row, 4] * rate
    return force + machine.values[row, 5] * v, rate


@inlined
def _bouc_wen(machine: Machine, row: int, order: int, lines: FloatArray) -> tuple[float, float]:
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
def trusted_share(
    machine: Machine, row: int, order: int, negligible: float, lines: FloatArray
) -> float:
    """Return the share of a step in which small first terms mean small later ones.

    The terms of exp(q) and of x^n rise until the order reaches the change of q, or n times
    the relative change of x; where they start from next to nothing, the series would seem to
    have converged long before. So that change is held to 4, unless the law does not matter. A
    branch that saturates nears its end like exp(-n u).

    Parameters
    ----------
    negligible : float
        Force that does not matter [N].
    """
    law, share = machine.lines[row, LAW], 1.0
    falls = law == LUGRE or law == FRICTION
    powers = law == ODD_POWER or law == EVEN_POWER or law == POWER_DAMPING or law == BOUC_WEN
    curved = law == BOUC_WEN and machine.values[row, 5] != NO_CURVE
    tame = machine.values[row, 2] <= _CHANGE and not curved
    if falls:
        tame = machine.values[row, 1] == machine.values[row, 0]
    if tame or not (falls or powers):
        return 1.0
    plane = STATE if curved else BASE
    while share > 1e-4:
        change, factor = 0.0, share
        for k in range(1, order):
            change += abs(lines[row, plane, k]) * factor
            factor *= share
        if curved:
            if _stays_flat(machine, row, change, negligible, lines):
                return share
        elif falls:
            highest = lines[row, BASE, 0] + change
            excess = machine.values[row, 1] - machine.values[row, 0]
            if change <= _CHANGE or excess * math.exp(min(highest, 0.0)) < negligible:
                return share
        else:
            here, exponent = abs(lines[row, BASE, 0]), machine.values[row, 2]
            if change * exponent <= _CHANGE * (here + change):
                return share
            force = abs(machine.values[row, 0]) * (here + change) ** exponent
            if (law == ODD_POWER or law == EVEN_POWER) and force < negligible:
                return share
        share *= 0.7
    return share


@inlined
def _stays_flat(
    machine: Machine, row: int, change: float, negligible: float, lines: FloatArray
) -> bool:
    """Return whether a way back changes so little, or a branch is so flat all the way."""
    unit = machine.values[row, 1] * machine.tables[int(machine.values[row, 5])]
    exponent, least = machine.values[row, 2], abs(lines[row, STATE, 0]) - change
    if exponent * change <= _CHANGE * unit:
        return True
    return (
        machine.values[row, 0] * unit * math.exp(exponent * (1.0 - least / unit)) < negligible
    )
