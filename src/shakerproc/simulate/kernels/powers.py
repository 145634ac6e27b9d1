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
    first: float,
    rate: float,
    amplitude: float,
    phase: float,
    step: float,
    pieces: FloatArray,
) -> None:
    """Set polynomials of a sine whose frequency changes evenly, by their Taylor series.

    Parameters
    ----------
    first, rate : float
        Frequency at time 0 [Hz], and how fast it changes [Hz/s].
    amplitude, phase : float
        Amplitude, and phase at time 0 [rad].
    step : float
        Length of an interval [s].
    pieces : (n_pieces, degree + 1) array
        Set: coefficients in rising powers of the share of the interval.
    """
    degree = pieces.shape[1] - 1
    bend = 2.0 * math.pi * rate * step * step
    for j in range(pieces.shape[0]):
        time = j * step
        turns = (0.5 * rate * time + first) * time
        angle = 2.0 * math.pi * (turns - math.floor(turns)) + phase
        speed = 2.0 * math.pi * (first + rate * time) * step
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
