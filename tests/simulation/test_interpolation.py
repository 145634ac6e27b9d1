"""A measured drive between its samples: what is missed, at its ends too, is said."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shakerproc.data import Channel, Recording, recording_of_arrays
from shakerproc.models import EFFECTS, Element, Excitation, Model
from shakerproc.planning import Staging, respond, with_usual_roles
from shakerproc.simulation import prepare, simulate
from shakerproc.simulation.pieces import finer

RATE = 5690.0


def multisine(seed, low, high, lines=60):
    rng = np.random.default_rng(seed)
    frequency = rng.uniform(low, high, lines)
    phase = rng.uniform(0.0, 2.0 * np.pi, lines)

    def signal(time):
        angle = 2.0 * np.pi * frequency * np.asarray(time)[..., None] + phase
        return np.sum(np.cos(angle), axis=-1)

    return signal


def missed(signal, n, upsample=1):
    """What the pieces miss of a known signal, at each step, over its largest sample."""
    samples = signal(np.arange(n) / RATE)
    made = prepare(samples, RATE, upsample=upsample)
    shares = np.linspace(0.0, 1.0, 9)[1:-1]
    found = made.pieces @ np.vander(shares, made.pieces.shape[1], increasing=True).T
    at = (np.arange(len(made.pieces))[:, None] + shares) / (RATE * upsample)
    error = np.max(np.abs(found - signal(at)), axis=1) / np.max(np.abs(samples))
    return error, made.interpolation


def swing(frequency):
    return lambda time: np.cos(2.0 * np.pi * frequency * np.asarray(time))


def test_a_drive_that_begins_at_full_swing_is_as_exact_there_as_in_the_middle():
    """(omega h)^6 / 46080 at 500 Hz and 5.69 kHz is 6e-7, from the first sample on."""
    error, said = missed(swing(500.0), 3000)
    omega_h = 2.0 * np.pi * 500.0 / RATE
    bound = 1.02 * omega_h**6 / 46080.0
    assert np.max(error[:20]) < bound
    assert np.max(error) < bound
    assert np.max(error) <= 1.02 * said.largest
    assert said.largest < 1.1 * bound


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6), st.floats(50.0, 2560.0), st.integers(300, 3000))
def test_what_is_said_is_what_is_missed(seed, high, n):
    """What is missed stays below a small multiple of what is said, and is not dwarfed by it."""
    error, said = missed(multisine(seed, 5.0, high), n)
    inside, ends = error[40:-40], np.concatenate((error[:20], error[-20:]))
    assert np.max(inside) < 3.0 * said.middle + 0.3 * said.first + 1e-12
    assert np.max(ends) < 5.0 * said.first + 1e-12
    assert said.first < 100.0 * np.max(error) + 1e-11


def test_the_error_of_a_simulation_counts_its_drive():
    """Against the same drive sampled eight times as finely, from the very first sample."""
    model = Model(
        "one mass",
        {"m": 1.0},
        (
            Element(EFFECTS["spring"](stiffness=(2.0 * np.pi * 1500.0) ** 2), ("base", "m")),
            Element(EFFECTS["damper"](damping_ratio=0.05), ("base", "m")),
        ),
        Excitation("base acceleration"),
    )
    signal, n = multisine(4, 5.0, 2000.0), 1500
    coarse = simulate(model, signal(np.arange(n) / RATE), RATE, growth=False)
    fine = simulate(model, signal(np.arange(8 * n - 7) / (8 * RATE)), 8 * RATE, growth=False)
    exact = fine.displacement[0, ::8]
    apart = np.max(np.abs(coarse.displacement[0] - exact)) / np.max(np.abs(exact))
    assert coarse.interpolation is not None
    assert apart < 2.0 * coarse.error
    assert coarse.error >= coarse.interpolation.largest > 1e-5
    assert fine.error < 1e-2 * coarse.error


@pytest.mark.parametrize("n", [2, 3, 4, 7, 40, 100])
@pytest.mark.parametrize("size", [0.0, 1e-300, 1.0, 1e300])
def test_few_samples_and_any_size_are_no_trouble(n, size):
    for samples in (np.ones(n), np.eye(n)[0], np.eye(n)[-1], np.cos(np.arange(n))):
        said = prepare(size * samples, RATE).interpolation
        assert 0.0 <= said.middle <= said.first <= 2.0


def test_a_drive_from_rest_has_no_error_at_its_ends():
    bell = np.hanning(2000)
    said = prepare(bell * swing(300.0)(np.arange(2000) / RATE), RATE).interpolation
    assert said.first < 1e-6


def test_finer_samples_may_go_on_past_the_last():
    signal, n = multisine(1, 5.0, 1000.0), 800
    (values,) = finer(signal(np.arange(n) / RATE), 4, 0, beyond=3)
    assert values.size == 4 * n
    assert np.max(np.abs(values - signal(np.arange(4 * n) / (4 * RATE)))) < 1e-3 * 60


def driven(signal, n):
    channels = [
        Channel("control 1", "m/s^2", "control 1", "m/s^2"),
        Channel("force", "N", "force", "N"),
    ]
    samples = signal(np.arange(n) / RATE)
    return recording_of_arrays("run", channels, np.array([samples, samples]), RATE)


def test_simulate_tells_how_well_it_knows_a_measured_drive():
    model = Model(
        "one mass",
        {"m": 1.0},
        (Element(EFFECTS["spring"](stiffness=1e6), ("base", "m")),),
        Excitation("force", "m"),
    )
    recording = driven(multisine(2, 5.0, 2500.0), 2000)
    assert isinstance(recording, Recording)
    facts = respond(model, with_usual_roles(recording), Staging(growth=False)).facts
    said = facts["interpolation_error"]
    assert said.first > 1e-4
    assert facts["error"] >= said.first
