"""What the thesis' scripts do and what is corrected, on recordings made here."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy import signal

from shakerproc.data import STANDARD_GRAVITY
from shakerproc.errors import SpectrumError
from shakerproc.spectra import Crop, ThesisSettings, thesis_tables

RATE = 5688.9


def recording(run):
    """Rest, `run` samples of noise on five channels that begin and end at 1 g, rest."""
    samples = np.random.default_rng(6).standard_normal((5, run))
    samples[1, [0, -1]] = 1.0
    return np.pad(samples, ((0, 0), (1000, 500))) * STANDARD_GRAVITY


def test_an_odd_crop_is_padded_and_its_sample_rate_stretched():
    """Traps 11 and 12: Fs = fs (n + 1)/n."""
    tables = thesis_tables(recording(20_001), RATE)
    assert (tables.crop["padded"], tables.crop["N"]) == (1, 20_002)
    assert tables.crop["start_in_file_0based"] == 1000
    assert tables.crop["stop_in_file_0based"] == 21_000
    assert_allclose(tables.crop["Fs"], RATE * 20_002 / 20_001, rtol=1e-12)
    even = thesis_tables(recording(20_000), RATE)
    assert (even.crop["padded"], even.crop["N"]) == (0, 20_000)
    assert_allclose(even.crop["Fs"], RATE, rtol=1e-12)


def test_corrected_tables_neither_pad_nor_stretch():
    tables = thesis_tables(recording(20_001), RATE, mode="corrected")
    assert (tables.crop["padded"], tables.crop["N"], tables.crop["Fs"]) == (0, 20_001, RATE)
    axes = [tables.tables[name].index for name in ("psd", "frf", "coherence")]
    assert_allclose(axes[0], axes[2], rtol=1e-12)


@pytest.mark.parametrize("mode", ["thesis", "corrected"])
def test_density_ratio_and_coherence_are_scipys_with_matlabs_window(mode):
    tables = thesis_tables(recording(20_000), RATE, mode=mode).tables
    crop = recording(20_000)[:, 1000:21_000] / STANDARD_GRAVITY
    options = {
        "fs": RATE,
        "window": np.hamming(1024),
        "noverlap": 512,
        "detrend": False,
    }
    _, density = signal.welch(crop, **options)
    assert_allclose(tables["psd"].columns["ch4"], density[3], rtol=1e-10)
    ratio = density[2] / (density[0] + density[1]) * 2.0
    assert_allclose(tables["frf"].columns["ch3"], ratio, rtol=1e-10)
    _, coherent = signal.coherence(crop[4], (crop[0] + crop[1]) / 2.0, **options)
    assert_allclose(tables["coherence"].columns["ch5"], coherent, rtol=1e-8, atol=1e-10)
    assert list(tables["frf"].columns) == ["ch3", "ch4", "ch5"]


def test_excerpt_and_periodogram_are_thinned_as_in_the_reference():
    tables = thesis_tables(recording(20_000), RATE).tables
    rows = tables["notch_signal"].index
    wanted = np.concatenate([
        np.arange(3000),
        np.arange(9999, 12_999),
        np.arange(17_000, 20_000),
    ])
    assert_array_equal(rows, wanted)
    assert_allclose(np.diff(tables["periodogram_every97"].index), 97 * RATE / 20_000)


def test_a_short_run_has_each_sample_once_in_its_excerpt():
    rows = thesis_tables(recording(4000), RATE).tables["notch_signal"].index
    assert_array_equal(rows, np.arange(4000))


def test_peaks_say_which_the_thesis_used_and_which_it_deleted():
    peaks = thesis_tables(recording(20_000), RATE).peaks
    assert {p.channel for p in peaks if p.used_by_thesis and p.quantity == "psd"} == {"ch4"}
    assert all(p.deleted == (p.frequency < 25.0) for p in peaks if p.quantity == "psd")
    assert not any(p.deleted for p in peaks if p.quantity == "frf")


def test_a_silent_response_has_no_peaks_and_no_warning():
    samples = recording(20_000)
    samples[4] = 0.0
    tables = thesis_tables(samples, RATE)
    assert not [p for p in tables.peaks if p.channel == "ch5"]


def test_a_gentle_run_is_refused_with_its_largest_value():
    samples = np.full((5, 5000), 0.3 * STANDARD_GRAVITY)
    with pytest.raises(SpectrumError, match=r"never reached: the largest value is 2\.942 m/s"):
        thesis_tables(samples, RATE)


def test_other_layouts_are_refused():
    with pytest.raises(SpectrumError, match="not 2 channels"):
        thesis_tables(recording(20_000)[:2], RATE)
    with pytest.raises(ValueError, match="mode must be thesis or corrected"):
        thesis_tables(recording(20_000), RATE, mode="exact")
    with pytest.raises(SpectrumError, match="fewer than one segment of 1024"):
        thesis_tables(recording(1000), RATE)


def test_roles_crop_and_segments_are_those_that_are_asked_for():
    samples = recording(20_000)
    tables = thesis_tables(
        samples[[4, 0, 2, 3]],
        RATE,
        crop=Crop(3001, 17_001),
        n_controls=1,
        names=["table", "a", "b", "c"],
        settings=ThesisSettings(segment=500, overlap=100, detrend="mean"),
    )
    crop = samples[:, 3001:17_001] / STANDARD_GRAVITY
    crop -= crop.mean(axis=1, keepdims=True)
    options = {"fs": RATE, "window": np.hamming(500), "noverlap": 100, "detrend": False}
    frequency, density = signal.welch(crop, **options)
    found = tables.tables
    assert_allclose(found["psd"].index, frequency, rtol=1e-12)
    assert list(found["psd"].columns) == ["table", "a", "b", "c"]
    assert_allclose(found["psd"].columns["b"][1:], density[2][1:], rtol=1e-9)
    assert_allclose(found["frf"].columns["a"][1:], (density[0] / density[4])[1:], rtol=1e-9)
    assert found["notch_psd"].index.size == 501
    assert tables.crop["start_in_file_0based"] == 3001
    assert tables.crop["stop_in_file_0based"] == 17_000


def test_bins_of_an_odd_number_of_samples_end_below_half_the_rate():
    odd = thesis_tables(recording(20_001), RATE, mode="corrected", crop=Crop(1000, 21_001))
    index = odd.tables["periodogram_every97"].index
    assert_allclose(index, np.fft.rfftfreq(20_001, 1.0 / RATE)[::97], rtol=1e-12)
