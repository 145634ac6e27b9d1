"""A reference that shares nothing with the program: one mass, Taylor series, 64-bit mantissa.

Coefficients in numpy's long double, a fixed order, steps of a fixed length, each switching
found by bisection on the polynomial. Slow, and as plain as possible.
"""

from dataclasses import dataclass

import numpy as np

EXTENDED = np.longdouble
ORDER = 22


@dataclass
class Oscillator:
    """m x'' + c x' + k x + (contact, cubic, friction) = force."""

    mass: float = 1.0
    damping: float = 0.0
    stiffness: float = 0.0
    contact: float = 0.0
    clearance: float = 0.0
    cubic: float = 0.0
    friction: float = 0.0


def chirp_series(amplitude, rate, start, step, *, cosine=False):
    """Series of amplitude sin(pi rate t^2), or its cosine, in powers of the share of a step."""
    pi = EXTENDED("3.14159265358979323846264338327950288")
    first, second = 2 * pi * rate * start * step, pi * rate * step * step
    angle = pi * rate * start * start
    sine, cosines = np.zeros(ORDER + 1, EXTENDED), np.zeros(ORDER + 1, EXTENDED)
    sine[0], cosines[0] = np.sin(angle), np.cos(angle)
    for k in range(1, ORDER + 1):
        s = first * cosines[k - 1] + (2 * second * cosines[k - 2] if k > 1 else 0)
        c = first * sine[k - 1] + (2 * second * sine[k - 2] if k > 1 else 0)
        sine[k], cosines[k] = s / k, -c / k
    return amplitude * (cosines if cosine else sine)


def line_series(left, right, start, step):
    """Series of the straight line from left (share 0) to right (share 1) over part of it."""
    series = np.zeros(ORDER + 1, EXTENDED)
    rise = EXTENDED(right) - EXTENDED(left)
    series[0], series[1] = EXTENDED(left) + rise * start, rise * step
    return series


def expand(oscillator, mode, slide, force, x, v, step):
    """Displacement and velocity as series over a step, contact and sliding fixed."""
    xs, vs = np.zeros(ORDER + 2, EXTENDED), np.zeros(ORDER + 2, EXTENDED)
    xs[0], vs[0] = x, v
    stiffness = EXTENDED(oscillator.stiffness) + (oscillator.contact if mode else 0)
    constant = mode * EXTENDED(oscillator.contact) * oscillator.clearance
    constant = constant - slide * EXTENDED(oscillator.friction)
    squares = np.zeros(ORDER + 1, EXTENDED)
    for k in range(ORDER + 1):
        total = force[k] - oscillator.damping * vs[k] - stiffness * xs[k]
        if k == 0:
            total += constant
        if oscillator.cubic:
            squares[k] = xs[: k + 1] @ xs[k::-1]
            total -= oscillator.cubic * (xs[: k + 1] @ squares[k::-1])
        xs[k + 1] = step * vs[k] / (k + 1)
        vs[k + 1] = step * total / oscillator.mass / (k + 1)
    return xs, vs


def horner(series, at):
    total = series[-1]
    for coefficient in series[-2::-1]:
        total = total * at + coefficient
    return total


def first_zero(function, pieces=16):
    """Share at which a function first rises from at most 0 to above 0, or None."""
    low = EXTENDED(0)
    for i in range(1, pieces + 1):
        high = EXTENDED(i) / pieces
        if function(high) > 0:
            for _ in range(70):
                middle = (low + high) / 2
                low, high = (low, middle) if function(middle) > 0 else (middle, high)
            return high
        low = high
    return None


def respond(oscillator, force_of, n, interval, x=0.0, v=0.0):
    """Displacements at the ends of n intervals; force_of(j, start, share) is a series.

    Contact: mode -1, 0 or 1. Friction: slide is the sense of v, 0 where the mass sticks.
    """
    x, v = EXTENDED(x), EXTENDED(v)
    out = np.zeros(n + 1, EXTENDED)
    out[0] = x
    a, rub = EXTENDED(oscillator.clearance), EXTENDED(oscillator.friction)
    mode = 0
    slide = (1 if v > 0 else -1) if rub and v else 0
    for j in range(n):
        start = EXTENDED(0)
        while start < 1:
            share = 1 - start
            force = force_of(j, start, share)
            if rub and slide == 0:
                held = restoring(oscillator, mode, x)
                go = EXTENDED(0)
                if abs(force[0] - held) <= rub:
                    go = first_zero(breaking_away(force, held, rub))
                if go is None:
                    break
                slide = 1 if horner(force, go) > held else -1
                start = start + go * share
                continue
            xs, vs = expand(oscillator, mode, slide, force, x, v, share * interval)
            leave = first_zero(leaving(mode, xs, vs, a, x)) if oscillator.contact else None
            stop = first_zero(stopping(vs, slide)) if rub else None
            end = min((at for at in (leave, stop) if at is not None), default=EXTENDED(1))
            x, v = horner(xs, end), horner(vs, end)
            if leave is None and stop is None:
                break
            start = start + end * share
            if end == leave:
                mode = (1 if v > 0 else -1) if mode == 0 else 0
            else:
                v, slide = EXTENDED(0), 0
        out[j + 1] = x
    return out


def restoring(oscillator, mode, x):
    """Force of springs and contact at a displacement."""
    contact = oscillator.contact * (x - mode * EXTENDED(oscillator.clearance)) if mode else 0
    return oscillator.stiffness * x + contact + oscillator.cubic * x**3


def breaking_away(force, held, rub):
    """A function that rises above 0 when the force on a mass at rest overcomes friction."""
    return lambda at: abs(horner(force, at) - held) - rub


def stopping(vs, slide):
    """A function that rises above 0 when the velocity turns against the sense of sliding."""
    return lambda at: -slide * horner(vs, at)


def leaving(mode, xs, vs, a, x):
    """A function that rises above 0 when the contact is made or lost."""
    if mode == 0:
        return lambda at: abs(horner(xs, at)) - a
    return lambda at: a - mode * horner(xs, at)
