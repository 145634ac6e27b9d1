"""Dry friction, and the regimes that it is drawn in."""

import numpy as np

from blind import laws
from blind.draws import Rng, log_uniform
from blind.ranges.scale import Hidden, Parameters, Scale
from blind.truth import Motion


def coulomb(rng: Rng, at: Scale) -> Hidden:
    """Return the hidden effect."""
    f = log_uniform(rng, 0.05, 0.6) * at.spring_force
    return Hidden({"sliding_force": f}, ((laws.COULOMB, (f,), ()),), main="sliding_force")


def stribeck(rng: Rng, at: Scale) -> Hidden:
    """Return the hidden effect."""
    f = log_uniform(rng, 0.05, 0.4) * at.spring_force
    top, v = f * rng.uniform(1.2, 2.0), log_uniform(rng, 0.1, 0.6) * at.velocity
    return Hidden(
        {"sliding_force": f, "breakaway_force": top, "stribeck_velocity": v},
        ((laws.STRIBECK, (f, top, v), ()),),
        main="sliding_force",
    )


def lugre(rng: Rng, at: Scale) -> Hidden:
    """Return the hidden effect."""
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


REGIME_FORCES = {
    "sticking": {"random": (0.8, 2.5), "sine sweep": (0.45, 1.0)},
    "locked": {"random": (5.0, 15.0), "sine sweep": (1.05, 3.0)},
}
"""Force that holds, over the rms (random) or amplitude (sweep) of what a rigid joint carries at
the highest level [-]."""
BRISTLE_FREQUENCY = 5000.0
"""Natural frequency of the mass on the bristles of a locked joint [Hz]."""
AT_REST = 1e-12
"""Velocity that is rounding, where a contact sticks [m/s]."""
SLIDES_BELOW, STICKS_ABOVE = 0.4, 0.5
"""Share of the driven time that a joint sticks at the highest level: below, above [-]."""


def in_regime(
    rng: Rng, hidden: Hidden, regime: str, drive: str, *, rigid: tuple[float, float]
) -> Hidden:
    """Return a friction law whose force is drawn again for a regime.

    `rigid` is the force that the joint carries while it sticks, and the mass beyond it [N, kg].
    """
    rigid_force, mass = rigid
    if regime not in REGIME_FORCES:
        return hidden
    low, high = REGIME_FORCES[regime][drive]
    now = hidden.parameters.get("breakaway_force", hidden.parameters["sliding_force"])
    factor = log_uniform(rng, low, high) * rigid_force / now
    powers = {"stribeck_velocity": 0.0, "bristle_damping": 0.5}
    numbers = {
        name: value * factor ** powers.get(name, 1.0)
        for name, value in hidden.parameters.items()
    }
    if regime == "locked" and "bristle_stiffness" in numbers:
        numbers |= _stiff_bristles(rng, numbers, mass)
    (code, values, thresholds) = hidden.parts[0]
    viscous = values[len(numbers) :]
    return Hidden(
        numbers, ((code, (*numbers.values(), *viscous), thresholds),), main=hidden.main
    )


def _stiff_bristles(rng: Rng, numbers: Parameters, mass: float) -> Parameters:
    """Return forces and bristles that are linear and rigid to the noise, in most draws."""
    more, omega = log_uniform(rng, 10.0, 30.0), 2.0 * np.pi * BRISTLE_FREQUENCY
    return {
        "sliding_force": numbers["sliding_force"] * more,
        "breakaway_force": numbers["breakaway_force"] * more,
        "bristle_stiffness": mass * omega**2,
        "bristle_damping": 0.6 * mass * omega,
    }


def sticking_share(hidden: Hidden, rate: np.ndarray, force: np.ndarray) -> float:
    """Return the share of samples at which a contact sticks (a bristle has not given way)."""
    if "bristle_stiffness" in hidden.parameters:
        return float(np.mean(np.abs(force) < 0.8 * hidden.parameters["sliding_force"]))
    return float(np.mean(np.abs(rate) < AT_REST))


def slips(hidden: Hidden, motion: Motion) -> bool:
    """Whether a contact gives way anywhere in a test."""
    return sticking_share(hidden, motion.rate[:, 0], motion.force[:, 0]) < 1.0


def accepted(regime: str, share: float, departure: float, noise: float) -> bool:
    """Whether a draw is in its regime.

    `departure` is how far the joint is from a rigid one, as a share of the response: locked
    bristles are rigid to the noise; a joint that sticks most of the time must show its slips.
    """
    if regime == "locked":
        return share == 1.0 and departure < 1.3 * noise
    if regime == "sticking":
        return STICKS_ABOVE < share < 0.99 and departure > max(0.03, 3.0 * noise)
    return share < SLIDES_BELOW
