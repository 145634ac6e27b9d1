"""Forces of velocity: dampers and dry friction."""

import numpy as np

from blind.compiled import kernel
from blind.laws.layout import (
    ASYMMETRIC_DAMPER,
    CONTACT_DAMPING,
    COULOMB,
    DAMPER,
    KIND,
    POSITION_DAMPING,
    QUADRATIC_DAMPING,
    REGION,
    SIGN,
    STRIBECK,
)


@kernel
def damper_law(m, p, code, z, w):
    """Force of a damper."""
    if code == DAMPER:
        return m[p] * w
    if code == QUADRATIC_DAMPING:
        return m[p] * w * abs(w)
    if code == CONTACT_DAMPING:
        return 0.0 if m[p + REGION] == 1.0 else m[p] * w
    if code == POSITION_DAMPING:
        return m[p] * z * z * w
    if code == ASYMMETRIC_DAMPER:
        return m[p] * abs(w)
    return np.nan


@kernel
def friction_law(m, p, code, z, w):
    """Force of a contact that slides."""
    if code == COULOMB:
        return m[p] * m[p + SIGN]
    if code == STRIBECK:
        fall = np.exp(-((w / m[p + 2]) ** 2))
        return m[p + SIGN] * (m[p] + (m[p + 1] - m[p]) * fall)
    return m[p] * abs(z) / m[p + 1] * m[p + SIGN]


@kernel
def breakaway(m, p, z):
    """Largest force that holds a sticking contact."""
    code = int(m[p + KIND])
    if code == COULOMB:
        return m[p]
    if code == STRIBECK:
        return m[p + 1]
    return m[p] * abs(z) / m[p + 1]
