"""Open inputs: noise and hum that no other channel shares, and what is not one."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import signal
from tests.recordings.test_health import RATE, excitation, recording_of, sdof

from shakerproc.recordings import health

N = 50_000
NOISE = 0.005 * 9.80665  # 5 mg, what an input of 24 bit shows with nothing connected


def opened(samples, *, driven=False, **options):
    """Names of the channels that are called open."""
    recording = replace(recording_of(samples, **options), driven=driven)
    return sorted(flag.channel for flag in health(recording) if flag.kind == "open input")


def noise(rng, n=N):
    return NOISE * rng.standard_normal(n)


def measured(kind, rng):
    base = excitation(kind, rng)
    rows = np.array([base, 1.01 * base, sdof(base), sdof(base, 180.0, 0.005)])
    return rows + 0.01 * rng.standard_normal(rows.shape)


@pytest.mark.parametrize("row", range(4))
@pytest.mark.parametrize("kind", ["random", "sweep", "50 Hz", "shock"])
def test_noise_alone_is_found_on_controls_and_responses(kind, row):
    rng = np.random.default_rng(row)
    samples = measured(kind, rng)
    samples[row] = noise(rng)
    assert opened(samples) == [f"ch{row + 1}"]


@pytest.mark.parametrize("bits", [16, 24])
def test_noise_of_a_few_steps_of_the_converter_is_found(bits):
    rng = np.random.default_rng(3)
    samples = measured("random", rng)
    samples[2] = 2.0 * rng.standard_normal(N)
    step = 500.0 / 2 ** (bits - 1)
    samples[2] *= step
    assert opened(np.round(samples / step) * step) == ["ch3"]


@pytest.mark.parametrize("natural", [50.0, 100.0, 60.0])
def test_a_resonance_at_a_multiple_of_the_mains_is_no_open_input(natural):
    rng = np.random.default_rng(4)
    base = excitation("sweep", rng)
    rows = np.array([base, base, sdof(base, natural, 0.002), sdof(base)])
    assert opened(rows + 1e-3 * rng.standard_normal(rows.shape), driven=True) == []


def test_hum_in_every_channel_does_not_hide_an_open_input():
    rng = np.random.default_rng(5)
    samples = measured("random", rng)
    samples[2] = noise(rng)
    samples += 0.2 * np.sin(2.0 * np.pi * 50.0 * np.arange(N) / RATE)
    assert opened(samples) == ["ch3"]


def test_a_node_of_one_mode_still_moves_with_another():
    rng = np.random.default_rng(6)
    samples = measured("random", rng)
    samples[2] = signal.lfilter(*signal.butter(2, [0.3, 0.35], "band"), samples[0])
    assert opened(samples + 0.02 * rng.standard_normal(samples.shape), driven=True) == []


def decay(rng, responses, n=N):
    t = np.arange(n) / RATE
    one = 50.0 * np.exp(-0.02 * 2 * np.pi * 40.0 * t) * np.sin(2 * np.pi * 40.0 * t)
    rows = [noise(rng), *((0.9**i * one + noise(rng)) for i in range(responses))]
    return np.array(rows)


@pytest.mark.parametrize("responses", [1, 2, 3])
def test_a_control_at_rest_while_something_decays_is_no_open_input(responses):
    samples = decay(np.random.default_rng(7), responses)
    assert opened(samples, roles=("control", *["response"] * responses)) == []


def test_a_response_that_does_not_decay_with_the_others_is_found():
    rng = np.random.default_rng(8)
    samples = decay(rng, 3)
    samples[2] = noise(rng)
    assert opened(samples, roles=("control", *["response"] * 3)) == ["ch3"]


def test_without_a_control_the_responses_are_held_against_each_other():
    rng = np.random.default_rng(9)
    samples = measured("random", rng)[1:]
    samples[1] = noise(rng)
    assert opened(samples, roles=("response",) * 3) == ["ch2"]


@pytest.mark.parametrize(("driven", "found"), [(True, ["ch2"]), (False, [])])
def test_of_two_channels_one_is_open_only_if_the_log_says_that_the_table_moves(driven, found):
    rng = np.random.default_rng(10)
    samples = np.array([excitation("random", rng), noise(rng)])
    assert opened(samples, driven=driven, roles=("control", "response")) == found


def test_where_nothing_else_moves_no_response_is_called_open():
    """Dead controls are constant, and that is said: the response measures."""
    samples = np.zeros((3, N))
    samples[2] = excitation("random", np.random.default_rng(12))
    roles = ("control", "control", "response")
    assert opened(samples, driven=True, roles=roles) == []


def test_a_strongly_nonlinear_response_is_no_open_input():
    rng = np.random.default_rng(11)
    samples = measured("random", rng)
    samples[2] = np.abs(samples[2]) ** 3 * np.sign(samples[2]) + 0.5 * samples[2]
    assert opened(samples, driven=True) == []


def test_memory_stays_small_with_many_channels():
    rng = np.random.default_rng(12)
    base = excitation("random", rng, 20_000)
    rows = base + 0.1 * rng.standard_normal((200, 20_000))
    rows[77] = noise(rng, 20_000)
    assert opened(rows, roles=("control", *["response"] * 199)) == ["ch78"]


def test_a_single_blow_between_two_pieces_is_no_open_input():
    rng = np.random.default_rng(13)
    force = np.zeros(N)
    force[30:34] = 200.0
    samples = np.array([force, sdof(force)]) + 0.01 * rng.standard_normal((2, N))
    assert opened(samples, driven=True, roles=("force", "response")) == []
