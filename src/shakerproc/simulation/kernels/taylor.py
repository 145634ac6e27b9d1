"""Steps by Taylor series on the present branches, as far as they converge."""

from shakerproc.data import FloatArray
from shakerproc.models.compiled import inlined, inner
from shakerproc.simulation.kernels.motion import (
    accelerate_here,
    between,
    finish_line,
    mobility,
    sticks,
    switch,
)
from shakerproc.simulation.kernels.polynomials import NEVER, first_rise, value
from shakerproc.simulation.kernels.table import (
    BOUC_WEN,
    DISPLACEMENT,
    EVEN_POWER,
    FRICTION,
    HERTZ,
    HIGHEST,
    HOLDING,
    IWAN,
    JENKINS,
    LAW,
    MEMORY,
    ODD_POWER,
    POWER_DAMPING,
    SERIES,
    STATE,
    TABLE,
    VELOCITY,
    Machine,
    MotionSeries,
    Store,
)
from shakerproc.simulation.laws.table import event, trusted_share, wall

NEAR = 0.02
"""How near to where it bends like a power that is not whole a law is left to DOP853, as a
share of the largest motion: a sixth of a sample's motion, at 50 samples in a period [-]."""

FORCED_STEP = 0.01
"""Share of a step that is taken without events where they follow each other for ever."""


@inlined
def shift(pieces: FloatArray, j: int, start: float, share: float, w: FloatArray) -> None:
    """Set the input series of a part of an interval, from start on and share long."""
    degree = pieces.shape[1] - 1
    for k in range(degree + 1):  # the higher ones are 0 for ever
        w[k] = pieces[j, k]
    if start != 0.0:
        for first in range(degree):
            for k in range(degree - 1, first - 1, -1):
                w[k] += start * w[k + 1]
    factor = 1.0
    for k in range(1, degree + 1):
        factor *= share
        w[k] *= factor


@inlined
def slot_of(machine: Machine, store: Store) -> int:
    """Return where the propagators of the present branches stand."""
    code = 0
    for row in range(machine.lines.shape[0]):
        free = store.force_of[row] >= 0 and machine.lines[row, LAW] != FRICTION
        code = 3 * code + (1 if free else machine.mode[row, 0] + 1)
    return store.slot_of[code]


@inlined
def expand_linear(
    store: Store,
    slot: int,
    step: float,
    scales: FloatArray,
    tolerance: float,
    series: MotionSeries,
) -> tuple[int, float]:
    """Set the series of a step on linear branches; return as `expand` does."""
    n_y, system = series.y.shape[0], store.system[slot]
    order, settled = 0, 0
    while order < HIGHEST:
        factor = step / (order + 1)
        settled += 1
        for i in range(n_y):
            total = system[i, n_y] * series.w[order]
            if order == 0:
                total += system[i, n_y + 1]
            for j in range(n_y):
                total += system[i, j] * series.y[j, order]
            series.y[i, order + 1] = factor * total
            if not abs(factor * total) <= tolerance * scales[i]:
                settled = 0
        order += 1
        if settled >= 2 and order > 3:
            return order, 1.0
    return order, _share(series.y, order, scales, tolerance)


@inlined
def expand(
    machine: Machine,
    time: float,
    step: float,
    scales: FloatArray,
    tolerance: float,
    series: MotionSeries,
) -> tuple[int, float]:
    """Set the series of a step; return their order and the share of it where they converge.

    Parameters
    ----------
    time, step : float
        Start and length of the step [s].
    scales : (n_y,) array
        Largest size of each of `y` so far; the truncation is compared with it.
    tolerance : float
        The last two terms as a share of that [-].
    series : MotionSeries
        Set, from order 0 of `y` and the whole of `w`, which stand there already.
    """
    n, n_y = machine.mass.size, series.y.shape[0]
    order, settled = 0, 0
    while order < HIGHEST:
        accelerate_here(machine, time, step, order, series)
        factor = step / (order + 1)
        for i in range(n):
            series.y[i, order + 1] = factor * series.y[n + i, order]
            series.y[n + i, order + 1] = factor * series.a[i, order]
        for i in range(2 * n, n_y):
            series.y[i, order + 1] *= factor
        order += 1
        if order > 3:
            settled += 1
            for i in range(n_y):
                if not abs(series.y[i, order]) <= tolerance * scales[i]:
                    settled = 0
            if settled == 2:
                break
    share = 1.0 if settled >= 2 else _share(series.y, order, scales, tolerance)
    for row in range(machine.lines.shape[0]):
        finish_line(machine, row, order, series)
        if sticks(machine, row):
            continue
        size = scales[0]
        for k in range(order):
            size += abs(series.lines[row, DISPLACEMENT, k])
        negligible = tolerance * size / (step * step * mobility(machine, row, row))
        trusted = trusted_share(machine, row, order, negligible, series.lines)
        if trusted < share:
            share = trusted
    return order, share


@inner
def _share(y: FloatArray, order: int, scales: FloatArray, tolerance: float) -> float:
    """Return the share of the step in which the last two terms are small enough.

    They are compared with the largest motion so far and the largest term; the latter shrinks
    with the step, so it is gone over again until that makes no more difference.
    """
    share = 1.0
    for _ in range(20):
        best = 1.0
        for i in range(y.shape[0]):
            largest, factor = scales[i], 1.0
            for k in range(order + 1):
                term = abs(y[i, k]) * factor
                if not term < 1e200:
                    return 0.001
                if term > largest:
                    largest = term
                factor *= share
            for k in range(order - 1, order + 1):
                if abs(y[i, k]) > tolerance * largest:
                    good = (tolerance * largest / abs(y[i, k])) ** (1.0 / k)
                    if good < best:
                        best = good
        if best > 0.95 * share:
            return best if best < share else share
        share = best
    return share


@inner
def _shorten(series: MotionSeries, order: int, share: float) -> None:
    """Rewrite the series for the first share of their step."""
    factor = 1.0
    for k in range(order + 1):
        series.w[k] *= factor
        for i in range(series.y.shape[0]):
            series.y[i, k] *= factor
        for row in range(series.lines.shape[0]):
            for kind in range(STATE + 1):
                series.lines[row, kind, k] *= factor
        factor *= share


@inlined
def _next_event_linear(
    machine: Machine,
    store: Store,
    slot: int,
    order: int,
    series: MotionSeries,
    scales: FloatArray,
    room: FloatArray,
    change: FloatArray,
) -> tuple[float, int, int]:
    """Return the share of the step at which the first event happens, its line and which.

    An event that cannot be reached whatever the terms do is not looked at any closer.
    """
    n_y, events = series.y.shape[0], store.events[slot]
    at, line, number = NEVER, -1, -1
    change_w = 0.0
    for k in range(1, order + 1):
        change_w += abs(series.w[k])
    for i in range(n_y):
        change[i] = 0.0
        for k in range(1, order + 1):
            change[i] += abs(series.y[i, k])
    for e in range(store.n_events[slot]):
        above = (
            events[e, n_y] * series.w[0] + events[e, n_y + 1] + abs(events[e, n_y]) * change_w
        )
        for i in range(n_y):
            above += events[e, i] * series.y[i, 0] + abs(events[e, i]) * change[i]
        row, which = store.which[slot, e, 0], store.which[slot, e, 1]
        kind, _, _ = event(machine, row, which)
        if above < -event_noise(machine, row, kind, scales):
            continue
        above = 0.0
        for k in range(order + 1):
            total = events[e, n_y] * series.w[k]
            if k == 0:
                total += events[e, n_y + 1]
            for i in range(n_y):
                total += events[e, i] * series.y[i, k]
            room[k] = total
            if k == 0 or total > 0.0:
                above += total
        share = _rise(machine, row, kind, order, above, scales, room)
        if share < at:
            at, line, number = share, row, which
    return at, line, number


@inlined
def _next_event(
    machine: Machine, order: int, series: MotionSeries, scales: FloatArray, room: FloatArray
) -> tuple[float, int, int]:
    """Return the share of the step at which the first event happens, its line and which."""
    at, line, number = NEVER, -1, -1
    for row in range(machine.lines.shape[0]):
        for which in range(2):
            kind, sign, level = event(machine, row, which)
            if kind < 0:
                break
            above = -level
            for k in range(order + 1):
                room[k] = sign * series.lines[row, kind, k]
                if k == 0 or room[k] > 0.0:
                    above += room[k]
            room[0] -= level
            share = _rise(machine, row, kind, order, above, scales, room)
            if share < at:
                at, line, number = share, row, which
    return at, line, number


@inlined
def _rise(
    machine: Machine,
    row: int,
    kind: int,
    last: int,
    above: float,
    scales: FloatArray,
    room: FloatArray,
) -> float:
    """Return when an event rises above 0, `above` being an upper bound of it in the step."""
    noise = event_noise(machine, row, kind, scales)
    if above < -noise:
        return NEVER
    next_noise = 0.0
    law = machine.lines[row, LAW]
    slides = law == JENKINS or law == SERIES
    if (law == FRICTION and kind == VELOCITY) or (slides and kind == STATE):
        for k in range(1, last + 1):
            next_noise += 1e-9 * abs(room[k])
    return first_rise(room, last, noise, next_noise)


@inlined
def event_noise(machine: Machine, row: int, kind: int, scales: FloatArray) -> float:
    """Return the distance from a switching surface that counts as 0."""
    if kind == DISPLACEMENT:
        return 1e-13 * scales[0]
    if kind == VELOCITY:
        return 1e-13 * scales[machine.mass.size]
    if kind == STATE and machine.lines[row, LAW] == SERIES:
        return 1e-13 * scales[0]
    if kind == HOLDING or kind == STATE:
        return 1e-13 * abs(machine.values[row, 1])
    return 0.0


@inlined
def near_no_series(machine: Machine, series: MotionSeries, scales: FloatArray) -> bool:
    """Return whether some law has no Taylor series where the motion is, or next to it."""
    n = machine.mass.size
    for row in range(machine.lines.shape[0]):
        law, state = machine.lines[row, LAW], machine.lines[row, MEMORY]
        exponent = machine.values[row, 2]
        if law == TABLE:
            return True
        at, size = 1.0, 0.0
        if law == HERTZ:
            if machine.mode[row, 0] == 1:
                at = between(machine, row, series.y, 0, 0) - machine.values[row, 1]
                size = scales[0]
        elif exponent == int(exponent):
            continue
        elif law == BOUC_WEN:
            at, size = series.y[2 * n + state, 0], scales[2 * n + state]
        elif law == ODD_POWER or law == EVEN_POWER or law == POWER_DAMPING:
            at, size = between(machine, row, series.y, 0, 0), scales[0]
        elif law == IWAN:
            at = between(machine, row, series.y, 0, 0) - machine.anchor[row, 0]
            size = machine.anchor[row, 3]
        if abs(at) <= NEAR * size:
            return True
    return False


@inlined
def careful(
    machine: Machine,
    store: Store,
    analytic: bool,
    pieces: FloatArray,
    j: int,
    passed: float,
    sample: float,
    scales: FloatArray,
    tolerance: float,
    series: MotionSeries,
    room: FloatArray,
    change: FloatArray,
    stats: FloatArray,
    span: int,
    before: int,
    motion: FloatArray,
    accelerations: FloatArray,
) -> float:
    """Carry the motion in order 0 to the end of an interval, through every event in it.

    Where the interval covers several samples, those inside it are set; the results lack the
    first `before` samples.

    Returns
    -------
    float
        Share of the interval that was reached: 1, or where the steps became too small, or
        where a model that is not analytic has no series.
    """
    n, n_y = machine.mass.size, series.y.shape[0]
    linear = store.parts.size > 0 and store.push.shape[2] == 0
    flips = 0
    inside = 1
    for _ in range(20000):
        if not analytic and near_no_series(machine, series, scales):
            return passed
        share = 1.0 - passed
        time, step = (j + passed) * sample, share * sample
        shift(pieces, j, passed, share, series.w)
        even_out(scales, n)
        slot = slot_of(machine, store) if linear else -1
        if linear:
            order, good = expand_linear(store, slot, step, scales, tolerance, series)
        else:
            order, good = expand(machine, time, step, scales, tolerance, series)
        stats[3] += 1.0
        if good < 1.0:
            _shorten(series, order, good)
        if linear:
            at, row, which = _next_event_linear(
                machine, store, slot, order, series, scales, room, change
            )
        else:
            at, row, which = _next_event(machine, order, series, scales, room)
        if flips > 8 + 4 * machine.lines.shape[0] and at < FORCED_STEP:
            stats[4] += 1.0
            at, row = FORCED_STEP, -1
        where = at if at < 1.0 else 1.0
        while inside < span and inside < span * (passed + where * good * share):
            past = (inside / span - passed) / (good * share)
            k = j * span + inside - before
            if k < motion.shape[0]:
                look_in(series, order, past, good, motion, accelerations, k)
            inside += 1
        for i in range(n_y):
            total = series.y[i, order]
            if i < n:
                stats[2] += abs(total)
            elif i < 2 * n:
                stats[6] += abs(total)
            for k in range(order - 1, -1, -1):
                total = total * where + series.y[i, k]
            series.y[i, 0] = total
            if abs(total) > scales[i]:
                scales[i] = abs(total)
        if at == NEVER and good == 1.0:
            return 1.0
        passed += where * good * share
        flips = flips + 1 if at < 1e-9 else 0
        if row >= 0:
            stats[1] += 1.0
            if wall(machine.lines[row, LAW]) and not any_friction(machine):
                machine.mode[row, 0] = 1 - machine.mode[row, 0]  # as switch does, by a call
            else:
                series.w[0] = value(pieces[j], 0, pieces.shape[1] - 1, passed)
                switch(machine, row, which, (j + passed) * sample, series)
        if passed >= 1.0 - 1e-14:
            return 1.0
        if not abs(series.y[0, 0]) < 1e100:
            return passed
    return passed


@inlined
def look_in(
    series: MotionSeries,
    order: int,
    past: float,
    good: float,
    motion: FloatArray,
    accelerations: FloatArray,
    row: int,
) -> None:
    """Write down the motion within a step; accelerations have the step before it was cut."""
    for i in range(series.y.shape[0]):
        total = series.y[i, order]
        for k in range(order - 1, -1, -1):
            total = total * past + series.y[i, k]
        motion[row, i] = total
    for i in range(series.a.shape[0]):
        total = series.a[i, order - 1]
        for k in range(order - 2, -1, -1):
            total = total * past * good + series.a[i, k]
        accelerations[row, i] = total


@inlined
def any_friction(machine: Machine) -> bool:
    """Return whether some joint could stick."""
    found = False
    for row in range(machine.lines.shape[0]):
        found = found or machine.lines[row, LAW] == FRICTION
    return found


@inlined
def even_out(scales: FloatArray, n: int) -> None:
    """Give all displacements one scale, and all velocities one: a mass at rest has none."""
    for first in range(0, 2 * n, n):
        largest = 0.0
        for i in range(first, first + n):
            if scales[i] > largest:
                largest = scales[i]
        for i in range(first, first + n):
            scales[i] = largest
