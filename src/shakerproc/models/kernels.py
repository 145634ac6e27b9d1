"""Memory carried along a prescribed motion, one compiled function for each law that has it."""

from typing import Final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models.compiled import compiled, inlined, inner


@compiled
def jenkins_along(displacement: FloatArray, stiffness: float, slip_force: float) -> FloatArray:
    """Return the force of a spring in series with a slider [N]; exact."""
    force = np.empty_like(displacement)
    spring, previous = 0.0, displacement[0]
    for i in range(displacement.size):
        spring += stiffness * (displacement[i] - previous)
        spring = min(max(spring, -slip_force), slip_force)
        force[i], previous = spring, displacement[i]
    return force


@compiled
def iwan_along(
    displacement: FloatArray, stiffness: float, slip_displacement: float, power: float
) -> FloatArray:
    """Return the force of the continuous Iwan element [N]; exact, by turning points.

    `power` is that of displacement in the loss of force: 2 plus the exponent of the
    distribution of slip displacements.

    The stack holds the turning points that are still remembered, outermost first. A branch
    closes where it meets the point before the one it started from; the motion then goes on
    along the branch around it (Masing's rules).
    """
    force = np.empty_like(displacement)
    points = np.empty(displacement.size + 2)  # displacement of each remembered turning point
    levels = np.empty(displacement.size + 2)  # force at it
    count = 0
    start = displacement[0]
    previous, direction, now = start, 0.0, 0.0
    for i in range(displacement.size):
        z = displacement[i]
        if z != previous:
            towards = 1.0 if z > previous else -1.0
            if direction * towards < 0.0:
                points[count], levels[count] = previous, now
                count += 1
            direction = towards
            while count >= 2 and towards * (z - points[count - 2]) >= 0.0:
                count -= 2
            if count == 1 and towards * (z - start) >= abs(points[0] - start):
                count = 0
            if count == 0:
                now = _iwan_backbone(z - start, stiffness, slip_displacement, power)
            else:
                half = 0.5 * (z - points[count - 1])
                now = levels[count - 1] + 2.0 * _iwan_backbone(
                    half, stiffness, slip_displacement, power
                )
        force[i], previous = now, z
    return force


@inner
def _iwan_backbone(
    displacement: float, stiffness: float, slip_displacement: float, power: float
) -> float:
    """Return the force of first loading [N]."""
    size = min(abs(displacement), slip_displacement)
    force = stiffness * size * (1.0 - (size / slip_displacement) ** (power - 1.0) / power)
    return force if displacement >= 0.0 else -force


_TERMS: Final = 13
"""Coefficients of a piece of a curve that saturates; the next is below 1e-15 of it [-]."""

_ROOT: Final = 0.4
"""Where the pieces of such a curve begin; before, it is a series in powers of its exponent."""

_WIDEST: Final = 0.1
_SHARP: Final = 5.0
"""Width of a piece, and the exponent above which it shrinks as the bend does [-]."""

_HEAD: Final = 3
"""Numbers of a curve before its coefficients: scale, pieces in a unit, how many there are."""


@compiled
def saturating_curve(share: float, exponent: float) -> FloatArray:
    """Return the numbers of the curve that solves H' = 1 - c H^n from 0, for `on_curve`.

    It is laid down along first loading, where an error dies out.
    """
    width = _WIDEST * min(1.0, _SHARP / exponent)
    first = int(_ROOT / width)
    count = int(np.ceil((2.0 + 40.0 / exponent) / width))  # there it is 1 to rounding
    curve = np.zeros(_HEAD + (1 + count) * _TERMS)
    curve[0], curve[1], curve[2] = share ** (-1.0 / exponent), 1.0 / width, count
    root, power = np.zeros(_TERMS), np.zeros(_TERMS)
    root[0], power[0] = 1.0, 1.0
    for k in range(1, _TERMS):
        root[k] = -power[k - 1] / (1.0 + k * exponent)
        _raise(root, power, exponent, k)
    curve[_HEAD : _HEAD + _TERMS] = root
    value = _by_root(curve, 0, first * width, exponent)
    piece = np.zeros(_TERMS)
    for i in range(first, count):
        for turn in range(2):  # from the start to the middle; from there, all of the piece
            piece[0], power[0] = value, value**exponent
            for k in range(1, _TERMS):
                piece[k] = ((1.0 if k == 1 else 0.0) - power[k - 1]) / k
                _raise(piece, power, exponent, k)
            total, factor = 0.0, 1.0
            for k in range(_TERMS):
                if turn == 1:
                    curve[_HEAD + (1 + i) * _TERMS + k] = piece[k] * factor
                total += piece[k] * factor
                factor *= 0.5 * width
            value = total
    return curve


@inner
def _raise(series: FloatArray, power: FloatArray, exponent: float, order: int) -> None:
    """Set the next coefficient of the power of a series."""
    total = 0.0
    for j in range(1, order + 1):
        total += ((exponent + 1.0) * j - order) * series[j] * power[order - j]
    power[order] = total / (order * series[0])


@inlined
def _by_root(curve: FloatArray, start: int, place: float, exponent: float) -> float:
    """Return the curve near its beginning."""
    bend, total = place**exponent, 0.0
    for k in range(_TERMS - 1, -1, -1):
        total = total * bend + curve[start + _HEAD + k]
    return place * total


@inlined
def on_curve(curve: FloatArray, start: int, place: float, exponent: float) -> float:
    """Return the curve of `saturating_curve`, which stands from `start` on, at a place."""
    scale = curve[start] if place >= 0.0 else -curve[start]
    share = place / scale
    if share < _ROOT:
        return scale * _by_root(curve, start, share, exponent)
    at = share * curve[start + 1]
    if not at < curve[start + 2]:
        return scale
    first = start + _HEAD + (1 + int(at)) * _TERMS
    way, total = 2.0 * (at - int(at)) - 1.0, 0.0
    for k in range(_TERMS - 1, -1, -1):
        total = total * way + curve[first + k]
    return scale * total


@compiled
def place_on_curve(curve: FloatArray, value: float, exponent: float) -> float:
    """Return where the curve of `saturating_curve` reaches a value, or its end."""
    low, high = 0.0, curve[0] * curve[2] / curve[1]
    for _ in range(60):
        middle = 0.5 * (low + high)
        if on_curve(curve, 0, middle, exponent) < value:
            low = middle
        else:
            high = middle
    return high


@compiled
def bouc_wen_along(
    displacement: FloatArray, values: FloatArray, curve: FloatArray
) -> FloatArray:
    """Return the force of the Bouc-Wen element [N], by Runge-Kutta steps in displacement.

    `values` are those of `Law.BOUC_WEN`, `curve` what `laws.curve_back` makes of them.
    """
    stiffness, yield_displacement, exponent, loading, unloading = values
    back = unloading if curve.size else 0.0
    steepest = max(1.0, abs(loading), abs(unloading))
    force = np.empty_like(displacement)
    memory, previous = 0.0, displacement[0]
    for i in range(displacement.size):
        way = (displacement[i] - previous) / yield_displacement
        if unloading == back and memory * way < 0.0:  # the memory is the way back
            gone = np.sign(way) * min(abs(way), abs(memory))
            memory, way = memory + gone, way - gone
        if loading == back:  # and goes on from there as it came
            memory, way = memory + way, 0.0
        far = abs(way) * steepest > 1.0  # the samples do not follow the loop
        longest, settled = (min(0.2, 1.0 / exponent), 1e-6) if far else (0.05, 1e-10)
        n_steps = int(np.ceil(abs(way) * steepest / longest))
        for _ in range(n_steps):
            growth = _bouc_wen_slope(memory, way, values, back, curve)
            if abs(growth) < settled:  # it has yielded
                break
            memory = _bouc_wen_step(memory, way / n_steps, values, back, curve)
        held = memory if back == 0.0 else on_curve(curve, 0, memory, exponent)
        force[i], previous = stiffness * yield_displacement * held, displacement[i]
    return force


@inner
def _bouc_wen_step(
    memory: float, way: float, values: FloatArray, back: float, curve: FloatArray
) -> float:
    """Return the memory after one Runge-Kutta step, both in units of yield displacement."""
    k1 = _bouc_wen_slope(memory, way, values, back, curve)
    k2 = _bouc_wen_slope(memory + 0.5 * way * k1, way, values, back, curve)
    k3 = _bouc_wen_slope(memory + 0.5 * way * k2, way, values, back, curve)
    k4 = _bouc_wen_slope(memory + way * k3, way, values, back, curve)
    return memory + way * (k1 + 2.0 * k2 + 2.0 * k3 + k4) / 6.0


@inner
def _bouc_wen_slope(
    memory: float, way: float, values: FloatArray, back: float, curve: FloatArray
) -> float:
    """Return the growth of memory with displacement: 1 less the yielded share."""
    exponent = values[2]
    share = values[3] if memory * way > 0.0 else values[4]
    if share == back:
        return 1.0
    held = memory if back == 0.0 else on_curve(curve, 0, memory, exponent)
    if exponent == 2.0:
        bend = held * held
    elif exponent == 1.0:
        bend = abs(held)
    else:
        bend = abs(held) ** exponent
    if back == 0.0:
        return 1.0 - share * bend
    return (1.0 - share * bend) / (1.0 - back * bend)


@compiled
def series_along(
    displacement: FloatArray, velocity: FloatArray, step: float, values: FloatArray
) -> FloatArray:
    """Return the force through play, spring, slider and damper in series [N].

    Exact for a velocity that is linear between its samples, but in steps in which contact or
    slip begins or ends: there for a displacement that is. `values` are those of `Law.SERIES`.
    """
    force = np.empty_like(displacement)
    rate = values[0] * values[4]
    reach, previous = 0.0, displacement[0]  # extension of play and spring
    for i in range(displacement.size):
        mean = (displacement[i] - previous) / step
        if mean != 0.0 or values[4] != 0.0:
            before, reach = reach, _series_after(reach, mean, step, values)
            if i > 0 and rate > 0.0 and _stays_closed(before, reach, values):
                change = (velocity[i] - velocity[i - 1]) / step
                reach += change * step * step * _ramp(rate * step)
        side = 1.0 if reach >= 0.0 else -1.0
        play = values[1] if side > 0.0 else values[2]
        force[i] = side * values[0] * max(side * reach - play, 0.0)
        previous = displacement[i]
    return force


@inner
def _stays_closed(before: float, after: float, values: FloatArray) -> bool:
    """Return whether contact without slip at both ends of a step is the same one."""
    if values[1] + values[2] > 0.0 and (before > 0.0) != (after > 0.0):
        return False
    limit = values[3] / values[0]
    for reach in (before, after):
        beyond = reach - values[1] if reach > 0.0 else -reach - values[2]
        if not 0.0 <= beyond < limit:
            return False
    return True


@inner
def _ramp(x: float) -> float:
    r"""Return the part of a relaxing extension that a velocity ramp about its mean adds.

    .. math:: \int_0^1 e^{-x (1 - s)} (s - \tfrac12) \, ds
        = \frac{1 + e^{-x}}{2 x} - \frac{1 - e^{-x}}{x^2}
    """
    # first term of the series, as the difference below loses its digits here
    if x < 1e-3:
        return x / 12.0
    return (1.0 + np.exp(-x)) / (2.0 * x) + np.expm1(-x) / (x * x)


@inner
def _series_after(reach: float, velocity: float, time: float, values: FloatArray) -> float:
    """Return the extension after a time at a constant velocity, stretch by stretch [m]."""
    stiffness, slip = values[0], values[3]
    rate = stiffness * values[4]  # of relaxation through the damper [1/s]
    for _ in range(8):  # it goes through open and closed at most a few times
        side = 1.0 if reach > 0.0 or (reach == 0.0 and velocity > 0.0) else -1.0
        play = values[1] if side > 0.0 else values[2]
        beyond, towards = side * reach - play, side * velocity
        if beyond < 0.0 or (beyond == 0.0 and towards < 0.0):  # open
            wall = values[1] if velocity > 0.0 else values[2]
            way = wall - reach if velocity > 0.0 else wall + reach
            if velocity == 0.0 or way >= abs(velocity) * time:
                return reach + velocity * time
            time -= way / abs(velocity)
            reach = wall if velocity > 0.0 else -wall
            if wall == 0.0:  # no play at all: on the other side of rest it is closed too
                reach = 1e-300 * velocity
            continue
        limit = slip / stiffness
        if rate == 0.0:
            after = min(beyond + towards * time, limit)
            if after >= 0.0:
                return side * (play + after)
            time -= -beyond / towards
        else:
            final = towards / rate
            after = min(final + (beyond - final) * np.exp(-rate * time), limit)
            if after >= 0.0:
                return side * (play + after)
            time -= np.log((beyond - final) / -final) / rate
        if play == 0.0 and values[1] + values[2] == 0.0:
            reach = 1e-300 * velocity
        else:
            reach = side * play * (1.0 - 1e-15)
    return reach


@compiled
def lugre_along(velocity: FloatArray, step: float, values: FloatArray) -> FloatArray:
    """Return the LuGre friction force [N]; the bristles exact for the mean velocity of a step.

    `values` are sliding force, breakaway force, Stribeck velocity, bristle stiffness, bristle
    damping and viscous damping.
    """
    sliding, breakaway, stribeck, stiffness, damping, viscous = values
    force = np.empty_like(velocity)
    bristle = 0.0
    for i in range(velocity.size):
        if i > 0:
            mean = 0.5 * (velocity[i] + velocity[i - 1])
            level = sliding + (breakaway - sliding) * np.exp(-((mean / stribeck) ** 2))
            rate = stiffness * abs(mean) / level
            bristle = bristle * np.exp(-rate * step) - mean * step * _mean_decay(rate * step)
        v = velocity[i]
        level = sliding + (breakaway - sliding) * np.exp(-((v / stribeck) ** 2))
        growth = v - stiffness * abs(v) * bristle / level
        force[i] = stiffness * bristle + damping * growth + viscous * v
    return force


@inner
def _mean_decay(x: float) -> float:
    """Return (exp(-x) - 1) / x, also for small x."""
    return np.expm1(-x) / x if x > 1e-12 else -1.0


@compiled
def attached_along(
    displacement: FloatArray, velocity: FloatArray, values: FloatArray, advance: FloatArray
) -> FloatArray:
    """Return the force of a mass on a spring and a damper that starts at rest with its place.

    `values` are stiffness and damping, `advance` the (2, 6) matrix that takes displacement
    and velocity of the attached mass, and those of its place before and after, one sample on.
    """
    stiffness, damping = values
    force = np.empty_like(displacement)
    x, v = displacement[0], velocity[0]
    for i in range(displacement.size):
        if i > 0:
            z, w = displacement[i - 1], velocity[i - 1]
            next_z, next_w = displacement[i], velocity[i]
            x, v = (
                _one_on(advance[0], x, v, z, w, next_z, next_w),
                _one_on(advance[1], x, v, z, w, next_z, next_w),
            )
        force[i] = stiffness * (displacement[i] - x) + damping * (velocity[i] - v)
    return force


@inner
def _one_on(
    row: FloatArray, x: float, v: float, z: float, w: float, next_z: float, next_w: float
) -> float:
    """Return a row times the state at the start of a sample and the place at its end."""
    own = row[0] * x + row[1] * v
    return own + row[2] * z + row[3] * w + row[4] * next_z + row[5] * next_w
