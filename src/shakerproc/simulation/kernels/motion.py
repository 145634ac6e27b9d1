"""Accelerations of the whole model, sticking joints held; the motion after an event."""

from typing import Final

from shakerproc.data import FloatArray
from shakerproc.models.compiled import inlined, inner
from shakerproc.simulation.kernels.table import (
    DISPLACEMENT,
    FRICTION,
    HOLDING,
    JENKINS,
    LAW,
    MEMORY,
    SERIES,
    STATE,
    VELOCITY,
    Machine,
    MotionSeries,
)
from shakerproc.simulation.laws.elements_in_series import series_limit, series_slip
from shakerproc.simulation.laws.table import follow, law_series, start

IRRESISTIBLE: Final = 1e100
"""Force for a unit of acceleration across a joint whose motion is imposed [kg]."""


@inlined
def between(
    machine: Machine, row: int, motions: FloatArray, start_at: int, order: int
) -> float:
    """Return the difference of the two places of a line, of one coefficient."""
    total = 0.0
    for i in range(machine.joints.shape[1]):
        total += machine.joints[row, i] * motions[start_at + i, order]
    return total


@inlined
def push(
    machine: Machine, row: int, amount: float, motions: FloatArray, start_at: int, order: int
) -> None:
    """Add the accelerations of a force across a line, which resists motion, in one order."""
    for i in range(machine.pushes.shape[1]):
        motions[start_at + i, order] -= amount * machine.pushes[row, i]


@inlined
def push_and_read(machine: Machine, row: int, amount: float, a: FloatArray, order: int) -> None:
    """Push the accelerations, and add to the force that is read."""
    push(machine, row, amount, a, 0, order)
    if machine.reads >= 0:
        a[machine.mass.size, order] += amount * machine.joints[row, machine.reads]


@inlined
def read_linear(machine: Machine, order: int, series: MotionSeries) -> None:
    """Set the force that is read to that of the linear part alone."""
    n = machine.mass.size
    if machine.reads >= 0:
        total = machine.reading[0, 2 * n] * series.w[order]
        for j in range(2 * n):
            total += machine.reading[0, j] * series.y[j, order]
        series.a[n, order] = total


@inlined
def mobility(machine: Machine, row: int, other: int) -> float:
    """Return the relative acceleration across a line for a unit force in another [1/kg]."""
    total = 0.0
    for i in range(machine.pushes.shape[1]):
        total += machine.joints[row, i] * machine.pushes[other, i]
    return total


@inlined
def sticks(machine: Machine, row: int) -> bool:
    """Return whether a line is a friction at rest."""
    return machine.lines[row, LAW] == FRICTION and machine.mode[row, 0] == 0


@inlined
def accelerate_here(
    machine: Machine, time: float, step: float, order: int, series: MotionSeries
) -> None:
    """Set one order of the accelerations, of the rates of the states, and of all lines.

    The rates go where the next order of the states will be.
    """
    n, n_lines = machine.mass.size, machine.lines.shape[0]
    for i in range(n):
        total = machine.matrix[i, 2 * n] * series.w[order]
        for j in range(2 * n):
            total += machine.matrix[i, j] * series.y[j, order]
        series.a[i, order] = total
    read_linear(machine, order, series)
    held = 0
    for row in range(n_lines):
        series.lines[row, DISPLACEMENT, order] = between(machine, row, series.y, 0, order)
        series.lines[row, VELOCITY, order] = between(machine, row, series.y, n, order)
        series.lines[row, HOLDING, order] = 0.0
        if sticks(machine, row):
            held += 1
            continue
        state = machine.lines[row, MEMORY]
        if state >= 0:
            series.lines[row, STATE, order] = series.y[2 * n + state, order]
        force, rate = law_series(machine, row, order, time, step, series.lines)
        if force != 0.0:  # most laws that are open, and most orders of the others, have none
            push_and_read(machine, row, force, series.a, order)
        if state >= 0:
            series.y[2 * n + state, order + 1] = rate
    if held > 0:
        hold(machine, held, order, series)


@inlined
def finish_line(machine: Machine, row: int, order: int, series: MotionSeries) -> None:
    """Set the last order of a line, which has no force any more.

    Switchings are then found on the very series that carries the motion: one that ended an
    order sooner would leave the motion a little off the surface, to be crossed once more.
    """
    series.lines[row, DISPLACEMENT, order] = between(machine, row, series.y, 0, order)
    series.lines[row, VELOCITY, order] = between(
        machine, row, series.y, machine.mass.size, order
    )
    series.lines[row, HOLDING, order] = 0.0
    state = machine.lines[row, MEMORY]
    if state >= 0:
        series.lines[row, STATE, order] = series.y[2 * machine.mass.size + state, order]


@inner
def accelerate(
    machine: Machine, time: float, step: float, order: int, series: MotionSeries
) -> None:
    """Do as `accelerate_here`, by a call."""
    accelerate_here(machine, time, step, order, series)


@inner
def hold(machine: Machine, held: int, order: int, series: MotionSeries) -> None:
    """Take the relative acceleration out of every sticking line: one linear system."""
    system, stuck = series.system, series.stuck
    i = 0
    for row in range(machine.lines.shape[0]):
        if sticks(machine, row):
            stuck[i] = row
            i += 1
    for i in range(held):
        system[i, held] = between(machine, stuck[i], series.a, 0, order)
        for j in range(held):
            system[i, j] = mobility(machine, stuck[i], stuck[j])
    for i in range(held):
        if system[i, i] == 0.0:  # no force holds a joint whose motion is imposed
            system[i, i] = 1.0 / IRRESISTIBLE if system[i, held] != 0.0 else 1.0
        for k in range(i + 1, held):
            factor = system[k, i] / system[i, i]
            for j in range(i, held + 1):
                system[k, j] -= factor * system[i, j]
    for i in range(held - 1, -1, -1):
        for j in range(i + 1, held):
            system[i, held] -= system[i, j] * system[j, held]
        system[i, held] /= system[i, i]
        series.lines[stuck[i], HOLDING, order] = system[i, held]
        push_and_read(machine, stuck[i], system[i, held], series.a, order)


@inner
def begin(machine: Machine, series: MotionSeries) -> None:
    """Set the branch of every line from the motion in order 0."""
    n = machine.mass.size
    for row in range(machine.lines.shape[0]):
        displacement = between(machine, row, series.y, 0, 0)
        velocity = between(machine, row, series.y, n, 0)
        memory = machine.lines[row, MEMORY]
        state = series.y[2 * n + memory, 0] if memory >= 0 else 0.0
        start(machine, row, displacement, velocity, state)
    settle(machine, 0.0, series)


@inner
def switch(machine: Machine, row: int, which: int, time: float, series: MotionSeries) -> None:
    """Follow the event of a line, the motion in order 0, and settle every sticking joint."""
    n = machine.mass.size
    law, before = machine.lines[row, LAW], machine.mode[row, 0]
    follow(machine, row, which, between(machine, row, series.y, 0, 0))
    if before != 0 and (law == FRICTION or law == JENKINS):
        _take_away(machine, row, between(machine, row, series.y, n, 0), series)
    elif law == JENKINS:
        limit = machine.values[row, 1] * machine.mode[row, 0]
        series.y[2 * n + machine.lines[row, MEMORY], 0] = limit
    elif law == SERIES:
        _slip(machine, row, before, series)
    settle(machine, time, series)


@inner
def _slip(machine: Machine, row: int, before: int, series: MotionSeries) -> None:
    """Set the state exactly where the slider of a series starts to slip, or stands."""
    n, mode = machine.mass.size, machine.mode[row, 0]
    side = 1.0 if mode > 0 else -1.0
    if mode == 2 or mode == -2:
        limit = side * series_limit(machine, row, side)
        series.y[2 * n + machine.lines[row, MEMORY], 0] = limit
    elif before == 2 or before == -2:
        left = between(machine, row, series.y, n, 0) - side * series_slip(machine, row)
        _take_away(machine, row, left, series)


@inner
def _take_away(machine: Machine, row: int, velocity: float, series: MotionSeries) -> None:
    """Take the rounding error of a velocity away where a slider stops [m/s].

    Where the motion is imposed there is none: no push moves the joint.
    """
    if mobility(machine, row, row) > 0.0:
        push(
            machine, row, velocity / mobility(machine, row, row), series.y, machine.mass.size, 0
        )


@inner
def settle(machine: Machine, time: float, series: MotionSeries) -> None:
    """Let the joints slide that stick although more than their breakaway force is on them.

    The one that is overloaded most goes first, since that unloads the others.
    """
    n_lines = machine.lines.shape[0]
    for _ in range(n_lines):
        held = 0
        for row in range(n_lines):
            if sticks(machine, row):
                held += 1
        if held == 0:
            return
        accelerate(machine, time, 0.0, 0, series)
        worst, excess = -1, 1e-12
        for row in range(n_lines):
            if sticks(machine, row):
                over = abs(series.lines[row, HOLDING, 0]) / machine.values[row, 1] - 1.0
                if over > excess:
                    worst, excess = row, over
        if worst < 0:
            return
        machine.mode[worst, 0] = 1 if series.lines[worst, HOLDING, 0] > 0.0 else -1
