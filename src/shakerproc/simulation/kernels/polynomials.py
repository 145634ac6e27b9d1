"""Polynomials over intervals: through values, of a chirp; products, powers, first roots."""

import math
from typing import Final

from shakerproc.data import FloatArray
from shakerproc.models.compiled import compiled, inlined, inner
from shakerproc.simulation.kernels.table import BASE


@compiled
def through(
    values: FloatArray, nodes: FloatArray, inverse_distances: FloatArray, pieces: FloatArray
) -> None:
    """Set polynomials through values at nodes, of which neighbours share the outer ones.

    By divided differences, which keep all digits; an inverse loses six.

    Parameters
    ----------
    values : (n_pieces * degree + 1,) array
        At the nodes of each piece, the last being the first of the next.
    nodes : (degree + 1,) array
        Their places in a piece, from 0 to 1.
    inverse_distances : (degree + 1, degree + 1) array
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
                pieces[j, i] = (pieces[j, i] - pieces[j, i - 1]) * inverse_distances[
                    i - k - 1, i
                ]
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


NEVER: Final = 2.0
_PARTS: Final = 8
_LAST_STEP: Final = 1e-8


@inlined
def value(series: FloatArray, first: int, last: int, at: float) -> float:
    """Return the sum of series[k] at^(k - first) for k from first to last."""
    total = series[last]
    for k in range(last - 1, first - 1, -1):
        total = total * at + series[k]
    return total


@inlined
def slope(series: FloatArray, first: int, last: int, at: float) -> float:
    """Return the derivative of that sum."""
    total = (last - first) * series[last]
    for k in range(last - 1, first, -1):
        total = total * at + (k - first) * series[k]
    return total if last > first else 0.0


@inlined
def first_rise(series: FloatArray, last: int, noise: float, next_noise: float) -> float:
    """Return the first time in 0 to 1 at which a polynomial rises above 0, or NEVER.

    A coefficient of order 0 or 1 below its noise counts as 0: it is what is left of a surface
    that the motion has just been put on. Roots at 0 are divided out, so that such a surface
    is not found again.
    """
    first = 0
    if abs(series[0]) <= noise:
        first = 1
        if abs(series[1]) <= next_noise:
            first = 2
            while first < last and series[first] == 0.0:
                first += 1
    if series[first] > 0.0:
        return 0.0
    above, steepness = series[first], series[first + 1]
    for k in range(first + 1, last + 1):
        if series[k] > 0.0:
            above += series[k]
        if k > first + 1:
            steepness -= (k - first) * abs(series[k])
    if above < 0.0 or first >= last:
        return NEVER
    if steepness <= 0.0:
        return _bracketed_rise(series, first, last)
    end = value(series, first, last, 1.0)
    if end <= 0.0:
        return NEVER
    return _root(series, first, last, 0.0, 1.0)  # it rises all the way


@inner
def _bracketed_rise(series: FloatArray, first: int, last: int) -> float:
    """Return the first rise above 0 of a polynomial that is below 0 at 0."""
    low, up = 0.0, series[first + 1] > 0.0
    for i in range(1, _PARTS + 1):
        high = i / _PARTS
        now = value(series, first, last, high)
        still_up = slope(series, first, last, high) > 0.0
        if now <= 0.0 and up and not still_up:  # a summit in between
            top = _summit(series, first, last, low, high)
            if value(series, first, last, top) > 0.0:
                return _root(series, first, last, low, top)
        if now > 0.0:
            return _root(series, first, last, low, high)
        low, up = high, still_up
    return NEVER


@inner
def _summit(series: FloatArray, first: int, last: int, low: float, high: float) -> float:
    """Return where the slope falls through 0 between low and high (bisection)."""
    for _ in range(45):
        middle = 0.5 * (low + high)
        if slope(series, first, last, middle) > 0.0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@inner
def _root(series: FloatArray, first: int, last: int, low: float, high: float) -> float:
    """Return the root between low (below 0) and high (above 0): Newton, kept in between.

    A step of 1e-8 is the last: the next one would be its square times the bend over twice the
    steepness, which is what rounding of the terms leaves of the root anyway.
    """
    below, above = value(series, first, last, low), value(series, first, last, high)
    at = (low * above - high * below) / (above - below)
    for _ in range(80):
        now, steepness = series[last], 0.0
        for k in range(last - 1, first - 1, -1):
            steepness = steepness * at + now
            now = now * at + series[k]
        if now > 0.0:
            high = at
        else:
            low = at
        step = now / steepness if steepness > 0.0 else 2.0
        if low <= at - step <= high:
            at -= step
            if abs(step) < _LAST_STEP:
                return at
        else:
            at = 0.5 * (low + high)
        if high - low < 1e-16:
            return at
    return at


@inlined
def product(lines: FloatArray, row: int, x: int, y: int, order: int) -> float:
    """Return the coefficient of this order of the product of two series of a line."""
    total = 0.0
    for j in range(order + 1):
        total += lines[row, x, j] * lines[row, y, order - j]
    return total


@inlined
def power(lines: FloatArray, row: int, exponent: float, order: int) -> float:
    """Return the coefficient of a power of the series in plane BASE of a line.

    Whole powers by squaring and multiplying; the planes after BASE hold what comes in
    between. Other powers, of the absolute value, by the recurrence of x y' = p x' y, which
    ends at 0.
    """
    whole = int(exponent)
    if exponent != whole:
        total = 0.0
        if order == 0:
            total = abs(lines[row, BASE, 0]) ** exponent
        else:
            for j in range(1, order + 1):
                share = (exponent + 1.0) * j - order
                total += share * lines[row, BASE, j] * lines[row, BASE + 1, order - j]
            total /= order * lines[row, BASE, 0]
        lines[row, BASE + 1, order] = total
        return total
    bit = 1
    while 2 * bit <= whole:
        bit *= 2
    plane = BASE
    bit //= 2
    while bit > 0:
        lines[row, plane + 1, order] = product(lines, row, plane, plane, order)
        plane += 1
        if whole & bit:
            lines[row, plane + 1, order] = product(lines, row, plane, BASE, order)
            plane += 1
        bit //= 2
    return lines[row, plane, order]
