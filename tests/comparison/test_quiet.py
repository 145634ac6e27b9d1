"""The lead-in at rest."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.comparison import quiet_of
from shakerproc.comparison.noise_sources import end_of, offsets_of

RATE = 2000.0


def channels(start, n=20000, noise=0.01):
    rng = np.random.default_rng(2)
    rows = noise * rng.standard_normal((3, n))
    rows[:, start:] += np.sin(0.3 * np.arange(n - start)) * np.minimum(
        np.arange(n - start) / 200.0, 1.0
    )
    return rows[:2], rows[2:]


def test_rest_ends_just_before_the_shaker_begins():
    quiet = quiet_of(*channels(2400), RATE)
    assert 2000 <= quiet.stop <= 2400
    assert quiet.responses.std() == pytest.approx(0.01, rel=0.1)


@pytest.mark.parametrize("start", [0, 60])
def test_too_short_a_rest_tells_nothing(start):
    assert quiet_of(*channels(start), RATE) is None


def blow(before, n=4000, rate=8192.0):
    """Return the force of a hammer and the ringing it starts, after some samples of rest."""
    rng = np.random.default_rng(6)
    rows = 1e-3 * rng.standard_normal((2, n))
    rows[0, before : before + 12] += np.sin(np.pi * np.arange(12) / 12.0)
    time = np.arange(n - before) / rate
    rows[1, before:] += np.exp(-12.0 * time) * np.sin(2.0 * np.pi * 250.0 * time)
    return rows[:1], rows[1:], rate


@pytest.mark.parametrize("before", [120, 410])
def test_a_recorder_that_waits_for_a_blow_keeps_a_rest(before):
    quiet = quiet_of(*blow(before))
    assert before - 48 <= quiet.stop <= before


def test_what_is_smooth_before_a_blow_is_no_rest():
    """A swing that is slow beside the sample rate stands still for some dozen samples."""
    force, response, rate = blow(410)
    slow = 0.02 * np.cos(2.0 * np.pi * 3.0 * np.arange(response.size) / rate)
    assert quiet_of(force, response + slow, rate) is None


def test_a_drive_that_is_turned_up_slowly_is_no_rest():
    controls, responses = channels(0, noise=0.0)
    rising = np.linspace(0.0, 1.0, controls.shape[1])
    rng = np.random.default_rng(4)
    controls, responses = (rising * rng.standard_normal((n, rising.size)) for n in (2, 1))
    assert quiet_of(controls, responses, RATE) is None


def test_a_recording_that_is_all_noise_has_no_lead_in():
    controls, responses = channels(20000)
    assert quiet_of(controls, responses, RATE) is None


def test_a_recording_of_a_few_samples_has_none():
    assert quiet_of(np.zeros((1, 50)), np.zeros((1, 50)), RATE) is None


def test_dead_silence_is_rest_without_noise():
    quiet = quiet_of(*channels(2400, noise=0.0), RATE)
    assert quiet.stop >= 2000
    assert np.max(np.abs(quiet.responses)) < 0.05


def test_a_decay_ends_where_it_has_died_away():
    time = np.arange(6000) / RATE
    decay = np.exp(-20.0 * time / time[-1]) * np.sin(2.0 * np.pi * 25.0 * time)
    noisy = decay + 1e-4 * np.random.default_rng(4).standard_normal(time.size)
    end = end_of(np.zeros((1, time.size)), noisy[None], RATE)
    # three times the noise, which no rms of a sine reaches below 0.42 of its amplitude
    assert 1e-4 < np.exp(-20.0 * end / time.size) < 3.0 * 1e-4 * np.sqrt(2.0) * 2.0
    assert end_of(np.zeros((1, 2000)), decay[None, :2000], RATE) == 2000


def test_a_decay_that_is_cut_within_a_period_has_no_offset_but_its_own():
    """The integral of A exp(-d t) cos(w t) over a recording is some A / w, not none."""
    times = np.arange(0.0, 45.0, 0.04)
    decay = np.exp(-0.01 * times) * np.cos(2.8 * times + 0.3)
    rows = np.array([decay + 0.5, decay - 2.0])
    found = offsets_of(rows, driven=False)[:, 0]
    assert_allclose(found, [0.5, -2.0], atol=1e-4)
    assert abs(offsets_of(rows, driven=True)[0, 0] - 0.5) > 5e-4
