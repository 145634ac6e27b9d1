"""The driver of windows of one test, or of all of it, nudged or free."""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.models.compiled import compiled, inlined, inner
from shakerproc.simulation.kernels.carried_forces import CarriedForces
from shakerproc.simulation.kernels.carrying import carry
from shakerproc.simulation.kernels.dop853 import one_sample
from shakerproc.simulation.kernels.exact import fast, record
from shakerproc.simulation.kernels.motion import (
    accelerate,
    begin,
    between,
    mobility,
    push,
    settle,
    sticks,
)
from shakerproc.simulation.kernels.table import (
    FRICTION,
    HOLDING,
    IWAN,
    JENKINS,
    LAW,
    MEMORY,
    SERIES,
    Machine,
    MotionSeries,
    Store,
)
from shakerproc.simulation.kernels.taylor import careful
from shakerproc.simulation.laws.elements_in_series import series_slip
from shakerproc.simulation.laws.table import follow, start


class Nudges(NamedTuple):
    """How the motion of a test is nudged, after every sample.

    Attributes
    ----------
    measured : (n_samples, m) array
        What the motion is held to: m combinations of displacements [m] and velocities [m/s]. No
        column, and the run is free.
    sees : (m, 2 n) array
        The same combinations of the model's displacements and velocities.
    gain : (2 n, m) array
        How far a difference moves each displacement and velocity.
    lead : int
        Samples of a window after which it is let go.
    difference : (m,) array
        Room for the differences.
    """

    measured: FloatArray
    sees: FloatArray
    gain: FloatArray
    lead: int
    difference: FloatArray


@inlined
def held_until(nudges: Nudges, first: int) -> int:
    """Return the last sample at which a window that begins at `first` is nudged."""
    return first + nudges.lead if nudges.measured.shape[1] > 0 else first


@inner
def nudge(
    machine: Machine,
    nudges: Nudges,
    sample: int,
    time: float,
    period: float,
    series: MotionSeries,
) -> None:
    """Move the motion in order 0 towards the measurement at a sample.

    The input at this instant stands in order 0 of `w`; `period` is that of the samples [s].
    """
    n, n_lines = machine.mass.size, machine.lines.shape[0]
    held = False
    for row in range(n_lines):
        held = held or sticks(machine, row)
    if held:  # what the joints that stick carry before
        accelerate(machine, time, 0.0, 0, series)
    for i in range(nudges.difference.size):
        total = nudges.measured[sample, i]
        for k in range(2 * n):
            total -= nudges.sees[i, k] * series.y[k, 0]
        nudges.difference[i] = total
    for k in range(2 * n):
        for i in range(nudges.difference.size):
            series.y[k, 0] += nudges.gain[k, i] * nudges.difference[i]
    for row in range(n_lines):
        _go_on(machine, row, period, series)
    if held:
        settle(machine, time, series)


@inlined
def _go_on(machine: Machine, row: int, period: float, series: MotionSeries) -> None:
    """Set the branch of a line whose motion was changed, with its memory kept."""
    n, law, mode = machine.mass.size, machine.lines[row, LAW], machine.mode[row, 0]
    displacement = between(machine, row, series.y, 0, 0)
    velocity = between(machine, row, series.y, n, 0)
    direction = 1 if velocity >= 0.0 else -1
    if law == FRICTION:
        if mode != 0 or not _resists(machine, row, velocity, period, series):
            machine.mode[row, 0] = direction
    elif law == JENKINS:
        if mode * direction < 0:
            machine.mode[row, 0] = 0
    elif law == IWAN:
        if mode * direction < 0:
            follow(machine, row, 0, displacement)
    elif law == SERIES and (mode == 2 or mode == -2):
        slips = 0.5 * mode * velocity >= series_slip(machine, row)
        machine.mode[row, 0] = mode if slips else mode // 2
    else:
        memory = machine.lines[row, MEMORY]
        state = series.y[2 * n + memory, 0] if memory >= 0 else 0.0
        start(machine, row, displacement, velocity, state)


@inlined
def _resists(
    machine: Machine, row: int, velocity: float, period: float, series: MotionSeries
) -> bool:
    """Return whether a joint that sticks takes a nudge up, and if so take it away.

    It acts like a force over the sample that follows, on top of what the joint carries.
    """
    easy = mobility(machine, row, row)
    if velocity == 0.0 or easy == 0.0:
        return velocity == 0.0
    impulse = velocity / easy
    if abs(series.lines[row, HOLDING, 0] + impulse / period) > machine.values[row, 1]:
        return False
    push(machine, row, impulse, series.y, machine.mass.size, 0)
    return True


LARGEST: Final = 1e100
"""Motion past it has run away [SI]."""

FREE_STEPS: Final = 2000
"""So many are free, whatever the length of the window, and so many may fall into one piece of
the input: a law that takes more is too fast for any sample to tell."""

MOST_IDLE: Final = 15
"""Samples that series carry before propagators are tried again: 1, 3, 7 and at most so many
after failures in a row [-]."""

DONE: Final = 0
STUCK: Final = 1
DIVERGED: Final = 2


@inlined
def _give_up(status: int, time: float, stats: FloatArray) -> int:
    """Return -1, and set why and when a window failed."""
    stats[0], stats[5] = status, time
    return -1


@inlined
def _walk(
    machine: Machine,
    store: Store,
    analytic: bool,
    tableau: FloatArray,
    pieces: FloatArray,
    j: int,
    stop: int,
    stride: int,
    span: int,
    before: int,
    sample: float,
    tolerance: float,
    series: MotionSeries,
    room: FloatArray,
    forces: CarriedForces,
    work: FloatArray,
    motion: FloatArray,
    accelerations: FloatArray,
    stats: FloatArray,
    patience: float,
    nudges: Nudges,
    until: int,
) -> int:
    """Carry the motion from piece j towards `stop`; return where it is, or -1 if it cannot."""
    scales = room[3]
    n, n_y, tables = machine.mass.size, series.y.shape[0], store.parts.size > 0
    linear = tables and store.push.shape[2] == 0
    passed, wanted, weary = 0.0, 1.0, stats[3] + patience
    idle, missed = 0, 0
    while j < stop and stats[3] < weary:
        end = min(stop, j + stride - j % stride) if j < until * stride else stop
        if linear and n == 1 and n_y == 2:
            j, passed = fast(
                machine, store, pieces, j, end, stride, before, scales, series, room[0],
                room[1], motion, accelerations, 1, 2,
            )  # fmt: skip
        elif linear:
            j, passed = fast(
                machine, store, pieces, j, end, stride, before, scales, series, room[0],
                room[1], motion, accelerations, n, n_y,
            )  # fmt: skip
        elif tables and idle > 0:
            idle -= 1
        elif tables:
            from_here = j
            j, passed = carry(
                machine, store, pieces, j, end, stride, before, sample, tolerance, scales,
                series, forces, motion, accelerations, n, n_y,
            )  # fmt: skip
            missed = 0 if j > from_here or passed > 0.0 else min(2 * missed + 1, MOST_IDLE)
            idle = missed
        if j == end:
            _nudge_here(machine, nudges, pieces, j, stride, sample, series, until)
            continue
        reached = careful(
            machine, store, analytic, pieces, j, passed, sample, scales, tolerance, series,
            room[2], room[1], stats, span, before, motion, accelerations,
        )  # fmt: skip
        if reached < 1.0 and analytic:
            status = STUCK if abs(series.y[0, 0]) < LARGEST else DIVERGED
            return _give_up(status, (j + reached) * sample, stats)
        if reached < 1.0:
            wanted = one_sample(
                machine, tableau, pieces, j, reached, wanted, sample, tolerance, series, work,
                scales, stats, FREE_STEPS,
            )  # fmt: skip
        j += 1
        passed = 0.0
        if not abs(series.y[0, 0]) < LARGEST:
            return _give_up(DIVERGED, j * sample, stats)
        row = j * span // stride - before
        if j % stride == 0 and row < motion.shape[0]:
            series.w[0] = 0.0
            for k in range(pieces.shape[1]):
                series.w[0] += pieces[j - 1, k]
            record(machine, j * sample, series, motion, accelerations, row)
            _nudge_here(machine, nudges, pieces, j, stride, sample, series, until)
    return j if abs(series.y[0, 0]) < LARGEST else _give_up(DIVERGED, j * sample, stats)


@inlined
def _nudge_here(
    machine: Machine,
    nudges: Nudges,
    pieces: FloatArray,
    j: int,
    stride: int,
    sample: float,
    series: MotionSeries,
    until: int,
) -> None:
    """Nudge the motion at the end of piece j - 1, where that ends a sample up to `until`."""
    if j % stride != 0 or j > until * stride:
        return
    series.w[0] = 0.0
    for k in range(pieces.shape[1]):
        series.w[0] += pieces[j - 1, k]
    nudge(machine, nudges, j // stride, j * sample, stride * sample, series)


@compiled
def walk_windows(
    machine: Machine,
    store: Store,
    analytic: bool,
    tableau: FloatArray,
    pieces: FloatArray,
    sample: float,
    stride: int,
    span: int,
    windows: NDArray[np.int64],
    starts: FloatArray,
    least: FloatArray,
    tolerance: float,
    series: MotionSeries,
    room: FloatArray,
    forces: CarriedForces,
    work: FloatArray,
    cursor: NDArray[np.int64],
    failed: NDArray[np.bool_],
    motion: FloatArray,
    accelerations: FloatArray,
    stats: FloatArray,
    patience: float,
    most: float,
    nudges: Nudges,
) -> int:
    """Fill in the next rows of the motion in all windows, one after the other.

    Parameters
    ----------
    machine : Machine
        The model; its branches are set first.
    store : Store
        Propagators, or one without slots where some law is not piecewise linear.
    analytic : bool
        Whether series carry the motion past switchings; otherwise DOP853 does.
    tableau, work
        See `dop853.integrate_dop853`.
    pieces : (n_pieces, degree + 1) array
        Input over each piece, in powers of the share of it that has passed; degree >= 1.
    sample : float
        Length of a piece [s].
    stride : int
        How many pieces lie between the rows of the results.
    span : int
        How many rows of the results a piece covers; 1 where there are propagators or several
        windows, or where the results have not all rows.
    windows : (n_windows, 2) array of int
        First sample and number of samples of each.
    starts : (n_windows, n_y) array
        Motion at the first sample of each.
    least : (n_y,) array
        Least size of each motion that errors are compared with.
    tolerance : float
        Truncation of a series, as a share of the largest motion so far [-].
    series : MotionSeries
        Room.
    room : (4, any) array
        Room for as many numbers in a row as there are orders, motions or events.
    forces : CarriedForces
        Room.
    cursor : (4,) array of int
        Window, samples of it that are done, piece, and steps around switchings in the window
        so far; goes on from there. Written to.
    failed : (n_windows,) array of bool
        Written to; the rows of such a window are left as they are.
    motion, accelerations : (n_rows, n_y) and (n_rows, n) array
        Set, as many rows as are done: displacements [m], velocities [m/s] and states, and
        accelerations [m/s^2], relative to the base.
    stats : (7,) array
        Added to: number of switchings in [1], sum of truncation errors of displacement [m] and
        of velocity [m/s] in [2] and [6], number of series in [3], steps forced past events in
        [4]. Of the last window that failed, status in [0] and time [s] in [5].
    patience : float
        Steps outside the propagators after which to return in any case.
    most : float
        Steps for each sample of a window, on average, past which it has failed.
    nudges : Nudges
        What the motion is held to.

    Returns
    -------
    int
        Rows that are done.
    """
    scales, row, n_y = room[3], 0, series.y.shape[0]
    while cursor[0] < windows.shape[0] and row < motion.shape[0]:
        window = cursor[0]
        first, count = windows[window, 0], windows[window, 1]
        if cursor[1] == 0:
            finite = True
            for i in range(n_y):
                series.y[i, 0] = starts[window, i]
                finite = finite and abs(series.y[i, 0]) < LARGEST
                scales[i] = max(least[i], abs(series.y[i, 0]))
            failed[window] = not finite
            cursor[2], cursor[3] = first * stride // span, 0
            if finite:
                at_end = cursor[2] == pieces.shape[0]
                last = cursor[2] - 1 if at_end else cursor[2]
                series.w[0] = pieces[last, 0]
                for k in range(1, pieces.shape[1]):
                    series.w[0] += pieces[last, k] if at_end else 0.0
                begin(machine, series)
                record(machine, cursor[2] * sample, series, motion, accelerations, row)
            cursor[1] = 1
            row += 1
        rows = min(count - cursor[1], motion.shape[0] - row)
        if rows > 0 and not failed[window]:
            here, steps = first + cursor[1], stats[3]
            reached = _walk(
                machine, store, analytic, tableau, pieces, cursor[2],
                -(-(here + rows - 1) * stride // span), stride, span, here - row, sample,
                tolerance, series, room, forces, work, motion, accelerations, stats, patience,
                nudges, held_until(nudges, first),
            )  # fmt: skip
            cursor[3] += int(stats[3] - steps)
            if reached < 0 or cursor[3] > most * count + FREE_STEPS:
                failed[window] = True
            else:
                done = min(reached * span // stride - here + 1, rows)
                cursor[1] += done
                cursor[2] = reached
                row += done
                if done < rows:
                    return row
                rows = 0
        cursor[1] += rows
        row += rows
        if cursor[1] == count:
            cursor[0] += 1
            cursor[1] = 0
    return row
