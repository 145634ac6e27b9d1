"""Bounds, levels, masks and statistics against their definitions and simulated experiments."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy import stats

from shakerproc.errors import SpectrumError
from shakerproc.spectra import cross_spectra, psd
from shakerproc.spectra.responses import (
    driven,
    excited,
    gain_random_error,
    masked,
    psd_bounds,
    response_bounds,
)
from shakerproc.spectra.welch.blocks import statistics
from shakerproc.spectra.welch.cross import control_imbalance, cumulative_rms, rms_in_band

RATE = 1000.0


def white(shape, seed=5):
    return np.random.default_rng(seed).standard_normal(shape)


@pytest.mark.parametrize("overlap", [0, 128, 192])
def test_psd_bounds_cover_the_truth_as_often_as_they_say(overlap):
    """400 recordings of white noise, each of a few averages; the truth is 2/fs."""
    inside, total = 0, 0
    for samples in white((400, 1, 2560)):
        spectra = cross_spectra(samples, RATE, segment=256, overlap=overlap)
        bounds = psd_bounds(spectra)
        truth = np.full(129, 2.0 / RATE)
        truth[[0, -1]] /= 2.0
        hits = (bounds.low <= truth) & (truth <= bounds.high)
        inside, total = inside + hits.sum(), total + hits.size
    assert 0.93 <= inside / total <= 0.97


@pytest.mark.parametrize("overlap", [0, 128])
def test_response_bounds_cover_the_truth_as_often_as_they_say(overlap):
    """300 recordings through a gain of 2 with as much noise; the truth has no phase."""
    rng = np.random.default_rng(8)
    gain, phase, total = 0, 0, 0
    for _ in range(300):
        x = rng.standard_normal(2560)
        y = 2.0 * x + 2.0 * rng.standard_normal(2560)
        spectra = cross_spectra(np.array([x, y]), RATE, segment=256, overlap=overlap)
        bounds, half = response_bounds(spectra, [0], [1])
        angle = np.angle(spectra.matrix[0, 1])[1:-1]
        gain += np.sum((bounds.low <= 2.0)[0, 1:-1] & (bounds.high >= 2.0)[0, 1:-1])
        phase += np.sum(np.abs(angle) <= half[0, 1:-1])
        total += angle.size
    assert 0.93 <= gain / total <= 0.97
    assert 0.93 <= phase / total <= 0.97


def test_gain_error_refuses_what_is_no_coherence():
    with pytest.raises(ValueError, match=r"coherence must lie in 0 to 1, not 1\.2"):
        gain_random_error(np.array([0.5, 1.2]), 10)
    with pytest.raises(ValueError, match="n_averages must be at least 1"):
        gain_random_error(np.array([0.5]), 0.5)
    assert gain_random_error(np.array([0.5]), 1)[0] == np.inf  # one average tells no scatter
    assert gain_random_error(np.array([0.0]), 10)[0] == np.inf
    with pytest.raises(ValueError, match="confidence must lie between 0 and 1"):
        psd_bounds(cross_spectra(white((1, 4096)), RATE), 95.0)


def test_whole_band_holds_the_rms_of_the_samples():
    samples = white((3, 40 * 256))
    spectra = cross_spectra(samples, RATE, segment=256, overlap=0, window="rectangular")
    rms = np.sqrt(np.mean(samples**2, axis=1))
    assert_allclose(rms_in_band(spectra), rms, rtol=1e-12)
    assert_allclose(cumulative_rms(spectra)[:, -1], rms, rtol=1e-12)


@given(middle=st.floats(0.5, 499.5))
@settings(max_examples=30, deadline=None)
def test_power_of_two_bands_adds_up(middle):
    spectra = cross_spectra(white((2, 8192)), RATE, segment=128)
    below = rms_in_band(spectra, (0.0, middle)) ** 2
    above = rms_in_band(spectra, (middle, RATE / 2)) ** 2
    assert_allclose(below + above, rms_in_band(spectra) ** 2, rtol=1e-12)


def test_a_tone_has_its_rms_in_a_narrow_band():
    t = np.arange(50_000) / RATE
    spectra = cross_spectra(np.sin(2 * np.pi * 100.3 * t)[None], RATE)
    assert_allclose(rms_in_band(spectra, (90.0, 110.0)), np.sqrt(0.5), rtol=2e-3)
    assert rms_in_band(spectra, (200.0, 300.0))[0] < 0.01  # sidelobes of -43 dB


def test_band_must_rise():
    with pytest.raises(ValueError, match="the band must rise, not run from 9 to 5 Hz"):
        rms_in_band(cross_spectra(white((1, 2048)), RATE), (9.0, 5.0))


def test_equal_controls_are_balanced_and_one_is_never_out_of_balance():
    x = white(20_000)
    near = x + 0.02 * white(20_000, 6)
    spectra = cross_spectra(np.array([x, near]), RATE)
    imbalance = control_imbalance(spectra, [0, 1], (5.0, 400.0))
    assert imbalance.warning is None
    assert_allclose(imbalance.overall, 0.02, rtol=0.1)
    assert control_imbalance(spectra, [0], (5.0, 400.0)) is None


def test_an_opposed_motion_of_the_controls_is_named_with_its_frequency():
    t = np.arange(40_000) / RATE
    x, tone = white(40_000), 0.3 * np.sin(2 * np.pi * 210.0 * t)
    spectra = cross_spectra(np.array([x + tone, x - tone]), RATE)
    imbalance = control_imbalance(spectra, [0, 1], (5.0, 400.0))
    assert abs(imbalance.worst_frequency - 210.0) < 3.0
    assert "doubtful" in imbalance.warning


def test_masks_keep_the_excited_band_without_notches():
    frequency = np.arange(0.0, 501.0, 5.0)
    keep = excited(frequency, (20.0, 400.0), notches=[50.0], half_width=1.0)
    assert set(frequency[~keep]) == {0, 5, 10, 15, *range(35, 70, 5), *range(405, 505, 5)}
    values = masked(np.ones((2, 101)), keep)
    assert np.isnan(values).sum() == 2 * np.sum(~keep)


def test_only_what_the_input_reaches_within_the_band_is_driven():
    frequency, density = np.arange(6.0), np.array([9e9, 1.0, 0.9e-4, 2e-4, 0.0, 9e9])
    found = driven(frequency, density, (1.0, 4.0))
    assert found.tolist() == [False, True, False, True, False, False]
    assert not driven(frequency, 0.0 * density, (1.0, 4.0)).any()


@given(cuts=st.lists(st.integers(0, 5000), max_size=6), shift=st.floats(-100, 100))
@settings(max_examples=30, deadline=None)
def test_statistics_are_scipys_however_the_samples_come(cuts, shift):
    samples = np.random.default_rng(2).gamma(1.5, size=(2, 5000)) + shift
    ours = statistics(np.split(samples, sorted(cuts), axis=1))
    assert ours.n_samples == 5000
    assert_allclose(ours.mean, samples.mean(axis=1), rtol=1e-12, atol=1e-12)
    assert_allclose(ours.standard_deviation, samples.std(axis=1), rtol=1e-10)
    assert_allclose(ours.rms, np.sqrt(np.mean(samples**2, axis=1)), rtol=1e-12)
    assert_allclose(ours.kurtosis, stats.kurtosis(samples, axis=1, fisher=False), rtol=1e-9)
    assert_allclose(ours.minimum, samples.min(axis=1))
    assert_allclose(ours.maximum, samples.max(axis=1))
    assert_allclose(ours.crest_factor, np.abs(samples).max(axis=1) / ours.rms, rtol=1e-12)


def test_a_sine_has_the_textbook_shape():
    t = np.arange(1000) / 1000.0
    sine = statistics(3.0 * np.sin(2 * np.pi * 5 * t)[None])
    assert_allclose(sine.crest_factor, np.sqrt(2.0), rtol=1e-9)
    assert_allclose(sine.kurtosis, 1.5, rtol=1e-9)


def test_silence_has_no_crest_factor_and_nothing_has_no_statistics():
    silence = statistics(np.zeros((1, 10)))
    assert np.isnan(silence.crest_factor[0])
    assert np.isnan(silence.kurtosis[0])
    with pytest.raises(SpectrumError, match="no sample"):
        statistics(np.zeros((1, 0)))


def test_a_white_density_is_flat_at_twice_its_variance_over_the_rate():
    density = psd(cross_spectra(white((1, 400_000)), RATE))[0, 2:-2]
    assert_allclose(density.mean(), 2.0 / RATE, rtol=0.01)
