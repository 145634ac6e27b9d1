"""Polynomials over intervals: through values at nodes, and of a chirp."""

import math

from shakerproc.data import FloatArray
from shakerproc.models.compiled import compiled


@compiled
def through(
    values: FloatArray, nodes: FloatArray, apart: FloatArray, pieces: FloatArray
) -> None:
    """Set polynomials through values at nodes, of which neighbours share the outer ones.

    By divided differences, which keep all digits; an inverse loses six.

    Parameters
    ----------
    values : (n_pieces * degree + 1,) array
        At the nodes of each piece, the last being the first of the next.
    nodes : (degree + 1,) array
        Their places in a piece, from 0 to 1.
    apart : (degree + 1, degree + 1) array
        One over the distance of the second node from the first.
    pieces : (n_pieces, degree + 1) array
        Set: coefficients in rising powers of the share of the piece.

    References
    ----------
    .. [1] A. Bjorck and V. Pereyra, "Solution of Vandermonde systems of equations",
       Mathematics of Computation 24, 893-903, 1970.
    """
    degree = nodes.size - 1
    for j in range(pieces.shape[0]):
        for i in range(degree + 1):
            pieces[j, i] = values[j * degree + i]
        for k in range(degree):
            for i in range(degree, k, -1):
                pieces[j, i] = (pieces[j, i] - pieces[j, i - 1]) * apart[i - k - 1, i]
        for k in range(degree - 1, 0, -1):  # the first node is 0
            for i in range(k, degree):
                pieces[j, i] -= nodes[k] * pieces[j, i + 1]


@compiled
def chirp_pieces(
    turning: tuple[float, float],
    bending: tuple[float, float],
    amplitude: float,
    phase: float,
    pieces: FloatArray,
) -> None:
    """Set polynomials of a sine whose frequency changes evenly, by their Taylor series.

    Many turns at once would cost the sine its digits. So the turns by interval come in two
    parts: products of the first with whole numbers are exact, and lose their whole turns
    before the second is added.

    Parameters
    ----------
    turning, bending : (float, float)
        Turns of the sine in an interval at time 0, and what they grow by with the square of
        the number of intervals, each a number of few bits and the rest.
    amplitude, phase : float
        Amplitude, and phase at time 0 [rad].
    pieces : (n_pieces, degree + 1) array
        Set: coefficients in rising powers of the share of the interval.
    """
    degree = pieces.shape[1] - 1
    turns_by_square = bending[0] + bending[1]
    bend = 4.0 * math.pi * turns_by_square
    for j in range(pieces.shape[0]):
        square = float(j) * j
        exact, more = bending[0] * square, turning[0] * j
        turns = exact - math.floor(exact) + more - math.floor(more)
        turns += bending[1] * square + turning[1] * j
        angle = 2.0 * math.pi * turns + phase
        speed = 2.0 * math.pi * (turning[0] + turning[1] + 2.0 * turns_by_square * j)
        sine, cosine = amplitude * math.sin(angle), amplitude * math.cos(angle)
        sine_before, cosine_before = 0.0, 0.0
        pieces[j, 0] = sine
        for k in range(1, degree + 1):
            share = 1.0 / k
            next_sine = share * (speed * cosine + bend * cosine_before)
            next_cosine = -share * (speed * sine + bend * sine_before)
            sine_before, cosine_before = sine, cosine
            sine, cosine = next_sine, next_cosine
            pieces[j, k] = sine
