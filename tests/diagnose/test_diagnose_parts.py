"""The parts of the search against what is known of them."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.diagnose import kernel, single
from shakerproc.diagnose.faults import clipped, hum_lines
from shakerproc.diagnose.fit import drawn_in
from shakerproc.diagnose.prepare import shifted, upsample, white_level
from shakerproc.diagnose.problem import Observed, Segment, beyond_filter
from shakerproc.diagnose.search import blocks
from shakerproc.diagnose.structure import (
    Joint,
    Sensing,
    Structure,
    correction,
    hold,
    matrices,
)


def structure():
    return Structure(np.array([0.1]), (Joint(-1, 0, 4e4, 3.0),), (Sensing(0, 2, True),))


def test_hold_moves_a_linear_system_exactly():
    """Constant input: the state after a step is that of the closed form at rest, x = u / w²."""
    system = matrices(structure())
    phi, start, end = hold(system.state, system.input[:, None], 1e-3)
    rest = np.linalg.solve(np.eye(2) - phi, start + end)
    assert_allclose(rest[:, 0], [-0.1 / 4e4, 0.0], atol=1e-12)


def test_upsampled_sine_is_sharpened_for_the_hold():
    rate, f, factor = 1000.0, 100.0, 4
    t = np.arange(4000) / rate
    fine = upsample(np.sin(2.0 * np.pi * f * t), factor)
    inner = slice(4000, 12000)
    expected = 1.0 / np.sinc(f / (rate * factor)) ** 2
    assert np.max(np.abs(fine[inner])) == pytest.approx(expected, rel=1e-3)


def test_shift_moves_a_sine():
    t = np.arange(4096) / 1024.0
    moved = shifted(np.sin(2 * np.pi * 8 * t), 0.01, slope=False, sample_rate=1024.0)
    assert_allclose(moved[300:-300], np.sin(2 * np.pi * 8 * (t + 0.01))[300:-300], atol=2e-3)


def test_white_level_sees_the_noise_beneath_a_signal():
    rng = np.random.default_rng(5)
    t = np.arange(60000) / 5688.9
    samples = 30.0 * np.sin(2 * np.pi * 200.0 * t) + 0.2 * rng.standard_normal(t.size)
    assert white_level(samples, 5688.9) == pytest.approx(0.2, rel=0.05)


def test_clipping_is_repeated_extremes():
    rng = np.random.default_rng(6)
    samples = rng.standard_normal(20000)
    assert clipped(samples) is None
    found = clipped(np.clip(samples, -1.5, 1.5))
    assert found is not None
    assert found[1] == pytest.approx(1.5)


def test_hum_is_a_line_at_the_mains_frequency():
    rng = np.random.default_rng(7)
    t = np.arange(40000) / 2048.0
    noise = rng.standard_normal(t.size)
    assert hum_lines(noise, 2048.0) is None
    found = hum_lines(noise + 0.2 * np.sin(2 * np.pi * 60.0 * t), 2048.0)
    assert found is not None
    assert found[0] == 60.0


def test_the_filter_takes_only_what_is_above_the_band():
    fine, rate = 8, 1000.0
    t = np.arange(8000 * fine) / (rate * fine)
    low, high = np.sin(2 * np.pi * 100.0 * t), np.sin(2 * np.pi * 1900.0 * t)
    dense = np.stack([low, low + high])
    seen = Observed(np.empty(0), np.empty(0), dense, dense[:, ::fine], 0.0)
    lost = beyond_filter(seen, fine)
    assert_allclose(lost[0, 200:-200], 0.0, atol=2e-3)
    assert_allclose(lost[1, 200:-200], high[::fine][200:-200], atol=5e-3)


def test_the_correction_is_the_steady_kalman_filter():
    """The covariance of the doubling satisfies the Riccati equation: iterate it once more."""
    system = matrices(structure())
    gain, sigma = correction(system, 2000.0, 0.3, np.array([0.2]), 0.0)
    phi, start, end = hold(system.state, (system.input * 0.3)[:, None], 1.0 / 2000.0)
    push = start + end
    p = np.zeros((2, 2))
    h, r = system.out, 0.04
    for _ in range(20000):
        k = p @ h.T / (h @ p @ h.T + r)
        p = phi @ (p - k @ h @ p) @ phi.T + push @ push.T
    spread = (h @ p @ h.T)[0, 0] + r
    assert_allclose(gain[:, 0], (p @ h.T)[:, 0] / spread, rtol=1e-4)
    assert_allclose(sigma[0], np.sqrt(spread), rtol=1e-6)


@pytest.mark.parametrize("op", [kernel.GAP, kernel.JENKINS, kernel.CUBIC])
def test_the_fast_observer_does_what_the_general_one_does(op):
    from shakerproc.diagnose.problem import _one

    rng = np.random.default_rng(3)
    own, n, fine = structure(), 3000, 4
    system = matrices(own)
    step = 1.0 / (2000.0 * fine)
    phi, g0, g1 = hold(system.state, system.input[:, None], step)
    u = rng.standard_normal(n * fine)
    measured = rng.standard_normal((1, n))
    known = {kernel.GAP: (5e4, 1e-5), kernel.JENKINS: (2e4, 0.1), kernel.CUBIC: (1e13,)}
    numbers = known[op]
    table = (
        np.array([op]), np.array([[*numbers, *[0.0] * (8 - len(numbers))]]),
        np.array([1]), np.array([0]),
    )  # fmt: skip
    results = []
    for simple in (True, False):
        innovations, states = np.empty((1, n)), np.empty((2, n))
        dense, expected = np.empty((1, n * fine)), np.empty((1, n))
        spread, direct = np.zeros(2), system.out_force / np.diag(system.force[1:])
        if simple:
            from types import SimpleNamespace as Bag

            segment = Bag(input=u, fine=fine, weight=np.ones((1, n)), start=0, sample_rate=2e3,
                          skip=10)  # fmt: skip
            tuned = Bag(noise=np.array([0.1]), input_noise=0.2, model_noise=0.3)
            logs = _one(system, (phi, g0, g1), direct, own, segment, measured, tuned,
                        Bag(gain=np.ones(1)), spread, table, step, True, 0.0, innovations,
                        states, dense, expected)  # fmt: skip
        else:
            logs = kernel.observe(
                phi, g0[:, 0].copy(), g1[:, 0].copy(), system.state[1:].copy(),
                system.input[1:].copy(), system.out, system.out_force, system.out_input, direct,
                1.0 / own.masses, u, fine, measured, np.ones((1, n)), np.array([0.1]), 0.2, 0.3,
                spread, *table, step, 0.0, 10, True, innovations, states, dense,
                expected,
            )  # fmt: skip
        results.append((logs, innovations, states, dense))
    for one, two in zip(*results, strict=True):
        assert_allclose(one, two, rtol=1e-6, atol=1e-9)


def brute_force(op, numbers, own, u, step, parts):
    """March in tiny steps: the displacement at every sample, friction as what stops a mass."""
    m, k, c = own.masses[0], own.stiffness[0], own.damping[0]
    h, z, v = step / parts, 0.0, 0.0
    out = np.empty(u.size)
    for i in range(u.size):
        out[i] = z
        to = u[min(i + 1, u.size - 1)]
        for j in range(parts):
            base = u[i] + (to - u[i]) * (j + 0.5) / parts
            pull = -k * z - c * v - m * base
            if op == kernel.CONTACT_DAMPING:
                v += h * (pull - (numbers[0] * v if abs(z) > numbers[1] else 0.0)) / m
            else:
                free = v + h * pull / m
                v = np.sign(free) * max(abs(free) - h * numbers[0] / m, 0.0)
            z += h * v
    return out


@pytest.mark.parametrize(
    ("op", "numbers"), [(kernel.COULOMB, (0.8,)), (kernel.CONTACT_DAMPING, (60.0, 4e-6))]
)
def test_the_jumps_of_forces_are_located_within_the_step(op, numbers):
    """Driven without corrections, against steps a hundred times finer."""
    own, n, rate, fine = structure(), 600, 2000.0, 4
    system = matrices(own)
    step = 1.0 / (rate * fine)
    u = (
        20.0
        * np.sin(2 * np.pi * 90.0 * np.arange(n * fine) * step)
        * np.linspace(0.0, 1.0, n * fine)
    )
    phi, g0, g1 = hold(system.state, system.input[:, None], step)
    states, innovations = np.empty((2, n)), np.empty(n)
    single.observe_one(
        phi.ravel().copy(), g0[:, 0].copy(), g1[:, 0].copy(), system.state[1].copy(),
        system.out[0].copy(), float(system.out_force[0, 0]), float(system.out_input[0]), -1.0,
        float(1.0 / own.masses[0]), float(system.input[1]), u, fine, np.zeros(n), np.zeros(n),
        0.1, 0.2, 0.3, np.zeros(2), np.array([op]),
        np.array([[*numbers, *[0.0] * (8 - len(numbers))]]), step, 0.0, 10, True, 0.0,
        innovations, states, np.empty(n * fine), np.empty(n),
    )  # fmt: skip
    reference = brute_force(op, numbers, own, u, step, 100)[::fine]
    linear = brute_force(kernel.CONTACT_DAMPING, (0.0, 0.0), own, u, step, 100)[::fine]
    error = np.max(np.abs(states[0] - reference)) / np.max(np.abs(reference))
    assert np.max(np.abs(linear - reference)) > 0.1 * np.max(np.abs(reference))
    assert error < 5e-3


def test_blocks_kept_aside_share_no_judged_sample_with_those_fitted():
    rate, n = 1000.0, 20500
    zeros = np.zeros((1, n))
    whole = Segment(0, "a", rate, 1, 0, 300, zeros[0], zeros, zeros, zeros + 1.0, 0, False)
    judged = {kept: np.zeros(n, dtype=int) for kept in (True, False)}
    for kept, count in judged.items():
        for piece in blocks(whole, kept=kept):
            count[piece.start + piece.skip : piece.start + piece.measured.shape[1]] += 1
    assert not np.any((judged[True] > 0) & (judged[False] > 0))
    assert max(np.max(count) for count in judged.values()) == 1
    assert not np.any(judged[False][:300])
    assert np.mean(judged[True]) == pytest.approx(1.0 / 3.0, abs=0.03)
    assert np.mean(judged[False]) > 0.58


def test_samples_that_miss_by_far_weigh_linearly():
    e = np.array([-40.0, -5.0, 1.0, 5.0, 20.0])
    loss = drawn_in(e) ** 2
    assert_allclose(loss[1:4], e[1:4] ** 2)
    assert_allclose(loss[[0, 4]], 2.0 * 5.0 * np.abs(e[[0, 4]]) - 25.0)
    assert np.all(np.sign(drawn_in(e)) == np.sign(e))
