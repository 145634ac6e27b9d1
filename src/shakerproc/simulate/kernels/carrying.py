"""Exact propagators under nonlinear forces: what a law does in a sample, as a quintic.

The linear part of a model, and of the branches that it is on, moves exactly. The force of
every other law over a sample is the quintic with the law's values and rates at both its ends
and at the end of the sample before (of the first after an event, with four terms of the law's
series at the start): it misses a sine by (omega h)^6 / 4800. Its far end is predicted and
corrected until the motion rests. States of laws with memory follow by an implicit rule of
order 4 that is stable however fast the state relaxes (Hermite and Obreshkov's). Where that
does not settle, or a branch ends, the sample is left to the Taylor series.
"""

from typing import Final, NamedTuple

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models.compiled import inlined, inner
from shakerproc.simulate.kernels.exact import by_motion
from shakerproc.simulate.kernels.modes import event, wall
from shakerproc.simulate.kernels.motion import between, sticks
from shakerproc.simulate.kernels.series import law_series
from shakerproc.simulate.kernels.table import (
    DISPLACEMENT,
    FIRST,
    FORCE_TERMS,
    LAW,
    MEMORY,
    SECOND,
    STATE,
    VELOCITY,
    Machine,
    Series,
    Store,
)
from shakerproc.simulate.kernels.taylor import even_out, shift, slot_of

_ATTEMPTS: Final = 3
_LOOSE: Final = 100.0
"""How far the first correction may be above the tolerance: a quintic misses a smooth force by
a three hundredth of what its extension to the next sample misses there [-]."""

_LESS_LOOSE: Final = 10.0
"""The same where a series predicts, after an event [-]."""

_SERIES_TERMS: Final = 4
"""Terms of its series by which a law is predicted where nothing came before."""

_FROM: Final = 0  # rows of `y`
_END: Final = 1
_FREE: Final = 2
_INPUT: Final = 3

_FORCE: Final = 0  # planes of `law`: force and rate, their slopes by the state
_RATE: Final = 1
_FORCE_BY_STATE: Final = 2
_RATE_BY_STATE: Final = 3


class Carried(NamedTuple):
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


def room_to_carry(n_motions: int, n_forces: int, degree: int) -> Carried:
    """Return empty room."""
    return Carried(
        np.zeros((n_forces, FORCE_TERMS)),
        np.zeros((n_forces, _SERIES_TERMS)),
        np.zeros((n_forces, 4)),
        np.zeros((n_forces, 2)),
        np.zeros((n_forces, 4, _SERIES_TERMS)),
        np.zeros((2, n_forces, 5)),
        np.zeros((4, max(n_motions, degree + 1))),
    )


@inner
def _ask(
    machine: Machine,
    store: Store,
    slot: int,
    time: float,
    step: float,
    orders: int,
    slopes: int,
    series: Series,
    room: Carried,
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
            c, state = store.carried[row], machine.lines[row, MEMORY]
            if c < 0 or (probing and state < 0):
                continue
            if sticks(machine, row):
                room.law[c, _FORCE, order] = 0.0
                room.law[c, _RATE, order] = 0.0
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
                room.law[c, _FORCE_BY_STATE, 0] = force
                room.law[c, _RATE_BY_STATE, 0] = rate
                continue
            room.law[c, _FORCE, order] = force
            room.law[c, _RATE, order] = rate
            if state >= 0:
                series.y[2 * n + state, order + 1] = rate * step / (order + 1)
        if not probing:
            _move_on(store, slot, order, step / (order + 1), series, room, n, n_y)


@inlined
def _move_on(
    store: Store,
    slot: int,
    order: int,
    factor: float,
    series: Series,
    room: Carried,
    n: int,
    n_y: int,
) -> None:
    """Set one order of the accelerations and the next of what the linear part moves."""
    system, push, n_forces = store.system, store.push, room.now.shape[0]
    for i in range(n):
        total = system[slot, n + i, n_y] * series.w[order]
        if order == 0:
            total += system[slot, n + i, n_y + 1]
        for k in range(n_y):
            total += system[slot, n + i, k] * series.y[k, order]
        for f in range(n_forces):
            total += push[slot, i, f] * room.law[f, _FORCE, order]
        series.a[i, order] = total
        series.y[i, order + 1] = factor * series.y[n + i, order]
        series.y[n + i, order + 1] = factor * total
    for i in range(2 * n, n_y):
        if store.owner[i - 2 * n] < 0:
            total = 0.0
            for k in range(n_y):
                total += system[slot, i, k] * series.y[k, order]
            series.y[i, order + 1] = factor * total


@inlined
def _note(
    machine: Machine, store: Store, side: int, y: FloatArray, series: Series, room: Carried,
    n: int,
) -> None:  # fmt: skip
    """Write down the motion across the carried lines at the start (0) or the end (1)."""
    line = room.line
    for row in range(machine.lines.shape[0]):
        c = store.carried[row]
        if c < 0:
            continue
        second, first = machine.lines[row, SECOND], machine.lines[row, FIRST]
        for kind in range(2):
            total = 0.0
            if second >= 0:
                total += y[kind * n + second]
            if first >= 0:
                total -= y[kind * n + first]
            line[side, c, kind] = total
        line[side, c, 2] = between(machine, row, series.a, 0, 0)
        if machine.lines[row, MEMORY] >= 0:
            line[side, c, 3] = y[2 * n + machine.lines[row, MEMORY]]
            line[side, c, 4] = room.law[c, _RATE, 0]


@inlined
def _ahead(machine: Machine, store: Store, step: float, room: Carried) -> bool:
    """Return whether every event of the carried lines is still ahead; see `exact.fast`."""
    for row in range(machine.lines.shape[0]):
        c = store.carried[row]
        if c < 0 or sticks(machine, row):
            continue
        for which in range(2):
            kind, sign, level = event(machine, row, which)
            if kind < 0:
                break
            at = 3 if kind == STATE else kind
            now = sign * room.line[1, c, at] - level
            if now >= 0.0:
                return False
            down = -sign * room.line[1, c, at + 1]
            if down > 0.0:
                up = sign * room.line[0, c, at + 1]
                if up > 0.0:
                    before = sign * room.line[0, c, at] - level
                    highest = now if now > before else before
                    if highest + step * up * down / (up + down) >= 0.0:
                        return False
    return True


@inlined
def _ahead_linear(
    machine: Machine,
    store: Store,
    slot: int,
    n_c: int,
    w: float,
    fastest: float,
    room: Carried,
    n_y: int,
) -> bool:
    """Return whether every event of the linear branches is still ahead; see `exact.fast`."""
    events, slopes, which = store.events[slot], store.slopes[slot], store.which[slot]
    y, end, c, n_forces = room.y[_FROM], room.y[_END], room.y[_INPUT], room.now.shape[0]
    for e in range(store.n_events[slot]):
        ahead = by_motion(events, e, end, w, n_y)
        for f in range(n_forces):
            ahead += events[e, n_y + 2 + f] * room.law[f, _FORCE, 0]
        if ahead >= 0.0:
            return False
        if ahead < -4.0 * fastest * store.part[slot] and wall(machine.lines[which[e, 0], LAW]):
            continue
        down = -by_motion(slopes, e, end, w, n_y)
        up = by_motion(slopes, e, y, c[0], n_y)
        before = by_motion(events, e, y, c[0], n_y)
        for f in range(n_forces):
            down -= slopes[e, n_y + 2 + f] * room.law[f, _FORCE, 0]
            up += slopes[e, n_y + 2 + f] * room.now[f, 0]
            before += events[e, n_y + 2 + f] * room.now[f, 0]
            down -= events[e, n_y + 2 + f] * room.law[f, _FORCE, 1]
            up += events[e, n_y + 2 + f] * room.now[f, 1]
        if events[e, n_y] != 0.0:
            up += events[e, n_y] * c[1]
            for k in range(1, n_c):
                down -= events[e, n_y] * k * c[k]
        if down > 0.0 and up > 0.0:
            highest = ahead if ahead > before else before
            if highest + up * down / (up + down) >= 0.0:
                return False
    return True


@inlined
def _correct_states(
    machine: Machine, store: Store, step: float, scales: FloatArray, room: Carried, n: int
) -> float:
    """Correct states, forces and rates at the end; return the largest correction.

    One step of Newton's method on s1 = s0 + h (r0 + r1) / 2 + h^2 (r0' - r1') / 12. The
    correction is a share of the largest state.
    """
    worst, law = 0.0, room.law
    for row in range(machine.lines.shape[0]):
        c, state = store.carried[row], 2 * n + machine.lines[row, MEMORY]
        if c < 0 or state < 2 * n:
            continue
        slope = step * law[c, _RATE_BY_STATE, 0]
        mean = 0.5 * (room.now[c, 2] + law[c, _RATE, 0])
        mean += (room.now[c, 3] - law[c, _RATE, 1]) / 12.0
        left = room.y[_FROM, state] + step * mean - room.y[_END, state]
        change = left / (1.0 - 0.5 * slope + slope * slope / 12.0)
        rate = law[c, _RATE_BY_STATE, 0] * change
        law[c, _RATE, 0] += rate
        law[c, _RATE, 1] += slope * rate
        law[c, _FORCE, 0] += law[c, _FORCE_BY_STATE, 0] * change
        law[c, _FORCE, 1] += law[c, _FORCE_BY_STATE, 0] * slope * change
        room.y[_END, state] += change
        size = max(scales[state], abs(room.y[_END, state]))
        if not abs(change) <= worst * size:
            worst = abs(change) / size if size > 0.0 else 0.0
    return worst


@inlined
def _bend_force(room: Carried, f: int, warm: bool) -> None:
    """Set the quintic of a force; see the top."""
    force, f0, f1 = room.force, room.now[f, 0], room.now[f, 1]
    end, slope = room.law[f, _FORCE, 0], room.law[f, _FORCE, 1]
    force[f, 0], force[f, 1] = f0, f1
    if warm:
        even = 0.5 * (end + room.was[f, 0]) - f0
        odd = 0.5 * (end - room.was[f, 0]) - f1
        turn = 0.5 * (slope - room.was[f, 1])
        rise = 0.5 * (slope + room.was[f, 1]) - f1
        force[f, 2], force[f, 4] = 2.0 * even - 0.5 * turn, 0.5 * turn - even
        force[f, 3], force[f, 5] = 2.5 * odd - 0.5 * rise, 0.5 * rise - 1.5 * odd
    else:
        left = end - f0 - f1 - force[f, 2] - force[f, 3]
        steeper = slope - f1 - 2.0 * force[f, 2] - 3.0 * force[f, 3]
        force[f, 4], force[f, 5] = 5.0 * left - steeper, steeper - 4.0 * left


@inlined
def _bend_rate(room: Carried, f: int) -> None:
    """Set the cubic with values and slopes of the rate of a state at both ends."""
    rate, r0, r1 = room.rate, room.now[f, 2], room.now[f, 3]
    rise, slope = room.law[f, _RATE, 0] - r0, room.law[f, _RATE, 1]
    rate[f, 0], rate[f, 1] = r0, r1
    rate[f, 2] = 3.0 * rise - 2.0 * r1 - slope
    rate[f, 3] = -2.0 * rise + r1 + slope


@inlined
def _extend(room: Carried) -> None:
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
def _set_out(
    machine: Machine,
    store: Store,
    slot: int,
    time: float,
    step: float,
    series: Series,
    room: Carried,
    n: int,
    n_y: int,
    n_c: int,
) -> None:
    """Predict forces and rates by their series at the start of a part."""
    for i in range(n_y):
        series.y[i, 0] = room.y[_FROM, i]
    for k in range(_SERIES_TERMS):
        series.w[k] = room.y[_INPUT, k] if k < n_c else 0.0
    _ask(machine, store, slot, time, step, _SERIES_TERMS, 0, series, room, n, n_y)
    _note(machine, store, 0, room.y[_FROM], series, room, n)
    for f in range(room.now.shape[0]):
        for k in range(_SERIES_TERMS):
            room.force[f, k] = room.law[f, _FORCE, k]
            room.rate[f, k] = room.law[f, _RATE, k]
        room.force[f, 4], room.force[f, 5] = 0.0, 0.0
        room.now[f, 0], room.now[f, 1] = room.force[f, 0], room.force[f, 1]
        room.now[f, 2], room.now[f, 3] = room.rate[f, 0], room.rate[f, 1]


@inlined
def _predict(
    store: Store, slot: int, step: float, room: Carried, n: int, n_y: int, n_c: int
) -> None:
    """Set the end of a part without the carried forces, and with those that are predicted."""
    table, y = store.step, room.y
    for i in range(n_y):
        total = table[slot, i, n_y + n_c]
        for k in range(n_c):
            total += table[slot, i, n_y + k] * y[_INPUT, k]
        for k in range(n_y):
            total += table[slot, i, k] * y[_FROM, k]
        y[_FREE, i] = y[_FROM, i] + total
        y[_END, i] = _with_forces(store, slot, room, i, n_y + n_c + 1)
    for i in range(2 * n, n_y):
        f = store.owner[i - 2 * n]
        if f >= 0:
            rise = 0.0
            for k in range(_SERIES_TERMS):
                rise += room.rate[f, k] / (k + 1)
            y[_END, i] = y[_FROM, i] + step * rise


@inlined
def _with_forces(store: Store, slot: int, room: Carried, i: int, column: int) -> float:
    """Return what a motion ends with under the carried forces as they are."""
    total = 0.0
    for f in range(room.now.shape[0]):
        for k in range(FORCE_TERMS):
            total += store.step[slot, i, column + FORCE_TERMS * f + k] * room.force[f, k]
    return room.y[_FREE, i] + total


@inlined
def _settle(
    machine: Machine,
    store: Store,
    slot: int,
    time: float,
    step: float,
    tolerance: float,
    warm: bool,
    scales: FloatArray,
    series: Series,
    room: Carried,
    n: int,
    n_y: int,
    n_c: int,
) -> bool:
    """Correct the end of a part by the forces there until it rests; return whether it does."""
    w, w_rate, y = room.y[_INPUT, 0], 0.0, room.y
    for k in range(1, n_c):
        w += y[_INPUT, k]
        w_rate += k * y[_INPUT, k]
    for _ in range(_ATTEMPTS):
        for i in range(n_y):
            series.y[i, 0] = y[_END, i]
        series.w[0], series.w[1] = w, w_rate
        _ask(machine, store, slot, time, step, 2, 1, series, room, n, n_y)
        worst = 0.0
        if n_y > 2 * n:
            worst = _correct_states(machine, store, step, scales, room, n)
        for f in range(room.now.shape[0]):
            _bend_force(room, f, warm)
            if n_y > 2 * n:
                _bend_rate(room, f)
        for i in range(n_y):
            if i >= 2 * n and store.owner[i - 2 * n] >= 0:
                continue
            end = _with_forces(store, slot, room, i, n_y + n_c + 1)
            change = abs(end - y[_END, i])
            if not change <= worst * scales[i]:
                worst = change / scales[i] if scales[i] > 0.0 else 1.0
            y[_END, i] = end
        if worst <= tolerance:
            return True
        if not worst <= (_LOOSE if warm else _LESS_LOOSE) * tolerance:
            return False
    return False


@inlined
def _keep(room: Carried) -> None:
    """Make the end of a part the start of the next."""
    for f in range(room.now.shape[0]):
        room.was[f, 0], room.was[f, 1] = room.now[f, 0], room.now[f, 1]
        room.now[f, 0], room.now[f, 1] = room.law[f, _FORCE, 0], room.law[f, _FORCE, 1]
        room.now[f, 2], room.now[f, 3] = room.law[f, _RATE, 0], room.law[f, _RATE, 1]
        for k in range(5):
            room.line[0, f, k] = room.line[1, f, k]


@inlined
def _write_down(
    store: Store,
    slot: int,
    w: float,
    room: Carried,
    motion: FloatArray,
    accelerations: FloatArray,
    row: int,
    n: int,
    n_y: int,
) -> None:
    """Write down the motion at the end of a sample."""
    for i in range(n_y):
        motion[row, i] = room.y[_END, i]
    for i in range(accelerations.shape[1]):
        at = n + i if i < n else n_y
        total = by_motion(store.system[slot], at, room.y[_END], w, n_y)
        for f in range(room.now.shape[0]):
            total += store.push[slot, i, f] * room.law[f, _FORCE, 0]
        accelerations[row, i] = total


@inlined
def carry(
    machine: Machine,
    store: Store,
    pieces: FloatArray,
    j: int,
    stop: int,
    stride: int,
    before: int,
    sample: float,
    tolerance: float,
    scales: FloatArray,
    series: Series,
    room: Carried,
    motion: FloatArray,
    accelerations: FloatArray,
    n: int,
    n_y: int,
) -> tuple[int, float]:
    """Carry the motion on until an event is near; as `exact.fast` does."""
    n_c, y = pieces.shape[1], room.y
    slot = slot_of(machine, store)
    parts, step = store.parts[slot], store.part[slot]
    even_out(scales, n)
    fastest = scales[n]
    for i in range(n_y):
        y[_FROM, i] = series.y[i, 0]
    k_out, wait, part, warm = j // stride - before, stride - j % stride, 0, False
    while j < stop:
        shift(pieces, j, part / parts, 1.0 / parts, y[_INPUT])
        time = (j + part / parts) * sample
        if warm:
            _extend(room)
        else:
            _set_out(machine, store, slot, time, step, series, room, n, n_y, n_c)
        _predict(store, slot, step, room, n, n_y, n_c)
        if not _settle(
            machine, store, slot, time + step, step, tolerance, warm, scales, series, room, n,
            n_y, n_c,
        ):  # fmt: skip
            break
        w = series.w[0]
        _note(machine, store, 1, y[_END], series, room, n)
        if not _ahead(machine, store, step, room):
            break
        if store.n_events[slot] > 0 and not _ahead_linear(
            machine, store, slot, n_c, w, fastest, room, n_y
        ):
            break
        _keep(room)
        warm = True
        part += 1
        if part == parts:
            part = 0
            j += 1
            wait -= 1
            if wait == 0:
                wait = stride
                k_out += 1
                _write_down(store, slot, w, room, motion, accelerations, k_out, n, n_y)
        for i in range(n_y):
            y[_FROM, i] = y[_END, i]
            size = abs(y[_END, i])
            if size > scales[i]:
                scales[i] = size
                if i >= n and i < 2 * n and size > fastest:
                    fastest = size
    for i in range(n_y):
        series.y[i, 0] = y[_FROM, i]
    return j, part / parts
