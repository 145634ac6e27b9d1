"""Branches of the laws: their ends, and the branch that follows."""

import math
from typing import Final

from shakerproc.models.compiled import inlined, inner
from shakerproc.simulation.kernels.polynomials import region_of, table_event
from shakerproc.simulation.kernels.table import (
    BOUC_WEN,
    CONSTANT,
    CONTACT_DAMPING,
    DISPLACEMENT,
    EVEN_POWER,
    FRICTION,
    HERTZ,
    HOLDING,
    IWAN,
    JENKINS,
    JUMP,
    LAW,
    LUGRE,
    ODD_POWER,
    POWER_DAMPING,
    QUADRATIC_DAMPING,
    SERIES,
    STACK,
    STATE,
    STOP,
    TABLE,
    VELOCITY,
    Machine,
)

NONE: Final = -1


@inlined
def wall(law: int) -> bool:
    """Return whether a law has a wall: open on one side of it, closed on the other."""
    return law == STOP or law == JUMP or law == CONTACT_DAMPING


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
def event(machine: Machine, row: int, which: int) -> tuple[int, float, float]:
    """Return quantity, sign and level of the event that ends the branch a line is on.

    The branch ends when ``sign * quantity - level`` rises above 0. There are at most two such
    events for a line (`which` 0 and 1); a quantity of NONE says that there is no such event.
    """
    law, mode = machine.lines[row, LAW], machine.mode[row, 0]
    if law == FRICTION or law == JENKINS:
        if mode == 0:
            kind = HOLDING if law == FRICTION else STATE
            return kind, 1.0 - 2.0 * which, machine.values[row, 1]
        return (VELOCITY if which == 0 else NONE), -1.0 * mode, 0.0
    if law == BOUC_WEN:
        if which == 0:
            return VELOCITY, (1.0 if mode == 0 or mode == 2 else -1.0), 0.0
        return STATE, (1.0 if mode < 2 else -1.0), 0.0
    if law == IWAN:
        direction = 1.0 if mode > 0 else -1.0
        if which == 0:
            return VELOCITY, -direction, 0.0
        kind = NONE if mode == 2 or mode == -2 else DISPLACEMENT
        return kind, direction, direction * machine.anchor[row, 2]
    if law == SERIES:
        return _event_in_series(machine, row, which)
    if law == TABLE:
        return table_event(machine, row, which)
    if law == HERTZ and which == 1:
        return _event_of_parting(machine, row)
    if which == 1:
        return NONE, 0.0, 0.0
    if wall(law) or law == HERTZ:
        side = machine.values[row, 2] * (1.0 if mode == 0 else -1.0)
        return DISPLACEMENT, side, side * machine.values[row, 1]
    if law == QUADRATIC_DAMPING or law == LUGRE:
        return VELOCITY, -1.0 * mode, 0.0
    if signed(law, machine.values[row, 2]):
        return DISPLACEMENT, -1.0 * mode, 0.0
    return NONE, 0.0, 0.0


@inlined
def _event_of_parting(machine: Machine, row: int) -> tuple[int, float, float]:
    """Return when a Hertz contact starts to part faster than it recovers, or ends to."""
    factor = machine.values[row, 3]
    if machine.mode[row, 0] == 0 or factor == 0.0:
        return NONE, 0.0, 0.0
    parts = 1.0 if machine.mode[row, 0] == 1 else -1.0
    return VELOCITY, -parts * machine.values[row, 2], parts / factor


@inlined
def series_limit(machine: Machine, row: int, side: float) -> float:
    """Return the extension of play and spring at which the slider of a series slips [m]."""
    play = machine.values[row, 1] if side > 0.0 else machine.values[row, 2]
    return play + machine.values[row, 3] / machine.values[row, 0]


@inlined
def series_slip(machine: Machine, row: int) -> float:
    """Return the velocity below which the slider of a series, at its force, stands [m/s]."""
    return machine.values[row, 3] * machine.values[row, 4]


@inlined
def _event_in_series(machine: Machine, row: int, which: int) -> tuple[int, float, float]:
    """Return an event as `event` does; branches: open 0, closed +-1, slipping +-2."""
    mode = machine.mode[row, 0]
    if mode == 0:
        return STATE, 1.0 - 2.0 * which, machine.values[row, 1 + which]
    side = 1.0 if mode > 0 else -1.0
    if mode == 2 or mode == -2:
        return (VELOCITY if which == 0 else NONE), -side, -series_slip(machine, row)
    if which == 0:
        return STATE, side, series_limit(machine, row, side)
    return STATE, -side, -(machine.values[row, 1] if mode > 0 else machine.values[row, 2])


@inner
def start(
    machine: Machine, row: int, displacement: float, velocity: float, state: float
) -> None:
    """Set the branch that a line starts on, with no memory of earlier motion but its state."""
    law = machine.lines[row, LAW]
    direction = 1 if velocity >= 0.0 else -1
    mode = direction
    if wall(law):
        beyond = machine.values[row, 2] * (displacement - machine.values[row, 1])
        mode = 1 if beyond > 0.0 else 0
    elif law == ODD_POWER or law == EVEN_POWER or law == POWER_DAMPING:
        mode = 1 if displacement >= 0.0 else -1
    elif law == JENKINS or (law == FRICTION and velocity == 0.0):
        mode = 0
    elif law == BOUC_WEN:
        up = 1 if direction > 0 else 0
        mode = up + (2 if state > 0.0 or (state == 0.0 and up == 1) else 0)
    elif law == CONSTANT:
        mode = 0
    elif law == SERIES:
        mode = _start_in_series(machine, row, state)
    elif law == HERTZ:
        mode = _start_in_contact(machine, row, displacement, velocity)
    elif law == TABLE:
        mode = region_of(machine, row, displacement, velocity)
    machine.mode[row, 0] = mode
    if law == IWAN:
        _start_iwan(machine, row, displacement, direction, state)


@inner
def _start_iwan(
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
        _turn_iwan(machine, row, displacement)


@inlined
def _start_in_contact(machine: Machine, row: int, displacement: float, velocity: float) -> int:
    side = machine.values[row, 2]
    if side * (displacement - machine.values[row, 1]) <= 0.0:
        return 0
    return 1 if 1.0 + machine.values[row, 3] * side * velocity > 0.0 else 2


@inlined
def _start_in_series(machine: Machine, row: int, state: float) -> int:
    if state > machine.values[row, 1]:
        return 1
    return -1 if -state > machine.values[row, 2] else 0


@inner
def follow(machine: Machine, row: int, which: int, displacement: float) -> None:
    """Take a line to the branch after the event `which`."""
    law, mode = machine.lines[row, LAW], machine.mode[row, 0]
    if wall(law):
        machine.mode[row, 0] = 1 - mode
    elif law == FRICTION or law == JENKINS:
        machine.mode[row, 0] = 1 - 2 * which if mode == 0 else 0
    elif law == BOUC_WEN:
        machine.mode[row, 0] = mode ^ (which + 1)
    elif law == SERIES:
        machine.mode[row, 0] = _after_in_series(machine, row, which)
    elif law == HERTZ:
        machine.mode[row, 0] = 1 if mode == 0 else which * (3 - mode)
    elif law == TABLE:
        top = int(machine.values[row, 3])
        machine.mode[row, 0] = mode + (1 if which == 0 and mode < top else -1)
    elif law == IWAN:
        if which == 0:
            _turn_iwan(machine, row, displacement)
        else:
            _close_iwan(machine, row)
    else:
        machine.mode[row, 0] = -mode


@inlined
def _after_in_series(machine: Machine, row: int, which: int) -> int:
    mode = machine.mode[row, 0]
    if mode == 0:
        return 1 - 2 * which
    if mode == 2 or mode == -2:
        return mode // 2
    if which == 0:
        return 2 * mode
    return 0 if machine.values[row, 1] + machine.values[row, 2] > 0.0 else -mode


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
def _turn_iwan(machine: Machine, row: int, displacement: float) -> None:
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
def _close_iwan(machine: Machine, row: int) -> None:
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
