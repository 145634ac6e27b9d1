"""The parts of the search against what is known of them."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.diagnose import kernel
from shakerproc.diagnose.faults import clipped, hum_lines
from shakerproc.diagnose.prepare import shifted, upsample, white_level
from shakerproc.diagnose.problem import Observed, beyond_filter
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


@pytest.mark.parametrize("op", [kernel.GAP, kernel.COULOMB, kernel.JENKINS, kernel.CUBIC])
def test_the_fast_observer_does_what_the_general_one_does(op):
    from shakerproc.diagnose.problem import _one

    rng = np.random.default_rng(3)
    own, n, fine = structure(), 3000, 4
    system = matrices(own)
    step = 1.0 / (2000.0 * fine)
    phi, g0, g1 = hold(system.state, system.input[:, None], step)
    u = rng.standard_normal(n * fine)
    measured = rng.standard_normal((1, n))
    numbers = {kernel.GAP: (5e4, 1e-5), kernel.COULOMB: (0.05,), kernel.JENKINS: (2e4, 0.1),
               kernel.CUBIC: (1e13,)}[op]  # fmt: skip
    table = (
        np.array([op]), np.array([[*numbers, *[0.0] * (8 - len(numbers))]]),
        np.array([1]), np.array([0]),
    )  # fmt: skip
    results = []
    for simple in (True, False):
        innovations, states = np.empty((1, n)), np.empty((2, n))
        dense = np.empty((1, n * fine))
        spread, direct = np.zeros(2), system.out_force / np.diag(system.force[1:])
        if simple:
            from types import SimpleNamespace as Bag

            segment = Bag(input=u, fine=fine, weight=np.ones((1, n)), start=0, sample_rate=2e3,
                          skip=10)  # fmt: skip
            tuned = Bag(noise=np.array([0.1]), input_noise=0.2, model_noise=0.3)
            logs = _one(system, (phi, g0, g1), direct, own, segment, measured, tuned,
                        Bag(gain=np.ones(1)), spread, table, step, True, innovations, states,
                        dense)  # fmt: skip
        else:
            logs = kernel.observe(
                phi, g0[:, 0].copy(), g1[:, 0].copy(), system.state[1:].copy(),
                system.input[1:].copy(), system.out, system.out_force, system.out_input, direct,
                1.0 / own.masses, u, fine, measured, np.ones((1, n)), np.array([0.1]), 0.2, 0.3,
                spread, *table, step, 0.0, 10, True, innovations, states, dense,
            )  # fmt: skip
        results.append((logs, innovations, states, dense))
    for one, two in zip(*results, strict=True):
        assert_allclose(one, two, rtol=1e-6, atol=1e-9)
