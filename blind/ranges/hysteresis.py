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
        {"stiffness": k, "slip_displacement": a},
        ((laws.IWAN, (k, a, 2.0), ()),),
        main="stiffness",
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


def power_iwan(rng: Rng, at: Scale) -> Hidden:
    """Return sliders whose slip displacements are spread as a power, not evenly."""
    k, a = (
        log_uniform(rng, 0.1, 1.0) * at.stiffness,
        log_uniform(rng, 0.3, 2.0) * at.displacement,
    )
    chi = rng.uniform(-0.8, -0.3) if rng.random() < 0.5 else rng.uniform(0.6, 3.0)
    return Hidden(
        {"stiffness": k, "slip_displacement": a, "chi": float(chi)},
        ((laws.IWAN, (k, a, chi + 2.0), ()),),
        main="stiffness",
    )


def general_bouc_wen(rng: Rng, at: Scale) -> Hidden:
    """Return a loop that softens with unlike branches, or that hardens (one in two)."""
    alpha = log_uniform(rng, 0.1, 1.0) * at.stiffness
    if rng.random() < 0.5:
        n, force = rng.uniform(1.0, 1.5), alpha * at.displacement
        total = -rng.uniform(0.15, 0.4) * alpha / force**n
        beta = -total / rng.uniform(0.1, 0.6)
    else:
        n = rng.uniform(1.0, 2.0)
        force = alpha * log_uniform(rng, 0.1, 0.8) * at.displacement
        total = alpha / force**n
        beta = total * rng.uniform(0.65, 1.0)
    numbers = (alpha, float(beta), float(total - beta), float(n))
    return Hidden(
        dict(zip(("alpha", "beta", "gamma", "exponent"), numbers, strict=True)),
        ((laws.GENERAL_BOUC_WEN, numbers, ()),),
        main="alpha",
    )


def series(rng: Rng, at: Scale) -> Hidden:
    """Return free play before a slider."""
    k = log_uniform(rng, 0.3, 2.0) * at.stiffness
    a = rng.uniform(0.15, 0.6) * at.displacement
    force = k * log_uniform(rng, 0.1, 0.8) * at.displacement
    return Hidden(
        {"stiffness": k, "clearance": a, "sliding_force": force},
        ((laws.SERIES, (k, a + force / k, a), ()),),
        main="clearance",
    )


def series_spring(rng: Rng, at: Scale) -> Hidden:
    """Return a spring before a slider: a Jenkins element by another name."""
    drawn = jenkins(rng, at)
    stiffness, force = drawn.parameters["stiffness"], drawn.parameters["slip_force"]
    numbers = {"stiffness": stiffness, "slip_force": force}
    return Hidden(numbers, drawn.parts, main="slip_force", kind="jenkins")


def saturating(rng: Rng, at: Scale) -> Hidden:
    """Return a spring f tanh(z / z0): Bouc-Wen with exponent 2 and branches that are one.

    The slope of that force is f / z0 less force^2 / (f z0).
    """
    z0 = rng.uniform(0.15, 0.5) * at.displacement
    f = log_uniform(rng, 0.3, 1.5) * at.stiffness * z0
    return Hidden(
        {"alpha": f / z0, "beta": 0.0, "gamma": 1.0 / (f * z0), "exponent": 2.0},
        ((laws.SATURATING, (f, z0), ()),),
        main="alpha",
        kind="general_bouc_wen",
    )
