"""Exact propagators where nothing switches, and rows of the results."""

from shakerproc.data import FloatArray
from shakerproc.models.compiled import inlined
from shakerproc.simulation.kernels.motion import accelerate
from shakerproc.simulation.kernels.table import LAW, Machine, MotionSeries, Store
from shakerproc.simulation.kernels.taylor import shift, slot_of
from shakerproc.simulation.laws.table import wall


@inlined
def by_motion(rows: FloatArray, e: int, y: FloatArray, w: float, n_y: int) -> float:
    """Return a row by (y, w, 1)."""
    total = rows[e, n_y] * w + rows[e, n_y + 1]
    for k in range(n_y):
        total += rows[e, k] * y[k]
    return total


@inlined
def _rate(coefficients: FloatArray, n_c: int) -> float:
    """Return the slope of a polynomial at 1."""
    total = 0.0
    for k in range(1, n_c):
        total += k * coefficients[k]
    return total


@inlined
def fast(
    machine: Machine,
    store: Store,
    pieces: FloatArray,
    j: int,
    stop: int,
    stride: int,
    before: int,
    scales: FloatArray,
    series: MotionSeries,
    y: FloatArray,
    end: FloatArray,
    motion: FloatArray,
    accelerations: FloatArray,
    n: int,
    n_y: int,
) -> tuple[int, float]:
    """Carry the motion on until an event is near; return the piece and the share of it.

    It goes on to piece `stop`, and the results lack the first `before` samples.

    A part of a sample is taken if every event is still ahead at its end, and, where it was
    first approached and then left again, the tangents at both ends meet before it. A wall that
    is further away than any mass has ever gone in four parts needs no such care.
    """
    n_c = pieces.shape[1]
    slot = slot_of(machine, store)
    parts, n_events = store.parts[slot], store.n_events[slot]
    step, system, which = store.step[slot], store.system[slot], store.which[slot]
    events, slopes = store.events[slot], store.slopes[slot]
    for i in range(n_y):
        y[i] = series.y[i, 0]
    part = 0
    k_out = j // stride - before  # counted on, since a division takes as long as all the rest
    wait = stride - j % stride
    fastest = 0.0
    for i in range(n, 2 * n):
        if scales[i] > fastest:
            fastest = scales[i]
    while j < stop:
        c = pieces[j]
        if parts > 1:
            shift(pieces, j, part / parts, 1.0 / parts, series.w)
            c = series.w
        w = 0.0
        for k in range(n_c):
            w += c[k]
        for i in range(n_y):  # the motion last: only what comes after it has to wait for it
            total = step[i, n_y + n_c]
            for k in range(n_c):
                total += step[i, n_y + k] * c[k]
            for k in range(n_y):
                total += step[i, k] * y[k]
            end[i] = y[i] + total
        free = True
        for e in range(n_events):
            ahead = by_motion(events, e, end, w, n_y)
            if ahead >= 0.0:
                free = False
                break
            if ahead < -4.0 * fastest * store.part[slot] and wall(
                machine.lines[which[e, 0], LAW]
            ):
                continue
            down = -by_motion(slopes, e, end, w, n_y)
            if events[e, n_y] != 0.0:
                down -= events[e, n_y] * _rate(c, n_c)
            if down > 0.0:
                up = by_motion(slopes, e, y, c[0], n_y) + events[e, n_y] * c[1]
                if up > 0.0:
                    earlier = by_motion(events, e, y, c[0], n_y)
                    highest = ahead if ahead > earlier else earlier
                    if highest + up * down / (up + down) >= 0.0:
                        free = False
                        break
        if not free:
            break
        part += 1
        if part == parts:
            part = 0
            j += 1
            wait -= 1
            if wait == 0:
                wait = stride
                k_out += 1
                for i in range(n_y):
                    motion[k_out, i] = end[i]
                for i in range(n):
                    accelerations[k_out, i] = by_motion(system, n + i, end, w, n_y)
                if machine.reads >= 0:
                    accelerations[k_out, n] = by_motion(system, n_y, end, w, n_y)
        for i in range(n_y):
            y[i] = end[i]
            size = abs(end[i])
            if size > scales[i]:
                scales[i] = size
                if i >= n and i < 2 * n and size > fastest:
                    fastest = size
    for i in range(n_y):
        series.y[i, 0] = y[i]
    return j, part / parts


@inlined
def record(
    machine: Machine,
    time: float,
    series: MotionSeries,
    motion: FloatArray,
    accelerations: FloatArray,
    k: int,
) -> None:
    """Write down the motion in order 0, the input being in order 0 of `w`."""
    accelerate(machine, time, 0.0, 0, series)
    for i in range(series.y.shape[0]):
        motion[k, i] = series.y[i, 0]
    for i in range(series.a.shape[0]):
        accelerations[k, i] = series.a[i, 0]
