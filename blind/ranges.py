"""What is drawn: one table of ranges, relative to the motion of the linear model.

The unit of each range is A, the characteristic displacement of the joint: the geometric mean
of rms and peak of the linear model's motion at the middle level; V = omega_n A; k, m, zeta,
omega are those of the linear joint.

| effect | parameter | range |
|---|---|---|
| gap | stiffness; clearance | 0.3-4 k; 0.2-0.9 A |
| offset_gap | stiffness; clearances | 0.3-4 k; 0.2-0.9 A and 1.4-3 times that, either side |
| stop | stiffness; clearance; side | 0.3-4 k; 0.1-0.8 A; either |
| cubic_stiffness | coefficient | 0.1-1 k/A^2; one in six softening, -0.02 to -0.1 |
| quadratic_stiffness | coefficient | 0.08-0.3 k/A, either sign |
| power_law | force; reference; exponent | 0.15-1 kA; A; 1.4-2.5 or 3.6-5 |
| coulomb_friction | sliding_force | 5-60 % of the rms of the spring force |
| stribeck_friction | sliding; breakaway; velocity | 5-40 %; 1.2-2 times; 0.1-0.6 V |
| lugre_friction | as stribeck; bristles | bristle deflection 0.03-0.2 A; damping 0.1-0.5 |
| quadratic_damping | coefficient | equivalent ratio 0.01-0.1 at V |
| contact_damping | damping; clearance | ratio 0.03-0.3; 0.2-0.9 A |
| jenkins | stiffness; slip_force | 0.1-1 k; 0.1-0.8 A times that |
| iwan | stiffness; slip_displacement | 0.1-1 k; 0.3-2 A |
| bouc_wen | stiffness; yield_displacement; exponent | 0.1-1 k; 0.1-0.8 A; 1-3 |
| attached_mode | mass; frequency; ratio | 0.02-0.15 m; 0.6-2.2 f_n; 0.005-0.04 |
| stiffness_drift | rate | +-3 to +-20 % over the test |

Outside the library: stiffness periodic in time (5-25 %, 0.5-12 Hz), Hunt-Crossley impact,
fractional damping (order 0.3-0.7 over three decades), saturating and sine springs, damping that
depends on position, softening with the recent motion, a damper that acts one way, friction that
grows with displacement (a wedge).

A draw counts only if the effect is exercised: at the highest level what its force leaves once z
and dz/dt (and the force of the other effect) are regressed out exceeds three times the noise
and 3 % of the response. Draws that miss it are drawn again, after six with 6 dB less noise.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from blind import laws

Rng = np.random.Generator
Parameters = dict[str, float]


@dataclass(frozen=True)
class Scale:
    """The linear joint and its motion; the last two are V and the rms of the spring force."""

    mass: float
    stiffness: float
    omega: float
    displacement: float
    velocity: float
    spring_force: float


@dataclass(frozen=True)
class Hidden:
    """One hidden effect: what it is called and what the truth integrates for it.

    `parts` are (code, parameters, thresholds); `attached` is (mass, stiffness, damping).
    """

    parameters: Parameters
    parts: tuple[tuple[int, tuple[float, ...], tuple[float, ...]], ...] = ()
    attached: tuple[float, float, float] | None = None
    main: str = ""


def log_uniform(rng: Rng, low: float, high: float) -> float:
    """Return a number whose logarithm is spread evenly."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def sign(rng: Rng) -> float:
    """Return 1 or -1."""
    return float(rng.choice([-1.0, 1.0]))


def _gap(rng: Rng, at: Scale) -> Hidden:
    k, a = log_uniform(rng, 0.3, 4.0) * at.stiffness, rng.uniform(0.2, 0.9) * at.displacement
    return Hidden(
        {"stiffness": k, "clearance": a}, ((laws.GAP, (k, a, a), (-a, a)),), main="clearance"
    )


def _offset_gap(rng: Rng, at: Scale) -> Hidden:
    k, a = log_uniform(rng, 0.3, 4.0) * at.stiffness, rng.uniform(0.2, 0.9) * at.displacement
    b = a * rng.uniform(1.4, 3.0)
    up, down = (a, b) if rng.random() < 0.5 else (b, a)
    return Hidden(
        {"stiffness": k, "clearance_positive": up, "clearance_negative": down},
        ((laws.OFFSET_GAP, (k, up, down), (-down, up)),),
        main="clearance_positive" if up < down else "clearance_negative",
    )


def _stop(rng: Rng, at: Scale) -> Hidden:
    k, a = log_uniform(rng, 0.3, 4.0) * at.stiffness, rng.uniform(0.1, 0.8) * at.displacement
    side = sign(rng)
    return Hidden(
        {"stiffness": k, "clearance": a, "side": side},
        ((laws.STOP, (k, a, side), (side * a,)),),
        main="clearance",
    )


def _cubic(rng: Rng, at: Scale) -> Hidden:
    share = -log_uniform(rng, 0.02, 0.1) if rng.random() < 1 / 6 else log_uniform(rng, 0.1, 1.0)
    c = share * at.stiffness / at.displacement**2
    return Hidden({"coefficient": c}, ((laws.CUBIC, (c,), ()),), main="coefficient")


def _quadratic(rng: Rng, at: Scale) -> Hidden:
    c = sign(rng) * log_uniform(rng, 0.08, 0.3) * at.stiffness / at.displacement
    return Hidden({"coefficient": c}, ((laws.QUADRATIC, (c,), ()),), main="coefficient")


def _power(rng: Rng, at: Scale) -> Hidden:
    n = rng.uniform(1.4, 2.5) if rng.random() < 0.5 else rng.uniform(3.6, 5.0)
    f = log_uniform(rng, 0.15, 1.0) * at.stiffness * at.displacement
    return Hidden(
        {"force": f, "reference_displacement": at.displacement, "exponent": n},
        ((laws.POWER, (f, at.displacement, n), ()),),
        main="exponent",
    )


def _coulomb(rng: Rng, at: Scale) -> Hidden:
    f = log_uniform(rng, 0.05, 0.6) * at.spring_force
    return Hidden({"sliding_force": f}, ((laws.COULOMB, (f,), ()),), main="sliding_force")


def _stribeck(rng: Rng, at: Scale) -> Hidden:
    f = log_uniform(rng, 0.05, 0.4) * at.spring_force
    top, v = f * rng.uniform(1.2, 2.0), log_uniform(rng, 0.1, 0.6) * at.velocity
    return Hidden(
        {"sliding_force": f, "breakaway_force": top, "stribeck_velocity": v},
        ((laws.STRIBECK, (f, top, v), ()),),
        main="sliding_force",
    )


def _lugre(rng: Rng, at: Scale) -> Hidden:
    f = log_uniform(rng, 0.05, 0.4) * at.spring_force
    top, v = f * rng.uniform(1.2, 2.0), log_uniform(rng, 0.1, 0.6) * at.velocity
    bristle = f / (log_uniform(rng, 0.03, 0.2) * at.displacement)
    damping = rng.uniform(0.1, 0.5) * np.sqrt(bristle * at.mass)
    return Hidden(
        {"sliding_force": f, "breakaway_force": top, "stribeck_velocity": v,
         "bristle_stiffness": bristle, "bristle_damping": damping},
        ((laws.LUGRE, (f, top, v, bristle, damping, 0.0), ()),),
        main="sliding_force",
    )  # fmt: skip


def _quadratic_damping(rng: Rng, at: Scale) -> Hidden:
    c = 2.0 * at.mass * at.omega * log_uniform(rng, 0.01, 0.1) / at.velocity
    return Hidden({"coefficient": c}, ((laws.QUADRATIC_DAMPING, (c,), ()),), main="coefficient")


def _contact_damping(rng: Rng, at: Scale) -> Hidden:
    c = 2.0 * at.mass * at.omega * log_uniform(rng, 0.03, 0.3)
    a = rng.uniform(0.2, 0.9) * at.displacement
    return Hidden(
        {"damping": c, "clearance": a},
        ((laws.CONTACT_DAMPING, (c, a), (-a, a)),),
        main="damping",
    )


def _jenkins(rng: Rng, at: Scale) -> Hidden:
    k, a = (
        log_uniform(rng, 0.1, 1.0) * at.stiffness,
        log_uniform(rng, 0.1, 0.8) * at.displacement,
    )
    return Hidden(
        {"stiffness": k, "slip_force": k * a}, ((laws.JENKINS, (k, a), ()),), main="slip_force"
    )


def _iwan(rng: Rng, at: Scale) -> Hidden:
    k, a = (
        log_uniform(rng, 0.1, 1.0) * at.stiffness,
        log_uniform(rng, 0.3, 2.0) * at.displacement,
    )
    return Hidden(
        {"stiffness": k, "slip_displacement": a}, ((laws.IWAN, (k, a), ()),), main="stiffness"
    )


def _bouc_wen(rng: Rng, at: Scale) -> Hidden:
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


def _attached(rng: Rng, at: Scale) -> Hidden:
    m = log_uniform(rng, 0.02, 0.15) * at.mass
    omega, zeta = log_uniform(rng, 0.6, 2.2) * at.omega, log_uniform(rng, 0.005, 0.04)
    return Hidden(
        {"mass": m, "frequency": omega / (2.0 * np.pi), "damping_ratio": zeta},
        attached=(m, m * omega**2, 2.0 * zeta * m * omega),
        main="frequency",
    )


def _drift(rng: Rng, at: Scale) -> Hidden:
    rate = sign(rng) * log_uniform(rng, 0.03, 0.2) / 20.0
    return Hidden(
        {"rate": rate, "reference": 0.0},
        ((laws.DRIFT, (at.stiffness, rate, 0.0), ()),),
        main="rate",
    )


def _parametric(rng: Rng, at: Scale) -> Hidden:
    share, f = log_uniform(rng, 0.05, 0.25), log_uniform(rng, 0.5, 12.0)
    p = (share * at.stiffness, 2.0 * np.pi * f, rng.uniform(0.0, 6.28))
    return Hidden({"share": share, "frequency": f}, ((laws.PARAMETRIC, p, ()),))


def _hunt_crossley(rng: Rng, at: Scale) -> Hidden:
    a = rng.uniform(0.2, 0.7) * at.displacement
    k = log_uniform(rng, 1.0, 5.0) * at.stiffness / np.sqrt(at.displacement)
    p = (k, a, a, rng.uniform(0.3, 0.9) / at.velocity)
    return Hidden({"clearance": a}, ((laws.HUNT_CROSSLEY, p, (-a, a)),))


def _fractional(rng: Rng, at: Scale) -> Hidden:
    order, k = rng.uniform(0.3, 0.7), log_uniform(rng, 0.2, 0.8) * at.stiffness
    tau = 10.0 ** np.linspace(-1.2, 1.2, 6) / at.omega
    weight = tau**-order / np.sum(tau**-order)
    p = (*(k * weight), *(1.0 / tau))
    return Hidden({"order": order}, ((laws.FRACTIONAL, tuple(map(float, p)), ()),))


def _saturating(rng: Rng, at: Scale) -> Hidden:
    z0 = rng.uniform(0.15, 0.5) * at.displacement
    f = log_uniform(rng, 0.3, 1.5) * at.stiffness * z0
    return Hidden({"force": f, "displacement": z0}, ((laws.SATURATING, (f, z0), ()),))


def _position_damping(rng: Rng, at: Scale) -> Hidden:
    c = 2.0 * at.mass * at.omega * log_uniform(rng, 0.03, 0.3) / at.displacement**2
    return Hidden({"coefficient": c}, ((laws.POSITION_DAMPING, (c,), ()),))


def _thixotropic(rng: Rng, at: Scale) -> Hidden:
    p = (rng.uniform(0.2, 0.6) * at.stiffness, at.displacement * rng.uniform(0.5, 1.5),
         log_uniform(rng, 0.02, 1.0))  # fmt: skip
    return Hidden({"time": p[2]}, ((laws.THIXOTROPIC, p, ()),))


def _sine_spring(rng: Rng, at: Scale) -> Hidden:
    z0 = rng.uniform(0.15, 0.5) * at.displacement
    f = rng.uniform(0.2, 0.7) * at.stiffness * z0
    return Hidden({"force": f, "displacement": z0}, ((laws.SINE_SPRING, (f, z0), ()),))


def _asymmetric_damper(rng: Rng, at: Scale) -> Hidden:
    c = 2.0 * at.mass * at.omega * log_uniform(rng, 0.03, 0.3) * sign(rng)
    # |w| on top of at least as much plain damping, so that no direction feeds energy in
    return Hidden(
        {"damping": c},
        ((laws.ASYMMETRIC_DAMPER, (c,), ()), (laws.DAMPER, (abs(c),), ())),
    )


def _wedge(rng: Rng, at: Scale) -> Hidden:
    f = log_uniform(rng, 0.05, 0.4) * at.spring_force
    return Hidden(
        {"force": f}, ((laws.WEDGE_FRICTION, (f, at.displacement), ()),), main="force"
    )


EFFECTS: dict[str, Callable[[Rng, Scale], Hidden]] = {
    "gap": _gap,
    "offset_gap": _offset_gap,
    "stop": _stop,
    "cubic_stiffness": _cubic,
    "quadratic_stiffness": _quadratic,
    "power_law": _power,
    "coulomb_friction": _coulomb,
    "stribeck_friction": _stribeck,
    "lugre_friction": _lugre,
    "quadratic_damping": _quadratic_damping,
    "contact_damping": _contact_damping,
    "jenkins": _jenkins,
    "iwan": _iwan,
    "bouc_wen": _bouc_wen,
    "attached_mode": _attached,
    "stiffness_drift": _drift,
}

OUTSIDE: dict[str, Callable[[Rng, Scale], Hidden]] = {
    "parametric": _parametric,
    "hunt_crossley": _hunt_crossley,
    "fractional": _fractional,
    "saturating": _saturating,
    "position_damping": _position_damping,
    "thixotropic": _thixotropic,
    "sine_spring": _sine_spring,
    "asymmetric_damper": _asymmetric_damper,
    "wedge_friction": _wedge,
}

FAULTS = ("sensor_delay", "sensor_gain", "sensor_polarity", "clipping", "mains_hum")

PAIRS = (
    ("gap", "coulomb_friction"),
    ("gap", "quadratic_damping"),
    ("gap", "attached_mode"),
    ("cubic_stiffness", "coulomb_friction"),
    ("cubic_stiffness", "quadratic_damping"),
    ("cubic_stiffness", "attached_mode"),
    ("quadratic_stiffness", "coulomb_friction"),
    ("stop", "stiffness_drift"),
    ("bouc_wen", "cubic_stiffness"),
    ("contact_damping", "cubic_stiffness"),
    ("stiffness_drift", "quadratic_damping"),
    ("gap", "sensor_delay"),
    ("cubic_stiffness", "sensor_gain"),
)
