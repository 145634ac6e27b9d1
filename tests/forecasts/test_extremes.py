"""Largest values against the theory of narrow-band Gaussian response."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.forecasts.quantities import largest_in


def narrow_band(generator, frequency, damping_ratio, seconds, rate):
    """Return the response of an oscillator to white noise, by its transfer function."""
    n = round(seconds * rate)
    f = np.fft.rfftfreq(n, 1.0 / rate)
    gain = 1.0 / (frequency**2 - f**2 + 2j * damping_ratio * frequency * f)
    white = generator.standard_normal(f.size) + 1j * generator.standard_normal(f.size)
    samples = np.fft.irfft(gain * white, n)
    return samples / np.std(samples)


def vanmarcke_mean(rate_of_crossings, seconds, bandwidth):
    """Return the mean of the largest size over sigma, by Vanmarcke's law (two-sided)."""
    x = np.linspace(0.5, 8.0, 4000)
    decay = 2.0 * rate_of_crossings * (1.0 - np.exp(-np.sqrt(np.pi / 2.0) * bandwidth**1.2 * x))
    decay /= np.exp(0.5 * x**2) - 1.0
    probability = (1.0 - np.exp(-0.5 * x**2)) * np.exp(-decay * seconds)
    return x[0] + np.trapezoid(1.0 - probability, x)


@pytest.mark.slow
def test_the_largest_of_a_longer_duration_is_that_of_narrow_band_gaussian_response():
    """Ten times the duration that is simulated, against Davenport's and Vanmarcke's mean."""
    generator = np.random.default_rng(7)
    frequency, ratio, rate, seconds, longer = 100.0, 0.02, 1000.0, 60.0, 10.0
    drawn = [
        largest_in(narrow_band(generator, frequency, ratio, seconds, rate), longer,
                   generator.random())
        for _ in range(200)
    ]  # fmt: skip
    crossings = 2.0 * frequency * seconds * longer
    davenport = np.sqrt(2.0 * np.log(crossings))
    davenport += 0.5772 / davenport
    bandwidth = np.sqrt(4.0 * ratio / np.pi)  # of an oscillator in white noise
    vanmarcke = vanmarcke_mean(frequency, seconds * longer, bandwidth)
    assert vanmarcke < davenport
    assert_allclose(np.mean(drawn), vanmarcke, rtol=0.02)
    assert_allclose(np.mean(drawn), davenport, rtol=0.06)


def test_the_largest_of_the_samples_is_kept_where_they_are_all():
    samples = np.r_[np.zeros(1000), -3.0, np.zeros(1000), 2.0]
    centred = np.abs(samples - samples.mean()).max()
    assert_allclose(largest_in(samples), centred)
