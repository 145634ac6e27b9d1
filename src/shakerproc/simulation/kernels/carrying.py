"""Exact propagators under nonlinear forces, each taken as a quintic in a sample.

The linear part of a model, and of the branches that it is on, moves exactly. The force of
every other law over a sample is the quintic with the law's values and rates at both its ends
and at the end of the sample before (of the first after an event, with four terms of the law's
series at the start): it misses a sine by (omega h)^6 / 4800. Its far end is predicted and
corrected until the motion rests, or would in the next correction. States of laws with memory
follow by an implicit rule of order 4 that is stable however fast the state relaxes (Hermite
and Obreshkov's). Where that does not settle, or a branch ends, the sample is left to the
Taylor series.
"""

from typing import Final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models.compiled import inlined
from shakerproc.simulation.kernels.carried_forces import (
    END,
    FORCE,
    FREE,
    FROM,
    INPUT,
    SERIES_TERMS,
    CarriedForces,
    ask,
    bend_force,
    bend_rate,
    correct_states,
    extend,
    keep,
    note,
    set_out,
)
from shakerproc.simulation.kernels.exact import by_motion
from shakerproc.simulation.kernels.motion import sticks
from shakerproc.simulation.kernels.table import (
    FORCE_TERMS,
    LAW,
    STATE,
    Machine,
    MotionSeries,
    Store,
)
from shakerproc.simulation.kernels.taylor import even_out, shift, slot_of
from shakerproc.simulation.laws.table import event, wall

_ATTEMPTS: Final = 3
_LOOSE: Final = 100.0
"""How far the first correction may be above the tolerance: a quintic misses a smooth force by
a three hundredth of what its extension to the next sample misses there [-]."""

_LESS_LOOSE: Final = 10.0
"""The same where a series predicts, after an event [-]."""

_UNKNOWN: Final = np.inf
"""How corrections shrink before two were made one after the other [-]."""

_LEAST_SHRINKING: Final = 1e-3
"""Least share of a correction that is expected of the next one: a law may be flat where two
were made, and steep a few parts on [-]."""

_LEFT: Final = 0.1
"""What a correction may leave, over the tolerance [-]."""


@inlined
def _ahead(machine: Machine, store: Store, step: float, room: CarriedForces) -> bool:
    """Return whether every event of the carried lines is still ahead; see `exact.fast`."""
    for row in range(machine.lines.shape[0]):
        c = store.force_of[row]
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
    room: CarriedForces,
    n_y: int,
) -> bool:
    """Return whether every event of the linear branches is still ahead; see `exact.fast`."""
    events, slopes, which = store.events[slot], store.slopes[slot], store.which[slot]
    y, end, c, n_forces = room.y[FROM], room.y[END], room.y[INPUT], room.now.shape[0]
    for e in range(store.n_events[slot]):
        ahead = by_motion(events, e, end, w, n_y)
        for f in range(n_forces):
            ahead += events[e, n_y + 2 + f] * room.law[f, FORCE, 0]
        if ahead >= 0.0:
            return False
        if ahead < -4.0 * fastest * store.part[slot] and wall(machine.lines[which[e, 0], LAW]):
            continue
        down = -by_motion(slopes, e, end, w, n_y)
        up = by_motion(slopes, e, y, c[0], n_y)
        before = by_motion(events, e, y, c[0], n_y)
        for f in range(n_forces):
            down -= slopes[e, n_y + 2 + f] * room.law[f, FORCE, 0]
            up += slopes[e, n_y + 2 + f] * room.now[f, 0]
            before += events[e, n_y + 2 + f] * room.now[f, 0]
            down -= events[e, n_y + 2 + f] * room.law[f, FORCE, 1]
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
def _predict(
    store: Store, slot: int, step: float, room: CarriedForces, n: int, n_y: int, n_c: int
) -> None:
    """Set the end of a part without the carried forces, and with those that are predicted."""
    table, y = store.step, room.y
    for i in range(n_y):
        total = table[slot, i, n_y + n_c]
        for k in range(n_c):
            total += table[slot, i, n_y + k] * y[INPUT, k]
        for k in range(n_y):
            total += table[slot, i, k] * y[FROM, k]
        y[FREE, i] = y[FROM, i] + total
        y[END, i] = _with_forces(store, slot, room, i, n_y + n_c + 1)
    for i in range(2 * n, n_y):
        f = store.owner[i - 2 * n]
        if f >= 0:
            rise = 0.0
            for k in range(SERIES_TERMS):
                rise += room.rate[f, k] / (k + 1)
            y[END, i] = y[FROM, i] + step * rise


@inlined
def _with_forces(store: Store, slot: int, room: CarriedForces, i: int, column: int) -> float:
    """Return the end of a motion under the carried forces as they are."""
    total = 0.0
    for f in range(room.now.shape[0]):
        for k in range(FORCE_TERMS):
            total += store.step[slot, i, column + FORCE_TERMS * f + k] * room.force[f, k]
    return room.y[FREE, i] + total


@inlined
def _settle(
    machine: Machine,
    store: Store,
    slot: int,
    time: float,
    step: float,
    tolerance: float,
    warm: bool,
    shrinking: float,
    scales: FloatArray,
    series: MotionSeries,
    room: CarriedForces,
    n: int,
    n_y: int,
    n_c: int,
) -> tuple[bool, float]:
    """Correct the end of a part by the forces there until it rests; return whether it does.

    And how much of a correction the next one is, as it was where two were made, and twice
    that with every part since: as much is left after a correction, which none is made to see.
    """
    w, w_rate, y = room.y[INPUT, 0], 0.0, room.y
    for k in range(1, n_c):
        w += y[INPUT, k]
        w_rate += k * y[INPUT, k]
    before = 0.0
    for attempt in range(_ATTEMPTS):
        for i in range(n_y):
            series.y[i, 0] = y[END, i]
        series.w[0], series.w[1] = w, w_rate
        ask(machine, store, slot, time, step, 2, 1, series, room, n, n_y)
        worst = 0.0
        if n_y > 2 * n:
            worst = correct_states(machine, store, step, scales, room, n)
        for f in range(room.now.shape[0]):
            bend_force(room, f, warm)
            if n_y > 2 * n:
                bend_rate(room, f)
        for i in range(n_y):
            if i >= 2 * n and store.owner[i - 2 * n] >= 0:
                continue
            end = _with_forces(store, slot, room, i, n_y + n_c + 1)
            change = abs(end - y[END, i])
            if not change <= worst * scales[i]:
                worst = change / scales[i] if scales[i] > 0.0 else 1.0
            y[END, i] = end
        if attempt > 0:
            shrinking = max(worst / before, _LEAST_SHRINKING)
        if worst <= tolerance:
            return True, shrinking
        if shrinking * worst <= _LEFT * tolerance:
            return True, 2.0 * shrinking
        if not worst <= (_LOOSE if warm else _LESS_LOOSE) * tolerance:
            return False, shrinking
        before = worst
    return False, shrinking


@inlined
def _write_down(
    store: Store,
    slot: int,
    w: float,
    room: CarriedForces,
    motion: FloatArray,
    accelerations: FloatArray,
    row: int,
    n: int,
    n_y: int,
) -> None:
    """Write down the motion at the end of a sample."""
    for i in range(n_y):
        motion[row, i] = room.y[END, i]
    for i in range(accelerations.shape[1]):
        at = n + i if i < n else n_y
        total = by_motion(store.system[slot], at, room.y[END], w, n_y)
        for f in range(room.now.shape[0]):
            total += store.push[slot, i, f] * room.law[f, FORCE, 0]
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
    series: MotionSeries,
    room: CarriedForces,
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
        y[FROM, i] = series.y[i, 0]
    shrinking = _UNKNOWN
    k_out, wait, part, warm = j // stride - before, stride - j % stride, 0, False
    while j < stop:
        shift(pieces, j, part / parts, 1.0 / parts, y[INPUT])
        time = (j + part / parts) * sample
        if warm:
            extend(room)
        else:
            set_out(machine, store, slot, time, step, series, room, n, n_y, n_c)
        _predict(store, slot, step, room, n, n_y, n_c)
        settled, shrinking = _settle(
            machine, store, slot, time + step, step, tolerance, warm, shrinking, scales, series,
            room, n, n_y, n_c,
        )  # fmt: skip
        if not settled:
            break
        w = series.w[0]
        note(machine, store, 1, y[END], series, room, n)
        if not _ahead(machine, store, step, room):
            break
        if store.n_events[slot] > 0 and not _ahead_linear(
            machine, store, slot, n_c, w, fastest, room, n_y
        ):
            break
        keep(room)
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
            y[FROM, i] = y[END, i]
            size = abs(y[END, i])
            if size > scales[i]:
                scales[i] = size
                if i >= n and i < 2 * n and size > fastest:
                    fastest = size
    for i in range(n_y):
        series.y[i, 0] = y[FROM, i]
    return j, part / parts
