"""Every combination of branches of a piecewise-linear model: rates, events, propagators."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.models.compiled import compiled, inlined, vectorised
from shakerproc.simulation.kernels.motion import (
    between,
    hold,
    push_and_read,
    read_linear,
    sticks,
)
from shakerproc.simulation.kernels.table import (
    DISPLACEMENT,
    FORCE_TERMS,
    HOLDING,
    MEMORY,
    STATE,
    VELOCITY,
    Machine,
    MotionSeries,
    Store,
)
from shakerproc.simulation.laws.table import event, law_series

_SMALL: Final = 0.25
_TERMS: Final = 14


@inlined
def _accelerate_linear(
    machine: Machine, order: int, store: Store, unit: int, series: MotionSeries
) -> None:
    """Do as `motion.accelerate_here`, with 1 N of one carried force and none of the others."""
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
        state = machine.lines[row, MEMORY]
        if state >= 0:
            series.lines[row, STATE, order] = series.y[2 * n + state, order]
        if sticks(machine, row):
            held += 1
            continue
        force, rate = 0.0, 0.0
        if store.force_of[row] < 0:
            force, rate = law_series(machine, row, order, 0.0, 1.0, series.lines)
        elif store.force_of[row] == unit:
            force = 1.0
        push_and_read(machine, row, force, series.a, order)
        if state >= 0:
            series.y[2 * n + state, order + 1] = rate
    if held > 0:
        hold(machine, held, order, series)


@compiled
def set_rates_and_events(
    machine: Machine, combinations: NDArray[np.int64], series: MotionSeries, store: Store
) -> None:
    """Set the fields `system`, `push`, `events`, `which` and `n_events` of a store.

    The laws themselves are asked: order 1 of their series is what they make of a unit of one
    motion or of the input, order 0 at rest what they are without any.

    Parameters
    ----------
    machine : Machine
        The model; its branches are written to.
    combinations : (s, r) array of int
        Branch of each line.
    series : MotionSeries
        Room.
    store : Store
        Zeros.
    """
    n, n_y, n_forces = machine.mass.size, series.y.shape[0], store.push.shape[2]
    for s in range(combinations.shape[0]):
        for row in range(combinations.shape[1]):
            machine.mode[row, 0] = combinations[s, row]
        for column in range(n_y + 2 + n_forces):
            order = 0 if column == n_y + 1 else 1
            force = column - n_y - 2
            for i in range(n_y):
                series.y[i, order] = 1.0 if i == column else 0.0
            series.w[order] = 1.0 if column == n_y else 0.0
            _accelerate_linear(machine, order, store, force, series)
            for i in range(series.a.shape[0]):
                if force >= 0:
                    store.push[s, i, force] = series.a[i, order]
                elif i == n:
                    store.system[s, n_y, column] = series.a[n, order]
            for i in range(n):
                if force >= 0:
                    break
                store.system[s, i, column] = series.y[n + i, order]
                store.system[s, n + i, column] = series.a[i, order]
            for i in range(2 * n, n_y):
                if force < 0:
                    store.system[s, i, column] = series.y[i, order + 1]
            e = 0
            for row in range(combinations.shape[1]):
                for which in range(2):
                    kind, sign, level = event(machine, row, which)
                    if kind < 0 or (store.force_of[row] >= 0 and kind != HOLDING):
                        continue  # those of carried lines change with their branch
                    store.events[s, e, column] = sign * series.lines[row, kind, order]
                    if order == 0:
                        store.events[s, e, column] -= level
                    store.which[s, e, 0], store.which[s, e, 1] = row, which
                    e += 1
            store.n_events[s] = e


@inlined
def _multiply(left: FloatArray, right: FloatArray, factor: float, out: FloatArray) -> None:
    """Set a product of two square matrices, times a factor."""
    size = left.shape[0]
    for i in range(size):
        for j in range(size):
            out[i, j] = 0.0
        for k in range(size):
            share = factor * left[i, k]
            if share != 0.0:
                for j in range(size):
                    out[i, j] += share * right[k, j]


@inlined
def _exponential_less_one(
    matrix: FloatArray, term: FloatArray, other: FloatArray, total: FloatArray
) -> None:
    """Set `total` to exp(A) - 1, by series, scaling and doubling; the others are used up."""
    size = matrix.shape[0]
    norm = 0.0
    for i in range(size):
        row = 0.0
        for j in range(size):
            row += abs(matrix[i, j])
        norm = max(norm, row)
    doublings, scale = 0, 1.0
    while norm * scale > _SMALL:
        doublings, scale = doublings + 1, 0.5 * scale
    for i in range(size):
        for j in range(size):
            matrix[i, j] *= scale
            term[i, j] = matrix[i, j]
            total[i, j] = matrix[i, j]
    for order in range(2, _TERMS + 1):
        _multiply(term, matrix, 1.0 / order, other)
        for i in range(size):
            for j in range(size):
                term[i, j] = other[i, j]
                total[i, j] += other[i, j]
    for _ in range(doublings):
        # exp(2 A) - 1 = 2 (exp(A) - 1) + (exp(A) - 1)^2 loses no digits (decision 16)
        _multiply(total, total, 1.0, other)
        for i in range(size):
            for j in range(size):
                total[i, j] = 2.0 * total[i, j] + other[i, j]


@vectorised
def set_propagators(units: FloatArray, room: FloatArray, store: Store) -> None:
    """Set the fields `slopes` and `step` of a store, the latter less 1.

    By (y, c, 1, forces) they give what is added to y, so that their rounding is that of the
    small change. exp of [[A, b, 0], [0, J, 0]] holds the integrals of exp(A (1 - x)) b x^k / k!
    in its columns, where J shifts (Al-Mohy and Higham, SIAM J. Sci. Comput. 33, 488-511, 2011).

    Parameters
    ----------
    units : (s, n_y) array
        Units of displacement, velocity and state in which the rates are of one size.
    room : (4, size, size) array, size = n_y + degree + 2 + 6 m
        Room.
    store : Store
        Its other fields are there.
    """
    part, n_forces = store.part, store.push.shape[2]
    n_y, size = units.shape[1], room.shape[1]
    n, last = store.push.shape[1] - 1, size - 1
    n_c = last - n_y - FORCE_TERMS * n_forces
    big, total = room[0], room[1]
    for s in range(part.size):
        for i in range(size):
            for j in range(size):
                big[i, j] = 0.0
        for i in range(n_y):
            scale = part[s] / units[s, i]
            for k in range(n_y):
                big[i, k] = scale * store.system[s, i, k] * units[s, k]
            big[i, n_y] = scale * store.system[s, i, n_y]
            big[i, last] = scale * store.system[s, i, n_y + 1]
            for f in range(n_forces):
                if n <= i < 2 * n:
                    big[i, n_y + n_c + FORCE_TERMS * f] = scale * store.push[s, i - n, f]
        for i in range(n_y, last - 1):
            place = i - n_y - n_c
            ends = place == -1 or (place >= 0 and place % FORCE_TERMS == FORCE_TERMS - 1)
            big[i, i + 1] = 0.0 if ends else 1.0
        _exponential_less_one(big, room[2], room[3], total)
        for i in range(n_y):
            for k in range(n_y):
                store.step[s, i, k] = total[i, k] * units[s, i] / units[s, k]
            factorial = units[s, i]
            for k in range(n_c):
                factorial *= max(1, k)
                store.step[s, i, n_y + k] = total[i, n_y + k] * factorial
            store.step[s, i, n_y + n_c] = total[i, last] * units[s, i]
            for f in range(n_forces):
                factorial = units[s, i]
                for k in range(FORCE_TERMS):
                    factorial *= max(1, k)
                    column = n_y + n_c + FORCE_TERMS * f + k
                    store.step[s, i, column + 1] = total[i, column] * factorial
        for e in range(store.n_events[s]):
            for k in range(n_y + 2 + n_forces):
                store.slopes[s, e, k] = 0.0
                if k >= n_y + 2:
                    for i in range(n):
                        rise = store.events[s, e, n + i] * store.push[s, i, k - n_y - 2]
                        store.slopes[s, e, k] += part[s] * rise
                    continue
                for i in range(n_y):
                    rise = store.events[s, e, i] * store.system[s, i, k]
                    store.slopes[s, e, k] += part[s] * rise
