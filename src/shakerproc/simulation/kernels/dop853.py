"""The driver for laws without a Taylor series everywhere: DOP853 on frozen branches.

Dormand and Prince's method of order 8 walks each branch as a smooth law; where an event has
happened by the end of a step, the step is taken again and again with other lengths until it
ends at the event.
"""

from typing import Final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models.compiled import compiled, inlined, inner
from shakerproc.simulation.kernels.motion import accelerate, begin, switch
from shakerproc.simulation.kernels.polynomials import value
from shakerproc.simulation.kernels.table import (
    DISPLACEMENT,
    HOLDING,
    MEMORY,
    STATE,
    Machine,
    MotionSeries,
)
from shakerproc.simulation.kernels.taylor import even_out, event_noise
from shakerproc.simulation.laws.table import event

_STAGES: Final = 12
_START: Final = 13  # rows of `work`: rates of the stages come first, at 12 those at the end
_END: Final = 14
_AHEAD: Final = 15  # events at the start, and at the end
_BEHIND: Final = 16
_LOAD: Final = 17  # largest holding force of each line at the stages of a step
WORK_ROWS: Final = 18

MOST_STEPS: Final = 20_000
"""Steps within a piece after which the motion counts as lost: its rates have run away [-]."""


@inlined
def _rates(
    machine: Machine, pieces: FloatArray, j: int, at: float, sample: float, series: MotionSeries
) -> None:
    """Set accelerations, rates of states and all lines at a share of a sample."""
    series.w[0] = value(pieces[j], 0, pieces.shape[1] - 1, at)
    accelerate(machine, (j + at) * sample, 0.0, 0, series)


@inner
def _step(
    machine: Machine,
    tableau: FloatArray,
    pieces: FloatArray,
    j: int,
    at: float,
    share: float,
    sample: float,
    series: MotionSeries,
    work: FloatArray,
) -> None:
    """Take one step from the motion in row START; the end goes to row END and to order 0.

    `tableau` (15, 13) holds the stages, the weights, two error estimates in its last rows,
    and the nodes in its last column.
    """
    n, n_y = machine.mass.size, series.y.shape[0]
    step = share * sample
    for row in range(machine.lines.shape[0]):
        work[_LOAD, row] = 0.0
    for stage in range(_STAGES + 1):
        for i in range(n_y):
            total = 0.0
            for k in range(stage):
                total += tableau[stage, k] * work[k, i]
            series.y[i, 0] = work[_START, i] + step * total
        node = tableau[stage, 12] if stage < _STAGES else 1.0
        _rates(machine, pieces, j, at + node * share, sample, series)
        for i in range(n):
            work[stage, i] = series.y[n + i, 0]
            work[stage, n + i] = series.a[i, 0]
        for i in range(2 * n, n_y):
            work[stage, i] = series.y[i, 1]
        for row in range(machine.lines.shape[0]):
            if abs(series.lines[row, HOLDING, 0]) > work[_LOAD, row]:
                work[_LOAD, row] = abs(series.lines[row, HOLDING, 0])
    for i in range(n_y):
        work[_END, i] = series.y[i, 0]


@inner
def _error(
    tableau: FloatArray,
    step: float,
    n_y: int,
    scales: FloatArray,
    tolerance: float,
    work: FloatArray,
) -> float:
    """Return the error of a step in units of the tolerance (Hairer's combined estimate)."""
    third, fifth = 0.0, 0.0
    for i in range(n_y):
        size = scales[i]
        if abs(work[_END, i]) > size:
            size = abs(work[_END, i])
        if size == 0.0:
            continue
        e5, e3 = 0.0, 0.0
        for k in range(_STAGES):
            e5 += tableau[13, k] * work[k, i]
            e3 += tableau[14, k] * work[k, i]
        fifth += (e5 / (tolerance * size)) ** 2
        third += (e3 / (tolerance * size)) ** 2
    if fifth == 0.0 and third == 0.0:
        return 0.0
    # err5^2 / sqrt(err5^2 + 0.01 err3^2), with the 0.01 of Hairer's and Wanner's dop853.f
    return step * fifth / ((fifth + 0.01 * third) * n_y) ** 0.5


@inner
def _watch(machine: Machine, series: MotionSeries, out: FloatArray) -> None:
    """Set every event from the lines in order 0: by how much it has happened."""
    for row in range(machine.lines.shape[0]):
        for which in range(2):
            kind, sign, level = event(machine, row, which)
            out[2 * row + which] = -1.0
            if kind >= 0:
                out[2 * row + which] = sign * series.lines[row, kind, 0] - level


@inner
def _slope(machine: Machine, row: int, kind: int, stage: int, work: FloatArray) -> float:
    """Return the rate of an event's function, at the start (stage 0) or the end (12)."""
    n = machine.mass.size
    if kind == STATE:
        return work[stage, 2 * n + machine.lines[row, MEMORY]]
    first = 0 if kind == DISPLACEMENT else n
    total = 0.0
    for i in range(n):
        total += machine.joints[row, i] * work[stage, first + i]
    return total


@inner
def _late(
    machine: Machine, share: float, sample: float, scales: FloatArray, work: FloatArray
) -> tuple[int, bool]:
    """Return the event that went furthest past its level in a step, -1 if none, and a doubt.

    The doubt is whether a level may have been passed and left again in between: the quantity
    came nearer at the start, goes away at the end, and the tangents meet behind the level. The
    force on a sticking joint has no tangents; it is looked at in every stage, and close to
    breaking away the steps are kept short.
    """
    found, furthest = -1, 0.0
    doubt = False
    step = share * sample
    for row in range(machine.lines.shape[0]):
        for which in range(2):
            kind, sign, _ = event(machine, row, which)
            if kind < 0:
                continue
            e = 2 * row + which
            before, now = work[_AHEAD, e], work[_BEHIND, e]
            if now > event_noise(machine, row, kind, scales):
                if found < 0 or now - before > furthest:
                    found, furthest = e, now - before
            elif kind != HOLDING:
                up = sign * _slope(machine, row, kind, 0, work) * step
                down = -sign * _slope(machine, row, kind, _STAGES, work) * step
                if up > 0.0 and down > 0.0:
                    highest = now if now > before else before
                    doubt = doubt or highest + up * down / (up + down) > 0.0
            else:
                load = work[_LOAD, row] / machine.values[row, 1]
                doubt = doubt or load > 1.0 or (load > 0.9 and share > 0.1)
    return found, doubt


@inner
def _locate(
    machine: Machine,
    tableau: FloatArray,
    pieces: FloatArray,
    j: int,
    at: float,
    share: float,
    sample: float,
    e: int,
    noise: float,
    series: MotionSeries,
    work: FloatArray,
) -> float:
    """Return the length of the step that ends at an event (false position, Illinois).

    What is above `noise` counts as past it.
    """
    low, high = 0.0, share
    below, above = work[_AHEAD, e], work[_BEHIND, e]
    if below >= 0.0:  # it started on the surface: has it left it first?
        low = 1e-3 * share
        _step(machine, tableau, pieces, j, at, low, sample, series, work)
        _watch(machine, series, work[_BEHIND])
        below = work[_BEHIND, e]
        if below >= 0.0:
            return 0.0
    side = 0
    length = high
    for _ in range(60):
        length = (low * above - high * below) / (above - below)
        _step(machine, tableau, pieces, j, at, length, sample, series, work)
        _watch(machine, series, work[_BEHIND])
        now = work[_BEHIND, e]
        if now > 0.0:
            high, above = length, now
            if side == 1:
                below *= 0.5
            side = 1
        else:
            low, below = length, now
            if side == -1:
                above *= 0.5
            side = -1
        if abs(now) <= noise or high - low < 1e-15 * share:
            break
    return length


@inner
def one_sample(
    machine: Machine,
    tableau: FloatArray,
    pieces: FloatArray,
    j: int,
    at: float,
    wanted: float,
    sample: float,
    tolerance: float,
    series: MotionSeries,
    work: FloatArray,
    scales: FloatArray,
    stats: FloatArray,
    most: int,
) -> float:
    """Carry the motion from a share `at` of a piece to its end, in so many steps at most.

    Returns
    -------
    float
        Step to try next, as a share of a piece, of which `wanted` was tried first.
    """
    n, n_y = machine.mass.size, series.y.shape[0]
    flips = 0
    last = stats[3] + most
    while at < 1.0:
        if stats[3] > last:
            series.y[0, 0] = np.inf  # as a motion that has run away is told
            return 1.0
        share = min(wanted, 1.0 - at)
        even_out(scales, n)
        _rates(machine, pieces, j, at, sample, series)
        for i in range(n_y):
            work[_START, i] = series.y[i, 0]
        _watch(machine, series, work[_AHEAD])
        _step(machine, tableau, pieces, j, at, share, sample, series, work)
        stats[3] += 1.0
        error = _error(tableau, share * sample, n_y, scales, tolerance, work)
        # the error grows with the eighth power of the step, hence exponents of -1/8
        if not error < 1.0 and share > 1e-9:
            wanted = share * max(0.2, 0.9 * error**-0.125) if error < 1e30 else 0.1 * share
            for i in range(n_y):
                series.y[i, 0] = work[_START, i]
            continue
        _watch(machine, series, work[_BEHIND])
        e, doubt = _late(machine, share, sample, scales, work)
        if doubt and share > 1e-3:
            wanted = 0.5 * share
            for i in range(n_y):
                series.y[i, 0] = work[_START, i]
            continue
        if e >= 0 and flips < 8 + 4 * machine.lines.shape[0]:
            length, other = share, e
            while other >= 0:  # until nothing else has happened before it
                e = other
                kind, _, _ = event(machine, e // 2, e % 2)
                noise = event_noise(machine, e // 2, kind, scales)
                length = _locate(
                    machine, tableau, pieces, j, at, length, sample, e, noise, series, work
                )  # fmt: skip
                _watch(machine, series, work[_BEHIND])
                work[_BEHIND, e] = -1.0
                other, _ = _late(machine, length, sample, scales, work)
                if length == 0.0:
                    break
            if length == 0.0:
                for i in range(n_y):
                    series.y[i, 0] = work[_START, i]
            _rates(machine, pieces, j, at + length, sample, series)
            switch(machine, e // 2, e % 2, (j + at + length) * sample, series)
            stats[1] += 1.0
            flips = flips + 1 if length < 1e-9 else 0
            at += length
        else:
            stats[4] += 1.0 if e >= 0 else 0.0
            flips = 0
            at = 1.0 if share == 1.0 - at else at + share
            growth = 0.9 * error**-0.125 if error > 1e-7 else 5.0
            wanted = min(max(wanted, share) * min(growth, 5.0), 1e9)
        stats[2] += min(error, 1.0) * tolerance * scales[0]
        stats[6] += min(error, 1.0) * tolerance * scales[n]
        for i in range(n_y):
            if abs(series.y[i, 0]) > scales[i]:
                scales[i] = abs(series.y[i, 0])
        if at > 1.0 - 1e-14:
            at = 1.0
    return wanted


@compiled
def integrate_dop853(
    machine: Machine,
    tableau: FloatArray,
    pieces: FloatArray,
    sample: float,
    stride: int,
    tolerance: float,
    series: MotionSeries,
    work: FloatArray,
    scales: FloatArray,
    motion: FloatArray,
    accelerations: FloatArray,
    stats: FloatArray,
) -> None:
    """Fill in the motion at the ends of the samples; status and time as `windows` tells them.

    Parameters
    ----------
    tableau : (15, 13) array
        See `_step`.
    work : (WORK_ROWS, any) array
        Room for as many numbers in a row as there are motions or twice the lines.
    scales : (n_y,) array
        Least size against which errors are held; becomes the largest motion.
    """
    n_y = series.y.shape[0]
    for i in range(n_y):
        if abs(series.y[i, 0]) > scales[i]:
            scales[i] = abs(series.y[i, 0])
    series.w[0] = pieces[0, 0]
    begin(machine, series)
    wanted = 1.0  # step, as a share of a sample
    for j in range(-1, pieces.shape[0]):
        if j >= 0:
            wanted = one_sample(
                machine, tableau, pieces, j, 0.0, wanted, sample, tolerance, series, work,
                scales, stats, MOST_STEPS,
            )  # fmt: skip
        if not abs(series.y[0, 0]) < 1e100:
            stats[0], stats[5] = 2.0, (j + 1) * sample
            return
        if (j + 1) % stride == 0:
            if j >= 0:
                _rates(machine, pieces, j, 1.0, sample, series)
            else:
                _rates(machine, pieces, 0, 0.0, sample, series)
            for i in range(n_y):
                motion[(j + 1) // stride, i] = series.y[i, 0]
            for i in range(series.a.shape[0]):
                accelerations[(j + 1) // stride, i] = series.a[i, 0]
    stats[5] = pieces.shape[0] * sample
