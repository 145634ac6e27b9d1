"""What changes between two steps: sides of thresholds, sticking, sliders, reversals."""

from blind.compiled import kernel
from blind.integration.forces import derivative, sticking, stretch
from blind.laws.dampers import breakaway
from blind.laws.hysteresis import iwan_depth, iwan_force
from blind.laws.layout import (
    BEFORE,
    DEPTH,
    ELEMENTS,
    FIRST,
    FORCES,
    IWAN,
    JENKINS,
    KIND,
    MASSES,
    N_ELEMENTS,
    N_MASSES,
    N_THRESHOLDS,
    REGION,
    REVERSALS,
    SECOND,
    SERIES,
    SIGN,
    SLIDES,
    STACK,
    STATE,
    STRIDE,
    THRESHOLDS,
    Y,
)


@kernel
def remember(m, h):
    """Update sliders and reversals after a step of h from BEFORE to Y; 1 if memory is full."""
    n = int(m[N_MASSES])
    for e in range(int(m[N_ELEMENTS])):
        p = ELEMENTS + STRIDE * e
        if m[p + KIND] not in (JENKINS, SERIES, IWAN):
            continue
        z, w = stretch(m, Y, p, n)
        z0, w0 = stretch(m, BEFORE, p, n)
        turned = w0 * w < 0.0
        turn = z0 + 0.5 * h * w0 * w0 / (w0 - w) if turned else z
        turn = max(turn, z) if w0 > 0.0 else min(turn, z)  # never short of where it stands
        if m[p + KIND] != IWAN:
            at, limit = Y + int(m[p + STATE]), m[p + 1]
            m[at] = min(max(m[at], turn - limit), turn + limit)
            m[at] = min(max(m[at], z - limit), z + limit)
        elif turned and reverse(m, p, turn) != 0:
            return 1
        else:
            m[p + DEPTH] = iwan_depth(z, m, int(m[p + DEPTH]))
    return 0


@kernel
def reverse(m, p, turn):
    """Keep a reversal of an Iwan element; 1 if memory is full."""
    depth = iwan_depth(turn, m, int(m[p + DEPTH]))
    f = iwan_force(m, p, turn, depth)
    if depth >= REVERSALS:
        return 1
    m[STACK + depth], m[STACK + REVERSALS + depth] = turn, f
    m[p + DEPTH] = depth + 1
    return 0


@kernel
def set_modes(m, x):
    """Put every element in the mode that its displacement and velocity call for."""
    set_regions(m)
    n = int(m[N_MASSES])
    for e in range(int(m[N_ELEMENTS])):
        p = ELEMENTS + STRIDE * e
        if m[p + SLIDES] == 0.0 or m[p + SIGN] == 0.0:
            continue
        z, w = stretch(m, Y, p, n)
        if m[p + SIGN] * w > 0.0:
            continue
        m[p + SIGN] = 0.0
        stop_sliding(m, p, n)
        derivative(m, Y, x)
        if abs(m[FORCES + e]) > breakaway(m, p, z):
            m[p + SIGN] = 1.0 if m[FORCES + e] > 0.0 else -1.0


@kernel
def set_regions(m):
    """Count the thresholds that every element is beyond."""
    for e in range(int(m[N_ELEMENTS])):
        p = ELEMENTS + STRIDE * e
        z, w = stretch(m, Y, p, int(m[N_MASSES]))
        region = 0.0
        for j in range(int(m[p + N_THRESHOLDS])):
            edge = m[p + THRESHOLDS + j]
            if z > edge or (z == edge and w > 0.0):
                region += 1.0
        m[p + REGION] = region


@kernel
def stop_sliding(m, p, n):
    """Give both ends of an element the same velocity, and keep the momentum."""
    a, b = int(m[p + FIRST]), int(m[p + SECOND])
    common = 0.0
    if a >= 0:
        ma, mb = m[MASSES + a], m[MASSES + b]
        common = (ma * m[Y + n + a] + mb * m[Y + n + b]) / (ma + mb)
        m[Y + n + a] = common
    m[Y + n + b] = common


@kernel
def release(m):
    """Let go what sticks with more force than it can bear."""
    n = int(m[N_MASSES])
    for e in range(int(m[N_ELEMENTS])):
        p = ELEMENTS + STRIDE * e
        if sticking(m, p):
            z, _ = stretch(m, Y, p, n)
            if abs(m[FORCES + e]) > breakaway(m, p, z):
                m[p + SIGN] = 1.0 if m[FORCES + e] > 0.0 else -1.0


@kernel
def stuck_share(m, done):
    """Share of the step until the first sticking contact must let go; all that is left if none.

    The force that holds it follows the excitation; that the rest of the structure moves on
    meanwhile matters in the second order only.
    """
    low, high = 0.0, 1.0 - done
    for i in range(40):
        x = high if i == 0 else 0.5 * (low + high)
        derivative(m, Y, done + x)
        over = overloaded(m)
        if i == 0 and not over:
            return high
        if over:
            high = x
        else:
            low = x
    return high


@kernel
def overloaded(m):
    """Whether a sticking contact bears more than it can, by the forces last computed."""
    n = int(m[N_MASSES])
    for e in range(int(m[N_ELEMENTS])):
        p = ELEMENTS + STRIDE * e
        if sticking(m, p):
            z, _ = stretch(m, Y, p, n)
            if abs(m[FORCES + e]) > breakaway(m, p, z):
                return True
    return False


@kernel
def any_sticks(m):
    """Whether any contact sticks."""
    found = False
    for e in range(int(m[N_ELEMENTS])):
        found = found or sticking(m, ELEMENTS + STRIDE * e)
    return found
