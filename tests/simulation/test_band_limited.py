"""Means of accelerations that jump, and inputs between their samples, against oversampling."""

import numpy as np
import pytest

from shakerproc.models import Element, Excitation, Model
from shakerproc.models.effects import (
    ContactDamping,
    CoulombFriction,
    CubicStiffness,
    Gap,
    Spring,
)
from shakerproc.simulation.inputs import MISSED, prepare_measured
from shakerproc.simulation.window_sensing import EDGE, has_jumps, mean_accelerations

RATE, COUNT, FINER = 1000.0, 2048, 64


def model_with(*effects):
    joined = tuple(Element(effect, ("base", "coupon")) for effect in (Spring(1e3), *effects))
    return Model("one mass", {"coupon": 1.0}, joined, Excitation("base acceleration"), {})


def jumping():
    """Return displacement and velocity at the samples, and means without what folds back.

    The acceleration changes its sign at 400 moments; its spectrum is cut off at half the rate
    where it is known 64 times a sample.
    """
    turns = np.zeros(COUNT * FINER)
    turns[np.random.default_rng(1).choice(turns.size, 400, replace=False)] = 1.0
    acceleration = np.where(np.cumsum(turns) % 2 == 0, 1.0, -1.0)
    acceleration -= acceleration.mean()
    step = 1.0 / (RATE * FINER)
    velocity = np.concatenate([[0.0], np.cumsum(acceleration[:-1])]) * step
    moved = velocity * step + 0.5 * acceleration * step**2
    displacement = np.concatenate([[0.0], np.cumsum(moved[:-1])])
    spectrum = np.fft.rfft(acceleration)
    spectrum[np.fft.rfftfreq(acceleration.size, step) > 0.5 * RATE] = 0.0
    low = np.fft.irfft(spectrum, acceleration.size).reshape(COUNT, FINER).mean(axis=1)
    return displacement[::FINER], velocity[::FINER], low[:-1]


def in_bands(rows):
    """Return the rms in four bands up to 0.4 of the rate."""
    power = np.abs(np.fft.rfft(rows * np.hanning(rows.size))) ** 2
    edges = (np.array([0.0, 0.1, 0.2, 0.3, 0.4]) * rows.size).astype(int)
    return np.sqrt(np.add.reduceat(power, edges[:-1]))[:4]


def test_what_folds_back_is_taken_away():
    displacement, velocity, wanted = jumping()
    plain = np.diff(velocity) * RATE
    found = mean_accelerations(displacement, velocity, RATE)
    folded, left = in_bands(plain - wanted), in_bands(found - wanted)
    assert np.all(folded[1:3] > 0.03 * in_bands(wanted)[1:3])  # there was something to take
    assert np.all(left[:3] < folded[:3] / 5.0)
    np.testing.assert_array_equal(found[:EDGE], plain[:EDGE])
    np.testing.assert_array_equal(found[-EDGE:], plain[-EDGE:])


@pytest.mark.parametrize("share", [0.01, 0.1, 0.3, 0.39])
def test_a_sine_keeps_its_means(share):
    """Nothing of it folds back: the mean over a sample in closed form."""
    omega, t = 2.0 * np.pi * share * RATE, np.arange(300) / RATE
    found = mean_accelerations(-np.cos(omega * t) / omega**2, np.sin(omega * t) / omega, RATE)
    wanted = np.diff(np.sin(omega * t)) / omega * RATE
    np.testing.assert_allclose(found, wanted, atol=2e-4)


def test_a_short_run_keeps_its_plain_means():
    velocity = np.random.default_rng(0).standard_normal(2 * EDGE + 1)
    found = mean_accelerations(np.cumsum(velocity), velocity, RATE)
    np.testing.assert_array_equal(found, np.diff(velocity) * RATE)


def test_jumps_are_those_of_dry_friction_and_damped_contacts():
    assert has_jumps(model_with(CoulombFriction(1.0)))
    assert has_jumps(model_with(ContactDamping(3.0, 1e-4)))
    assert not has_jumps(model_with())
    assert not has_jumps(model_with(Gap(5e3, 1e-4), CubicStiffness(1e9)))


def between_samples(given, finer=8):
    """Return the input eight times a sample, from its pieces."""
    at = np.arange((given.n_samples - 1) * finer) / finer * given.stride
    piece = np.minimum(at.astype(int), len(given.pieces) - 1)
    powers = (at - piece)[:, None] ** np.arange(given.pieces.shape[1])
    return np.sum(powers * given.pieces[piece], axis=1)


def tones(highest, times):
    """Return 30 tones up to a share of the rate."""
    rng = np.random.default_rng(2)
    frequencies = np.linspace(0.02, highest, 30)
    phases = rng.uniform(0.0, 2.0 * np.pi, 30)
    return np.sum(np.cos(2.0 * np.pi * np.outer(times, frequencies) + phases), axis=1)


def test_a_drive_up_to_a_third_of_the_rate_is_cut_finer():
    samples = tones(0.35, np.arange(1500))
    given = prepare_measured(samples, RATE, imposed=False)
    assert given.stride > 1
    assert given.missed_between < MISSED
    middle = slice(400 * 8, 1100 * 8)
    wanted = tones(0.35, np.arange(1499 * 8) / 8.0)[middle]
    apart = between_samples(given)[middle] - wanted
    assert np.max(np.abs(apart)) < MISSED * np.max(np.abs(samples))


def test_noise_up_to_half_the_rate_is_not_cut_finer():
    rng = np.random.default_rng(3)
    samples = tones(0.1, np.arange(1500)) + 0.05 * rng.standard_normal(1500)
    assert prepare_measured(samples, RATE, imposed=False).stride == 1
