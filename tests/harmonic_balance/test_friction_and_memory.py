"""Dry friction made exact by shooting, and laws with memory, against Den Hartog and time."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from tests.harmonic_balance.oscillators import DAMPING, model

from shakerproc.models import EFFECTS
from shakerproc.simulation import closed_forms, simulate
from shakerproc.simulation.harmonic_balance import frequency_response, samples_of_branch
from shakerproc.simulation.harmonic_balance.shooting import periodic_orbit


def sliding(friction):
    return model(
        EFFECTS["spring"](stiffness=1.0), EFFECTS["coulomb_friction"](sliding_force=friction)
    )


def den_hartogs_state(ratio, friction):
    """Displacement and velocity at the peak of the force, and the largest displacement.

    Den Hartog's half cycle from the largest displacement downwards, for k = m = F_0 = 1: the
    friction, the forced motion and a free motion that takes the velocity out at both ends.
    """
    dynamic = 1.0 / (1.0 - ratio**2)
    turning = np.tan(np.pi / (2.0 * ratio)) / ratio
    largest = np.sqrt(dynamic**2 - (friction * turning) ** 2)
    phase = np.arctan2(-friction * turning / dynamic, largest / dynamic)
    angle = (-phase) % (2.0 * np.pi)  # of the force, since the largest displacement
    sign = 1.0 if angle < np.pi else -1.0  # the way up is the way down, turned round
    angle %= np.pi
    free = angle / ratio
    displacement = (
        friction
        + dynamic * np.cos(angle + phase)
        - friction * (np.cos(free) + np.tan(np.pi / (2.0 * ratio)) * np.sin(free))
    )
    velocity = -dynamic * ratio * np.sin(angle + phase) + friction * (
        np.sin(free) - np.tan(np.pi / (2.0 * ratio)) * np.cos(free)
    )
    return sign * np.array([displacement, velocity]), largest


@pytest.mark.slow
@pytest.mark.parametrize("friction", [0.2, 0.5])
@pytest.mark.parametrize("ratio", [0.6, 0.8, 1.3])
def test_shooting_finds_den_hartogs_motion(ratio, friction):
    expected, largest = den_hartogs_state(ratio, friction)
    closed = closed_forms.coulomb_amplitude(np.array(ratio), friction)
    assert_allclose(closed, largest, rtol=1e-12)
    guess = 1.02 * expected
    orbit = periodic_orbit(sliding(friction), 1.0, ratio / (2.0 * np.pi), guess)
    assert orbit is not None
    assert_allclose(orbit.state, expected, atol=1e-10 * largest)
    assert np.max(np.abs(np.linalg.eigvals(orbit.monodromy))) < 1.0


def test_shooting_says_when_it_finds_nothing():
    undamped = model(EFFECTS["spring"](stiffness=1.0))
    assert periodic_orbit(undamped, 1.0, 1.0 / (2.0 * np.pi), np.array([0.1, 0.0])) is None


@pytest.mark.slow
def test_response_with_friction_is_polished():
    response = frequency_response(
        sliding(0.3), 1.0, from_hz=0.6 / (2 * np.pi), to_hz=0.9 / (2 * np.pi), harmonics=63
    )
    (branch,) = response.branches
    assert np.isfinite(branch.multipliers).all()
    assert branch.stable.all()
    exact = closed_forms.coulomb_amplitude(2.0 * np.pi * branch.frequency, 0.3)
    found = np.max(samples_of_branch(branch, 2048)[:, 0], axis=-1)
    assert_allclose(found, exact, rtol=3e-4)  # 63 harmonics of an exact motion


@pytest.mark.parametrize("relaxation", [0.01, 0.3, 2.0, 30.0])
def test_a_maxwell_element_has_its_complex_stiffness_whatever_its_relaxation(relaxation):
    """The linear response in closed form, k + i omega c m / (m + i omega c) in the denominator.

    Relaxation times from 1/100 of a radian to five periods: memory that is gone before the next
    sample, and memory that outlasts many rounds.
    """
    omega = 10.0 * np.pi
    maxwell = EFFECTS["series"]((
        EFFECTS["spring"](stiffness=2000.0),
        EFFECTS["damper"](damping=2000.0 * relaxation / omega),
    ))
    shaken = model(
        EFFECTS["spring"](stiffness=1000.0), maxwell, EFFECTS["damper"](damping=20.0 * DAMPING)
    )
    response = frequency_response(shaken, 3.0, from_hz=4.5, to_hz=5.5, harmonics=3)
    branch = response.branches[0]
    rate = 2.0 * np.pi * branch.frequency
    time = 1j * rate * relaxation / omega
    mass = float(next(iter(shaken.masses.values())))
    dynamic = (
        1000.0 + 2000.0 * time / (1.0 + time) + 1j * rate * 20.0 * DAMPING - mass * rate**2
    )
    force = 3.0 * (mass if shaken.excitation.moves_base else 1.0)
    found = np.max(np.abs(samples_of_branch(branch, 1024)[:, 0]), axis=-1)
    assert_allclose(found, np.abs(force / dynamic), rtol=2e-5)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "parameters"),
    [
        ("jenkins", {"stiffness": 2000.0, "slip_force": 1.0}),
        ("iwan", {"stiffness": 2000.0, "slip_displacement": 1e-3}),
        ("bouc_wen", {"stiffness": 2000.0, "yield_displacement": 1e-3, "exponent": 2.0}),
    ],
)
def test_laws_with_memory_agree_with_time(kind, parameters):
    shaken = model(
        EFFECTS["spring"](stiffness=1000.0),
        EFFECTS[kind](**parameters),
        EFFECTS["damper"](damping=20.0 * DAMPING),
    )
    response = frequency_response(shaken, 3.0, from_hz=5.0, to_hz=5.5, harmonics=15)
    branch = response.branches[0]
    assert np.isnan(branch.multipliers).all()
    settled = simulate(
        shaken,
        lambda t: 3.0 * np.cos(10.0 * np.pi * t),
        320.0,
        duration=8.0,
        growth=False,
    )
    expected = np.max(np.abs(settled.displacement[0, -640:]))
    found = np.max(np.abs(samples_of_branch(branch, 1024)[0, 0]))
    assert_allclose(found, expected, rtol=3e-3)
