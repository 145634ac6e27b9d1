"""Blows are found, judged and windowed, against pulses and noise that are known."""

import re

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.errors import SpectrumError
from shakerproc.spectra.blows import (
    BlockCut,
    Setup,
    Strikes,
    find_strikes,
    impulse_share,
    incomplete,
    judge,
    usual_length,
    windowed,
)
from shakerproc.spectra.welch.blocks import range_ends

RATE, WIDTH = 1000.0, 10
PULSE = np.sin(np.pi * (np.arange(WIDTH) + 0.5) / WIDTH)


def force_of(blows, n=10_000, noise=0.0, offset=0.0):
    """Force of half-sines at samples, with their heights."""
    force = offset + noise * np.random.default_rng(3).standard_normal(n)
    for at, height in blows:
        force[at : at + WIDTH] += height * PULSE
    return force


def ringing(force):
    """What a sensor with a quick decay makes of a force."""
    decay = np.exp(-np.arange(400) / 60.0) * np.sin(0.5 * np.arange(400))
    return np.convolve(force, decay)[: force.size]


def judged(force, responses, at, length=1000):
    """One blow, 50 samples before its trigger and so many altogether."""
    strikes = find_strikes(force, RATE, None, 0.1)
    at = min(strikes.samples, key=lambda sample: abs(sample - at))
    rows = np.array([force, *responses])
    ends = range_ends(np.split(rows, [300, 1020], axis=1))
    cut = BlockCut(50, length, None, 0.0, RATE)
    names = ("hammer", *(f"a{i}" for i in range(1, len(rows))))
    block = rows[:, at - 50 : at - 50 + length]
    rest = block[:, : cut.quiet].std(axis=1, ddof=1) if cut.quiet > 1 else np.zeros(len(block))
    return judge(block, at, Setup(0, names, ends, strikes, cut, rest))


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_blows_are_found_where_they_are_whatever_offset_and_sign(sign):
    blows = [(1000, 100.0), (4000, 60.0), (7000, 80.0)]
    force = sign * force_of(blows, noise=0.5, offset=7.0)
    found = find_strikes(force, RATE, None, 0.1)
    assert found.sign == sign
    assert found.offset == pytest.approx(7.0 * sign, abs=0.05)
    assert found.noise == pytest.approx(0.5, rel=0.05)
    assert all(0 <= at - start < 2 for at, (start, _) in zip(found.samples, blows, strict=True))


def test_a_trigger_in_newtons_leaves_weaker_blows_out():
    force = force_of([(1000, 100.0), (4000, 40.0), (7000, 80.0)])
    assert len(find_strikes(force, RATE, 50.0, 0.1).samples) == 2


def test_a_rebound_begins_no_blow():
    force = force_of([(1000, 100.0), (1060, 50.0), (4000, 80.0)])
    assert len(find_strikes(force, RATE, None, 0.1).samples) == 2


def test_noise_is_no_blow():
    with pytest.raises(SpectrumError, match=r"does not stand out of its noise of 0\.5"):
        find_strikes(force_of([], noise=0.5), RATE, None, 0.1)


def test_a_trigger_that_is_never_reached_says_what_is():
    with pytest.raises(SpectrumError, match=r"trigger of 500 N, its largest value is 9[89]"):
        find_strikes(force_of([(1000, 100.0)]), RATE, 500.0, 0.1)


@pytest.mark.parametrize(
    ("at", "wanted"),
    [
        ([1000, 4000, 6500, 9000], 2499),
        ([1000, 4000, 4300, 7000, 9900], 2699),  # 300 is a blow too many
        ([1000], 9050),
    ],
)
def test_a_block_ends_before_the_next_blow(at, wanted):
    force = force_of([(k, 100.0) for k in at])
    strikes = find_strikes(force, RATE, None, 0.01)
    assert usual_length(strikes, force.size, 50) == pytest.approx(wanted, abs=1)


def test_a_good_blow_is_kept_with_its_force_and_width():
    force = force_of([(1000, 100.0)], noise=0.1)
    blow = judged(force, [ringing(force)], 1000)
    assert blow.kept
    assert blow.force == pytest.approx(100.0, rel=0.02)
    assert blow.width == pytest.approx(2.0 / 3.0 * WIDTH / RATE, abs=1.1 / RATE)  # of a sine
    assert blow.end_share < 0.01


@pytest.mark.parametrize(
    ("second", "told"),
    [
        ((1060, 30.0), "double hit: 30% of its force 6. ms after it"),
        (
            (1700, 100.0),
            "another blow in the block: (99|100|101)% of its force 70. ms after it",
        ),
        ((970, 8.0), "double hit: 8% of its force 2. ms before it"),
    ],
)
def test_a_second_pulse_in_the_block_rejects_it(second, told):
    force = force_of([(1000, 100.0), second], noise=0.1)
    blow = judged(force, [ringing(force)], 1000)
    assert re.search(told, blow.reason)


def test_ringing_of_the_hammer_below_a_twentieth_is_no_second_hit():
    force = force_of([(1000, 100.0), (1030, 4.0)], noise=0.1)
    assert judged(force, [ringing(force)], 1000).kept


def test_samples_at_the_end_of_the_range_reject_it_on_either_side():
    force = force_of([(1000, 100.0), (5000, 20.0)], noise=0.1)
    response = np.maximum(ringing(force), -110.0)
    assert judged(force, [response], 1000).reason.startswith("overload of a1")
    assert judged(force, [response], 5000).kept
    assert judged(np.minimum(force, 85.0), [ringing(force)], 1000).reason.startswith(
        "overload of hammer"
    )


def test_a_coarsely_quantised_response_is_no_overload():
    force = force_of([(1000, 100.0)], noise=0.1)
    slow = np.convolve(force, np.exp(-np.arange(2000) / 900) * np.sin(0.02 * np.arange(2000)))
    response = np.round(slow[: force.size] / 10.0) * 10.0
    assert "overload" not in judged(force, [response], 1000).reason


def test_a_blow_that_nothing_answers_is_rejected_but_one_sensor_is_enough():
    force = force_of([(1000, 100.0)], noise=0.1)
    noise = np.random.default_rng(5).standard_normal(force.size)
    assert judged(force, [noise], 1000).reason.startswith("no response")
    assert judged(force, [noise, ringing(force)], 1000).kept
    noise[1600:] += 100.0  # something else, much later
    assert judged(force, [noise], 1000).reason.startswith("no response")


def test_what_is_left_at_the_end_is_that_of_the_decay():
    force = force_of([(1000, 100.0)])
    decay = np.exp(-np.arange(5000) / 500.0) * np.cos(0.7 * np.arange(5000))
    blow = judged(force, [np.convolve(force, decay)[: force.size]], 1000)
    assert blow.end_share == pytest.approx(np.exp(-950.0 / 500.0) / np.sqrt(2.0), rel=0.1)


def test_a_block_beyond_the_recording_says_so():
    cut = BlockCut(50, 1000, None, 0.0, RATE)
    assert incomplete(1000, cut, 10_000) == ""
    assert "begins 0.02 s before it, pretrigger is 0.05 s" in incomplete(20, cut, 10_000)
    assert "ends 0.5 s after it" in incomplete(9500, cut, 10_000)


def test_windows_take_offsets_away_and_the_force_outside_the_pulse():
    cut = BlockCut(50, 1000, 20, 5.0, RATE)
    block = np.array([force_of([(45, 100.0)], 1000, 0.1, 3.0), np.full(1000, -2.0)])
    names, ends = ("hammer", "a1"), np.full((2, 2), np.nan)
    found = windowed(
        block,
        Setup(0, names, ends, Strikes((50,), 1, 10.0, 0.1, 3.0), cut, np.zeros(len(names))),
    )
    assert_allclose(found[1], 0.0, atol=1e-12)
    assert (found[0, :30] == 0.0).all()
    assert (found[0, 70:] == 0.0).all()
    assert_allclose(found[0, 45:55], 100.0 * PULSE, atol=1.0)
    assert_allclose(cut.window[[0, 200]], [1.0, np.exp(-1.0)])


def test_a_blow_is_brief_and_its_answer_is_not():
    force = force_of([(100, 100.0)], 1000)
    assert impulse_share(force) > 0.99
    slow = np.exp(-np.arange(1000) / 300.0) * np.sin(0.5 * np.arange(1000))
    assert impulse_share(slow) < 0.2
