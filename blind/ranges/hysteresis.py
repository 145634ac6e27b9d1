"""Laws with memory of the displacement."""

from blind import laws
from blind.draws import Rng, log_uniform
from blind.ranges.scale import Hidden, Scale


def jenkins(rng: Rng, at: Scale) -> Hidden:
    """Return the hidden effect."""
    k, a = (
        log_uniform(rng, 0.1, 1.0) * at.stiffness,
        log_uniform(rng, 0.1, 0.8) * at.displacement,
    )
    return Hidden(
        {"stiffness": k, "slip_force": k * a}, ((laws.JENKINS, (k, a), ()),), main="slip_force"
    )


def iwan(rng: Rng, at: Scale) -> Hidden:
    """Return the hidden effect."""
    k, a = (
        log_uniform(rng, 0.1, 1.0) * at.stiffness,
        log_uniform(rng, 0.3, 2.0) * at.displacement,
    )
    return Hidden(
        {"stiffness": k, "slip_displacement": a}, ((laws.IWAN, (k, a), ()),), main="stiffness"
    )


def bouc_wen(rng: Rng, at: Scale) -> Hidden:
    """Return the hidden effect."""
    k, a = (
        log_uniform(rng, 0.1, 1.0) * at.stiffness,
        log_uniform(rng, 0.1, 0.8) * at.displacement,
    )
    n = rng.uniform(1.0, 3.0)
    return Hidden(
        {"stiffness": k, "yield_displacement": a, "exponent": n},
        ((laws.BOUC_WEN, (k, a, n), ()),),
        main="stiffness",
    )
