"""What identification relies on, of every effect, in every joint of a chain of three masses.

The oracle is the equation of motion itself: the force that the simulated accelerations leave
for the effect, against the law that the effect states (`force_along`, which shares no code
with the steppers), and velocities and displacements against the integrals of accelerations.
"""

from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import cumulative_simpson

from shakerproc.models import BASE, Element, Excitation, Model
from shakerproc.models.effects import EFFECTS, EXAMPLES, Damper, QuadraticStiffness, Spring
from shakerproc.models.identification import JointScales
from shakerproc.simulation import simulate

MASSES = {"coupon": 0.03, "rim": 0.02, "tip": 0.015}
PLACES = (BASE, *MASSES)
JOINTS = tuple(pairwise(PLACES))
STIFFNESS, DAMPING = 1.2e5, 1.5
RATE, SECONDS = 65536.0, 0.05
TONES = ((91.0, 30.0), (173.0, 45.0), (331.0, 60.0))  # Hz, m/s^2
GENTLE = {**EXAMPLES, "quadratic_stiffness": QuadraticStiffness(1e8)}  # holds its mass
STICKY = {"coulomb_friction", "stribeck_friction"}

every_kind = pytest.mark.parametrize("kind", EFFECTS)
every_joint = pytest.mark.parametrize("joint", JOINTS, ids="-".join)


def base_acceleration(time):
    return sum(level * np.sin(2.0 * np.pi * f * time) for f, level in TONES)


def base_displacement(time):
    """The same, integrated twice from rest."""
    total = 0.0
    for f, level in TONES:
        omega = 2.0 * np.pi * f
        total = total + level / omega * (time - np.sin(omega * time) / omega)
    return total


def base_velocity(time):
    return sum(
        level / (2.0 * np.pi * f) * (1.0 - np.cos(2.0 * np.pi * f * time)) for f, level in TONES
    )


def chain(effect, joint, *, flipped):
    """A chain of springs and dampers with one effect more in one joint."""
    elements = [
        Element(linear, pair)
        for pair in JOINTS
        for linear in (Spring(STIFFNESS), Damper(DAMPING))
    ]
    elements.append(Element(effect, joint[::-1] if flipped else joint))
    return Model("chain", MASSES, tuple(elements), Excitation("base acceleration"))


def moved(effect, joint, *, flipped, sign=1.0):
    return simulate(
        chain(effect, joint, flipped=flipped),
        lambda time: sign * base_acceleration(time),
        RATE,
        duration=SECONDS,
        tolerance=1e-12,
        growth=False,
    )


def rows_of(simulation, names):
    """Motion relative to the base of places, the base at rest, by name."""
    still = np.zeros(simulation.excitation.size)
    return {
        name: tuple(
            still if name == BASE else rows[simulation.masses.index(name)]
            for rows in (simulation.displacement, simulation.velocity, simulation.acceleration)
        )
        for name in names
    }


def left_for_the_effect(simulation):
    """Force that must come from the effect, on each mass, by Newton's law, by name."""
    motion = rows_of(simulation, PLACES)
    left = {name: mass * motion[name][2] for name, mass in MASSES.items()}
    for first, second in JOINTS:
        z, v = (motion[second][i] - motion[first][i] for i in range(2))
        force = STIFFNESS * z + DAMPING * v
        left[second] = left[second] + force
        if first != BASE:
            left[first] = left[first] - force
    return left


def stated(effect, simulation, between):
    """Force of the effect along the simulated motion, as it states it itself, and velocity."""
    motion = rows_of(simulation, PLACES)
    first, second = between
    z, v = (motion[second][i] - motion[first][i] for i in range(2))
    if effect.absolute:
        z = motion[second][0] + base_displacement(simulation.time)
        v = motion[second][1] + base_velocity(simulation.time)
    return effect.force_along(z, v, RATE), v


@every_kind
@every_joint
def test_simulation_obeys_the_law_that_the_effect_states(kind, joint):
    effect = GENTLE[kind]
    for flipped in (False, True):
        between = joint[::-1] if flipped else joint
        if effect.absolute and between[1] == BASE:
            continue  # there is nothing that it could sit on
        simulation = moved(effect, joint, flipped=flipped)
        left = left_for_the_effect(simulation)
        force, velocity = stated(effect, simulation, between)
        wanted = {name: np.zeros(force.size) for name in MASSES}
        if between[1] != BASE:
            wanted[between[1]] = -force
        if between[0] != BASE and not effect.absolute:
            wanted[between[0]] = force
        kept = np.ones(force.size, bool)
        if kind in STICKY:  # at rest the law gives a limit, not a force
            kept = np.abs(velocity) > 1e-6 * np.max(np.abs(velocity))
            limit = max(effect.rows()[0].values[:2])
            for name in between:
                if name != BASE:
                    assert np.max(np.abs(left[name])) <= limit * (1.0 + 1e-9)
        scale = np.max(np.abs(force))
        assert scale > 0.0
        for name in MASSES:
            jumps = np.abs(np.diff(wanted[name], prepend=0.0)) > 0.2 * scale
            fine = kept & ~jumps
            assert_allclose(left[name][fine], wanted[name][fine], atol=0.01 * scale)


@every_kind
@every_joint
def test_velocity_and_displacement_are_the_integrals_of_acceleration(kind, joint):
    simulation = moved(GENTLE[kind], joint, flipped=False)
    relative = simulation.acceleration - simulation.excitation
    for integrated, motion in (
        (relative, simulation.velocity),
        (simulation.velocity, simulation.displacement),
    ):
        found = cumulative_simpson(integrated, dx=1.0 / RATE, axis=1, initial=0.0)
        assert_allclose(found, motion, atol=0.06 * np.max(np.abs(motion)))


@every_kind
@every_joint
def test_an_exchange_of_places_mirrors_the_motion(kind, joint):
    effect = GENTLE[kind]
    if effect.absolute:
        pytest.skip("it sits on one place")
    one, other = (
        moved(effect, joint, flipped=False),
        moved(effect, joint, flipped=True, sign=-1.0),
    )
    size = np.max(np.abs(one.displacement))
    assert_allclose(other.displacement, -one.displacement, atol=1e-6 * size)


SCALES = {
    "moves": JointScales(1e-4, 0.05, 10.0, 1.2e5, 0.0286, 20.0, 5000.0),
    "no spring": JointScales(1e-4, 0.05, 10.0, 0.0, 0.0286, 20.0, 5000.0),
    "locked": JointScales(1e-9, 1e-6, 10.0, 1.2e5, 0.0286, 20.0, 5000.0),
}


@every_kind
@pytest.mark.parametrize("at", SCALES.values(), ids=SCALES)
def test_every_start_builds_an_effect_within_bounds(kind, at):
    sought = EFFECTS[kind].identification(at)
    if sought is None:
        return
    assert 0 < len(sought.starts) <= 24 * 2  # two variants, the sides of a stop, at most
    assert set(sought.scaled) <= set(sought.free)
    for start in sought.starts:
        assert_builds(kind, sought, start)
        for name, free in sought.free.items():
            assert free.low <= start[name] <= free.high
            assert_allclose(free.from_fitted(free.to_fitted(start[name])), start[name])
    for end in ("low", "high"):
        corner = {name: getattr(free, end) for name, free in sought.free.items()}
        assert_builds(kind, sought, {**sought.starts[0], **corner})


def assert_builds(kind, sought, values):
    assert isinstance(EFFECTS[kind].of_numbers(sought.numbers(values)), EFFECTS[kind])


@every_kind
def test_the_force_is_proportional_to_what_is_scaled(kind):
    sought = EFFECTS[kind].identification(SCALES["moves"])
    if sought is None or not sought.scaled or kind == "stiffness_drift":
        pytest.skip("nothing is scaled")
    time = np.arange(4000) / 4e4
    z, v = 8e-5 * np.sin(300.0 * time), 8e-5 * 300.0 * np.cos(300.0 * time)

    def force(values):
        return EFFECTS[kind].of_numbers(sought.numbers(values)).force_along(z, v, 4e4)

    for start in sought.starts[:: max(1, len(sought.starts) // 4)]:
        half = {**start, **{name: 0.5 * start[name] for name in sought.scaled}}
        size = np.max(np.abs(force(start)))
        assert_allclose(force(half), 0.5 * force(start), atol=1e-9 * size)


CONTAINED = [
    (kind, contained)
    for kind in EFFECTS
    if (sought := EFFECTS[kind].identification(SCALES["moves"])) is not None
    for contained in sought.contains
]


@pytest.mark.parametrize(
    ("kind", "contained"), CONTAINED, ids=[f"{kind}-{c.kind}" for kind, c in CONTAINED]
)
def test_a_contained_effect_is_nearly_the_law_of_one_of_its_extensions(kind, contained):
    """Its force along a sine; a stiff spring before a slider turns the corners in 4 % of it."""
    at = SCALES["moves"]
    sought, simpler = (
        EFFECTS[kind].identification(at),
        EFFECTS[contained.kind].identification(at),
    )
    rate, omega = 2e5, at.velocity / at.displacement
    time = np.arange(round(4.0 * np.pi / omega * rate)) / rate
    z = 0.9 * at.displacement * np.sin(omega * time)
    v = 0.9 * at.velocity * np.cos(omega * time)
    for start in simpler.starts:
        truth = (
            EFFECTS[contained.kind].of_numbers(simpler.numbers(start)).force_along(z, v, rate)
        )
        extended = contained.extend(start)
        left = [
            np.sqrt(np.mean((made(kind, sought, values).force_along(z, v, rate) - truth) ** 2))
            for values in extended
        ]
        if contained.limit and extended:
            assert min(left) < 0.35 * np.sqrt(np.mean(truth**2)) + 1e-12


def made(kind, sought, values):
    return EFFECTS[kind].of_numbers(sought.numbers(sought.within_bounds(values)))
