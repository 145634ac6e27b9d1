"""The Iwan element: branches between turning points, and their memory."""

from shakerproc.data import FloatArray
from shakerproc.models.compiled import inlined, inner
from shakerproc.simulation.kernels.polynomials import power, product
from shakerproc.simulation.kernels.table import BASE, DISPLACEMENT, PLANES, STACK, Machine


@inlined
def iwan(machine: Machine, row: int, order: int, lines: FloatArray) -> float:
    """Return the coefficient of the force on the present branch: of all slips, or a curve."""
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


@inner
def start_iwan(
    machine: Machine, row: int, displacement: float, direction: int, state: float
) -> None:
    """Start an Iwan line on first loading, as far from its rest as its state says."""
    side = direction
    if state != 0.0:
        side = 1 if state > 0.0 else -1
    beyond = abs(state) >= machine.values[row, 1]
    machine.mode[row, 0] = 2 * side if beyond else side
    machine.mode[row, 1] = 0
    machine.anchor[row, 0] = displacement - state
    machine.anchor[row, 1] = 0.0
    _set_iwan_limit(machine, row)
    if side != direction:
        turn_iwan(machine, row, displacement)


@inlined
def iwan_force(machine: Machine, row: int, displacement: float) -> float:
    """Return the force on the present branch of an Iwan line [N]."""
    stiffness, mode = machine.values[row, 0], machine.mode[row, 0]
    direction = 1.0 if mode > 0 else -1.0
    if mode == 2 or mode == -2:
        return iwan_slip(machine, row, direction)
    way = displacement - machine.anchor[row, 0]
    power = machine.values[row, 2]
    if power == 2.0:
        share = 1.0 - direction * way / machine.anchor[row, 3]
    else:
        slipped = 2.0 * abs(way) / machine.anchor[row, 3]
        share = 1.0 - slipped ** (power - 1.0) / power
    return machine.anchor[row, 1] + stiffness * way * share


@inlined
def iwan_slip(machine: Machine, row: int, direction: float) -> float:
    """Return the force of an Iwan line of which all slips [N]."""
    power = machine.values[row, 2]
    return direction * machine.values[row, 0] * machine.values[row, 1] * (power - 1.0) / power


@inner
def turn_iwan(machine: Machine, row: int, displacement: float) -> None:
    """Remember a turning point and start the branch that leads back from it.

    The stack starts with the mirror image of the first turning point, where a return would
    meet first loading again, so that the first loop closes like all others.
    """
    force = iwan_force(machine, row, displacement)
    mode, count = machine.mode[row, 0], machine.mode[row, 1]
    if count == 0:
        middle = machine.anchor[row, 0]
        if mode == 2 or mode == -2:
            middle = displacement - 0.5 * mode * machine.values[row, 1]
        machine.stack[row, 0, 0] = 2.0 * middle - displacement
        machine.stack[row, 1, 0] = -force
        count = 1
    if count == STACK:
        count = _forget_smallest_loop(machine, row, count)
    machine.stack[row, 0, count] = displacement
    machine.stack[row, 1, count] = force
    machine.mode[row, 0] = -1 if mode > 0 else 1
    machine.mode[row, 1] = count + 1
    machine.anchor[row, 0] = displacement
    machine.anchor[row, 1] = force
    _set_iwan_limit(machine, row)


@inner
def close_iwan(machine: Machine, row: int) -> None:
    """Go on along the branch around the loop that closed, or slip fully."""
    count = machine.mode[row, 1]
    way = abs(machine.anchor[row, 2] - machine.anchor[row, 0])
    if way >= 0.5 * machine.anchor[row, 3] * (1.0 - 1e-12):
        machine.mode[row, 0] = 2 if machine.mode[row, 0] > 0 else -2
        machine.mode[row, 1] = 0
        return
    count -= 2
    if count <= 1:  # what is around it is first loading
        middle = 0.5 * (machine.stack[row, 0, 0] + machine.stack[row, 0, 1])
        machine.anchor[row, 0] = middle
        machine.anchor[row, 1] = 0.0
        count = 0
    else:
        machine.anchor[row, 0] = machine.stack[row, 0, count - 1]
        machine.anchor[row, 1] = machine.stack[row, 1, count - 1]
    machine.mode[row, 1] = count
    _set_iwan_limit(machine, row)


@inner
def _set_iwan_limit(machine: Machine, row: int) -> None:
    """Set where the present branch of an Iwan line ends, and its scale.

    On first loading the scale is 2 z_s and full slip at z_s; on a later branch both are twice
    that, and the branch ends earlier where it closes the loop around it.
    """
    slip = machine.values[row, 1]
    direction = 1.0 if machine.mode[row, 0] > 0 else -1.0
    count, here = machine.mode[row, 1], machine.anchor[row, 0]
    scale = slip if count == 0 else 2.0 * slip
    limit = here + direction * scale
    if count >= 2:
        closing = machine.stack[row, 0, count - 2]
        if direction * (closing - limit) < 0.0:
            limit = closing
    machine.anchor[row, 2] = limit
    machine.anchor[row, 3] = 2.0 * scale


@inner
def _forget_smallest_loop(machine: Machine, row: int, count: int) -> int:
    """Drop the two neighbouring turning points closest to each other; return the count."""
    best, smallest = 2, 1e300  # the first two hold the middle of first loading
    for i in range(2, count - 1):
        size = abs(machine.stack[row, 0, i + 1] - machine.stack[row, 0, i])
        if size < smallest:
            best, smallest = i, size
    for i in range(best, count - 2):
        machine.stack[row, 0, i] = machine.stack[row, 0, i + 2]
        machine.stack[row, 1, i] = machine.stack[row, 1, i + 2]
    return count - 2
