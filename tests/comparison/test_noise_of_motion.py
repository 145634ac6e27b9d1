"""Noise where a recording never rests: written noise, on motions that scipy integrates."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import StateSpace, lsim

from shakerproc import comparison

SIGMA = 0.02


def told(found, rate):
    return float(np.sqrt(found.responses[0, 0] * rate / 2.0))


@pytest.mark.parametrize("decay", [0.02, 0.15])
def test_the_noise_of_a_decay_that_does_not_end_is_told(decay):
    """A pendulum before a camera of thirty pictures a second."""
    rate, t = 30.0, np.arange(1200) / 30.0

    def falls(_t, y):
        return [y[1], -28.0 * np.sin(y[0]) - 0.02 * y[1] - decay * y[1] * abs(y[1])]

    swung = solve_ivp(falls, (0.0, 40.0), [0.9, 0.0], t_eval=t, rtol=1e-8).y[0]
    seen = swung + SIGMA * 0.1 * np.random.default_rng(3).standard_normal(t.size)
    channels = comparison.Channels(
        np.zeros((1, t.size)), (seen - seen.mean())[None], rate, (5.0, 13.5)
    )
    assert told(comparison.noise_of(channels), rate) == pytest.approx(0.1 * SIGMA, rel=0.15)


def quake(seed, pre_event_s):
    """Return base and top of a mass on a spring of 2 Hz under a quake that swells."""
    rng, rate = np.random.default_rng(seed), 200.0
    t = np.arange(6000) / rate
    swell = np.clip((t - pre_event_s) / 3.0, 0.0, None) ** 2 * np.exp(2.0 - 0.5 * t)
    steps = rng.standard_normal(t.size)
    base = np.convolve(steps, np.hanning(40), "same") * swell
    omega = 4.0 * np.pi
    frame = StateSpace(
        [[0.0, 1.0], [-(omega**2), -0.06 * omega]], [[0.0], [-1.0]],
        [[-(omega**2), -0.06 * omega]], [[0.0]],
    )  # fmt: skip
    _, top, _ = lsim(frame, base, t)
    scale = 1.0 / np.abs(top).max()
    rows = np.array([base, top]) * scale + SIGMA * 0.1 * rng.standard_normal((2, t.size))
    return comparison.Channels(rows[:1], rows[1:], rate, (0.3, 10.0)), rate


@pytest.mark.parametrize("pre_event_s", [0.0, 0.5])
def test_a_begin_that_already_moves_is_no_noise(pre_event_s):
    found = [told_in_band(*quake(seed, pre_event_s)) for seed in range(8)]
    in_band = 0.1 * SIGMA * np.sqrt(10.0 / 100.0)
    assert np.median(found) == pytest.approx(in_band, rel=0.15)
    assert max(found) < 1.5 * in_band


def told_in_band(channels, rate):
    found = comparison.noise_of(channels)
    inside = found.frequency <= 10.0
    return float(np.sqrt(found.responses[0, inside].sum() * found.frequency[0]))


def test_a_quartile_of_few_averages_is_not_below_the_noise():
    rate, n = 1000.0, 1200
    found = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        tone = np.sin(2.0 * np.pi * 30.0 * np.arange(n) / rate)
        rows = np.array([tone, tone]) + SIGMA * rng.standard_normal((2, n))
        channels = comparison.Channels(rows[:1], rows[1:], rate, (20.0, 40.0))
        found.append(told(comparison.noise_of(channels), rate))
    assert np.mean(found) == pytest.approx(SIGMA, rel=0.04)


@pytest.mark.parametrize(("rest_s", "beside"), [(0.0, True), (5.0, False)])
def test_noise_that_is_told_beside_a_motion_says_so(rest_s, beside):
    rng, rate = np.random.default_rng(2), 200.0
    time = np.arange(4000) / rate
    drive = np.sin(2.0 * np.pi * 3.0 * time) * (time >= rest_s)
    rows = np.array([drive, 0.5 * drive]) + 1e-3 * rng.standard_normal((2, time.size))
    found = comparison.noise_of(comparison.Channels(rows[:1], rows[1:], rate, (1.0, 10.0)))
    assert found.may_be_motion is beside
