"""Health: ends of a recording, distributions without tails, gains that cannot be."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import signal
from tests.recordings.test_health import RATE, N, excitation, four_channels, recording_of, sdof

from shakerproc.data import Channel, recording_of_arrays
from shakerproc.recordings import health
from shakerproc.runs.joining import side_by_side


def told(samples, *kinds, roles=("control", "control", "response", "response"), block=2**17):
    recording = recording_of(samples, roles=roles)
    return [(f.kind, f.channel) for f in health(recording, block=block) if f.kind in kinds]


@pytest.mark.parametrize("block", [2**17, 10_000])
@pytest.mark.parametrize(
    ("at", "width"), [(0, 3), (1, 1), (30, 3), (N - 31, 1), (N - 6, 3), (N - 3, 1)]
)
def test_a_spike_at_an_end_is_found_as_in_the_middle(at, width, block):
    samples = four_channels("random", np.random.default_rng(at))
    samples[2, at : at + width] += 60.0 * np.std(samples[2])
    assert told(samples, "spike", block=block) == [("spike", "ch3")]


def test_the_rest_of_a_pulse_at_the_first_sample_is_no_spike():
    """A half-sine of 24 samples of which the last three are left."""
    samples = four_channels("random", np.random.default_rng(3))
    samples[2, :3] += 60.0 * np.std(samples[2]) * np.array([1.0, 0.66, 0.33])
    assert told(samples, "spike") == []


def noise(rng, n):
    return signal.sosfilt(
        signal.butter(4, [0.005, 0.5], "band", output="sos"), rng.normal(size=n)
    )


AFTER = {
    "AC coupling": lambda x: signal.lfilter(*signal.butter(1, 0.0005, "high"), x),
    "a low-pass": lambda x: signal.sosfilt(signal.butter(8, 0.4, output="sos"), x),
}


@pytest.mark.parametrize(
    ("after", "level"), [("AC coupling", 1.2), ("AC coupling", 2.0), ("a low-pass", 1.2)]
)
def test_clipping_before_a_filter_is_told_of_the_channel_alone(after, level):
    """At 1.2 standard deviations 23 % of the samples, at 2 it is 4.6 %."""
    rng = np.random.default_rng(4)
    base = noise(rng, 4 * N)
    response = sdof(base)
    limit = level * np.std(response)
    rows = np.array([base, AFTER[after](np.clip(response, -limit, limit)), sdof(base, 400.0)])
    roles = ("control", "response", "response")
    assert told(rows, "short tails", "clipping", roles=roles) == [("short tails", "ch2")]


def test_what_has_short_tails_without_being_clipped_is_not_accused():
    rng, t = np.random.default_rng(5), np.arange(4 * N) / RATE
    drift = 20.0 * np.sin(0.3 * t) + 9.0 * np.sin(0.77 * t)
    waves = {
        "sine": np.sin(2.0 * np.pi * 97.0 * t),
        "slow sweep": signal.chirp(t, 100.0, t[-1], 101.0),
        "sweep": signal.chirp(t, 5.0, t[-1], 2000.0, method="log"),
        "square": signal.square(2.0 * np.pi * 33.0 * t),
        "wandering": np.sin(2.0 * np.pi * 100.0 * t + drift),
        "three tones": sum(np.sin(2.0 * np.pi * f * t) for f in (97.0, 131.0, 305.0)),
        "drive clipped at 3 sigma": np.clip(rng.normal(size=t.size), -3.0, 3.0),
    }
    for name, wave in waves.items():
        rows = np.array([wave, 0.01 * rng.normal(size=t.size)])
        assert told(rows, "short tails", roles=("response",) * 2) == [], name


@pytest.mark.parametrize("factor", [0.1, 10.0, 9.80665, 1.0 / 9.80665, -10.0])
@pytest.mark.parametrize("kind", ["random", "sweep"])
def test_a_response_that_follows_its_base_with_another_gain_is_told(kind, factor):
    samples = four_channels(kind, np.random.default_rng(6), noise=1e-3)
    samples[2] *= factor
    assert told(samples, "gain") == [("gain", "ch3")]


@pytest.mark.parametrize("seconds", [1.0, 2.0, 5.0])
@pytest.mark.parametrize(("factor", "kind"), [(-1.0, "polarity"), (9.80665, "gain"), (1.0, "")])
def test_a_short_test_is_judged_by_its_periods(seconds, factor, kind):
    """The base is white: a quarter of a second holds two periods of 8 Hz, and of all above."""
    samples = four_channels("random", np.random.default_rng(10), noise=1e-3)
    samples = samples[:, 1000 : 1000 + round(seconds * RATE)]
    samples[3] *= factor
    assert told(samples, "gain", "polarity") == ([(kind, "ch4")] if kind else [])


def test_a_wrong_control_is_named_and_not_every_response():
    samples = four_channels("random", np.random.default_rng(7), noise=1e-3)[[0, 2, 3]]
    samples[0] *= 10.0
    roles = ("control", "response", "response")
    assert told(samples, "gain", roles=roles) == [("gain", "ch1")]


@pytest.mark.parametrize("damping", [0.02, 0.3, 1.0])
@pytest.mark.parametrize("seconds", [2.0, N / RATE])
def test_a_base_isolated_system_has_no_wrong_gain(damping, seconds):
    rng, t = np.random.default_rng(8), np.arange(round(seconds * RATE)) / RATE
    base = 5.0 * signal.chirp(t, 40.0, t[-1], 500.0, method="log")
    rows = np.array([base, sdof(base, 8.0, damping), sdof(base, 5.0, damping)])
    rows += 1e-4 * rng.normal(size=rows.shape)
    assert told(rows, "gain", "polarity", roles=("control", "response", "response")) == []


def test_beside_a_force_no_gain_is_judged():
    base = excitation("random", np.random.default_rng(9))
    units = (("control", "m/s^2"), ("force", "N"), ("response", "m/s^2"))
    channels = [Channel(role, unit, role, unit, role) for role, unit in units]
    rows = np.array([base, 3.0 * base, 10.0 * base])
    recording = recording_of_arrays("run", channels, rows, RATE)
    assert "gain" not in {flag.kind for flag in health(recording)}


def test_noise_of_a_resonance_near_a_multiple_of_the_mains_is_no_hum():
    rng = np.random.default_rng(10)
    rows = np.array([rng.normal(size=N), sdof(0.05 * rng.normal(size=N), 183.0, 0.003)])
    said = [flag.message for flag in health(recording_of(rows, roles=("control", "response")))]
    assert not any("hum" in message for message in said)


def test_orders_of_a_shaft_that_no_other_channel_shares_are_no_open_input():
    rng, t = np.random.default_rng(11), np.arange(N) / RATE
    angle = 2.0 * np.pi * (20.0 * t + 2.0 * t**2)
    rows = np.array([np.sin(angle), np.sin(angle), np.sin(2.0 * angle)])
    rows += 1e-4 * rng.normal(size=rows.shape)
    assert told(rows, "open input", roles=("response",) * 3) == []


@pytest.mark.parametrize("zeros", [-20, 0, 5, 16, 40, 3000])
def test_shocks_and_the_rest_between_them_are_no_dropout(zeros):
    """Two half-sines and what follows in two masses, in steps of a converter.

    The first comes after exact zeros, or the recording begins with it, or in its middle.
    """
    n = np.arange(N)
    phase = (n - zeros) / (0.011 * RATE)
    base = 300.0 * np.sin(np.pi * np.clip(phase, 0.0, 1.0))
    rows = np.array([base, sdof(base), sdof(base, 90.0, 0.05)])
    rows[:, 30_000:] += rows[:, : N - 30_000]
    still = ("dropout", "stuck", "zero tail")
    assert (
        told(np.round(rows / 0.01) * 0.01, *still, roles=("control",) + 2 * ("response",)) == []
    )
    rng = np.random.default_rng(15)
    failing = 20.0 * rng.normal(size=(3, N))
    failing[1, 20_000:20_400] = 0.0
    assert told(np.round(failing), *still) == [("dropout", "ch2")]


@pytest.mark.parametrize(("low", "accused"), [(20.0, False), (0.1, True)])
def test_a_channel_of_a_low_rate_is_open_only_where_it_could_see_the_others(low, accused):
    """Noise of 10 Hz beside what moves above 20 Hz, or below 5 Hz for the most part."""
    rng, rate, n = np.random.default_rng(16), 256.0, 256 * 60
    high = 100.0 if low > 5.0 else 4.0
    band = signal.butter(4, [low, high], "band", fs=rate, output="sos")
    base = signal.sosfilt(band, rng.normal(size=n))
    main = recording_of_arrays("run", [
        Channel(name, "m/s^2", name, "g", name) for name in ("control", "response")
    ], np.array([base, 0.5 * base]) + 1e-4 * rng.normal(size=(2, n)), rate)  # fmt: skip
    slow = Channel("temperature", "m/s^2", "temperature", "g", "response")
    other = recording_of_arrays("run", [slow], 0.01 * rng.normal(size=(1, 600)), 10.0)
    flags = health(replace(side_by_side(main, other, None), driven=True))
    assert [f.channel for f in flags if f.kind == "open input"] == ["temperature"] * accused
