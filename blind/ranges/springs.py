"""Springs of every form: what depends on displacement alone."""

import numpy as np

from blind import laws
from blind.draws import Rng, log_uniform, sign
from blind.ranges.scale import Hidden, Scale


def gap(rng: Rng, at: Scale) -> Hidden:
    """Return the hidden effect."""
    k, a = log_uniform(rng, 0.3, 4.0) * at.stiffness, rng.uniform(0.2, 0.9) * at.displacement
    return Hidden(
        {"stiffness": k, "clearance": a}, ((laws.GAP, (k, a, a), (-a, a)),), main="clearance"
    )


def offset_gap(rng: Rng, at: Scale) -> Hidden:
    """Return the hidden effect."""
    k, a = log_uniform(rng, 0.3, 4.0) * at.stiffness, rng.uniform(0.2, 0.9) * at.displacement
    b = a * rng.uniform(1.4, 3.0)
    up, down = (a, b) if rng.random() < 0.5 else (b, a)
    return Hidden(
        {"stiffness": k, "clearance_positive": up, "clearance_negative": down},
        ((laws.OFFSET_GAP, (k, up, down), (-down, up)),),
        main="clearance_positive" if up < down else "clearance_negative",
    )


def stop(rng: Rng, at: Scale) -> Hidden:
    """Return the hidden effect."""
    k, a = log_uniform(rng, 0.3, 4.0) * at.stiffness, rng.uniform(0.1, 0.8) * at.displacement
    side = sign(rng)
    return Hidden(
        {"stiffness": k, "clearance": a, "side": side},
        ((laws.STOP, (k, a, side), (side * a,)),),
        main="clearance",
    )


def hertz(rng: Rng, at: Scale) -> Hidden:
    """Return the hidden effect."""
    a = rng.uniform(0.2, 0.7) * at.displacement
    k = log_uniform(rng, 1.0, 5.0) * at.stiffness / np.sqrt(at.displacement)
    factor = rng.uniform(0.3, 0.9) / at.velocity
    return Hidden(
        {"stiffness": k, "clearance": a, "restitution_loss": factor / 1.5},
        ((laws.HUNT_CROSSLEY, (k, a, a, factor), (-a, a)),),
        main="clearance",
    )


def cubic(rng: Rng, at: Scale) -> Hidden:
    """Return the hidden effect."""
    share = -log_uniform(rng, 0.02, 0.1) if rng.random() < 1 / 6 else log_uniform(rng, 0.1, 1.0)
    c = share * at.stiffness / at.displacement**2
    return Hidden({"coefficient": c}, ((laws.CUBIC, (c,), ()),), main="coefficient")


def quadratic(rng: Rng, at: Scale) -> Hidden:
    """Return the hidden effect."""
    c = sign(rng) * log_uniform(rng, 0.08, 0.3) * at.stiffness / at.displacement
    return Hidden({"coefficient": c}, ((laws.QUADRATIC, (c,), ()),), main="coefficient")


def power(rng: Rng, at: Scale) -> Hidden:
    """Return the hidden effect."""
    n = rng.uniform(1.4, 2.5) if rng.random() < 0.5 else rng.uniform(3.6, 5.0)
    f = log_uniform(rng, 0.15, 1.0) * at.stiffness * at.displacement
    return Hidden(
        {"force": f, "reference_displacement": at.displacement, "exponent": n},
        ((laws.POWER, (f, at.displacement, n), ()),),
        main="exponent",
    )


def constant_force(rng: Rng, at: Scale) -> Hidden:
    """Return a dead weight on a joint whose free play the model holds; at rest it is open."""
    k, a = log_uniform(rng, 0.5, 3.0) * at.stiffness, rng.uniform(0.4, 0.9) * at.displacement
    start = sign(rng) * rng.uniform(0.3, 0.8) * a
    force = -at.stiffness * start
    return Hidden(
        {"force": force},
        ((laws.CONSTANT, (force,), ()), (laws.GAP, (k, a, a), (-a, a))),
        main="force",
        start=start,
        known=(("gap", {"stiffness": f"{k:.10g} N/m", "clearance": f"{a:.10g} m"}),),
    )


def pendulum(rng: Rng, at: Scale) -> Hidden:
    """Return the spring of an arc, of which a cubic that softens is the beginning."""
    length = 2.0 * at.displacement / rng.uniform(0.3, 1.2)
    k = at.stiffness
    return Hidden(
        {"coefficient": -k / (6.0 * length**2)},
        ((laws.SPRING, (-k,), ()), (laws.SINE_SPRING, (k * length, length), ())),
        main="coefficient",
        kind="cubic_stiffness",
    )


def bistable(rng: Rng, at: Scale) -> Hidden:
    """Return a negative stiffness beside a cubic; the user measured the stiffness in a well."""
    start = sign(rng) * rng.uniform(0.3, 1.0) * at.displacement
    c = at.stiffness / (2.0 * start**2)
    return Hidden(
        {"coefficient": c},
        ((laws.SPRING, (-1.5 * at.stiffness,), ()), (laws.CUBIC, (c,), ())),
        main="coefficient",
        start=start,
        kind="cubic_stiffness",
        wells=True,
    )
