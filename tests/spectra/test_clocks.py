"""The clock of a second recorder, against sums of sines that are known at every time."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.errors import SpectrumError
from shakerproc.interpolation import interpolated
from shakerproc.spectra.clocks import clock_against

RNG = np.random.default_rng(11)
LINES = RNG.uniform(5.0, 180.0, 150)
PHASES = RNG.uniform(0.0, 2.0 * np.pi, 150)


def motion(time):
    out = np.zeros(time.size)
    for frequency, phase in zip(LINES, PHASES, strict=True):
        out += np.cos(2.0 * np.pi * frequency * time + phase)
    return out


@pytest.mark.parametrize(
    ("offset", "drift", "rate"),
    [(0.0, 0.0, 1000.0), (1.2345, 80e-6, 1000.0), (-2.5, -120e-6, 800.0), (0.3, 50e-6, 2048.0)],
)
def test_offset_and_drift_are_found_to_a_hundredth_of_a_sample(offset, drift, rate):
    reference = motion(np.arange(40_000) / 1000.0)
    other = -0.3 * motion(np.arange(int(38 * rate)) / rate / (1.0 + drift) + offset)
    other += 0.5 * np.random.default_rng(2).standard_normal(other.size)
    found = clock_against(reference, 1000.0, other, rate)
    assert found.offset == pytest.approx(offset, abs=3e-5)
    assert found.drift == pytest.approx(drift, abs=2e-6)
    assert found.correlation > 0.9


def test_of_a_motion_that_repeats_the_smallest_offset_is_taken():
    """Lines at multiples of 0.1 Hz: every 10 s it is the same."""
    lines, phases = np.round(LINES, 1), PHASES

    def periodic(time):
        return np.cos(2.0 * np.pi * np.outer(time, lines) + phases).sum(axis=1)

    reference = periodic(np.arange(40_000) / 1000.0)
    other = periodic(np.arange(36_000) / 1000.0 / (1.0 + 50e-6) + 1.3)
    found = clock_against(reference, 1000.0, other, 1000.0)
    assert found.offset == pytest.approx(1.3, abs=1e-4)
    assert found.drift == pytest.approx(50e-6, abs=2e-6)


def test_samples_between_samples_are_those_of_the_signal():
    times = np.arange(100, 5000) / 700.0 + 0.00031
    samples = motion(np.arange(10_000) / 1000.0)
    found = interpolated(lambda a, b: samples[a:b], samples.size, 1000.0, times, 700.0)
    inside = (times > 0.1) & (times < 9.9)
    assert_allclose(found[inside], motion(times[inside]), atol=2e-3 * np.std(samples))


def test_signals_of_different_motions_have_no_common_clock():
    noise = np.random.default_rng(3).standard_normal((2, 30_000))
    with pytest.raises(SpectrumError, match=r"correlate to 0\.\d+ at most"):
        clock_against(noise[0], 1000.0, noise[1], 1000.0)
