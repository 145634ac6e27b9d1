"""Rates of the state: joints, drive, and the force of every element."""

from blind.compiled import kernel
from blind.laws.force import law
from blind.laws.layout import (
    BASE,
    ELEMENTS,
    FIRST,
    FORCE_ON,
    FORCES,
    JOINTS,
    MASSES,
    N_ELEMENTS,
    N_MASSES,
    NOW,
    PUSH,
    RATES,
    SECOND,
    SIGN,
    SLIDES,
    STEP,
    STRIDE,
    TIME,
)


@kernel
def derivative(m, y, x):
    """Fill the rates of the state at y, a share x into the step, and all forces."""
    n = int(m[N_MASSES])
    linear_rates(m, y, x)
    m[NOW] = m[TIME] + x * m[STEP]
    stuck = False
    for e in range(int(m[N_ELEMENTS])):
        p = ELEMENTS + STRIDE * e
        if sticking(m, p):
            stuck = True
            continue
        z, w = stretch(m, y, p, n)
        m[FORCES + e] = law(m, p, z, w, y)
        apply(m, p, m[FORCES + e], n)
    if stuck:
        for e in range(int(m[N_ELEMENTS])):
            p = ELEMENTS + STRIDE * e
            if sticking(m, p):
                m[FORCES + e] = hold(m, p, n)
                apply(m, p, m[FORCES + e], n)


@kernel
def linear_rates(m, y, x):
    """Fill the rates by the joints, the base acceleration and the force."""
    n, base = int(m[N_MASSES]), parabola(x, m, BASE)
    for i in range(n):
        m[RATES + i] = m[y + n + i]
        rate = -base
        for j in range(2 * n):
            rate -= m[JOINTS + 8 * i + j] * m[y + j]
        m[RATES + n + i] = rate
    pushed = int(m[FORCE_ON])
    if pushed >= 0:
        m[RATES + n + pushed] += parabola(x, m, PUSH) / m[MASSES + pushed]


@kernel
def sticking(m, p):
    """Whether an element is a contact that sticks."""
    return m[p + SLIDES] == 1.0 and m[p + SIGN] == 0.0


@kernel
def stretch(m, y, p, n):
    """Displacement and velocity across an element."""
    a, b = int(m[p + FIRST]), int(m[p + SECOND])
    if a >= 0:
        return m[y + b] - m[y + a], m[y + n + b] - m[y + n + a]
    return m[y + b], m[y + n + b]


@kernel
def apply(m, p, f, n):
    """Let an element pull its ends together with a force."""
    a, b = int(m[p + FIRST]), int(m[p + SECOND])
    m[RATES + n + b] -= f / m[MASSES + b]
    if a >= 0:
        m[RATES + n + a] += f / m[MASSES + a]


@kernel
def hold(m, p, n):
    """Force that keeps a sticking contact from accelerating."""
    a, b = int(m[p + FIRST]), int(m[p + SECOND])
    give, wanted = 1.0 / m[MASSES + b], m[RATES + n + b]
    if a >= 0:
        give += 1.0 / m[MASSES + a]
        wanted -= m[RATES + n + a]
    return wanted / give


@kernel
def parabola(x, m, at):
    """Through three numbers from `at` on, at 0, 1/2 and 1."""
    a, b, c = m[at], m[at + 1], m[at + 2]
    return a + x * (-3.0 * a + 4.0 * b - c + x * (2.0 * a - 4.0 * b + 2.0 * c))
