"""Laws that the library lacks."""

import numpy as np

from blind import laws
from blind.draws import Rng, log_uniform, sign
from blind.ranges.scale import Hidden, Scale


def parametric(rng: Rng, at: Scale) -> Hidden:
    """Return the hidden effect."""
    share, f = log_uniform(rng, 0.05, 0.25), log_uniform(rng, 0.5, 12.0)
    p = (share * at.stiffness, 2.0 * np.pi * f, rng.uniform(0.0, 6.28))
    return Hidden({"share": share, "frequency": f}, ((laws.PARAMETRIC, p, ()),))


def fractional(rng: Rng, at: Scale) -> Hidden:
    """Return the hidden effect."""
    order, k = rng.uniform(0.3, 0.7), log_uniform(rng, 0.2, 0.8) * at.stiffness
    tau = 10.0 ** np.linspace(-1.2, 1.2, 6) / at.omega
    weight = tau**-order / np.sum(tau**-order)
    p = (*(k * weight), *(1.0 / tau))
    return Hidden({"order": order}, ((laws.FRACTIONAL, tuple(map(float, p)), ()),))


def position_damping(rng: Rng, at: Scale) -> Hidden:
    """Return the hidden effect."""
    c = 2.0 * at.mass * at.omega * log_uniform(rng, 0.03, 0.3) / at.displacement**2
    return Hidden({"coefficient": c}, ((laws.POSITION_DAMPING, (c,), ()),))


def thixotropic(rng: Rng, at: Scale) -> Hidden:
    """Return the hidden effect."""
    p = (rng.uniform(0.2, 0.6) * at.stiffness, at.displacement * rng.uniform(0.5, 1.5),
         log_uniform(rng, 0.02, 1.0))  # fmt: skip
    return Hidden({"time": p[2]}, ((laws.THIXOTROPIC, p, ()),))


def sine_spring(rng: Rng, at: Scale) -> Hidden:
    """Return the hidden effect."""
    z0 = rng.uniform(0.15, 0.5) * at.displacement
    f = rng.uniform(0.2, 0.7) * at.stiffness * z0
    return Hidden({"force": f, "displacement": z0}, ((laws.SINE_SPRING, (f, z0), ()),))


def asymmetric_damper(rng: Rng, at: Scale) -> Hidden:
    """Return the hidden effect."""
    c = 2.0 * at.mass * at.omega * log_uniform(rng, 0.03, 0.3) * sign(rng)
    # |w| on top of at least as much plain damping, so that no direction feeds energy in
    return Hidden(
        {"damping": c},
        ((laws.ASYMMETRIC_DAMPER, (c,), ()), (laws.DAMPER, (abs(c),), ())),
    )


def wedge(rng: Rng, at: Scale) -> Hidden:
    """Return the hidden effect."""
    f = log_uniform(rng, 0.05, 0.4) * at.spring_force
    return Hidden(
        {"force": f}, ((laws.WEDGE_FRICTION, (f, at.displacement), ()),), main="force"
    )
