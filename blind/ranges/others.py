"""Dampers, an attached mode and a drift."""

import numpy as np

from blind import laws
from blind.draws import Rng, log_uniform, sign
from blind.ranges.scale import Hidden, Scale


def quadratic_damping(rng: Rng, at: Scale) -> Hidden:
    """Return the hidden effect."""
    c = 2.0 * at.mass * at.omega * log_uniform(rng, 0.01, 0.1) / at.velocity
    return Hidden({"coefficient": c}, ((laws.QUADRATIC_DAMPING, (c,), ()),), main="coefficient")


def contact_damping(rng: Rng, at: Scale) -> Hidden:
    """Return the hidden effect."""
    c = 2.0 * at.mass * at.omega * log_uniform(rng, 0.03, 0.3)
    a = rng.uniform(0.2, 0.9) * at.displacement
    return Hidden(
        {"damping": c, "clearance": a},
        ((laws.CONTACT_DAMPING, (c, a), (-a, a)),),
        main="damping",
    )


def attached(rng: Rng, at: Scale) -> Hidden:
    """Return the hidden effect."""
    m = log_uniform(rng, 0.02, 0.15) * at.mass
    omega, zeta = log_uniform(rng, 0.6, 2.2) * at.omega, log_uniform(rng, 0.005, 0.04)
    return Hidden(
        {"mass": m, "frequency": omega / (2.0 * np.pi), "damping_ratio": zeta},
        attached=(m, m * omega**2, 2.0 * zeta * m * omega),
        main="frequency",
    )


def drift(rng: Rng, at: Scale) -> Hidden:
    """Return the hidden effect."""
    rate = sign(rng) * log_uniform(rng, 0.03, 0.2) / 20.0
    return Hidden(
        {"rate": rate, "reference": 0.0},
        ((laws.DRIFT, (at.stiffness, rate, 0.0), ()),),
        main="rate",
    )
