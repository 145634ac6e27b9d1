"""Response functions against closed forms, other people's results and simulated noise."""

import numpy as np
import pytest
from nptdms import TdmsFile
from numpy.testing import assert_allclose
from scipy import io, signal

from shakerproc.spectra import (
    CrossSpectra,
    coherence,
    cross_spectra,
    find_peaks,
    h1,
    h2,
    hv,
    multiple_coherence,
    psd,
    psd_ratio,
)

RATE = 2000.0


def filtered_noise(n_samples=400_000, seed=3):
    """Return white noise, a lightly damped filter's answer, and the filter's own response."""
    x = np.random.default_rng(seed).standard_normal(n_samples)
    coefficients = signal.iirpeak(210.0, 8.0, fs=RATE)
    return x, signal.lfilter(*coefficients, x), coefficients


def test_all_three_estimators_find_a_linear_filter():
    x, y, coefficients = filtered_noise()
    spectra = cross_spectra(np.array([x, y]), RATE, segment=4096)
    _, wanted = signal.freqz(*coefficients, worN=spectra.frequency, fs=RATE)
    near = slice(300, 600)
    for estimate in (h1, h2, hv):
        found = estimate(spectra, [0], [1])[0]
        assert_allclose(found[near], wanted[near], atol=0.02)
    assert_allclose(psd_ratio(spectra, [0], [1])[0][near], np.abs(wanted[near]) ** 2, atol=0.03)


def test_noise_on_the_response_lowers_coherence_and_leaves_h1_alone():
    x, y, _ = filtered_noise()
    noisy = y + 0.5 * np.random.default_rng(4).standard_normal(y.size)
    spectra = cross_spectra(np.array([x, y, noisy]), RATE, segment=2048)
    clean, dirty = h1(spectra, [0], [1, 2])[:, 200:230]
    assert_allclose(np.abs(dirty), np.abs(clean), rtol=0.1)
    without = psd(spectra)[1, 200:230]
    wanted = without / (without + 0.25 * 2.0 / RATE)  # the density of noise of 0.5 rms
    found = coherence(spectra, [0], [2])[0, 200:230]
    assert_allclose(found.mean(), wanted.mean(), atol=0.02)
    assert np.all(np.abs(h2(spectra, [0], [2])) >= np.abs(h1(spectra, [0], [2])))


def test_hv_is_the_geometric_mean_of_h1_and_h2():
    x, y, _ = filtered_noise(40_000)
    spectra = cross_spectra(np.array([x, y + x[::-1]]), RATE)
    one, two, vector = (f(spectra, [0], [1]) for f in (h1, h2, hv))
    assert_allclose(np.abs(vector), np.sqrt(np.abs(one * two)), rtol=1e-12)
    assert_allclose(np.angle(vector), np.angle(one), atol=1e-12)


def test_the_mean_control_is_the_mean_of_the_signals():
    x, y, _ = filtered_noise(40_000)
    other = x + 0.3 * np.random.default_rng(9).standard_normal(x.size)
    pair = cross_spectra(np.array([x, other, y]), RATE)
    mean = cross_spectra(np.array([(x + other) / 2.0, y]), RATE)
    assert_allclose(h1(pair, [0, 1], [2]), h1(mean, [0], [1]), rtol=1e-10)
    assert_allclose(coherence(pair, [0, 1], [2]), coherence(mean, [0], [1]), rtol=1e-9)


def test_two_inputs_explain_what_neither_does_alone():
    rng = np.random.default_rng(10)
    a, b = rng.standard_normal((2, 200_000))
    y = a + np.roll(b, 5)
    spectra = cross_spectra(np.array([a, b + 0.5 * a, y]), RATE)
    together = multiple_coherence(spectra, [0, 1], [2])[0, 5:-5]
    assert together.min() > 0.97  # the roll leaks 5 of 1024 samples
    assert coherence(spectra, [0], [2])[0, 5:-5].mean() < 0.6


def test_controls_that_are_one_count_as_one():
    x, y, _ = filtered_noise(40_000)
    spectra = cross_spectra(np.array([x, x, y]), RATE)
    assert_allclose(
        multiple_coherence(spectra, [0, 1], [2]), coherence(spectra, [0], [2]), rtol=1e-9
    )


def test_a_silent_control_gives_no_number_rather_than_infinity():
    spectra = cross_spectra(np.array([np.zeros(4096), np.ones(4096)]), RATE)
    assert np.isnan(h1(spectra, [0], [1])).all()
    assert np.isnan(coherence(spectra, [0], [1])).all()
    with pytest.raises(ValueError, match="at least one control"):
        h1(spectra, [], [1])


@pytest.mark.shared
def test_transfer_functions_of_cambridge_are_reproduced(shared):
    """cued_gc4: published time series and the transfer functions their authors computed."""
    time = np.load(shared / "data" / "cued_gc4" / "time_data.npz")
    stored = np.load(shared / "data" / "cued_gc4" / "tf_data.npz")
    spectra = cross_spectra(
        time["y"].T,
        1.0 / (time["t"][1] - time["t"][0]),
        segment=12728,
        overlap=6364,
        window="periodic hann",
        detrend="segment mean",
    )
    assert_allclose(spectra.frequency, stored["f"], rtol=1e-12)
    found = h1(spectra, [0], [1, 2, 3, 4]).T
    assert_allclose(found, stored["y"], rtol=1e-10, atol=1e-10)


def analyser_spectra(data) -> CrossSpectra:
    """The analyser's own averages, as the matrix that our functions start from."""
    one, two = data["MagSpec_chan_1"].ravel(), data["MagSpec_chan_2"].ravel()
    cross = data["Hf_Cross_Spec_chan_2"].ravel()
    matrix = np.array([[one, cross], [cross.conj(), two]]).astype(complex)
    return CrossSpectra(
        frequency=data["Freq_domain"].ravel(),
        matrix=matrix,
        inputs=(0, 1),
        density=np.array([one, two]),
        sample_rate=1280.0,
        n_samples=4096,
        segment=4096,
        overlap=0,
        n_fft=4096,
        window_name="rectangular",
        window=np.ones(4096),
        detrend="none",
        n_segments=1,
        effective_averages=1.0,
        lit_segments=np.ones((2, one.size)),
    )


@pytest.mark.shared
@pytest.mark.parametrize("case", ["case1", "case2"])
def test_definitions_are_those_of_a_commercial_analyser(case, shared):
    folder = shared / "data" / "bobcat_analyzer_vibrationtesting"
    data = io.loadmat(folder / f"{case}.mat")
    spectra = analyser_spectra(data)
    frf, coherent = data["Hf_chan_2"].ravel(), data["Hf_coh_chan_2"].ravel()
    scale = np.abs(frf).max()
    assert_allclose(h1(spectra, [0], [1])[0], frf, rtol=1e-6, atol=1e-6 * scale)
    assert_allclose(coherence(spectra, [0], [1])[0], coherent, atol=1e-6)


@pytest.mark.shared
def test_hammer_hit_has_the_resonance_that_the_analyser_found(shared):
    """Only the last of the averaged hits is stored: the resonance must be the same."""
    folder = shared / "data" / "bobcat_analyzer_vibrationtesting"
    data = io.loadmat(folder / "case1.mat")
    hit = np.array([data["Time_chan_1"].ravel(), data["Time_chan_2"].ravel()], dtype=float)
    spectra = cross_spectra(hit, 1280.0, segment=4096, window="rectangular")
    ours = np.abs(h1(spectra, [0], [1])[0, :1601])
    theirs = np.abs(data["Hf_chan_2"].ravel())
    (peak,) = find_peaks(spectra.frequency[:1601], ours, (100.0, 400.0), count=1)
    (wanted,) = find_peaks(spectra.frequency[:1601], theirs, (100.0, 400.0), count=1)
    assert abs(peak.frequency - wanted.frequency) < spectra.bin_width
    ratio = psd(spectra)[0, 16:1500] / data["PSD_chan_1"].ravel()[16:1500]
    assert 0.2 < np.median(ratio) < 1.0  # a density like theirs, of a weaker hit


@pytest.mark.shared
def test_the_wind_turbine_tower_sways_at_0_806_hertz_on_all_channels(shared):
    path = shared / "data" / "tdms_owilab" / "good_tdms_1.tdms"
    with TdmsFile.open(path) as file:
        samples = np.array([channel[:] for channel in file["acceleration"].channels()])
    spectra = cross_spectra(samples, 30.0, segment=4096, detrend="mean")
    assert samples.shape[0] == 8
    for density in psd(spectra):
        (peak,) = find_peaks(spectra.frequency, density, (0.5, 1.5), count=1)
        assert abs(peak.frequency - 0.806) < 0.01
