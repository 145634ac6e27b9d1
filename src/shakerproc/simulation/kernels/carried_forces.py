"""Forces of laws that are carried over a sample as quintics, and states that follow them."""

from typing import Final, NamedTuple

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models.compiled import inlined, inner
from shakerproc.simulation.kernels.motion import between, sticks
from shakerproc.simulation.kernels.table import (
    DISPLACEMENT,
    FORCE_TERMS,
    MEMORY,
    STATE,
    VELOCITY,
    Machine,
    MotionSeries,
    Store,
)
from shakerproc.simulation.laws.table import law_series

SERIES_TERMS: Final = 4
"""Terms of its series by which a law is predicted where nothing came before."""

FROM: Final = 0  # rows of `y`
END: Final = 1
FREE: Final = 2
INPUT: Final = 3

FORCE: Final = 0  # planes of `law`: force and rate, their slopes by the state
RATE: Final = 1
FORCE_BY_STATE: Final = 2
RATE_BY_STATE: Final = 3


class CarriedForces(NamedTuple):
    """Room for forces over a part of a sample, by the share of it that has passed.

    Attributes
    ----------
    force, rate : (m, 6) and (m, 4) array
        Coefficients of each carried force [N], and of the rate of its state.
    now : (m, 4) array
        Force, its slope, rate and its slope at the start of the part.
    was : (m, 2) array
        Force and its slope at the start of the part before.
    law : (m, 4, orders) array
        What the law gave last: force, rate, and the slopes of both by the state.
    line : (2, m, 5) array
        Displacement, velocity, acceleration, state and its rate, at start and end.
    y : (4, any) array
        Motion at the start, at the end, at the end without carried forces; and the input.
    """

    force: FloatArray
    rate: FloatArray
    now: FloatArray
    was: FloatArray
    law: FloatArray
    line: FloatArray
    y: FloatArray


def room_to_carry(n_motions: int, n_forces: int, degree: int) -> CarriedForces:
    """Return empty room."""
    return CarriedForces(
        np.zeros((n_forces, FORCE_TERMS)),
        np.zeros((n_forces, SERIES_TERMS)),
        np.zeros((n_forces, 4)),
        np.zeros((n_forces, 2)),
        np.zeros((n_forces, 4, SERIES_TERMS)),
        np.zeros((2, n_forces, 5)),
        np.zeros((4, max(n_motions, degree + 1))),
    )


@inlined
def _move_on(
    store: Store,
    slot: int,
    order: int,
    factor: float,
    series: MotionSeries,
    room: CarriedForces,
    n: int,
    n_y: int,
) -> None:
    """Set one order of the accelerations and the next of the linear part's motion."""
    system, push, n_forces = store.system, store.push, room.now.shape[0]
    for i in range(n):
        total = system[slot, n + i, n_y] * series.w[order]
        if order == 0:
            total += system[slot, n + i, n_y + 1]
        for k in range(n_y):
            total += system[slot, n + i, k] * series.y[k, order]
        for f in range(n_forces):
            total += push[slot, i, f] * room.law[f, FORCE, order]
        series.a[i, order] = total
        series.y[i, order + 1] = factor * series.y[n + i, order]
        series.y[n + i, order + 1] = factor * total
    for i in range(2 * n, n_y):
        if store.owner[i - 2 * n] < 0:
            total = 0.0
            for k in range(n_y):
                total += system[slot, i, k] * series.y[k, order]
            series.y[i, order + 1] = factor * total


@inner
def ask(
    machine: Machine,
    store: Store,
    slot: int,
    time: float,
    step: float,
    orders: int,
    slopes: int,
    series: MotionSeries,
    room: CarriedForces,
    n: int,
    n_y: int,
) -> None:
    """Set orders of the carried forces and rates, of accelerations, and the next motion.

    With slopes 1, the derivatives by the state are asked for too, by order 1 of the laws for
    a state that alone changes.
    """
    n_lines = machine.lines.shape[0]
    for turn in range(orders + slopes):
        probing = slopes == 1 and turn == 1
        order = turn - slopes if slopes == 1 and turn > 1 else turn
        for row in range(n_lines):
            c, state = store.force_of[row], machine.lines[row, MEMORY]
            if c < 0 or (probing and state < 0):
                continue
            if sticks(machine, row):
                room.law[c, FORCE, order] = 0.0
                room.law[c, RATE, order] = 0.0
                continue
            z = between(machine, row, series.y, 0, order)
            v = between(machine, row, series.y, n, order)
            series.lines[row, DISPLACEMENT, order] = 0.0 if probing else z
            series.lines[row, VELOCITY, order] = 0.0 if probing else v
            if state >= 0:
                own = 1.0 if probing else series.y[2 * n + state, order]
                series.lines[row, STATE, order] = own
            force, rate = law_series(machine, row, order, time, step, series.lines)
            if probing:
                room.law[c, FORCE_BY_STATE, 0] = force
                room.law[c, RATE_BY_STATE, 0] = rate
                continue
            room.law[c, FORCE, order] = force
            room.law[c, RATE, order] = rate
            if state >= 0:
                series.y[2 * n + state, order + 1] = rate * step / (order + 1)
        if not probing:
            _move_on(store, slot, order, step / (order + 1), series, room, n, n_y)


@inlined
def note(
    machine: Machine, store: Store, side: int, y: FloatArray, series: MotionSeries,
    room: CarriedForces, n: int,
) -> None:  # fmt: skip
    """Write down the motion across the carried lines at the start (0) or the end (1)."""
    line = room.line
    for row in range(machine.lines.shape[0]):
        c = store.force_of[row]
        if c < 0:
            continue
        for kind in range(2):
            total = 0.0
            for i in range(n):
                total += machine.joints[row, i] * y[kind * n + i]
            line[side, c, kind] = total
        line[side, c, 2] = between(machine, row, series.a, 0, 0)
        if machine.lines[row, MEMORY] >= 0:
            line[side, c, 3] = y[2 * n + machine.lines[row, MEMORY]]
            line[side, c, 4] = room.law[c, RATE, 0]


@inlined
def correct_states(
    machine: Machine, store: Store, step: float, scales: FloatArray, room: CarriedForces, n: int
) -> float:
    """Correct states, forces and rates at the end; return the largest correction.

    One step of Newton's method on s1 = s0 + h (r0 + r1) / 2 + h^2 (r0' - r1') / 12. The
    correction is a share of the largest state.
    """
    worst, law = 0.0, room.law
    for row in range(machine.lines.shape[0]):
        c, state = store.force_of[row], 2 * n + machine.lines[row, MEMORY]
        if c < 0 or state < 2 * n:
            continue
        slope = step * law[c, RATE_BY_STATE, 0]
        mean = 0.5 * (room.now[c, 2] + law[c, RATE, 0])
        mean += (room.now[c, 3] - law[c, RATE, 1]) / 12.0
        left = room.y[FROM, state] + step * mean - room.y[END, state]
        change = left / (1.0 - 0.5 * slope + slope * slope / 12.0)
        rate = law[c, RATE_BY_STATE, 0] * change
        law[c, RATE, 0] += rate
        law[c, RATE, 1] += slope * rate
        law[c, FORCE, 0] += law[c, FORCE_BY_STATE, 0] * change
        law[c, FORCE, 1] += law[c, FORCE_BY_STATE, 0] * slope * change
        room.y[END, state] += change
        size = max(scales[state], abs(room.y[END, state]))
        if not abs(change) <= worst * size:
            worst = abs(change) / size if size > 0.0 else 0.0
    return worst


@inlined
def bend_force(room: CarriedForces, f: int, warm: bool) -> None:
    """Set the quintic of a force; see the top."""
    force, f0, f1 = room.force, room.now[f, 0], room.now[f, 1]
    end, slope = room.law[f, FORCE, 0], room.law[f, FORCE, 1]
    force[f, 0], force[f, 1] = f0, f1
    if warm:
        # Hermite: values and slopes at shares -1, 0 and 1, even and odd powers apart
        even = 0.5 * (end + room.was[f, 0]) - f0
        odd = 0.5 * (end - room.was[f, 0]) - f1
        turn = 0.5 * (slope - room.was[f, 1])
        rise = 0.5 * (slope + room.was[f, 1]) - f1
        force[f, 2], force[f, 4] = 2.0 * even - 0.5 * turn, 0.5 * turn - even
        force[f, 3], force[f, 5] = 2.5 * odd - 0.5 * rise, 0.5 * rise - 1.5 * odd
    else:
        # no part before: the law's own series up to the cube, then value and slope at the end
        left = end - f0 - f1 - force[f, 2] - force[f, 3]
        steeper = slope - f1 - 2.0 * force[f, 2] - 3.0 * force[f, 3]
        force[f, 4], force[f, 5] = 5.0 * left - steeper, steeper - 4.0 * left


@inlined
def bend_rate(room: CarriedForces, f: int) -> None:
    """Set the cubic with values and slopes of the rate of a state at both ends."""
    rate, r0, r1 = room.rate, room.now[f, 2], room.now[f, 3]
    rise, slope = room.law[f, RATE, 0] - r0, room.law[f, RATE, 1]
    rate[f, 0], rate[f, 1] = r0, r1
    # Hermite: values and slopes at both ends
    rate[f, 2] = 3.0 * rise - 2.0 * r1 - slope
    rate[f, 3] = -2.0 * rise + r1 + slope


@inlined
def extend(room: CarriedForces) -> None:
    """Predict forces and rates by the polynomials of the part before."""
    for f in range(room.now.shape[0]):
        a3, a4, a5 = room.force[f, 3], room.force[f, 4], room.force[f, 5]
        room.force[f, 2] += 3.0 * a3 + 6.0 * a4 + 10.0 * a5
        room.force[f, 3] += 4.0 * a4 + 10.0 * a5
        room.force[f, 4] += 5.0 * a5
        room.rate[f, 2] += 3.0 * room.rate[f, 3]
        room.force[f, 0], room.force[f, 1] = room.now[f, 0], room.now[f, 1]
        room.rate[f, 0], room.rate[f, 1] = room.now[f, 2], room.now[f, 3]


@inner
def set_out(
    machine: Machine,
    store: Store,
    slot: int,
    time: float,
    step: float,
    series: MotionSeries,
    room: CarriedForces,
    n: int,
    n_y: int,
    n_c: int,
) -> None:
    """Predict forces and rates by their series at the start of a part."""
    for i in range(n_y):
        series.y[i, 0] = room.y[FROM, i]
    for k in range(SERIES_TERMS):
        series.w[k] = room.y[INPUT, k] if k < n_c else 0.0
    ask(machine, store, slot, time, step, SERIES_TERMS, 0, series, room, n, n_y)
    note(machine, store, 0, room.y[FROM], series, room, n)
    for f in range(room.now.shape[0]):
        for k in range(SERIES_TERMS):
            room.force[f, k] = room.law[f, FORCE, k]
            room.rate[f, k] = room.law[f, RATE, k]
        room.force[f, 4], room.force[f, 5] = 0.0, 0.0
        room.now[f, 0], room.now[f, 1] = room.force[f, 0], room.force[f, 1]
        room.now[f, 2], room.now[f, 3] = room.rate[f, 0], room.rate[f, 1]


@inlined
def keep(room: CarriedForces) -> None:
    """Make the end of a part the start of the next."""
    for f in range(room.now.shape[0]):
        room.was[f, 0], room.was[f, 1] = room.now[f, 0], room.now[f, 1]
        room.now[f, 0], room.now[f, 1] = room.law[f, FORCE, 0], room.law[f, FORCE, 1]
        room.now[f, 2], room.now[f, 3] = room.law[f, RATE, 0], room.law[f, RATE, 1]
        for k in range(5):
            room.line[0, f, k] = room.line[1, f, k]
