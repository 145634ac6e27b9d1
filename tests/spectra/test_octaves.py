"""Octave bands against the tables of IEC 61260-1, tones and noise."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.signal import sosfreqz

from shakerproc.spectra import cross_spectra
from shakerproc.spectra.octaves import (
    octave_bands,
    octave_filter,
    rms_of_density,
    rms_through_filters,
)

RATE = 8192.0

CLASS_1 = (
    (0.0, -0.4, 0.4), (0.125, -0.4, 0.5), (0.25, -0.4, 0.7), (0.375, -0.4, 1.4),
    (0.4999, -0.4, 5.3), (0.5, 1.6, 5.3), (1.0, 16.6, np.inf), (2.0, 40.5, np.inf),
    (3.0, 60.0, np.inf), (4.0, 70.0, np.inf),
)  # fmt: skip
"""Octaves from the middle, least and largest attenuation [dB] (IEC 61260-1:2014, table 1)."""


def test_exact_and_nominal_frequencies_are_those_of_the_standard():
    """IEC 61260-1:2014, annex E, thirds of an octave from 25 to 250 Hz."""
    bands = octave_bands(3, 25.0, 250.0)
    nominal = [25, 31.5, 40, 50, 63, 80, 100, 125, 160, 200, 250]
    exact = [
        25.119, 31.623, 39.811, 50.119, 63.096, 79.433, 100.0, 125.89, 158.49, 199.53, 251.19
    ]  # fmt: skip
    assert bands.nominal.tolist() == nominal
    assert_allclose(bands.middle, exact, rtol=3e-5)
    assert_allclose(bands.upper[:-1], bands.lower[1:], rtol=1e-12)
    assert_allclose(bands.upper / bands.lower, 10**0.1, rtol=1e-12)


def test_octaves_have_their_names():
    bands = octave_bands(1, 1.0, 16_000.0)
    nominal = [1, 2, 4, 8, 16, 31.5, 63, 125, 250, 500, 1000, 2000, 4000, 8000, 16_000]
    assert bands.nominal.tolist() == nominal


def test_bands_of_an_even_fraction_meet_at_the_reference():
    bands = octave_bands(6, 900.0, 1100.0)
    assert np.any(np.isclose(bands.upper, 1000.0, rtol=1e-12))


@pytest.mark.parametrize("fraction", [1, 3, 6, 12])
@pytest.mark.parametrize("nominal", [1.0, 16.0, 100.0, 1000.0, 2000.0])
def test_filters_keep_the_limits_of_class_1(fraction, nominal):
    bands = octave_bands(fraction, 0.95 * nominal, 1.05 * nominal)
    ratio = 10.0**0.3
    for i, middle in enumerate(bands.middle):
        sos = octave_filter(bands, i, RATE)
        for octaves, least, most in CLASS_1:
            share = (ratio ** (0.5 / fraction) - 1.0) / (ratio**0.5 - 1.0)
            high = 1.0 + share * (ratio**octaves - 1.0)
            for frequency in (middle * high, middle / high):
                if frequency < 0.499 * RATE:
                    response = sosfreqz(sos, worN=[frequency], fs=RATE)[1]
                    attenuation = -20.0 * np.log10(np.abs(response[0]))
                    assert least - 1e-6 <= attenuation <= most, (middle, frequency)


@pytest.mark.parametrize("fraction", [1, 3])
def test_a_tone_is_in_its_band_alone(fraction):
    bands = octave_bands(fraction, 31.5, 1000.0)
    i = int(np.argmin(np.abs(bands.middle - 250.0)))
    t = np.arange(round(20 * RATE)) / RATE
    tone = 3.0 * np.sqrt(2.0) * np.sin(2.0 * np.pi * bands.middle[i] * t)
    rms = rms_through_filters([tone[np.newaxis]], RATE, bands)[0]
    assert_allclose(rms[i], 3.0, rtol=5e-3)
    assert np.delete(rms, i).max() < 3.0 * 10 ** (-16.6 / 20.0)


def test_white_noise_has_the_power_of_the_bandwidth():
    rng = np.random.default_rng(2)
    noise = rng.standard_normal((2, round(120 * RATE)))
    bands = octave_bands(3, 63.0, 2000.0)
    wanted = np.sqrt((bands.upper - bands.lower) / (RATE / 2.0))
    spectra = cross_spectra([noise], RATE, segment=8192, window="hann")
    assert_allclose(rms_of_density(spectra, bands)[0] / wanted, 1.0, atol=0.03)
    blocks = np.split(noise, [1, 5000, 300_000], axis=1)
    butterworth = np.sqrt((np.pi / 8.0) / np.sin(np.pi / 8.0))  # noise bandwidth, fourth order
    seen = rms_through_filters(blocks, RATE, bands)[1] / wanted
    assert_allclose(seen[:12], butterworth, atol=0.03)  # below, where the scale is not warped


def test_bands_below_the_bins_are_not_read_from_a_density():
    noise = np.random.default_rng(3).standard_normal((1, 20_000))
    spectra = cross_spectra([noise], RATE, segment=1024)  # bins of 8 Hz
    found = rms_of_density(spectra, octave_bands(3, 20.0, 63.0))
    assert np.isnan(found[0]).tolist() == [True, True, True, False, False, False]


def test_bands_beyond_the_sample_rate_are_refused():
    with pytest.raises(ValueError, match="below 3686"):
        rms_through_filters([np.zeros((1, 10))], RATE, octave_bands(3, 3150.0, 4000.0))
