"""The first time at which a polynomial on 0 to 1 rises above 0."""

from typing import Final

from shakerproc.data import FloatArray
from shakerproc.models.compiled import inlined, inner

NEVER: Final = 2.0
_GOLDEN: Final = 0.6180339887498949
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
