"""Fixed steps of Runge-Kutta of order 4, cut where an element crosses or sticks."""

from blind.compiled import kernel
from blind.integration.contacts import any_sticks, release, remember, set_modes, stuck_share
from blind.integration.forces import derivative, stretch
from blind.laws.layout import (
    BASE,
    BEFORE,
    BOUC_WEN,
    ELEMENTS,
    FORCES,
    GENERAL_BOUC_WEN,
    KIND,
    LIMIT,
    LUGRE,
    MODES,
    N_ELEMENTS,
    N_MASSES,
    N_THRESHOLDS,
    PUSH,
    RATES,
    REGION,
    SIGN,
    SLIDES,
    STATE_SIZE,
    STEP,
    STRIDE,
    SUBSTEPS,
    THRESHOLDS,
    TIME,
    TRIAL,
    WORK,
    Y,
)

MOST_CUTS = 40
"""Crossings that are located in one step; what comes after them is not."""


@kernel
def rk4(m, done, share):
    """Fill TRIAL with the state after a share of the step, from `done` on."""
    size, h = int(m[STATE_SIZE]), share * m[STEP]
    for i in range(size):
        m[RATES + i] = 0.0
        m[TRIAL + i] = m[Y + i]
    for stage in range(4):
        step = 0.0 if stage == 0 else (1.0 if stage == 3 else 0.5)
        weight = h / (6.0 if stage in (0, 3) else 3.0)
        for i in range(size):
            m[WORK + i] = m[Y + i] + step * h * m[RATES + i]
        derivative(m, WORK, done + step * share)
        for i in range(size):
            m[TRIAL + i] += weight * m[RATES + i]


@kernel
def margin(m, y, which):
    """How far the frozen mode still is from its end, below 0 past it; which = 4 e + kind."""
    p, j = ELEMENTS + STRIDE * (which // 4), which % 4
    z, w = stretch(m, y, p, int(m[N_MASSES]))
    if j == 3:
        return m[p + SIGN] * w
    side = 1.0 if m[p + REGION] > j else -1.0
    return side * (z - m[p + THRESHOLDS + j])


@kernel
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


@kernel
def locate(m, which, share, done):
    """Share of the step at which a margin has just ended (Illinois rule), or 0."""
    low, high, last = 0.0, share, 0
    g_low, g_high = margin(m, Y, which), margin(m, TRIAL, which)
    if g_low <= 0.0:
        return 0.0
    for _ in range(14):
        if high - low < 1e-10 * share:
            break
        x = low + (high - low) * g_low / (g_low - g_high)
        rk4(m, done, x)
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


@kernel
def stable_share(m, share):
    """At most so much of a step that no bristle and no loop decays by more than half in it."""
    n = int(m[N_MASSES])
    for e in range(int(m[N_ELEMENTS])):
        p = ELEMENTS + STRIDE * e
        if m[p + KIND] in (LUGRE, BOUC_WEN, GENERAL_BOUC_WEN):
            _, w = stretch(m, Y, p, n)
            decay = decay_rate(m, p) * abs(w) * m[STEP]
            if decay * share > 0.5:
                share = 0.5 / decay
    return share


@kernel
def decay_rate(m, p):
    """Decay of a memory over the way [1/m]: bristles that slide, loops that have yielded."""
    if m[p + KIND] == LUGRE:
        return m[p + 3] / m[p]
    if m[p + KIND] == BOUC_WEN:
        return m[p + 2] / m[p + 1]
    larger = max(abs(m[p + 1] + m[p + 2]), abs(m[p + 2] - m[p + 1]))
    return m[p + 3] * m[p] ** (1.0 - 1.0 / m[p + 3]) * larger ** (1.0 / m[p + 3])


@kernel
def one_step(m):
    """Carry the state over one step, cut at each crossing."""
    done, cuts, modes = 0.0, 0, m[MODES] == 1.0
    while done < 1.0:
        share = 1.0 - done
        if modes and cuts < MOST_CUTS and any_sticks(m):
            share = stuck_share(m, done)
            cuts += 1 if share < 1.0 - done else 0
        share = stable_share(m, share)
        rk4(m, done, share)
        which = first_crossed(m) if modes and cuts < MOST_CUTS else -1
        if which >= 0:
            cuts += 1
            share = locate(m, which, share, done)
            rk4(m, done, share)
        if accept(m, share) != 0:
            return 2
        done = 1.0 if 1.0 - done - share < 1e-9 else done + share
        if modes and (cuts > 0 or done == 1.0):
            set_modes(m, done)
            if any_sticks(m):
                derivative(m, Y, done)
                release(m)
    return 0


@kernel
def accept(m, share):
    """Take the trial state over; 1 where a memory is full."""
    for i in range(int(m[STATE_SIZE])):
        m[BEFORE + i] = m[Y + i]
        m[Y + i] = m[TRIAL + i]
    return remember(m, share * m[STEP])


@kernel
def integrate(m, base, push, accelerations, samples):
    """Fill the outputs; return 0, 1 where the motion ran away, 2 where a memory is full.

    Accelerations are those at the beginnings of the steps, then their means over the steps.
    """
    acceleration, means = accelerations[0], accelerations[1]
    n, every = int(m[N_MASSES]), int(m[SUBSTEPS])
    set_modes(m, 0.0)
    for k in range(acceleration.shape[0]):
        m[TIME] = k * m[STEP]
        for i in range(3):
            m[BASE + i], m[PUSH + i] = base[2 * k + i], push[2 * k + i]
        derivative(m, Y, 0.0)
        for i in range(n):
            acceleration[k, i] = m[RATES + n + i] + base[2 * k]
        if k % every == 0:
            sample(m, k // every, samples)
        felt = (base[2 * k] + 4.0 * base[2 * k + 1] + base[2 * k + 2]) / 6.0
        for i in range(n):
            means[k, i] = felt - m[Y + n + i] / m[STEP]
        status = one_step(m)
        if status != 0:
            return status
        for i in range(n):
            means[k, i] += m[Y + n + i] / m[STEP]
            if not abs(m[Y + i]) < m[LIMIT]:
                return 1
    return 0


@kernel
def sample(m, row, samples):
    """Keep displacement, velocity, stretch, its rate and forces in a row of the samples."""
    n, at = int(m[N_MASSES]), 0
    for i in range(2 * n):
        samples[row, i] = m[Y + i]
    at = 2 * n
    ne = int(m[N_ELEMENTS])
    for e in range(ne):
        z, w = stretch(m, Y, ELEMENTS + STRIDE * e, n)
        samples[row, at + e] = z
        samples[row, at + ne + e] = w
        samples[row, at + 2 * ne + e] = m[FORCES + e]
