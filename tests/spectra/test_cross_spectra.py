"""The engine against scipy, and against itself however the samples are cut up."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy import signal

from shakerproc.errors import SpectrumError
from shakerproc.spectra import cross_spectra, psd, window_samples
from shakerproc.spectra.welch import engine

RATE = 5688.9
SCIPY_DETREND = {"none": False, "segment mean": "constant"}


def noise(n_channels: int, n_samples: int, seed: int = 1) -> np.ndarray:
    return np.random.default_rng(seed).standard_normal((n_channels, n_samples)) + 0.3


def scipy_matrix(samples, segment, overlap, n_fft, detrend):
    """The same matrix by one call of scipy for each pair of channels."""
    options = {
        "fs": RATE,
        "window": signal.get_window("hamming", segment, fftbins=False),
        "nperseg": segment,
        "noverlap": overlap,
        "nfft": n_fft,
        "detrend": detrend,
    }
    return np.array([[signal.csd(a, b, **options)[1] for b in samples] for a in samples])


@pytest.mark.parametrize("detrend", ["none", "segment mean"])
@pytest.mark.parametrize(
    ("segment", "overlap", "n_fft"),
    [(1024, 512, 1024), (1000, 300, 1024), (333, 0, 333), (9000, 8000, 9000), (40, 0, 40)],
)
def test_equals_scipy(segment, overlap, n_fft, detrend):
    samples = noise(3, 30_011)
    ours = cross_spectra(
        samples, RATE, segment=segment, overlap=overlap, n_fft=n_fft, detrend=detrend
    )
    theirs = scipy_matrix(samples, segment, overlap, n_fft, SCIPY_DETREND[detrend])
    assert_allclose(ours.matrix, theirs, rtol=1e-13, atol=1e-13 * np.abs(theirs).max())
    density = np.einsum("iif->if", theirs).real
    assert_allclose(psd(ours), density, rtol=1e-13)


@pytest.mark.parametrize("detrend", ["none", "mean", "segment mean"])
def test_the_compiled_loops_of_long_recordings_equal_numpy(detrend, monkeypatch):
    samples = noise(4, 40_011)
    options = {"segment": 200, "overlap": 77, "n_fft": 256, "detrend": detrend}
    by_numpy = cross_spectra(samples, RATE, **options)
    monkeypatch.setattr(engine, "GROUP_VALUES", 2**14)
    for before in (0, 2**16):  # from the start, and after some groups
        monkeypatch.setattr(engine, "COMPILED_AFTER", before)
        compiled = cross_spectra(samples, RATE, **options)
        limit = 1e-13 * np.abs(by_numpy.matrix).max()
        assert_allclose(compiled.matrix, by_numpy.matrix, rtol=1e-13, atol=limit)
        assert_allclose(compiled.lit_segments, by_numpy.lit_segments, rtol=1e-12)


@pytest.mark.parametrize("name", ["hann", "hamming", "blackman", "flat top", "rectangular"])
@pytest.mark.parametrize("length", [2, 7, 1024])
def test_windows_are_scipys(name, length):
    theirs = {"flat top": "flattop", "rectangular": "boxcar"}.get(name, name)
    symmetric = signal.get_window(theirs, length, fftbins=False)
    assert_allclose(window_samples(name, length), symmetric, rtol=0, atol=1e-15)
    periodic = signal.get_window(theirs, length, fftbins=True)
    assert_allclose(window_samples(f"periodic {name}", length), periodic, rtol=0, atol=1e-15)


@settings(max_examples=60, deadline=None)
@given(
    cuts=st.lists(st.integers(0, 9001), max_size=12),
    segment=st.integers(2, 700),
    share=st.floats(0.0, 0.999),
    detrend=st.sampled_from(["none", "mean", "segment mean"]),
)
def test_does_not_depend_on_the_blocks(cuts, segment, share, detrend):
    samples = noise(2, 9001)
    options = {"segment": segment, "overlap": int(share * segment), "detrend": detrend}
    whole = cross_spectra(samples, RATE, **options)
    blocks = np.split(samples, sorted(cuts), axis=1)
    assert_array_equal(cross_spectra(blocks, RATE, **options).matrix, whole.matrix)
    other_order = cross_spectra(np.asfortranarray(samples), RATE, **options)
    assert_array_equal(other_order.matrix, whole.matrix)


@given(offset=st.floats(-1e4, 1e4))
@settings(max_examples=20, deadline=None)
def test_mean_of_the_crop_is_removed_once(offset):
    samples = noise(2, 5003)
    centred = samples - samples.mean(axis=1, keepdims=True)
    ours = cross_spectra(samples + offset, RATE, detrend="mean", segment=256).matrix
    wanted = cross_spectra(centred, RATE, segment=256).matrix
    assert_allclose(ours, wanted, rtol=0, atol=1e-11 * np.abs(wanted).max())


def test_power_in_time_is_power_in_frequency():
    """Parseval: with a rectangular window, no overlap and whole segments nothing is lost."""
    samples = noise(4, 64 * 512)
    spectra = cross_spectra(samples, RATE, segment=512, overlap=0, window="rectangular")
    in_time = samples @ samples.T / samples.shape[1]
    assert_allclose(spectra.matrix.sum(axis=2).real * spectra.bin_width, in_time, rtol=1e-12)


def test_matrix_is_hermitian_and_not_negative():
    matrix = cross_spectra(noise(4, 9999), RATE, segment=128).matrix
    assert_array_equal(matrix, matrix.conj().swapaxes(0, 1))
    assert np.linalg.eigvalsh(np.moveaxis(matrix, -1, 0)).min() > 0.0


def test_one_array_of_whole_numbers_is_read_as_it_stands():
    counts = np.arange(8000, dtype=np.int16).reshape(2, 4000) % 97
    assert_array_equal(
        cross_spectra(counts, RATE, segment=100).matrix,
        cross_spectra(counts.astype(float), RATE, segment=100).matrix,
    )


def test_too_few_samples_are_refused():
    with pytest.raises(SpectrumError, match="600 samples are fewer than one segment of 1024"):
        cross_spectra(noise(2, 600), RATE)
    with pytest.raises(SpectrumError, match="0 samples are fewer"):
        cross_spectra([], RATE)


def test_a_sample_that_is_not_a_number_is_refused():
    samples = noise(3, 5000)
    samples[1, 3000] = np.nan
    with pytest.raises(
        SpectrumError, match="channel 2 of 3 holds samples that are not numbers"
    ):
        cross_spectra(samples, RATE)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"overlap": 1024}, "overlap must be 0 to 1023"),
        ({"n_fft": 512}, "n_fft must be at least the segment"),
        ({"window": "hammock"}, "window must be one of rectangular, hann"),
        ({"window": np.ones(5)}, "window must hold 1024 weights"),
        ({"segment": 1}, "segment must be at least 2"),
        ({"detrend": "linear"}, "detrend must be none, mean or segment mean"),
    ],
)
def test_options_that_do_not_fit_are_refused(options, message):
    with pytest.raises(ValueError, match=message):
        cross_spectra(noise(1, 5000), RATE, **options)


def test_blocks_must_agree_in_their_channels():
    with pytest.raises(ValueError, match="a block has 3 channels, not 2"):
        cross_spectra([noise(2, 100), noise(3, 100)], RATE)
    with pytest.raises(ValueError, match=r"a block must be \(n_channels, n\)"):
        cross_spectra([np.zeros(100)], RATE)


def test_lit_segments_tell_a_tone_from_noise_and_from_a_sweep():
    t = np.arange(200_000) / RATE
    tone = np.sin(2 * np.pi * 1000.0 * t)
    sweep = np.sin(2 * np.pi * (100.0 * t + 25.0 * t**2))  # 50 Hz/s, 5 bins a hop
    spectra = cross_spectra(np.array([tone, noise(1, t.size)[0], sweep]), RATE)
    at = int(np.argmin(np.abs(spectra.frequency - 1000.0)))
    assert_allclose(spectra.lit_segments[0, at], spectra.n_segments, rtol=1e-3)
    middle = spectra.lit_segments[1, 10:-10].mean()
    assert_allclose(middle, spectra.n_segments / 2.0, rtol=0.05)
    assert spectra.lit_segments[2, at] < 5.0


def test_effective_averages_of_half_overlapping_hann_are_the_textbook_ones():
    """Welch's own example: half overlap loses little (correlation 1/6 of neighbours)."""
    spectra = cross_spectra(noise(1, 512 * 101), RATE, window="periodic hann")
    assert spectra.n_segments == 100
    assert_allclose(spectra.effective_averages, 100 / (1 + 2 * 0.99 / 36), rtol=1e-4)
    assert_allclose(spectra.degrees_of_freedom, 2 * spectra.effective_averages)
    assert_allclose(spectra.resolution, 1.5 * RATE / 1024, rtol=1e-12)
    assert_allclose(spectra.bin_width, RATE / 1024)
