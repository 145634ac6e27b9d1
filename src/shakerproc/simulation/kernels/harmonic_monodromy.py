"""How a small disturbance of a periodic motion has changed after one period."""

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models.compiled import compiled

TERMS = 16


@compiled
def multiply(left: FloatArray, right: FloatArray, out: FloatArray) -> None:
    """Set `out` to the product of two small square matrices."""
    size = left.shape[0]
    for i in range(size):
        for k in range(size):
            total = 0.0
            for j in range(size):
                total += left[i, j] * right[j, k]
            out[i, k] = total


@compiled
def exponential(matrix: FloatArray, rooms: FloatArray) -> FloatArray:
    """Return the exponential of a small matrix, by its series after halving.

    The matrix is overwritten; `rooms` is a (3, size, size) array to work in, and the result is
    one of its parts.
    """
    size = matrix.shape[0]
    norm = 0.0
    for i in range(size):
        row = 0.0
        for j in range(size):
            row += abs(matrix[i, j])
        norm = max(norm, row)
    halvings, scale = 0, 1.0
    while norm * scale > 0.5:
        scale *= 0.5
        halvings += 1
    matrix *= scale
    result, term, other = rooms[0], rooms[1], rooms[2]
    for i in range(size):
        for j in range(size):
            result[i, j] = term[i, j] = 1.0 if i == j else 0.0
    bound = 1.0
    for n in range(1, TERMS):
        multiply(term, matrix, other)
        term, other = other, term
        term /= n
        result += term
        bound *= norm * scale / n
        if bound < 1e-18:
            break
    for _ in range(halvings):
        multiply(result, result, other)
        result, other = other, result
    return result


@compiled
def propagate(
    durations: FloatArray, early: FloatArray, late: FloatArray, jumps: FloatArray
) -> FloatArray:
    r"""Return the product of the propagators of all spans (Magnus, fourth order).

    .. math:: \Omega = \tfrac{h}{2} (A_1 + A_2) + \tfrac{\sqrt3 h^2}{12} [A_2, A_1]

    Where the two matrices are the same it is exact. The commutator has no trace, so that the
    determinant is that of the flow whatever the step.

    Parameters
    ----------
    durations : (n_spans,) array
        Length of each span [s].
    early, late : (n_spans, size, size) array
        Rate of change of a disturbance at the two Gauss points of each span [1/s].
    jumps : (n_spans, size, size) array
        What happens to the disturbance at the end of each span.

    Returns
    -------
    (size, size) array
        Disturbance after over disturbance before.

    References
    ----------
    .. [1] A. Iserles and S. P. Nørsett, "On the solution of linear differential equations in
       Lie groups", Philosophical Transactions A 357, 983-1019, 1999.
    """
    size = early.shape[1]
    result, other, twist = np.eye(size), np.empty((size, size)), np.empty((size, size))
    rooms = np.empty((3, size, size))
    for i in range(durations.size):
        h = durations[i]
        multiply(late[i], early[i], twist)
        multiply(early[i], late[i], other)
        for j in range(size):
            for k in range(size):
                turn = np.sqrt(3.0) / 12.0 * h * h * (twist[j, k] - other[j, k])
                twist[j, k] = 0.5 * h * (early[i, j, k] + late[i, j, k]) + turn
        step = exponential(twist, rooms)
        multiply(step, result, other)
        multiply(jumps[i], other, result)
    return result
