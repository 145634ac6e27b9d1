"""The notch filters against scipy's design and filtfilt, and against what they are for."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import signal

from shakerproc.errors import SpectrumError
from shakerproc.spectra import notch, periodogram, thesis_notch
from shakerproc.spectra.tones.notch_filters import (
    butterworth_band_stop,
    centred_notch,
    filter_both_ways,
)

RATE = 5688.9


def noise(n_samples=20_000):
    return np.random.default_rng(7).standard_normal((2, n_samples)) + 0.4


@pytest.mark.parametrize("band", [(49.0, 51.0), (4.0, 7.0), (1000.0, 2500.0)])
def test_butterworth_is_scipys(band):
    above, below = butterworth_band_stop(*band, RATE)
    wanted_above, wanted_below = signal.butter(1, band, "bandstop", fs=RATE)
    assert_allclose(above, wanted_above, rtol=1e-12)
    assert_allclose(below, wanted_below, rtol=1e-12)


def test_thesis_filter_is_scipys_filtfilt_with_six_samples():
    design = signal.butter(1, [49.0, 51.0], "bandstop", fs=RATE)
    wanted = signal.filtfilt(*design, noise(), padlen=6)
    assert_allclose(thesis_notch(noise(), RATE), wanted, rtol=0, atol=1e-11)


def test_thesis_null_lies_below_50_hertz():
    """Trap 37: at the warped geometric mean, 49.990 Hz."""
    design = butterworth_band_stop(49.0, 51.0, RATE)
    frequency, response = signal.freqz(*design, worN=np.linspace(49.9, 50.1, 2001), fs=RATE)
    assert abs(frequency[np.argmin(np.abs(response))] - 49.990) < 0.0005


@pytest.mark.parametrize(("frequency", "width"), [(50.0, 2.0), (700.0, 40.0)])
def test_centred_notch_has_its_null_and_width_where_it_was_asked(frequency, width):
    design = centred_notch(frequency, width, RATE)
    edges = signal.freqz(*design, worN=[frequency], fs=RATE)[1]
    assert np.abs(edges[0]) < 1e-9
    grid = np.linspace(frequency - width, frequency + width, 40_001)
    twice = np.abs(signal.freqz(*design, worN=grid, fs=RATE)[1]) ** 4  # power after two passes
    lowered = grid[twice <= 0.5]
    assert_allclose(lowered[-1] - lowered[0], width, rtol=1e-3)


def test_tone_and_harmonics_go_and_the_rest_stays():
    t = np.arange(int(20 * RATE)) / RATE
    other = 0.2 * np.sin(2 * np.pi * 333.0 * t)
    tones = sum(a * np.sin(2 * np.pi * 50.0 * k * t + k) for k, a in ((1, 3.0), (3, 1.0)))
    result = notch((other + tones)[None], RATE, 50.0, harmonics=(1, 2, 3))
    kept = other[result.start : result.stop]
    assert result.samples.shape == (1, kept.size)
    assert_allclose(result.samples[0], kept, atol=0.003)
    only_first = notch((other + tones)[None], RATE, 50.0)
    assert np.abs(only_first.samples[0] - kept).max() > 0.9


def test_trim_is_the_users():
    assert notch(noise(), RATE, 50.0, trim=0.0).samples.shape == (2, 20_000)
    cut = notch(noise(), RATE, 50.0, trim=1.0)
    assert (cut.start, cut.stop) == (5689, 20_000 - 5689)


def test_harmonics_beyond_the_samples_are_left_alone():
    samples = noise()
    one = notch(samples, RATE, 2000.0, harmonics=(1, 2), trim=0.1)
    assert_allclose(one.samples, notch(samples, RATE, 2000.0, trim=0.1).samples)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: thesis_notch(noise(6), RATE), "needs more than 6 samples, not 6"),
        (lambda: thesis_notch(noise(), 90.0), "does not lie between 0 and half the sample"),
        (lambda: notch(noise(5000), RATE, 50.0), "leaves nothing of 0.879 s: take a wider"),
        (
            lambda: notch(noise(), RATE, 0.5, width=2.0, trim=0.1),
            "from -0.5 to 1.5 Hz does not lie",
        ),
        (lambda: filter_both_ways(noise(5), np.ones(3), np.ones(3), pad=9), "more than 9"),
    ],
)
def test_what_cannot_be_filtered_is_refused(call, message):
    with pytest.raises(SpectrumError, match=message):
        call()


def test_periodogram_is_scipys():
    for n_samples in (5000, 5001):
        wanted = signal.periodogram(noise(n_samples), RATE, detrend=False)
        frequency, density = periodogram(noise(n_samples), RATE)
        assert_allclose(frequency, wanted[0], rtol=1e-12)
        assert_allclose(density, wanted[1], rtol=1e-9, atol=1e-18)
