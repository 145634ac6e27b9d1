"""Peaks: the tallest where they are, and the rule of MATLAB's findpeaks to the letter."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy import signal

from shakerproc.spectra import cross_spectra, find_peaks, psd
from shakerproc.spectra.peaks.finding import local_maxima, saddles, separated, thesis_peaks

FREQUENCY = np.arange(0.0, 100.0)


def test_tallest_comes_first_whatever_its_place():
    """The thesis' trap 30: 38.9 Hz (1.0) before 900 Hz (100)."""
    values = np.full(100, 0.1)
    values[[7, 80]] = [1.0, 100.0]
    found = find_peaks(FREQUENCY, values, (0.0, 99.0))
    assert [peak.bin_frequency for peak in found] == [80.0, 7.0]
    assert find_peaks(FREQUENCY, values, (0.0, 50.0))[0].bin_frequency == 7.0
    assert find_peaks(FREQUENCY, values, (0.0, 99.0), height=1.0)[0].value == 100.0
    assert len(find_peaks(FREQUENCY, values, (0.0, 99.0), height=1.0)) == 1


def test_only_the_tallest_within_the_distance_is_kept():
    values = np.full(100, 0.1)
    values[[20, 30, 50]] = [5.0, 6.0, 4.0]
    found = find_peaks(FREQUENCY, values, (0.0, 99.0), distance=10.0)
    assert [peak.bin_frequency for peak in found] == [30.0, 50.0]


def test_nothing_to_find_gives_nothing():
    assert find_peaks(FREQUENCY, np.ones(100), (0.0, 99.0)) == ()
    assert find_peaks(FREQUENCY, FREQUENCY, (0.0, 99.0)) == ()


def test_masked_values_are_no_neighbours():
    values = np.abs(np.sin(FREQUENCY))
    values[10:20] = np.nan
    assert all(not 9 <= peak.index <= 20 for peak in find_peaks(FREQUENCY, values, (0.0, 99.0)))


def test_parabola_finds_the_top_of_a_bell_exactly():
    """The logarithm of a Gaussian bell is a parabola."""
    values = np.exp(-((FREQUENCY - 41.37) ** 2) / 8.0)
    (peak,) = find_peaks(FREQUENCY, values, (0.0, 99.0), count=1)
    assert_allclose(peak.frequency, 41.37, rtol=1e-12)
    assert peak.bin_frequency == 41.0


def test_a_tone_between_bins_is_found_within_a_tenth_of_a_bin():
    t = np.arange(40_000) / 1000.0
    for tone in (100.0, 100.3, 100.5):
        spectra = cross_spectra(np.sin(2 * np.pi * tone * t)[None], 1000.0, segment=1000)
        (peak,) = find_peaks(spectra.frequency, psd(spectra)[0], (50.0, 200.0), count=1)
        assert abs(peak.frequency - tone) < 0.1
    assert find_peaks(spectra.frequency, psd(spectra)[0], (0.1, 0.2)) == ()


@given(st.lists(st.floats(0.0, 10.0), min_size=3, max_size=60), st.floats(1.0, 8.0))
@settings(max_examples=200, deadline=None)
def test_separation_is_scipys_where_the_two_agree(numbers, distance):
    """scipy keeps peaks `distance` apart, MATLAB removes them; ties are excluded."""
    values = np.array(numbers)
    values = values + np.linspace(0.0, 1e-3, values.size) ** 2
    if np.unique(values).size < values.size:
        return
    wanted, _ = signal.find_peaks(values, distance=np.floor(distance) + 1)
    found = np.sort(separated(local_maxima(values), values, distance))
    assert_array_equal(found, wanted)


def test_flat_top_counts_by_its_first_value_and_ends_do_not_count():
    assert_array_equal(local_maxima(np.array([0.0, 2.0, 2.0, 1.0, 3.0, 3.0])), [1])
    assert_array_equal(local_maxima(np.array([5.0, 2.0, 2.0, 5.0])), [])
    assert_array_equal(local_maxima(np.array([1.0, 2.0])), [])


def test_thesis_looks_at_the_lower_257_of_513_bins():
    """MATLAB rounds 256.5 up (trap 34)."""
    values = np.zeros(513)
    values[[100, 255, 300]] = [1.0, 2.0, 9.0]
    assert_array_equal(thesis_peaks(values, 0.4), [100, 255])
    assert_array_equal(thesis_peaks(values, 0.4, height=1.0), [255])
    values[200] = 1.5
    assert_array_equal(thesis_peaks(values, 0.4), [100, 255])  # 200 hidden by 255


def test_arguments_must_fit():
    with pytest.raises(ValueError, match="the band must rise"):
        find_peaks(FREQUENCY, FREQUENCY, (5.0, 5.0))
    with pytest.raises(ValueError, match="frequencies for"):
        find_peaks(FREQUENCY, np.ones(5), (0.0, 1.0))


@pytest.mark.parametrize("seed", range(5))
def test_saddles_are_those_of_scipy(seed):
    level = np.round(np.random.default_rng(seed).standard_normal(400), 1)  # with equal values
    peaks = signal.argrelmax(level)[0]
    prominence, left, right = signal.peak_prominences(level, peaks)
    found = saddles(level, peaks)
    assert_allclose(level[peaks] - level[found], prominence, rtol=1e-12)
    assert_array_equal(found, np.where(level[left] >= level[right], left, right))
