"""Forces with a memory: states of the element, or the reversals that still matter."""

import numpy as np

from blind.compiled import kernel
from blind.laws.layout import (
    BOUC_WEN,
    DEPTH,
    FRACTIONAL,
    GENERAL_BOUC_WEN,
    IWAN,
    JENKINS,
    KIND,
    LUGRE,
    RATES,
    REVERSALS,
    SERIES,
    STACK,
    STATE,
)


@kernel
def memory_law(m, p, z, w, y):
    """Force of a law with memory; the rates of its states (in y from `at` on) go to RATES."""
    at, code = int(m[p + STATE]), int(m[p + KIND])
    if code == LUGRE:
        return lugre(m, p, w, y, at)
    if code in (BOUC_WEN, GENERAL_BOUC_WEN):
        return bouc_wen(m, p, w, y, at)
    if code in (JENKINS, SERIES):
        return slider(m, p, code, z - m[y + at])
    if code == IWAN:
        return iwan_force(m, p, z, int(m[p + DEPTH]))
    if code == FRACTIONAL:
        return fractional(m, p, w, y, at)
    return thixotropic(m, p, z, y, at)


@kernel
def lugre(m, p, w, y, at):
    """Sliding, breakaway, velocity, bristle stiffness and damping, viscous damping."""
    g = m[p] + (m[p + 1] - m[p]) * np.exp(-((w / m[p + 2]) ** 2))
    m[RATES + at] = w - m[p + 3] * abs(w) * m[y + at] / g
    return m[p + 3] * m[y + at] + m[p + 4] * m[RATES + at] + m[p + 5] * w


@kernel
def bouc_wen(m, p, w, y, at):
    """Stiffness, yield, exponent; or alpha, beta, gamma, exponent, whose state is the force."""
    r = m[y + at]
    if m[p + KIND] == GENERAL_BOUC_WEN:
        size = abs(r) ** m[p + 3]
        turned = m[p + 1] * abs(w) * np.sign(r) + m[p + 2] * w
        m[RATES + at] = m[p] * w - turned * size
        return r
    shape = 1.0 if r * w > 0.0 else 0.0
    m[RATES + at] = w / m[p + 1] * (1.0 - shape * abs(r) ** m[p + 2])
    return m[p] * m[p + 1] * r


@kernel
def slider(m, p, code, u):
    """Force before a slider: stiffness, largest displacement; in series the play between."""
    if code == JENKINS:
        return m[p] * min(max(u, -m[p + 1]), m[p + 1])
    size = min(max(abs(u) - m[p + 2], 0.0), m[p + 1] - m[p + 2])
    return m[p] * size * np.sign(u)


@kernel
def fractional(m, p, w, y, at):
    """Six Maxwell elements spread over the decades: stiffness, 1/tau."""
    total = 0.0
    for i in range(6):
        m[RATES + at + i] = m[p + i] * w - m[p + 6 + i] * m[y + at + i]
        total += m[y + at + i]
    return total


@kernel
def thixotropic(m, p, z, y, at):
    """Softens with the recent mean square of the motion."""
    m[RATES + at] = (z * z - m[y + at]) / m[p + 2]
    return -m[p] * z * m[y + at] / (m[y + at] + m[p + 1] * m[p + 1])


@kernel
def iwan_backbone(m, p, x):
    """First loading of sliders: stiffness, slip displacement, exponent of distribution + 2."""
    k, limit, power = m[p], m[p + 1], m[p + 2]
    size = min(abs(x), limit)
    return k * size * (1.0 - (size / limit) ** (power - 1.0) / power) * np.sign(x)


@kernel
def iwan_depth(z, m, depth):
    """How many reversals still matter once z is reached."""
    while depth > 0:
        top = m[STACK + depth - 1]
        if depth == 1:
            if abs(z) > abs(top):
                depth = 0
            break
        before = m[STACK + depth - 2]
        if (z - before) * (before - top) > 0.0:
            depth -= 2
        elif (z - top) * (top - before) > 0.0:
            depth -= 1
        else:
            break
    return depth


@kernel
def iwan_force(m, p, z, depth):
    """Force of sliders whose slip displacements are spread as a power, by Masing's rule."""
    depth = iwan_depth(z, m, depth)
    if depth == 0:
        return iwan_backbone(m, p, z)
    top = depth - 1
    return m[STACK + REVERSALS + top] + 2.0 * iwan_backbone(m, p, 0.5 * (z - m[STACK + top]))
