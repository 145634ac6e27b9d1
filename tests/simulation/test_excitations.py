"""Excitations: what their momentary frequency, density and rms are."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.signal import welch

from shakerproc.simulation.excitations import (
    NoiseProfile,
    faded,
    flat_profile,
    harmonic,
    linear_sweep,
    logarithmic_sweep,
    multisine,
    random_noise,
    rest,
    sampled,
    stepped_sine,
)
from shakerproc.simulation.pieces import pieces_of_samples, pieces_of_signal


def momentary_frequency(signal, time):
    """From the phase of the signal and of its companion a quarter turn ahead."""
    step = 1e-6
    ahead = np.arctan2(signal[0](time + step), signal[1](time + step))
    behind = np.arctan2(signal[0](time - step), signal[1](time - step))
    return np.angle(np.exp(1j * (ahead - behind))) / (4.0 * np.pi * step)


@pytest.mark.parametrize(
    ("make", "expected"),
    [
        (lambda p: harmonic(7.0, 2.0, p), lambda t: 7.0 + 0.0 * t),
        (lambda p: linear_sweep(5.0, 45.0, 8.0, 2.0, p), lambda t: 5.0 + 5.0 * t),
        (lambda p: linear_sweep(45.0, 5.0, 8.0, 2.0, p), lambda t: 45.0 - 5.0 * t),
        (lambda p: logarithmic_sweep(5.0, 500.0, 60.0, 2.0, p), lambda t: 5.0 * 2.0**t),
        (
            lambda p: logarithmic_sweep(500.0, 5.0, 30.0, 2.0, p),
            lambda t: 500.0 * 2.0 ** (-t / 2),
        ),
    ],
)
def test_the_momentary_frequency_is_the_one_asked_for(make, expected):
    """The phase is the integral of the frequency, which eq. 5.1 of the thesis is not."""
    time = np.linspace(0.1, 6.0, 57)
    pair = make(0.0), make(0.5 * np.pi)
    assert_allclose(momentary_frequency(pair, time), expected(time), rtol=1e-6)
    assert np.max(np.abs(pair[0](np.linspace(0.0, 6.0, 9001)))) <= 2.0


def test_stepped_sines_are_whole_cycles_without_a_jump():
    signal = stepped_sine([2.0, 4.0, 5.0], 4, 3.0)
    ends = np.array([2.0, 3.0, 3.8])
    assert_allclose(signal(ends), 0.0, atol=1e-12)
    assert_allclose(signal(np.array([0.125, 2.0625, 3.05])), 3.0, rtol=1e-12)
    assert_allclose(signal(np.array([4.0, 9.0])), 0.0)
    with pytest.raises(ValueError, match="at least one cycle"):
        stepped_sine([1.0], 0, 1.0)


def test_samples_have_both_ends():
    assert sampled(rest(), 2.0, 10.0).shape == (21,)


def test_the_rms_of_a_profile_is_its_integral():
    profile = NoiseProfile((20.0, 80.0, 350.0, 2000.0), (0.01, 0.04, 0.04, 0.007))
    frequency = np.geomspace(20.0, 2000.0, 200001)
    density = profile.at(frequency)
    integral = np.sum(0.5 * (density[1:] + density[:-1]) * np.diff(frequency))
    assert_allclose(profile.rms, np.sqrt(integral), rtol=1e-6)
    assert_allclose(flat_profile(10.0, 110.0, 0.09).rms, 3.0)
    slope = NoiseProfile(
        (10.0, 100.0), (1.0, 0.1)
    )  # the exponent -1 has a logarithm as integral
    assert_allclose(slope.rms, np.sqrt(10.0 * np.log(10.0)))
    assert_allclose(profile.at(np.array([1.0, 40.0, 3000.0])), [0.0, 0.02, 0.0])


@pytest.mark.parametrize(
    ("frequency", "density", "message"),
    [
        ((1.0,), (1.0,), "at least two"),
        ((1.0, 2.0), (1.0,), "as many densities"),
        ((2.0, 1.0), (1.0, 1.0), "must rise"),
        ((0.0, 1.0), (1.0, 1.0), "frequency must be above 0"),
        ((1.0, 2.0), (1.0, 0.0), "density must be above 0"),
    ],
)
def test_a_profile_that_is_none_is_refused(frequency, density, message):
    with pytest.raises(ValueError, match=message):
        NoiseProfile(frequency, density)


def test_noise_has_the_density_of_its_profile():
    profile = NoiseProfile((50.0, 200.0, 800.0), (0.1, 1.0, 0.05))
    noise = random_noise(profile, 200.0, 4000.0, np.random.default_rng(1))
    frequency, density = welch(noise, 4000.0, nperseg=4000)
    inside = (frequency > 60.0) & (frequency < 750.0)
    assert_allclose(np.mean(density[inside] / profile.at(frequency[inside])), 1.0, rtol=0.02)
    assert_allclose(np.std(noise), profile.rms, rtol=0.02)
    assert np.all(density[frequency > 820.0] < 1e-6)


def test_a_multisine_has_it_exactly_in_every_period():
    profile = flat_profile(10.0, 90.0, 0.5)
    signal = multisine(profile, 4.0, 512.0, np.random.default_rng(2), periods=3)
    assert signal.size == 3 * 2048
    assert_allclose(signal[:2048], signal[2048:4096], rtol=0.0, atol=0.0)
    lines = np.abs(np.fft.rfft(signal[:2048])) ** 2 * 2.0 / 512.0 / 2048.0
    assert_allclose(lines[40:361], 0.5, rtol=1e-12)
    assert_allclose(lines[:40], 0.0, atol=1e-20)
    other = multisine(profile, 4.0, 512.0, np.random.default_rng(3))
    assert abs(np.corrcoef(other, signal[:2048])[0, 1]) < 0.2


def test_ramps_rise_and_fall_alike():
    ramped = faded(np.ones(1001), 1000.0, 0.1)
    assert np.all(np.diff(ramped[:100]) > 0.0)
    assert_allclose(ramped, ramped[::-1])
    assert np.all(ramped[100:-100] == 1.0)
    with pytest.raises(ValueError, match="holds only 2 samples"):
        random_noise(flat_profile(1.0, 2.0, 1.0), 0.02, 100.0, np.random.default_rng(0))


def test_the_pieces_of_a_signal_go_through_it():
    signal = linear_sweep(0.0, 30.0, 30.0, 5.0)
    pieces = pieces_of_signal(signal, 15000, 500.0)
    share = np.array([0.0, 0.123, 0.5, 0.77, 1.0])
    values = pieces @ np.vander(share, pieces.shape[1], increasing=True).T
    time = (np.arange(15000)[:, None] + share) / 500.0
    rounding = 2.0 * np.pi * 450.0 * np.finfo(float).eps  # of the angle after 450 turns
    assert_allclose(values, signal(time), atol=5.0 * 2.0 * rounding)


def test_a_chirp_keeps_its_digits_over_hundreds_of_turns():
    """At sample j of 500 a second, 1 Hz/s has turned j^2 / 500000 times: a whole-number sum."""
    pieces = pieces_of_signal(linear_sweep(0.0, 30.0, 30.0, 1.0), 15000, 500.0)
    turns = (np.arange(15000) ** 2 % 500000) / 500000.0
    assert_allclose(pieces[:, 0], np.sin(2.0 * np.pi * turns), atol=4.0 * np.finfo(float).eps)


@pytest.mark.parametrize("rate", [20.0, 45.0, 70.0, 1e6])
def test_chirps_of_any_rate_have_pieces(rate):
    """From so few samples a turn that no series ends, to so many that four terms do."""
    signal = linear_sweep(8.0, 12.0, 2.0, 3.0, 0.3)
    n = round(2.0 * min(rate, 1000.0))
    pieces = pieces_of_signal(signal, n, rate)
    share = np.linspace(0.0, 1.0, 7)
    values = pieces @ np.vander(share, pieces.shape[1], increasing=True).T
    time = (np.arange(n)[:, None] + share) / rate
    expected = 3.0 * np.sin(2.0 * np.pi * (8.0 + time) * time + 0.3)  # 2 Hz/s
    assert_allclose(values, expected, atol=1e-12 if rate > 40.0 else 1e-3)


@pytest.mark.parametrize(
    ("hold", "degree", "limit"), [("linear", 1, 4e-2), ("band-limited", 5, 1e-5)]
)
def test_the_pieces_of_samples_follow_a_band_limited_signal(hold, degree, limit):
    """A 500 Hz sine at 5.69 kHz: 2.5 % droop by straight lines, next to nothing by quintics."""
    rate = 5688.9
    time = np.arange(4001) / rate
    samples = np.sin(2.0 * np.pi * 500.0 * time)
    pieces = pieces_of_samples(samples, upsample=1, hold=hold)
    assert pieces.shape == (4000, degree + 1)
    middle = pieces[1000:3000] @ 0.5 ** np.arange(degree + 1)
    expected = np.sin(2.0 * np.pi * 500.0 * (time[1000:3000] + 0.5 / rate))
    error = np.max(np.abs(middle - expected))
    assert error < limit
    assert_allclose(np.sum(pieces, axis=1), samples[1:], atol=1e-12)
    assert_allclose(pieces[:, 0], samples[:-1], atol=1e-12)


def test_the_ends_of_samples_do_not_ring():
    """A signal that neither starts nor ends at 0 and is not periodic."""
    rate = 1000.0
    time = np.arange(2001) / rate
    samples = 3.0 + 2.0 * time + np.cos(2.0 * np.pi * 20.0 * time + 0.4)
    finer = pieces_of_samples(samples, upsample=4, hold="band-limited")
    at = np.arange(8000) / 4.0 / rate
    expected = 3.0 + 2.0 * at + np.cos(2.0 * np.pi * 20.0 * at + 0.4)
    assert_allclose(finer[:, 0], expected, atol=3e-3)
    assert_allclose(finer[400:-400, 0], expected[400:-400], atol=2e-5)
