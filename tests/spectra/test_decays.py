"""Frequency and damping over amplitude, against decays whose laws are known in closed form."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.special import ellipk

from shakerproc.errors import SpectrumError
from shakerproc.spectra.decays import decay_curve, decay_lines, free_start, trend_of

RATE = 2048.0


def decaying(modes, seconds, noise, seed):
    """A sum of decaying sinusoids of (natural frequency [Hz], damping ratio, amplitude)."""
    rng = np.random.default_rng(seed)
    t = np.arange(round(seconds * RATE)) / RATE
    total = noise * rng.standard_normal(t.size)
    for frequency, zeta, amplitude in modes:
        omega = 2.0 * np.pi * frequency
        angle = omega * np.sqrt(1.0 - zeta**2) * t + rng.uniform(0.0, 2.0 * np.pi)
        total += amplitude * np.exp(-zeta * omega * t) * np.cos(angle)
    return total


def released(acceleration, seconds, amplitude):
    """Displacement of a mass of 1 kg let go at an amplitude, by an integrator of scipy."""
    t = np.arange(round(seconds * RATE)) / RATE
    found = solve_ivp(
        lambda _, y: (y[1], acceleration(y[0], y[1])),
        (0.0, t[-1]),
        (amplitude, 0.0),
        "DOP853",
        t,
        rtol=1e-8,
        atol=1e-10 * amplitude,
    )
    return found.y[0]


def only_curve(samples, band=(20.0, 350.0)):
    """The curve of the tallest line."""
    (line,) = decay_lines(samples[np.newaxis], RATE, band, count=1)
    curve = decay_curve(samples, RATE, line)
    assert curve.problem == ""
    return curve


def test_a_linear_decay_with_noise_shows_no_trend_and_its_intervals_hold():
    modes = ((60.0, 0.005, 100.0), (143.0, 0.008, 40.0))
    held, sure, drawn, trends = np.zeros((2, 2)), 0, 0, 0
    for seed in range(12):
        samples = decaying(modes, 4.0, 0.2, seed)
        lines = decay_lines(samples[np.newaxis], RATE, (20.0, 350.0))
        for line in lines[:2]:
            frequency, zeta, _ = min(modes, key=lambda mode: abs(mode[0] - line.frequency))
            curve = decay_curve(samples, RATE, line)
            drawn += len(curve.fitted)
            for k, readings in enumerate((curve.fitted, curve.charted)):
                held[k] += np.sum(
                    [
                        (
                            abs(one.frequency - frequency) < one.frequency_error,
                            abs(one.damping - zeta) < one.damping_error,
                        )
                        for one in readings
                    ],
                    axis=0,
                )
                trend = trend_of(readings)
                trends += 2
                sure += trend.shifts + trend.damps
    assert drawn > 300
    assert held.min() / drawn > 0.92
    assert sure <= 0.04 * trends


def test_modes_are_found_each_in_the_channel_that_shows_it():
    first = decaying([(40.0, 0.01, 5.0), (90.0, 0.01, 50.0)], 3.0, 0.01, 1)
    second = decaying([(40.0, 0.01, 20.0)], 3.0, 0.01, 2)
    low, high = decay_lines(np.array([first, second]), RATE, (20.0, 350.0))
    assert (low.row, high.row) == (1, 0)
    assert low.frequency == pytest.approx(40.0, rel=2e-3)
    assert high.distance == pytest.approx(50.0, rel=0.01)


def test_neighbours_within_the_shift_of_one_mode_stay_two():
    modes = ((130.0, 0.007, 10.0), (150.0, 0.005, 8.0))
    samples = decaying(modes, 4.0, 0.001, 3)
    lines = decay_lines(samples[np.newaxis], RATE, (20.0, 350.0))
    for line, (frequency, zeta, _) in zip(lines, modes, strict=True):
        for one in decay_curve(samples, RATE, line).fitted[:3]:
            assert one.frequency == pytest.approx(frequency, rel=2e-4)
            assert one.damping == pytest.approx(zeta, rel=0.02)


def test_two_modes_too_close_to_tell_apart_give_no_curve():
    modes = ((520.0, 0.0075, 10.0), (530.0, 0.0075, 10.0), (410.0, 0.006, 10.0))
    samples = decaying(modes, 4.0, 0.001, 0)
    for line in decay_lines(samples[np.newaxis], RATE, (450.0, 600.0)):
        curve = decay_curve(samples, RATE, line)
        assert curve.problem or curve.rises > 1.2


def test_noise_has_no_modes():
    samples = np.random.default_rng(4).standard_normal((20, 8192))
    for row in samples:
        assert decay_lines(row[np.newaxis], RATE, (20.0, 900.0)) == ()


def test_a_duffing_oscillator_decays_along_its_backbone():
    """f = omega sqrt(1 + e) / (4 K(m)) with m = e / (2 (1 + e)) and e = alpha (A / omega)^2."""
    omega, zeta, amplitude = 2.0 * np.pi * 50.0, 0.003, 1.0
    alpha = 0.1 * omega**2
    samples = released(
        lambda x, v: -2.0 * zeta * omega * v - omega**2 * x - alpha * x**3, 3.0, amplitude
    )
    curve = only_curve(samples, (20.0, 100.0))
    for readings in (curve.fitted, curve.charted):
        for one in readings:
            peak = one.amplitude * (1.0 + 0.1 * one.amplitude**2 / 32.0)  # with 3 f
            e = 0.1 * peak**2
            backbone = omega * np.sqrt(1.0 + e) / (4.0 * ellipk(0.5 * e / (1.0 + e)))
            assert abs(one.frequency - backbone) < 1.1 * one.frequency_error
            assert one.frequency == pytest.approx(backbone, rel=4e-4)
        assert trend_of(readings).shifts
        assert trend_of(readings).shift > 0.01


def test_dry_friction_damps_as_one_over_amplitude():
    """In each half cycle the centre is at +-d, so that a peak is 2 d below the last."""
    frequency, d, first = 60.0, 0.004, 1.0
    half_cycles = 2.0 * frequency * np.arange(round(1.05 * RATE)) / RATE
    k = np.floor(half_cycles)
    peak = np.maximum(first - d - 2.0 * d * k, 0.0)
    samples = peak * np.cos(np.pi * half_cycles) + np.where(k % 2 == 0, d, -d)
    curve = only_curve(samples)
    for readings in (curve.fitted, curve.charted):
        for one in readings:
            if one.amplitude > 0.15:
                exact = 2.0 * d / (np.pi * one.amplitude)
                assert one.damping == pytest.approx(exact, rel=0.05)
        assert trend_of(readings).exponent == pytest.approx(-1.0, abs=0.1)
        assert trend_of(readings).law == -1


def test_quadratic_damping_goes_as_amplitude():
    """Balance of energy over a cycle: zeta = 4 c A / (3 pi m)."""
    omega, c = 2.0 * np.pi * 50.0, 0.05
    samples = released(lambda x, v: -(omega**2) * x - c * v * abs(v), 6.0, 1.0)
    curve = only_curve(samples, (20.0, 100.0))
    for readings in (curve.fitted, curve.charted):
        exact = [4.0 * c * one.amplitude / (3.0 * np.pi) for one in readings]
        assert_allclose([one.damping for one in readings], exact, rtol=0.025)
        assert trend_of(readings).exponent == pytest.approx(1.0, abs=0.03)
        assert trend_of(readings).law == 1


def test_a_decay_shorter_than_it_needs_says_how_long():
    samples = decaying([(60.0, 0.005, 100.0), (66.0, 0.005, 100.0)], 0.6, 0.01, 1)
    lines = decay_lines(samples[np.newaxis], RATE, (20.0, 350.0))
    assert len(lines) == 2
    problem = decay_curve(samples, RATE, lines[0]).problem
    assert problem.startswith("the decay lasts 0.6 s, and ")
    assert "to isolate 59.84 Hz from what lies 6.65 Hz away" in problem


def test_a_decay_that_is_over_at_once_says_so():
    samples = decaying([(60.0, 0.1, 10.0), (80.0, 0.001, 1.0)], 4.0, 0.1, 1)
    lines = decay_lines(samples[np.newaxis], RATE, (20.0, 350.0))
    assert (
        "it ends, in noise or in another mode, within"
        in decay_curve(samples, RATE, lines[0]).problem
    )


def test_the_free_part_begins_where_the_input_rests():
    force = np.zeros(4000)
    force[500:520] = 100.0
    force[520:600] = 2.0  # the hammer rings
    noise = 0.01 * np.random.default_rng(1).standard_normal((2, 4000))
    assert free_start(noise, (force + noise[0])[np.newaxis]) == 520
    noise[1, 700] = 5.0
    assert free_start(noise, np.zeros((0, 4000))) == 701


@pytest.mark.parametrize("hold", [0, 1, 200, 1500])
def test_what_is_held_before_it_is_let_go_is_not_free(hold):
    t = np.maximum(np.arange(6000) - hold, 0) / 1000.0
    row = 0.3 * np.exp(-0.1 * t) * np.cos(2.0 * np.pi * 0.6 * t)
    noise = 3e-4 * np.random.default_rng(1).standard_normal(row.size)
    start = free_start((row + noise)[np.newaxis], np.zeros((0, row.size)))
    assert start - hold < 0.6 * 1000.0 / 0.6  # from the crest on the other side at the latest
    assert start >= hold or hold < 50  # 0.03 of a period is no hold that shows in noise


def test_no_free_part_is_one_line():
    rng = np.random.default_rng(1)
    with pytest.raises(SpectrumError, match="no free part: the input moves to its end"):
        free_start(rng.standard_normal((1, 4000)), np.sin(np.arange(4000.0))[np.newaxis])
    growing = np.exp(np.arange(4000) / 500.0)[np.newaxis]
    with pytest.raises(SpectrumError, match="no free part: the largest motion is at its end"):
        free_start(growing, np.zeros((0, 4000)))


@pytest.mark.parametrize("seconds", [2.0, 4.0, 12.0])
def test_a_mode_that_shifts_is_one_though_it_still_rings_at_the_end(seconds):
    """A cubic spring by averaging: from 56 to 50 Hz, amplitude and phase in closed form."""
    rate, sigma, omega, extra = 2048.0, 0.8, 2.0 * np.pi * 50.0, 0.12
    time = np.arange(round(seconds * rate)) / rate
    amplitude = np.exp(-sigma * time)
    phase = omega * (time + extra * (1.0 - amplitude**2) / (2.0 * sigma))
    rows = (amplitude * np.cos(phase))[np.newaxis]
    rows = rows + 1e-4 * np.random.default_rng(4).standard_normal(rows.shape)
    (line,) = decay_lines(rows, rate, (20.0, 120.0))
    curve = decay_curve(rows[0], rate, line)
    assert not curve.problem
    for one in curve.fitted:
        true = 50.0 * (1.0 + extra * one.amplitude**2)
        assert one.frequency == pytest.approx(true, rel=2e-3)
