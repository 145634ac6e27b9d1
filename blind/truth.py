"""The motion of the truth: fixed-step Runge-Kutta of order 4 with located crossings.

Coordinates are relative to the base. The base acceleration (or the force) is given at twice the
rate of the steps. A step in which an element crosses a threshold or stops sliding is cut there;
a contact that sticks is held by the force it needs until that exceeds what it can bear.

The kernels share one array m, laid out in `laws`; p is the place of an element's table in it.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit

from blind import laws
from blind.laws import (
    BEFORE,
    DEPTH,
    ELEMENTS,
    FIRST,
    FORCE_ON,
    FORCES,
    JOINTS,
    KIND,
    MASSES,
    N_ELEMENTS,
    N_MASSES,
    N_THRESHOLDS,
    RATES,
    REGION,
    REVERSALS,
    SECOND,
    SIGN,
    SIZE,
    SLIDES,
    STACK,
    STATE,
    STATE_SIZE,
    STRIDE,
    THRESHOLDS,
    TRIAL,
    WORK,
    Y,
    breakaway,
    iwan_depth,
    iwan_force,
    law,
)  # fmt: skip


@dataclass(frozen=True)
class Truth:
    """Masses, linear joints as (first end, second end, stiffness, damping), and elements.

    An element is (code, first end, second end, parameters, thresholds); -1 is the base.
    """

    masses: tuple[float, ...]
    joints: tuple[tuple[int, int, float, float], ...]
    elements: tuple[tuple[int, int, int, tuple[float, ...], tuple[float, ...]], ...]
    force_on: int = -1


@dataclass(frozen=True)
class Motion:
    """What one test does: acceleration over fine steps, the rest over samples."""

    acceleration: np.ndarray
    displacement: np.ndarray
    velocity: np.ndarray
    stretch: np.ndarray
    rate: np.ndarray
    force: np.ndarray


@njit(cache=True, error_model="numpy")
def derivative(m, y, t, base, push):
    """Fill the rates of the state that stands at y, and the force of each element."""
    n, ne = int(m[N_MASSES]), int(m[N_ELEMENTS])
    for i in range(n):
        m[RATES + i] = m[y + n + i]
        rate = -base
        for j in range(2 * n):
            rate -= m[JOINTS + 8 * i + j] * m[y + j]
        m[RATES + n + i] = rate
    pushed = int(m[FORCE_ON])
    if pushed >= 0:
        m[RATES + n + pushed] += push / m[MASSES + pushed]
    stuck = False
    for e in range(ne):
        p = ELEMENTS + STRIDE * e
        if m[p + SLIDES] == 1.0 and m[p + SIGN] == 0.0:
            stuck = True
            continue
        z, w = stretch(m, y, p, n)
        f = law(m, p, z, w, t, y)
        m[FORCES + e] = f
        apply(m, p, f, n)
    if stuck:
        for e in range(ne):
            p = ELEMENTS + STRIDE * e
            if m[p + SLIDES] == 1.0 and m[p + SIGN] == 0.0:
                m[FORCES + e] = hold(m, p, n)
                apply(m, p, m[FORCES + e], n)


@njit(cache=True, error_model="numpy")
def stretch(m, y, p, n):
    """Displacement and velocity across an element."""
    a, b = int(m[p + FIRST]), int(m[p + SECOND])
    if a >= 0:
        return m[y + b] - m[y + a], m[y + n + b] - m[y + n + a]
    return m[y + b], m[y + n + b]


@njit(cache=True, error_model="numpy")
def apply(m, p, f, n):
    """Let an element pull its ends together with a force."""
    a, b = int(m[p + FIRST]), int(m[p + SECOND])
    m[RATES + n + b] -= f / m[MASSES + b]
    if a >= 0:
        m[RATES + n + a] += f / m[MASSES + a]


@njit(cache=True, error_model="numpy")
def hold(m, p, n):
    """Force that keeps a sticking contact from accelerating."""
    a, b = int(m[p + FIRST]), int(m[p + SECOND])
    give, wanted = 1.0 / m[MASSES + b], m[RATES + n + b]
    if a >= 0:
        give += 1.0 / m[MASSES + a]
        wanted -= m[RATES + n + a]
    return wanted / give


@njit(cache=True, error_model="numpy")
def parabola(x, a, b, c):
    """Through a, b, c at 0, 1/2 and 1."""
    return a + x * (-3.0 * a + 4.0 * b - c + x * (2.0 * a - 4.0 * b + 2.0 * c))


@njit(cache=True, error_model="numpy")
def rk4(m, t, h, done, share, b0, b1, b2, f0, f1, f2):
    """Fill TRIAL with the state after a share of the step that begins at t, from `done` on."""
    size = int(m[STATE_SIZE])
    for i in range(size):
        m[RATES + i] = 0.0
        m[TRIAL + i] = m[Y + i]
    for stage in range(4):
        step = 0.0 if stage == 0 else (1.0 if stage == 3 else 0.5)
        weight = share * h / (6.0 if stage == 0 or stage == 3 else 3.0)
        for i in range(size):
            m[WORK + i] = m[Y + i] + step * share * h * m[RATES + i]
        x = done + step * share
        base, push = parabola(x, b0, b1, b2), parabola(x, f0, f1, f2)
        derivative(m, WORK, t + x * h, base, push)
        for i in range(size):
            m[TRIAL + i] += weight * m[RATES + i]


@njit(cache=True, error_model="numpy")
def margin(m, y, which):
    """How far the frozen mode still is from its end, below 0 past it; which = 4 e + kind."""
    p, j = ELEMENTS + STRIDE * (which // 4), which % 4
    z, w = stretch(m, y, p, int(m[N_MASSES]))
    if j == 3:
        return m[p + SIGN] * w
    side = 1.0 if m[p + REGION] > j else -1.0
    return side * (z - m[p + THRESHOLDS + j])


@njit(cache=True, error_model="numpy")
def first_crossed(m):
    """Which margin of the trial state is below 0, or -1."""
    for e in range(int(m[N_ELEMENTS])):
        p = ELEMENTS + STRIDE * e
        for j in range(int(m[p + N_THRESHOLDS])):
            if margin(m, TRIAL, 4 * e + j) < 0.0:
                return 4 * e + j
        if m[p + SLIDES] == 1.0 and m[p + SIGN] != 0.0 and margin(m, TRIAL, 4 * e + 3) < 0.0:
            return 4 * e + 3
    return -1


@njit(cache=True, error_model="numpy")
def locate(m, which, share, t, h, done, b0, b1, b2, f0, f1, f2):
    """Share of the step at which a margin has just ended (Illinois rule), or 0."""
    low, high, last = 0.0, share, 0
    g_low, g_high = margin(m, Y, which), margin(m, TRIAL, which)
    if g_low <= 0.0:
        return 0.0
    for _ in range(14):
        if high - low < 1e-10 * share:
            break
        x = low + (high - low) * g_low / (g_low - g_high)
        rk4(m, t, h, done, x, b0, b1, b2, f0, f1, f2)
        g = margin(m, TRIAL, which)
        if g > 0.0:
            low, g_low = x, g
            g_high *= 0.5 if last == 1 else 1.0
            last = 1
        else:
            high, g_high = x, g
            g_low *= 0.5 if last == 2 else 1.0
            last = 2
            if g == 0.0:
                break
    return high


@njit(cache=True, error_model="numpy")
def remember(m, h):
    """Update sliders and reversals after a step of h from BEFORE to Y; 1 if memory is full."""
    n = int(m[N_MASSES])
    for e in range(int(m[N_ELEMENTS])):
        p = ELEMENTS + STRIDE * e
        if m[p + KIND] != laws.JENKINS and m[p + KIND] != laws.IWAN:
            continue
        z, w = stretch(m, Y, p, n)
        z0, w0 = stretch(m, BEFORE, p, n)
        turned = w0 * w < 0.0
        turn = z0 + 0.5 * h * w0 * w0 / (w0 - w) if turned else z
        turn = max(turn, z) if w0 > 0.0 else min(turn, z)  # never short of where it stands
        if m[p + KIND] == laws.JENKINS:
            at, limit = Y + int(m[p + STATE]), m[p + 1]
            m[at] = min(max(m[at], turn - limit), turn + limit)
            m[at] = min(max(m[at], z - limit), z + limit)
            continue
        if turned:
            depth = iwan_depth(turn, m, int(m[p + DEPTH]))
            f = iwan_force(turn, m[p], m[p + 1], m, depth)
            if depth >= REVERSALS:
                return 1
            m[STACK + depth], m[STACK + REVERSALS + depth] = turn, f
            m[p + DEPTH] = depth + 1
        m[p + DEPTH] = iwan_depth(z, m, int(m[p + DEPTH]))
    return 0


@njit(cache=True, error_model="numpy")
def set_modes(m, t, base, push):
    """Put every element in the mode that its displacement and velocity call for."""
    n = int(m[N_MASSES])
    for e in range(int(m[N_ELEMENTS])):
        p = ELEMENTS + STRIDE * e
        z, w = stretch(m, Y, p, n)
        region = 0.0
        for j in range(int(m[p + N_THRESHOLDS])):
            edge = m[p + THRESHOLDS + j]
            if z > edge or (z == edge and w > 0.0):
                region += 1.0
        m[p + REGION] = region
    for e in range(int(m[N_ELEMENTS])):
        p = ELEMENTS + STRIDE * e
        if m[p + SLIDES] == 0.0 or m[p + SIGN] == 0.0:
            continue
        z, w = stretch(m, Y, p, n)
        if m[p + SIGN] * w > 0.0:
            continue
        m[p + SIGN] = 0.0
        stop_sliding(m, p, n)
        derivative(m, Y, t, base, push)
        if abs(m[FORCES + e]) > breakaway(m, p, z):
            m[p + SIGN] = 1.0 if m[FORCES + e] > 0.0 else -1.0


@njit(cache=True, error_model="numpy")
def stop_sliding(m, p, n):
    """Give both ends of an element the same velocity, and keep the momentum."""
    a, b = int(m[p + FIRST]), int(m[p + SECOND])
    common = 0.0
    if a >= 0:
        ma, mb = m[MASSES + a], m[MASSES + b]
        common = (ma * m[Y + n + a] + mb * m[Y + n + b]) / (ma + mb)
        m[Y + n + a] = common
    m[Y + n + b] = common


@njit(cache=True, error_model="numpy")
def release(m):
    """Let go what sticks with more force than it can bear."""
    n = int(m[N_MASSES])
    for e in range(int(m[N_ELEMENTS])):
        p = ELEMENTS + STRIDE * e
        if m[p + SLIDES] == 1.0 and m[p + SIGN] == 0.0:
            z, _ = stretch(m, Y, p, n)
            if abs(m[FORCES + e]) > breakaway(m, p, z):
                m[p + SIGN] = 1.0 if m[FORCES + e] > 0.0 else -1.0


@njit(cache=True, error_model="numpy")
def stuck_share(m, t, h, done, b0, b1, b2, f0, f1, f2):
    """Share of the step until the first sticking contact must let go; all that is left if none.

    The force that holds it follows the excitation; that the rest of the structure moves on
    meanwhile matters in the second order only.
    """
    low, high = 0.0, 1.0 - done
    for i in range(40):
        x = high if i == 0 else 0.5 * (low + high)
        base, push = parabola(done + x, b0, b1, b2), parabola(done + x, f0, f1, f2)
        derivative(m, Y, t + (done + x) * h, base, push)
        over = overloaded(m)
        if i == 0 and not over:
            return high
        if over:
            high = x
        else:
            low = x
    return high


@njit(cache=True, error_model="numpy")
def overloaded(m):
    """Whether a sticking contact bears more than it can, by the forces last computed."""
    n = int(m[N_MASSES])
    for e in range(int(m[N_ELEMENTS])):
        p = ELEMENTS + STRIDE * e
        if m[p + SLIDES] == 1.0 and m[p + SIGN] == 0.0:
            z, _ = stretch(m, Y, p, n)
            if abs(m[FORCES + e]) > breakaway(m, p, z):
                return True
    return False


@njit(cache=True, error_model="numpy")
def sticks(m):
    """Whether any contact sticks."""
    for e in range(int(m[N_ELEMENTS])):
        p = ELEMENTS + STRIDE * e
        if m[p + SLIDES] == 1.0 and m[p + SIGN] == 0.0:
            return True
    return False


@njit(cache=True, error_model="numpy")
def stable_share(m, h, share):
    """At most so much of a step that no bristle decays by more than half in it."""
    n = int(m[N_MASSES])
    for e in range(int(m[N_ELEMENTS])):
        p = ELEMENTS + STRIDE * e
        if m[p + KIND] == laws.LUGRE:
            _, w = stretch(m, Y, p, n)
            decay = m[p + 3] * abs(w) / m[p] * h
            if decay * share > 0.5:
                share = 0.5 / decay
    return share


@njit(cache=True, error_model="numpy")
def one_step(m, t, h, modes, b0, b1, b2, f0, f1, f2):
    """Carry the state over one step, cut at each crossing."""
    size = int(m[STATE_SIZE])
    done, cuts = 0.0, 0
    while done < 1.0:
        share = 1.0 - done
        if modes and cuts < 40 and sticks(m):
            share = stuck_share(m, t, h, done, b0, b1, b2, f0, f1, f2)
            cuts += 1 if share < 1.0 - done else 0
        share = stable_share(m, h, share)
        rk4(m, t, h, done, share, b0, b1, b2, f0, f1, f2)
        if modes and cuts < 40:
            which = first_crossed(m)
            if which >= 0:
                cuts += 1
                share = locate(m, which, share, t, h, done, b0, b1, b2, f0, f1, f2)
                rk4(m, t, h, done, share, b0, b1, b2, f0, f1, f2)
        for i in range(size):
            m[BEFORE + i] = m[Y + i]
            m[Y + i] = m[TRIAL + i]
        if remember(m, share * h) != 0:
            return 2
        done += share
        if 1.0 - done < 1e-9:
            done = 1.0
        if modes and (cuts > 0 or done == 1.0):
            base, push = parabola(done, b0, b1, b2), parabola(done, f0, f1, f2)
            set_modes(m, t + done * h, base, push)
            if sticks(m):
                derivative(m, Y, t + done * h, base, push)
                release(m)
    return 0


@njit(cache=True, error_model="numpy")
def integrate(m, modes, base, push, h, sub, limit, acc, q, v, z, w, f):
    """Fill the outputs; return 0, 1 where the motion ran away, 2 where a memory is full."""
    n, ne = int(m[N_MASSES]), int(m[N_ELEMENTS])
    set_modes(m, 0.0, base[0], push[0])
    for k in range(acc.shape[0]):
        b0, b1, b2 = base[2 * k], base[2 * k + 1], base[2 * k + 2]
        f0, f1, f2 = push[2 * k], push[2 * k + 1], push[2 * k + 2]
        derivative(m, Y, k * h, b0, f0)
        for i in range(n):
            acc[k, i] = m[RATES + n + i] + b0
        if k % sub == 0:
            for i in range(n):
                q[k // sub, i], v[k // sub, i] = m[Y + i], m[Y + n + i]
            for e in range(ne):
                p = ELEMENTS + STRIDE * e
                z[k // sub, e], w[k // sub, e] = stretch(m, Y, p, n)
                f[k // sub, e] = m[FORCES + e]
        status = one_step(m, k * h, h, modes, b0, b1, b2, f0, f1, f2)
        if status != 0:
            return status
        for i in range(n):
            if not abs(m[Y + i]) < limit:
                return 1
    return 0


def _linear(truth: Truth) -> np.ndarray:
    """Return what the joints take off the accelerations, for each displacement and velocity."""
    n = len(truth.masses)
    matrix = np.zeros((n, 2 * n))
    for first, second, stiffness, damping in truth.joints:
        ends = [(second, 1.0)] + ([(first, -1.0)] if first >= 0 else [])
        for row, a in ends:
            for column, b in ends:
                matrix[row, column] += a * b * stiffness / truth.masses[row]
                matrix[row, n + column] += a * b * damping / truth.masses[row]
    return matrix


def _memory(truth: Truth) -> np.ndarray:
    """Return the array that the kernels share."""
    m = np.zeros(SIZE)
    n = len(truth.masses)
    m[N_MASSES], m[N_ELEMENTS], m[FORCE_ON] = n, len(truth.elements), truth.force_on
    m[MASSES : MASSES + n] = truth.masses
    for i, row in enumerate(_linear(truth)):
        m[JOINTS + 8 * i : JOINTS + 8 * i + row.size] = row
    size = 2 * n
    for e, (code, first, second, parameters, thresholds) in enumerate(truth.elements):
        p = ELEMENTS + STRIDE * e
        m[p : p + len(parameters)] = parameters
        m[p + THRESHOLDS : p + THRESHOLDS + len(thresholds)] = thresholds
        m[p + FIRST], m[p + SECOND], m[p + KIND] = first, second, code
        m[p + N_THRESHOLDS], m[p + SLIDES] = len(thresholds), code in laws.SLIDING
        m[p + STATE] = size
        size += laws.STATES.get(code, 0)
    m[STATE_SIZE] = size
    if size > TRIAL - Y or n > JOINTS - MASSES or len(truth.elements) > 6:
        raise ValueError("too many masses, elements or states for the kernels")
    return m


def move(
    truth: Truth,
    base: np.ndarray,
    force: np.ndarray,
    sample_rate: float,
    substeps: int,
    limit: float,
) -> Motion | None:
    """Return the motion under base acceleration and force, or None if it runs away.

    `base` and `force` hold 2 * substeps * n_samples + 1 values; the run starts at rest.
    """
    n, ne = len(truth.masses), len(truth.elements)
    n_steps = (base.size - 1) // (2 * substeps) * substeps
    modes = any(
        thresholds or code in laws.SLIDING for code, _, _, _, thresholds in truth.elements
    )
    acceleration = np.empty((n_steps, n))
    outputs = [np.empty((n_steps // substeps, size)) for size in (n, n, ne, ne, ne)]
    status = integrate(
        _memory(truth), modes, base, force, 1.0 / (sample_rate * substeps), substeps, limit,
        acceleration, *outputs,
    )  # fmt: skip
    if status == 2:
        raise RuntimeError("the memory of an Iwan element is full")
    return None if status else Motion(acceleration, *outputs)
