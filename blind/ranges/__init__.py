"""What is drawn: one table of ranges, relative to the motion of the linear model.

The unit of each range is A, the characteristic displacement of the joint: the geometric mean
of rms and peak of the linear model's motion at the middle level; V = omega_n A; k, m, zeta,
omega are those of the linear joint.

| effect | parameter | range |
|---|---|---|
| gap | stiffness; clearance | 0.3-4 k; 0.2-0.9 A |
| offset_gap | stiffness; clearances | 0.3-4 k; 0.2-0.9 A and 1.4-3 times that, either side |
| stop | stiffness; clearance; side | 0.3-4 k; 0.1-0.8 A; either |
| hertz_contact | stiffness; clearance; loss | 1-5 k/sqrt(A); 0.2-0.7 A; 0.2-0.6 / V |
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
| constant_force | force | rests at 0.3-0.8 of a known gap (0.5-3 k; 0.4-0.9 A) |
| bistable | coefficient | wells at 0.3-1 A with stiffness k, both visited |
| series | stiffness; play; slider | 0.3-2 k; 0.15-0.6 A; 0.1-0.8 A times the stiffness |
| general_bouc_wen | alpha; beta; gamma; exponent | 0.1-1 k; softening or hardening |
| power_iwan | as iwan; chi | -0.8 to -0.3 or 0.6-3 |

`series_spring` is a Jenkins element, `saturating` a Bouc-Wen law whose branches are one,
f tanh(z / z0), and both are to be called so. A bistable spring seen from a well is a cubic
beside a quadratic spring: both are right.

Outside the library: stiffness periodic in time (5-25 %, 0.5-12 Hz), fractional damping (order
0.3-0.7 over three decades), sine springs, damping that
depends on position, softening with the recent motion, a damper that acts one way, friction that
grows with displacement (a wedge).

A draw counts only if the effect is exercised: at the highest level what its force leaves once z
and dz/dt (and the force of the other effect) are regressed out exceeds three times the noise
and 3 % of the response. Draws that miss it are drawn again, after six with 6 dB less noise.
"""

from collections.abc import Callable

from blind.draws import Rng
from blind.ranges import friction, hysteresis, others, outside, springs
from blind.ranges.scale import Hidden, Scale

EFFECTS: dict[str, Callable[[Rng, Scale], Hidden]] = {
    "gap": springs.gap,
    "offset_gap": springs.offset_gap,
    "stop": springs.stop,
    "hertz_contact": springs.hertz,
    "cubic_stiffness": springs.cubic,
    "quadratic_stiffness": springs.quadratic,
    "power_law": springs.power,
    "coulomb_friction": friction.coulomb,
    "stribeck_friction": friction.stribeck,
    "lugre_friction": friction.lugre,
    "quadratic_damping": others.quadratic_damping,
    "contact_damping": others.contact_damping,
    "jenkins": hysteresis.jenkins,
    "iwan": hysteresis.iwan,
    "bouc_wen": hysteresis.bouc_wen,
    "attached_mode": others.attached,
    "stiffness_drift": others.drift,
    "constant_force": springs.constant_force,
    "bistable": springs.bistable,
    "series": hysteresis.series,
    "series_spring": hysteresis.series_spring,
    "general_bouc_wen": hysteresis.general_bouc_wen,
    "saturating": hysteresis.saturating,
    "power_iwan": hysteresis.power_iwan,
}

OUTSIDE: dict[str, Callable[[Rng, Scale], Hidden]] = {
    "parametric": outside.parametric,
    "fractional": outside.fractional,
    "position_damping": outside.position_damping,
    "thixotropic": outside.thixotropic,
    "sine_spring": outside.sine_spring,
    "asymmetric_damper": outside.asymmetric_damper,
    "wedge_friction": outside.wedge,
}

BENCH: dict[str, Callable[[Rng, Scale], Hidden]] = {"pendulum": springs.pendulum}
"""What is drawn in brief campaigns alone."""

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

FRICTION = ("coulomb_friction", "stribeck_friction", "lugre_friction")
ALSO_CALLED: dict[str, tuple[str, ...]] = {}
"""Other kinds that are the same law as a hidden one."""
ALSO_SETS = {"bistable": ("cubic_stiffness", "quadratic_stiffness")}
"""Sets of kinds at one joint that are the same law, seen from another origin."""
