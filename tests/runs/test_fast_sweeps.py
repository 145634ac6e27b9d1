"""A sweep too fast for its damping says by how much its peak is low and shifted."""

import re

import numpy as np
import pytest
from numpy.testing import assert_allclose
from tests.runs.test_peak_tables import mode, processed
from tests.small_campaign import RATE

from shakerproc.spectra import swept_mode, swept_response
from shakerproc.spectra.tones.passing import passing, swept_peak, swept_shift


def swept(rate, low=40.0, high=90.0, sample_rate=RATE):
    """A logarithmic sweep of amplitude 1 [oct/min], downwards where the rate is negative."""
    seconds = 60.0 * np.log2(high / low) / abs(rate)
    time = np.arange(round(seconds * sample_rate)) / sample_rate
    growth = np.log(2.0) * abs(rate) / 60.0
    base = np.sin(2.0 * np.pi * low * np.expm1(growth * time) / growth)
    return base if rate > 0.0 else base[::-1].copy()


@pytest.mark.parametrize("ratio", [0.003, 0.01, 0.03])
@pytest.mark.parametrize("rate", [2.0, -4.0])
def test_the_steady_peak_is_found_in_a_sweep_that_is_too_fast(ratio, rate):
    """The truth: the transmissibility of a mass on a spring, from its formula."""
    base = swept(rate, sample_rate=1024.0)
    noise = 1e-3 * np.random.default_rng(1).standard_normal((2, base.size))
    samples = np.array([base, mode(base, 60.0, ratio, 1024.0)]) + noise
    (sweep,) = swept_response(samples, 1024.0, [0], (40.0, 90.0))
    found = swept_mode(sweep, 1)
    assert_allclose(found.ratio, ratio, rtol=min(0.05, found.half))
    assert_allclose(found.frequency, 60.0, rtol=0.002)
    r = np.linspace(0.8, 1.2, 100_001)
    steady = np.abs((1.0 + 2j * ratio * r) / (1.0 - r**2 + 2j * ratio * r))
    assert_allclose(found.steady_gain, steady.max(), rtol=0.05)
    assert_allclose(found.steady_frequency, 60.0 * r[np.argmax(steady)], rtol=0.002)


def test_a_mode_that_is_passed_slowly_answers_as_in_steady_state():
    frequency = np.linspace(90.0, 110.0, 50)
    slow, steady = (passing(frequency, 100.0, 0.01, rate) for rate in (1e-6, 0.0))
    assert_allclose(slow, steady, rtol=1e-5)


@pytest.mark.parametrize("rate", [3.0, -30.0])
def test_a_mode_that_is_passed_fast_answers_as_the_integral_says(rate):
    frequency, s = np.array([98.0, 100.0, 103.0]), np.linspace(0.0, 8.0, 1_600_001)
    pole = 2.0 * np.pi * 100.0 * complex(-0.01, np.sqrt(1.0 - 1e-4))
    for f, got in zip(frequency, passing(frequency, 100.0, 0.01, rate), strict=True):
        phase = (pole - 2j * np.pi * f) * s + 1j * np.pi * rate * s**2
        assert_allclose(got, np.trapezoid(np.exp(phase), s), rtol=1e-5)


def test_the_shift_is_where_the_integral_is_largest():
    frequency = np.linspace(99.0, 106.0, 70_001)
    height = np.abs(passing(frequency, 100.0, 0.01, 3.0))
    found = frequency[np.argmax(height)] - 100.0 * np.sqrt(1.0 - 1e-4)
    assert_allclose(swept_shift(3.0, 100.0, 0.01), found, atol=2e-3)
    assert_allclose(swept_peak(3.0, 100.0, 0.01), height.max() * 2.0 * np.pi, rtol=1e-3)


def test_a_sweep_too_fast_for_its_damping_says_so_on_the_terminal_and_in_the_table(
    tmp_path, capfd
):
    base = swept(4.0)
    options = ("--excitation", "sine sweep", "--from-hz", "40", "--to-hz", "90")
    summary, rows = processed(tmp_path, mode(base, 60.0, 0.003), base, *options)
    shown = capfd.readouterr()
    (flag,) = [flag for flag in summary.flags if flag.kind == "sweep rate"]
    low, shift, slower = re.search(
        r"low by (\d+)% and ([\d.]+) Hz too high; sweep at ([\d.]+) oct/min or slower for 5%",
        flag.message,
    ).groups()
    (row,) = [row for row in rows if row["quantity"] == "sweep up"]
    assert_allclose(float(low), 100.0 * (1.0 - float(row["height"]) / (0.5 / 0.003)), atol=3.0)
    assert_allclose(float(shift), float(row["frequency_hz"]) - 60.0, atol=0.15)
    assert_allclose(float(row["height_steady"]), 0.5 / 0.003, rtol=0.05)
    rate = 60.0 * np.log(2.0) * float(slower) / 60.0
    assert_allclose(swept_peak(rate, 60.0, 0.003), 0.95, atol=0.02)
    assert "sweep is too fast for its damping" not in shown.out
    assert "sweep up is too fast for its damping (zeta 0.3" in shown.err


def test_a_slow_sweep_says_nothing(tmp_path):
    base = swept(4.0)
    options = ("--excitation", "sine sweep", "--from-hz", "40", "--to-hz", "90")
    summary, rows = processed(tmp_path, mode(base, 60.0, 0.05), base, *options)
    assert "sweep rate" not in {flag.kind for flag in summary.flags}
    (row,) = [row for row in rows if row["quantity"] == "sweep up"]
    assert_allclose(float(row["height_steady"]), float(row["height"]), rtol=0.03)


@pytest.mark.parametrize(("rate", "told"), [(16.0, True), (1.0, False)])
def test_a_passing_that_no_mode_follows_is_told_beside_its_gain(rate, told, tmp_path, capfd):
    base = swept(rate)
    response = mode(base, 60.0, 0.003 if told else 0.03)
    options = "--excitation", "sine sweep", "--from-hz", "40", "--to-hz", "90", "--no-crop"
    summary, _ = processed(tmp_path, response, base, *options)
    (peak,) = summary.channels[1].swept_peaks
    assert (peak.steady_gain is None) == told
    assert ("steady gain withheld (ch3 up)" in capfd.readouterr().out) == told
