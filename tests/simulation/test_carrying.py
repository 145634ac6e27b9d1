"""Nonlinear forces carried by exact propagators: every effect, order, limits, interruption."""

import signal
import threading
import time

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from shakerproc.models import EFFECTS, Element, Excitation, Model, Sensor
from shakerproc.models.effects import (
    EXAMPLES,
    BoucWen,
    CoulombFriction,
    CubicStiffness,
    Damper,
    Gap,
    LuGreFriction,
    Spring,
)
from shakerproc.simulation import Runs, free_runs, prepare, simulate

RATE, COUNT = 8000.0, 2400
STIFFNESS, DAMPING, MASS = 1.2e5, 4.0, 0.0286
SENSORS = {
    "z": Sensor("coupon", "relative displacement"),
    "v": Sensor("coupon", "relative velocity"),
}


def shaken(*effects, between=("base", "coupon")):
    held = (Spring(STIFFNESS), Damper(damping=DAMPING), *effects)
    joined = tuple(Element(effect, between) for effect in held)
    return Model("m", {"coupon": MASS}, joined, Excitation("base acceleration"), SENSORS)


def noise(rate=RATE, count=COUNT, size=60.0, seed=3):
    frequency = np.fft.rfftfreq(count, 1.0 / rate)
    spectrum = np.fft.rfft(np.random.default_rng(seed).standard_normal(count))
    spectrum[(frequency < 60.0) | (frequency > 600.0)] = 0.0
    samples = np.fft.irfft(spectrum, count) * np.hanning(count) ** 0.3
    return samples * size / np.std(samples)


def whole(given):
    return Runs((given,), np.array([[0, 0, given.n_samples]]))


@pytest.mark.parametrize("between", [("base", "coupon"), ("coupon", "base")])
@pytest.mark.parametrize("kind", EFFECTS)
def test_every_effect_moves_as_the_fine_solver_says(kind, between):
    size = 15.0 if kind == "quadratic_stiffness" else 60.0  # more than that drives it away
    if kind == "attached_mode":
        between = ("base", "coupon")  # it stands on its mass, whichever way
    model, given = shaken(EXAMPLES[kind], between=between), prepare(noise(size=size), RATE)
    fine = simulate(model, given, tolerance=1e-13)
    found = free_runs(model, whole(given), means=False)
    assert not found.failed.any()
    for row, name in zip(found.outputs[0], SENSORS, strict=True):
        size = np.max(np.abs(fine.outputs[name]))
        limit = 5e-5 * max(1.0, fine.growth) * size
        assert_allclose(row, fine.outputs[name], rtol=0.0, atol=limit, err_msg=name)


def test_against_a_solver_that_shares_no_code():
    """Cubic spring and Bouc-Wen, a sine of which the pieces are exact to rounding."""
    size, drive = 80.0, 2.0 * np.pi * 250.0
    cubic, bouc_wen = 2e13, BoucWen(6e4, 4e-5, 2.0)
    model = shaken(CubicStiffness(cubic), bouc_wen)
    given = prepare(lambda t: size * np.sin(drive * t), RATE, duration=0.05)

    def rates(t, y):
        z, v, h = y
        hold = STIFFNESS * z + DAMPING * v + cubic * z**3 + 6e4 * h
        slip = v - 0.5 * (abs(v) * abs(h) * h + v * h * h) / 4e-5**2
        return v, -hold / MASS - size * np.sin(drive * t), slip

    times = np.arange(given.n_samples) / RATE
    solved = solve_ivp(
        rates, (0.0, times[-1]), (0.0, 0.0, 0.0), "DOP853", times, rtol=1e-11, atol=1e-16,
        max_step=1e-5,
    )  # fmt: skip
    found = free_runs(model, whole(given), tolerance=1e-7, means=False).outputs[0]
    assert np.max(np.abs(found[0] - solved.y[0])) < 2e-6 * np.max(np.abs(solved.y[0]))


def test_the_error_falls_with_the_sixth_power_of_the_sample():
    """A cubic spring, and a tolerance that never leaves a sample to the series."""
    model, errors = shaken(CubicStiffness(1e12)), []
    for rate in (4000.0, 8000.0):
        given = prepare(lambda t: 60.0 * np.sin(2.0 * np.pi * 150.0 * t), rate, duration=0.1)
        fine = simulate(model, given, growth=False).outputs["z"]
        found = free_runs(model, whole(given), tolerance=1e-2, means=False).outputs[0][0]
        errors.append(np.max(np.abs(found - fine)) / np.max(np.abs(fine)))
    assert errors[1] < errors[0] / 30.0
    assert errors[1] < 1e-6


@pytest.mark.parametrize(
    "law", [(), (Gap(9e4, 1.0),), (CubicStiffness(1e-3),), (CoulombFriction(1e-12),)]
)
def test_linear_limits_are_exact(law):
    given = prepare(noise(), RATE)
    linear = simulate(shaken(), given, growth=False).outputs["z"]
    found = free_runs(shaken(*law), whole(given), means=False).outputs[0][0]
    assert_allclose(found, linear, rtol=0.0, atol=1e-8 * np.max(np.abs(linear)))


def test_a_bristle_far_stiffer_than_a_sample_can_follow_slides_like_coulomb():
    given = prepare(noise(), RATE)
    dry = simulate(shaken(CoulombFriction(1.5)), given, growth=False).outputs["z"]
    bristle = LuGreFriction(1.5, 1.5, 1e-2, 3e6, 100.0, 0.0)
    found = free_runs(shaken(bristle), whole(given), means=False).outputs[0][0]
    assert np.max(np.abs(found - dry)) < 0.1 * np.max(np.abs(dry))


def test_windows_are_those_of_the_whole_run_whatever_their_order_and_test():
    model = shaken(EXAMPLES["lugre_friction"])
    tests = prepare(noise(), RATE), prepare(noise(seed=4), RATE)
    windows = np.array([
        [1, 700, 400],
        [0, 0, COUNT],
        [1, 0, COUNT],
        [0, 650, 1],
        [0, 700, 400],
    ])
    starts = np.zeros((len(windows), 3))
    starts[[0, 4], 0] = 2e-5
    together = free_runs(model, Runs(tests, windows, starts))
    for i, window in enumerate(windows):
        alone = free_runs(model, Runs(tests, windows[[i]], starts[[i]]))
        assert together.outputs[i].shape == (2, window[2])
        assert_allclose(together.outputs[i], alone.outputs[0], rtol=0.0, atol=1e-15)


def test_an_interrupt_is_heard_at_once():
    model, given = shaken(EXAMPLES["bouc_wen"]), prepare(noise(), RATE)
    windows = np.repeat([[0, 0, COUNT]], 4000, axis=0)
    free_runs(model, Runs((given,), windows[:1]))
    main = threading.main_thread().ident
    timer = threading.Timer(0.3, lambda: signal.pthread_kill(main, signal.SIGINT))
    # a job in the background is started with interrupts ignored
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    begin = time.monotonic()
    try:
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            free_runs(model, Runs((given,), windows))
    finally:
        signal.signal(signal.SIGINT, before)
    assert time.monotonic() - begin < 5.0
