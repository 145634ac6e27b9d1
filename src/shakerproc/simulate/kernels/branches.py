"""Every combination of branches of a piecewise-linear model: rates, events, propagators."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.models.compiled import compiled, inlined
from shakerproc.simulate.kernels.modes import event
from shakerproc.simulate.kernels.motion import accelerate
from shakerproc.simulate.kernels.table import Machine, Series, Store

_SMALL: Final = 0.25
_TERMS: Final = 14


@compiled
def set_rates_and_events(
    machine: Machine, combinations: NDArray[np.int64], series: Series, store: Store
) -> None:
    """Set the fields `system`, `events`, `which` and `n_events` of a store.

    The laws themselves are asked: order 1 of their series is what they make of a unit of one
    motion or of the input, order 0 at rest what they are without any.

    Parameters
    ----------
    machine : Machine
        The model; its branches are written to.
    combinations : (s, r) array of int
        Branch of each line.
    series : Series
        Room.
    store : Store
        Zeros.
    """
    n, n_y = machine.mass.size, series.y.shape[0]
    for s in range(combinations.shape[0]):
        for row in range(combinations.shape[1]):
            machine.mode[row, 0] = combinations[s, row]
        for column in range(n_y + 2):
            order = 1 if column <= n_y else 0
            for i in range(n_y):
                series.y[i, order] = 1.0 if i == column else 0.0
            series.w[order] = 1.0 if column == n_y else 0.0
            accelerate(machine, 0.0, 1.0, order, series)
            for i in range(n):
                store.system[s, i, column] = series.y[n + i, order]
                store.system[s, n + i, column] = series.a[i, order]
            for i in range(2 * n, n_y):
                store.system[s, i, column] = series.y[i, order + 1]
            e = 0
            for row in range(combinations.shape[1]):
                for which in range(2):
                    kind, sign, level = event(machine, row, which)
                    if kind < 0:
                        continue
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
        _multiply(total, total, 1.0, other)
        for i in range(size):
            for j in range(size):
                total[i, j] = 2.0 * total[i, j] + other[i, j]


@compiled
def set_propagators(units: FloatArray, room: FloatArray, store: Store) -> None:
    """Set the fields `slopes` and `step` of a store, the latter less 1.

    By (y, c, 1) they give what is added to y, so that their rounding is that of the small
    change. exp of [[A, b, 0], [0, J, 0]] holds the integrals of exp(A (1 - x)) b x^k / k! in
    its columns, where J shifts (Al-Mohy and Higham, SIAM J. Sci. Comput. 33, 488-511, 2011).

    Parameters
    ----------
    units : (s, n_y) array
        Units of displacement, velocity and state in which the rates are of one size.
    room : (4, n_y + degree + 2, n_y + degree + 2) array
        Room.
    store : Store
        Its other fields are there.
    """
    part = store.part
    n_y, size = units.shape[1], room.shape[1]
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
            big[i, size - 1] = scale * store.system[s, i, n_y + 1]
        for i in range(n_y, size - 2):
            big[i, i + 1] = 1.0
        _exponential_less_one(big, room[2], room[3], total)
        for i in range(n_y):
            for k in range(n_y):
                store.step[s, i, k] = total[i, k] * units[s, i] / units[s, k]
            factorial = units[s, i]
            for k in range(n_y, size - 1):
                factorial *= max(1, k - n_y)
                store.step[s, i, k] = total[i, k] * factorial
            store.step[s, i, size - 1] = total[i, size - 1] * units[s, i]
        for e in range(store.n_events[s]):
            for k in range(n_y + 2):
                store.slopes[s, e, k] = 0.0
                for i in range(n_y):
                    rise = store.events[s, e, i] * store.system[s, i, k]
                    store.slopes[s, e, k] += part[s] * rise
