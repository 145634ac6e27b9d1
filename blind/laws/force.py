"""The force of one element, whatever its law."""

from blind.compiled import kernel
from blind.laws.dampers import damper_law, friction_law
from blind.laws.hysteresis import memory_law
from blind.laws.layout import (
    ASYMMETRIC_DAMPER,
    BOUC_WEN,
    CONTACT_DAMPING,
    COULOMB,
    DAMPER,
    FRACTIONAL,
    GENERAL_BOUC_WEN,
    IWAN,
    JENKINS,
    KIND,
    LUGRE,
    POSITION_DAMPING,
    QUADRATIC_DAMPING,
    SERIES,
    STRIBECK,
    THIXOTROPIC,
    WEDGE_FRICTION,
)
from blind.laws.springs import spring_law


@kernel
def law(m, p, z, w, y):
    """Force of one element; the rates of its states go to RATES."""
    code = int(m[p + KIND])
    if code in (COULOMB, STRIBECK, WEDGE_FRICTION):
        return friction_law(m, p, code, z, w)
    if code in (
        DAMPER,
        QUADRATIC_DAMPING,
        CONTACT_DAMPING,
        POSITION_DAMPING,
        ASYMMETRIC_DAMPER,
    ):
        return damper_law(m, p, code, z, w)
    if code in (
        LUGRE, BOUC_WEN, GENERAL_BOUC_WEN, JENKINS, SERIES, IWAN, FRACTIONAL, THIXOTROPIC,
    ):  # fmt: skip
        return memory_law(m, p, z, w, y)
    return spring_law(m, p, code, z, w)
