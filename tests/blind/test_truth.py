"""The truth that blind trials are drawn from, against closed forms and against finer steps."""

import numpy as np
import pytest
from blind.excitations import SAMPLE_RATE, Drive, waveform
from blind.ranges import Scale
from blind.truth import Truth, move
from numpy.testing import assert_allclose
from scipy import signal

from blind import assembly, laws, ranges, recorder, structures

OMEGA, ZETA, MASS = 2.0 * np.pi * 120.0, 0.015, 0.4
JOINT = (-1, 0, MASS * OMEGA**2, 2.0 * ZETA * MASS * OMEGA)
DRIVE = Drive("random", 9.0, 10.0, 1000.0, True, 0.05, 0.05, (7,))
EVERY_LAW = {**ranges.EFFECTS, **ranges.OUTSIDE}


def run(elements, substeps, joints=(JOINT,), drive=DRIVE, n_samples=6000):
    wave = waveform(drive, 2 * substeps, n_samples)
    truth = Truth((MASS,) if len(joints) == 1 else (MASS, 0.5 * MASS), joints, elements)
    return move(
        truth, wave, np.zeros_like(wave), sample_rate=SAMPLE_RATE, substeps=substeps, limit=1.0
    )


def pulse(elements, joint, seconds, acceleration=50.0, substeps=8):
    """A base pulse of half a millisecond, then silence."""
    n = int(seconds * SAMPLE_RATE) * 2 * substeps + 1
    base = np.zeros(n)
    base[: int(5e-4 * SAMPLE_RATE * 2 * substeps)] = -acceleration
    truth = Truth((MASS,), (joint,), elements)
    return move(truth, base, np.zeros(n), sample_rate=SAMPLE_RATE, substeps=substeps, limit=1.0)


def _parabola_top(y):
    """The largest value of a curve through three samples, from the largest of these four."""
    i = min(max(int(np.argmax(y)), 1), 2)
    a, b, c = y[i - 1 : i + 2]
    return b + (a - c) ** 2 / (8.0 * (2.0 * b - a - c))


def test_linear_motion_is_that_of_the_transfer_function():
    wave = waveform(DRIVE, 16, 6000)
    fine = np.arange(wave.size) / (16.0 * SAMPLE_RATE)
    system = signal.lti([-1.0], [1.0, 2.0 * ZETA * OMEGA, OMEGA**2])
    _, expected, _ = signal.lsim(system, wave, fine)
    z = run((), 8).displacement[:, 0]
    assert_allclose(z, expected[:-1:16], atol=2e-5 * np.max(np.abs(z)))


def test_friction_takes_the_same_off_every_swing():
    """Free vibration under dry friction: each half cycle is 2 F / k shorter, then it sticks."""
    k, force = MASS * OMEGA**2, 2.0
    motion = pulse(((laws.COULOMB, -1, 0, (force,), ()),), (-1, 0, k, 0.0), 0.1, 400.0)
    z, w = motion.displacement[:, 0], motion.velocity[:, 0]
    turns = np.flatnonzero(w[:-1] * w[1:] < 0.0)
    peaks = np.array([_parabola_top(np.abs(z[i - 1 : i + 3])) for i in turns])
    assert_allclose(-np.diff(peaks[:8]), 2.0 * force / k, rtol=0.02)
    assert abs(z[-1]) <= force / k
    assert np.ptp(z[-50:]) < 1e-15
    assert np.max(np.abs(w[-50:])) < 1e-15


def test_friction_above_the_inertia_force_never_slips():
    motion = run(((laws.COULOMB, -1, 0, (MASS * 100.0,), ()),), 4)
    assert np.max(np.abs(motion.displacement)) < 1e-15


def test_gap_lengthens_the_period_as_its_backbone_says():
    """omega / omega_n = 1 / (1 + 2 a / (pi (A - a))), free play without a spring."""
    k, a = MASS * OMEGA**2, 2e-5
    motion = pulse(((laws.GAP, -1, 0, (k, a, a), (-a, a)),), (-1, 0, 0.0, 0.0), 0.5, 120.0)
    z = motion.displacement[:, 0]
    amplitude = np.max(np.abs(motion.stretch))
    up = np.flatnonzero((z[:-1] < 0.0) & (z[1:] >= 0.0))
    crossing = up - z[up] / (z[up + 1] - z[up])
    frequency = SAMPLE_RATE * (len(up) - 1) / (crossing[-1] - crossing[0])
    expected = 120.0 / (1.0 + 2.0 * a / (np.pi * (amplitude - a)))
    assert_allclose(frequency, expected, rtol=2e-4)


def test_iwan_is_many_sliders():
    k, limit, n = 2e5, 3e-5, 4000
    motion = run(((laws.IWAN, -1, 0, (k, limit, 2.0), ()),), 4, n_samples=3000)
    z = motion.stretch[:, 0]
    slips = limit * (np.arange(n) + 0.5) / n
    slider, expected = np.zeros(n), []
    for x in z:
        slider = np.clip(slider, x - slips, x + slips)
        expected.append(np.mean(x - slider) * k)
    assert_allclose(motion.force[:, 0], expected, atol=0.01 * np.max(np.abs(expected)))


def test_momentum_is_kept_in_a_chain_with_friction():
    """What the base spring does not give the two masses, they only give each other."""
    joints = (JOINT, (0, 1, 1e5, 0.0))
    friction = (laws.STRIBECK, 0, 1, (0.5, 0.8, 1e-3), ())
    motion = run((friction,), 8, joints)
    inner = MASS * motion.acceleration[::8, 0] + 0.5 * MASS * motion.acceleration[::8, 1]
    outer = -JOINT[2] * motion.displacement[:, 0] - JOINT[3] * motion.velocity[:, 0]
    assert_allclose(inner, outer, atol=1e-8 * np.max(np.abs(outer)))


@pytest.mark.parametrize("kind", EVERY_LAW)
def test_halving_the_step_changes_nothing_that_matters(kind):
    """A third of a second is short against the growth of a disturbance; noise is 1e-3."""
    # in small wells it runs away, or goes from one to the other as chance will have it
    size = {"quadratic_stiffness": 6e-5, "bistable": 3e-4}.get(kind, 3e-5)
    scale = Scale(MASS, JOINT[2], OMEGA, size, OMEGA * size, JOINT[2] * 1e-5)
    hidden = EVERY_LAW[kind](np.random.default_rng(5), scale)
    structure = structures.Structure((MASS,), (structures.Joint(*JOINT),))
    truth, _ = assembly.assemble(structure, 0, [hidden])

    def response(substeps):
        wave = waveform(DRIVE, 2 * substeps, 2048)
        motion = move(
            truth,
            wave,
            np.zeros_like(wave),
            sample_rate=SAMPLE_RATE,
            substeps=substeps,
            limit=1.0,
        )
        return motion.velocity[:, 0]

    coarse, fine = response(recorder.SUBSTEPS), response(2 * recorder.SUBSTEPS)
    assert np.sqrt(np.mean((coarse - fine) ** 2) / np.mean(fine**2)) < 2e-4


def test_a_truth_at_rest_stays_where_it_rests():
    """Wells of a bistable joint, and a dead weight beside a gap."""
    scale = Scale(MASS, JOINT[2], OMEGA, 3e-5, OMEGA * 3e-5, JOINT[2] * 1e-5)
    structure = structures.Structure((MASS,), (structures.Joint(*JOINT),))
    for kind in ("bistable", "constant_force"):
        hidden = EVERY_LAW[kind](np.random.default_rng(5), scale)
        truth, _ = assembly.assemble(structure, 0, [hidden])
        still = np.zeros(1601)
        motion = move(truth, still, still, sample_rate=SAMPLE_RATE, substeps=8, limit=1.0)
        assert_allclose(motion.displacement[:, 0], hidden.start, rtol=1e-9)


def test_a_series_is_play_before_a_slider():
    """Along its own motion: the slider follows, the force is capped and lags by the play."""
    k, a, force = 2e5, 1e-5, 1.0
    motion = run(((laws.SERIES, -1, 0, (k, a + force / k, a), ()),), 8, n_samples=3000)
    slid, expected = 0.0, []
    for z in motion.stretch[:, 0]:
        slid = np.clip(slid, z - a - force / k, z + a + force / k)
        u = z - slid
        expected.append(k * np.sign(u) * max(abs(u) - a, 0.0))
    assert np.max(np.abs(expected)) == pytest.approx(force)
    assert_allclose(motion.force[:, 0], expected, atol=0.03 * force)


def test_bristles_at_high_velocity_stay_stable():
    """A decay of bristles that is fast against the step ends in sliding friction."""
    numbers = (0.5, 0.6, 1e-3, 2e7, 200.0, 0.0)
    motion = run(((laws.LUGRE, -1, 0, numbers, ()),), 8)
    sliding = np.abs(motion.rate[:, 0]) > 0.01
    assert np.median(np.abs(motion.force[sliding, 0])) == pytest.approx(0.5, rel=0.02)
    assert np.max(np.abs(motion.force[sliding, 0])) < 1.5


@pytest.mark.parametrize(
    ("code", "numbers"),
    [
        (laws.BOUC_WEN, (2e7, 1e-7, 1.5)),
        (laws.GENERAL_BOUC_WEN, (2e7, 1e7 / 2.0**1.5, 1e7 / 2.0**1.5, 1.5)),
    ],
)
def test_a_loop_that_has_yielded_holds_its_force_however_fast_it_moves(code, numbers):
    """Stiffness times yield displacement, 2 N, slows the mass evenly: v = v0 - F t / m."""
    motion = pulse(((code, -1, 0, numbers, ()),), (-1, 0, 0.0, 0.0), 0.02, 400.0)
    t = np.arange(motion.velocity.shape[0]) / SAMPLE_RATE
    after = t > 1e-3
    slope, _ = np.polyfit(t[after], motion.velocity[after, 0], 1)
    assert slope == pytest.approx(-2.0 / MASS, rel=1e-6)
