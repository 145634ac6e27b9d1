"""Forces of displacement, or of displacement and time."""

import numpy as np

from blind.compiled import kernel
from blind.laws.layout import (
    CONSTANT,
    CUBIC,
    DRIFT,
    GAP,
    HUNT_CROSSLEY,
    NOW,
    OFFSET_GAP,
    PARAMETRIC,
    POWER,
    QUADRATIC,
    REGION,
    SATURATING,
    SINE_SPRING,
    SPRING,
    STOP,
)


@kernel
def spring_law(m, p, code, z, w):
    """Force of a spring of any form."""
    if code in (SPRING, CUBIC, QUADRATIC, POWER):
        return polynomial(m, p, code, z)
    if code in (GAP, OFFSET_GAP, STOP, HUNT_CROSSLEY):
        return contact(m, p, code, z, w)
    if code in (DRIFT, PARAMETRIC):
        return timed(m, p, code, z)
    return bounded(m, p, code, z)


@kernel
def polynomial(m, p, code, z):
    """Force of a power of displacement."""
    if code == SPRING:
        return m[p] * z
    if code == CUBIC:
        return m[p] * z * z * z
    if code == QUADRATIC:
        return m[p] * z * z
    return m[p] * np.sign(z) * (abs(z) / m[p + 1]) ** m[p + 2]


@kernel
def contact(m, p, code, z, w):
    """Force of a wall on either side; thresholds: minus number 2, and number 1."""
    region = m[p + REGION]
    if code == STOP:  # stiffness, clearance, side
        closed = (m[p + 2] > 0.0) == (region == 1.0)
        return m[p] * (z - m[p + 2] * m[p + 1]) if closed else 0.0
    if code == HUNT_CROSSLEY:  # stiffness at unit depth, clearances, velocity factor
        return impact(m, p, region, z, w)
    if region == 0.0:
        return m[p] * (z + m[p + 2])
    return m[p] * (z - m[p + 1]) if region == 2.0 else 0.0


@kernel
def impact(m, p, region, z, w):
    """Force of an impact that grows with the depth to the power of 3/2 and with velocity."""
    if region == 0.0:
        return -m[p] * max(-z - m[p + 2], 0.0) ** 1.5 * max(1.0 - m[p + 3] * w, 0.0)
    if region == 2.0:
        return m[p] * max(z - m[p + 1], 0.0) ** 1.5 * max(1.0 + m[p + 3] * w, 0.0)
    return 0.0


@kernel
def timed(m, p, code, z):
    """Force of a stiffness that changes with time."""
    if code == DRIFT:  # stiffness, rate, reference time
        return m[p] * m[p + 1] * (m[NOW] - m[p + 2]) * z
    return m[p] * z * np.cos(m[p + 1] * m[NOW] + m[p + 2])


@kernel
def bounded(m, p, code, z):
    """Force that does not grow without end."""
    if code == CONSTANT:
        return m[p]
    if code == SATURATING:
        return m[p] * np.tanh(z / m[p + 1])
    if code == SINE_SPRING:
        return m[p] * np.sin(z / m[p + 1])
    return np.nan
