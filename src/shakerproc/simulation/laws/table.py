"""Force, event, start and follower of every law: the one table that the steppers ask.

Each law has a file beside this one; laws of one line stand here alone. Order 0 of a series is
the law itself, so the steppers that need no series call it too.
"""

import math

from shakerproc.data import FloatArray
from shakerproc.models.compiled import inlined, inner
from shakerproc.simulation.kernels.polynomials import product
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
    HOLDING,
    IWAN,
    JENKINS,
    JUMP,
    LAW,
    LUGRE,
    NO_CURVE,
    NONE,
    ODD_POWER,
    POWER_DAMPING,
    QUADRATIC_DAMPING,
    SERIES,
    STATE,
    STOP,
    TABLE,
    VELOCITY,
    Machine,
)
from shakerproc.simulation.laws.bouc_wen import CHANGE, bouc_wen, stays_flat
from shakerproc.simulation.laws.elements_in_series import (
    after_in_series,
    elements_in_series,
    event_in_series,
    start_in_series,
)
from shakerproc.simulation.laws.friction import friction_level, lugre
from shakerproc.simulation.laws.hertz import event_of_parting, hertz, start_in_contact
from shakerproc.simulation.laws.iwan import close_iwan, iwan, start_iwan, turn_iwan
from shakerproc.simulation.laws.powers import power_law, signed
from shakerproc.simulation.laws.tabulated import region_of, table_event, tabulated


@inlined
def wall(law: int) -> bool:
    """Return whether a law has a wall: open on one side of it, closed on the other."""
    return law == STOP or law == JUMP or law == CONTACT_DAMPING


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
        return mode * friction_level(machine, row, order, lines), 0.0
    if law == JENKINS:
        return lines[row, STATE, order], (k * v if mode == 0 else 0.0)
    if law == JUMP:
        return k * z * mode, 0.0
    if law == CONTACT_DAMPING:
        return k * v * mode, 0.0
    if law == ODD_POWER or law == EVEN_POWER or law == POWER_DAMPING:
        return k * power_law(machine, row, order, lines), 0.0
    if law == QUADRATIC_DAMPING:
        return k * mode * product(lines, row, VELOCITY, VELOCITY, order), 0.0
    if law == DRIFT:
        earlier = lines[row, DISPLACEMENT, order - 1] * step if order > 0 else 0.0
        return k * ((time - machine.values[row, 1]) * z + earlier), 0.0
    if law == IWAN:
        return iwan(machine, row, order, lines), 0.0
    if law == LUGRE:
        return lugre(machine, row, order, lines)
    if law == BOUC_WEN:
        return bouc_wen(machine, row, order, lines)
    if law == CONSTANT:
        return (k if order == 0 else 0.0), 0.0
    if law == SERIES:
        return elements_in_series(machine, row, order, lines)
    if law == HERTZ:
        return (hertz(machine, row, order, lines) if mode == 1 else 0.0), 0.0
    if law == TABLE:
        return tabulated(machine, row, order, lines), 0.0
    return math.nan, 0.0


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
        return event_in_series(machine, row, which)
    if law == TABLE:
        return table_event(machine, row, which)
    if law == HERTZ and which == 1:
        return event_of_parting(machine, row)
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
        mode = start_in_series(machine, row, state)
    elif law == HERTZ:
        mode = start_in_contact(machine, row, displacement, velocity)
    elif law == TABLE:
        mode = region_of(machine, row, displacement, velocity)
    machine.mode[row, 0] = mode
    if law == IWAN:
        start_iwan(machine, row, displacement, direction, state)


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
        machine.mode[row, 0] = after_in_series(machine, row, which)
    elif law == HERTZ:
        machine.mode[row, 0] = 1 if mode == 0 else which * (3 - mode)
    elif law == TABLE:
        top = int(machine.values[row, 3])
        machine.mode[row, 0] = mode + (1 if which == 0 and mode < top else -1)
    elif law == IWAN:
        if which == 0:
            turn_iwan(machine, row, displacement)
        else:
            close_iwan(machine, row)
    else:
        machine.mode[row, 0] = -mode


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
    tame = machine.values[row, 2] <= CHANGE and not curved
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
            if stays_flat(machine, row, change, negligible, lines):
                return share
        elif falls:
            highest = lines[row, BASE, 0] + change
            excess = machine.values[row, 1] - machine.values[row, 0]
            if change <= CHANGE or excess * math.exp(min(highest, 0.0)) < negligible:
                return share
        else:
            here, exponent = abs(lines[row, BASE, 0]), machine.values[row, 2]
            if change * exponent <= CHANGE * (here + change):
                return share
            force = abs(machine.values[row, 0]) * (here + change) ** exponent
            if (law == ODD_POWER or law == EVEN_POWER) and force < negligible:
                return share
        share *= 0.7
    return share
