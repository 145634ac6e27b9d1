"""What holds for any recording: units, order of channels, and what is added to nothing."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from shakerproc.data import Channel, recording_of_arrays
from shakerproc.runs import process_recording
from shakerproc.testlog import Processing, Test

RATE, N = 1024.0, 8192
QUICK = settings(max_examples=8, deadline=None, suppress_health_check=list(HealthCheck))
seeds = st.integers(0, 2**32 - 1)


def shaken(seed, natural=120.0, damping=0.03):
    """Return a control at random [m/s^2] and the response of one mass to it."""
    rng = np.random.default_rng(seed)
    control = rng.standard_normal(N)
    frequency = np.fft.rfftfreq(N, 1.0 / RATE)
    turned = 2.0j * damping * frequency * natural
    gain = (natural**2 + turned) / (natural**2 - frequency**2 + turned)
    response = np.fft.irfft(np.fft.rfft(control) * gain, N)
    return np.array([control, response]) + 1e-3 * rng.standard_normal((2, N))


def processed(samples, roles=("control", "response")):
    channels = [
        Channel(f"ch{i}", "m/s^2", f"ch{i}", "m/s^2", role) for i, role in enumerate(roles)
    ]
    recording = recording_of_arrays("run", channels, samples, RATE)
    return process_recording(recording, Test(id=1, processing=Processing(crop=None)))


@QUICK
@given(seeds, st.floats(-3.0, 3.0).map(lambda power: 10.0**power))
def test_a_louder_recording_has_the_same_peaks_and_responses(seed, times):
    samples = shaken(seed)
    quiet, loud = processed(samples), processed(times * samples)
    np.testing.assert_allclose(loud.averages.psd, times**2 * quiet.averages.psd, rtol=1e-9)
    np.testing.assert_allclose(
        loud.averages.statistics.rms, times * quiet.averages.statistics.rms, rtol=1e-9
    )
    np.testing.assert_allclose(
        loud.averages.against.h1, quiet.averages.against.h1, rtol=1e-6, atol=1e-9
    )
    found = [[p.peak.frequency for p in run.averages.psd_peaks[1]] for run in (quiet, loud)]
    np.testing.assert_allclose(found[1], found[0], rtol=1e-9)


@QUICK
@given(seeds)
def test_the_order_of_channels_changes_nothing_but_the_order(seed):
    control, response = shaken(seed)
    one = processed(np.array([control, response]))
    other = processed(np.array([response, control]), roles=("response", "control"))
    np.testing.assert_array_equal(other.averages.psd, one.averages.psd[::-1])
    np.testing.assert_allclose(other.averages.against.h1, one.averages.against.h1, rtol=1e-12)
    assert other.controls == (1,)


@settings(QUICK, max_examples=3)  # every wiggle of the noise is tried as a mode
@given(seeds, st.integers(2, 4))
def test_a_response_that_is_a_multiple_of_the_control_has_that_gain_everywhere(seed, times):
    control = shaken(seed)[0]
    found = processed(np.array([control, float(times) * control])).averages.against
    np.testing.assert_allclose(found.h1[0][found.valid], times, rtol=1e-9)
    assert np.min(found.coherence[0][found.valid]) == pytest.approx(1.0, abs=1e-9)
