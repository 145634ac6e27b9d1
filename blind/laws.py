"""The force laws of the truth, each written once more and on purpose not shared.

z is the displacement of the second end of an element against the first, w its velocity. A law
sees which side of its thresholds z is on (`region`) and which way it slides (`sign`, 0 where it
sticks); both are frozen during a step and changed at located crossings, so that each step
integrates a smooth function.
"""

import numpy as np
from numba import njit

SPRING, DAMPER, GAP, OFFSET_GAP, STOP, CUBIC, QUADRATIC, POWER = range(8)
COULOMB, STRIBECK, LUGRE, QUADRATIC_DAMPING, CONTACT_DAMPING, JENKINS, IWAN = range(8, 15)
BOUC_WEN, DRIFT = 15, 16
PARAMETRIC, HUNT_CROSSLEY, FRACTIONAL, SATURATING, POSITION_DAMPING = range(20, 25)
THIXOTROPIC, SINE_SPRING, ASYMMETRIC_DAMPER, WEDGE_FRICTION = range(25, 29)

STATES = {LUGRE: 1, BOUC_WEN: 1, FRACTIONAL: 6, THIXOTROPIC: 1, JENKINS: 1}
SLIDING = (COULOMB, STRIBECK, WEDGE_FRICTION)

N_MASSES, N_ELEMENTS, STATE_SIZE, FORCE_ON, MASSES, JOINTS, FORCES = 0, 1, 2, 3, 4, 8, 40
ELEMENTS, STRIDE, Y, TRIAL, WORK, RATES, BEFORE = 48, 24, 192, 208, 224, 240, 256
STACK, REVERSALS, SIZE = 272, 2**17, 272 + 2**18
"""Places in the one array that the kernels share (passing many arrays would cost more than the
laws): masses, joints as a matrix, forces and tables of the elements, five states, reversals."""
THRESHOLDS, FIRST, SECOND, KIND, REGION = 12, 14, 15, 16, 17
SIGN, SLIDES, N_THRESHOLDS, STATE, DEPTH = 18, 19, 20, 21, 22
"""Places in the table of an element: twelve parameters, two thresholds, ends, mode, memory."""


@njit(cache=True, error_model="numpy")
def iwan_backbone(x, k, limit):  # noqa: D103
    if x >= limit:
        return 0.5 * k * limit
    if x <= -limit:
        return -0.5 * k * limit
    return k * x * (1.0 - 0.5 * abs(x) / limit)


@njit(cache=True, error_model="numpy")
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


@njit(cache=True, error_model="numpy")
def iwan_force(z, k, limit, m, depth):
    """Force of sliders spread evenly over slip displacements 0 to limit, by Masing's rule."""
    depth = iwan_depth(z, m, depth)
    if depth == 0:
        return iwan_backbone(z, k, limit)
    top = depth - 1
    return m[STACK + REVERSALS + top] + 2.0 * iwan_backbone(
        0.5 * (z - m[STACK + top]), k, limit
    )


@njit(cache=True, error_model="numpy")
def breakaway(m, p, z):
    """Largest force that holds a sticking contact."""
    code = int(m[p + KIND])
    if code == COULOMB:
        return m[p]
    if code == STRIBECK:
        return m[p + 1]
    return m[p] * abs(z) / m[p + 1]


@njit(cache=True, error_model="numpy")
def law(m, p, z, w, t, y):
    """Force of one element; the rates of its states (in y from `at` on) go to RATES."""
    code, region, sign = int(m[p + KIND]), int(m[p + REGION]), m[p + SIGN]
    at = int(m[p + STATE])
    if code == SPRING:
        return m[p] * z
    if code == DAMPER:
        return m[p] * w
    if code in (GAP, OFFSET_GAP):  # thresholds: minus number 2, and number 1
        if region == 0:
            return m[p] * (z + m[p + 2])
        if region == 2:
            return m[p] * (z - m[p + 1])
        return 0.0
    if code == STOP:  # stiffness, clearance, side
        if (m[p + 2] > 0.0) == (region == 1):
            return m[p] * (z - m[p + 2] * m[p + 1])
        return 0.0
    if code == CUBIC:
        return m[p] * z * z * z
    if code == QUADRATIC:
        return m[p] * z * z
    if code == POWER:
        return m[p] * np.sign(z) * (abs(z) / m[p + 1]) ** m[p + 2]
    if code == COULOMB:
        return m[p] * sign
    if code == STRIBECK:
        return sign * (m[p] + (m[p + 1] - m[p]) * np.exp(-((w / m[p + 2]) ** 2)))
    if code == LUGRE:  # sliding, breakaway, velocity, bristle stiffness, damping, viscous
        g = m[p] + (m[p + 1] - m[p]) * np.exp(-((w / m[p + 2]) ** 2))
        m[RATES + at] = w - m[p + 3] * abs(w) * m[y + at] / g
        return m[p + 3] * m[y + at] + m[p + 4] * m[RATES + at] + m[p + 5] * w
    if code == QUADRATIC_DAMPING:
        return m[p] * w * abs(w)
    if code == CONTACT_DAMPING:
        return 0.0 if region == 1 else m[p] * w
    if code == JENKINS:  # stiffness, slip displacement
        return m[p] * min(max(z - m[y + at], -m[p + 1]), m[p + 1])
    if code == IWAN:
        return iwan_force(z, m[p], m[p + 1], m, int(m[p + DEPTH]))
    if code == BOUC_WEN:
        r = m[y + at]
        shape = 1.0 if r * w > 0.0 else 0.0
        m[RATES + at] = w / m[p + 1] * (1.0 - shape * abs(r) ** m[p + 2])
        return m[p] * m[p + 1] * r
    if code == DRIFT:  # stiffness, rate, reference time
        return m[p] * m[p + 1] * (t - m[p + 2]) * z
    if code == PARAMETRIC:
        return m[p] * z * np.cos(m[p + 1] * t + m[p + 2])
    if code == HUNT_CROSSLEY:  # stiffness at unit depth, clearances, velocity factor
        if region == 0:
            return -m[p] * max(-z - m[p + 2], 0.0) ** 1.5 * max(1.0 - m[p + 3] * w, 0.0)
        if region == 2:
            return m[p] * max(z - m[p + 1], 0.0) ** 1.5 * max(1.0 + m[p + 3] * w, 0.0)
        return 0.0
    if code == FRACTIONAL:  # six Maxwell elements spread over the decades: stiffness, 1/tau
        total = 0.0
        for i in range(6):
            m[RATES + at + i] = m[p + i] * w - m[p + 6 + i] * m[y + at + i]
            total += m[y + at + i]
        return total
    if code == SATURATING:
        return m[p] * np.tanh(z / m[p + 1])
    if code == POSITION_DAMPING:
        return m[p] * z * z * w
    if code == THIXOTROPIC:  # softens with the recent mean square of the motion
        m[RATES + at] = (z * z - m[y + at]) / m[p + 2]
        return -m[p] * z * m[y + at] / (m[y + at] + m[p + 1] * m[p + 1])
    if code == SINE_SPRING:
        return m[p] * np.sin(z / m[p + 1])
    if code == ASYMMETRIC_DAMPER:
        return m[p] * abs(w)
    if code == WEDGE_FRICTION:
        return m[p] * abs(z) / m[p + 1] * sign
    return np.nan
