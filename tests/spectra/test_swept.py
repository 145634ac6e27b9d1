"""Swept, stepped and steady sine against the closed form of a linear mass on a spring."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import signal

from shakerproc.errors import SpectrumError
from shakerproc.spectra import (
    spectrogram,
    stepped_response,
    stitched,
    swept_response,
    tone_response,
)
from shakerproc.spectra.tones.swept import MOST_WINDOWS, SMEAR

RATE = 2000.0


def sweep_phase(kind, low, high, seconds):
    """Phase [rad] and frequency [Hz] of a sweep, and the frequency as a function of time."""
    t = np.arange(round(seconds * RATE)) / RATE
    if kind == "linear":
        law = lambda time: low + (high - low) * time / seconds  # noqa: E731
        return 2 * np.pi * (low * t + (high - low) * t**2 / (2 * seconds)), law
    growth = np.log(high / low) / seconds
    law = lambda time: low * np.exp(growth * time)  # noqa: E731
    return 2 * np.pi * low * np.expm1(growth * t) / growth, law


def filter_of(natural, ratio):
    """Mass on a spring and damper, base to absolute acceleration, as a digital filter."""
    omega = 2.0 * np.pi * natural
    continuous = ([2.0 * ratio * omega, omega**2], [1.0, 2.0 * ratio * omega, omega**2])
    above, below, _ = signal.cont2discrete(continuous, 1.0 / RATE, "foh")
    return above.ravel(), below


def mass_on_a_spring(base, natural, ratio):
    return signal.lfilter(*filter_of(natural, ratio), base)


def closed_form(frequency, natural, ratio):
    """Response of that filter, from its coefficients."""
    return signal.freqz(*filter_of(natural, ratio), worN=np.asarray(frequency), fs=RATE)[1]


@pytest.mark.parametrize(
    ("kind", "low", "high", "seconds"),
    [
        ("logarithmic", 5.0, 400.0, 120.0),
        ("logarithmic", 400.0, 5.0, 120.0),
        ("linear", 10.0, 300.0, 100.0),
        ("linear", 300.0, 10.0, 100.0),
    ],
)
def test_slow_sweep_through_a_linear_system_gives_its_response(kind, low, high, seconds):
    phase, law = sweep_phase(kind, low, high, seconds)
    base = 3.0 * np.sin(phase + 0.7)
    noise = 0.01 * np.random.default_rng(1).standard_normal((2, base.size))
    samples = np.array([base, mass_on_a_spring(base, 60.0, 0.1)]) + noise
    (sweep,) = swept_response(samples, RATE, [0], (4.0, 450.0))
    assert sweep.direction == ("up" if high > low else "down")
    assert_allclose(sweep.frequency, law(sweep.time), rtol=3e-3)
    assert_allclose(sweep.control, 3.0, rtol=0.03)
    assert_allclose(sweep.gain[0], 1.0, rtol=1e-9)
    wanted = closed_form(sweep.frequency, 60.0, 0.1)
    near = sweep.frequency > 2.0 * min(low, high)
    tolerance = 0.03 * np.abs(wanted) + 0.005
    assert np.all(np.abs(sweep.gain[1] - wanted)[near] < tolerance[near])
    assert sweep.frequency.min() < 1.3 * min(low, high)
    assert sweep.frequency.max() > 0.97 * max(low, high)


def test_known_harmonics_are_found_with_their_phase():
    phase, _ = sweep_phase("logarithmic", 10.0, 150.0, 60.0)
    control = np.cos(phase)
    wanted = [0.5 * np.exp(0.3j), 0.2 * np.exp(-1j), 0.1j, 0.05, 0.02 * np.exp(2j)]
    response = 0.8 + sum(
        np.abs(c) * np.cos(k * phase + np.angle(c)) for k, c in enumerate(wanted, start=1)
    )
    (sweep,) = swept_response(np.array([control, response]), RATE, [0], (8.0, 200.0))
    for k, amplitude in enumerate(wanted):
        assert_allclose(sweep.harmonics[1, k], amplitude, atol=0.006)
    assert np.all(sweep.purity > 0.98)


def test_harmonics_above_half_the_sample_rate_are_not_made_up():
    phase, _ = sweep_phase("logarithmic", 50.0, 400.0, 30.0)
    (sweep,) = swept_response(np.sin(phase)[None], RATE, [0], (40.0, 450.0))
    for k in range(5):
        known = np.isfinite(sweep.harmonics[0, k])
        assert sweep.frequency[known].max() * (k + 1) < RATE / 2
        assert known.any()


def up_and_down():
    up, _ = sweep_phase("logarithmic", 10.0, 200.0, 40.0)
    down, _ = sweep_phase("logarithmic", 200.0, 10.0, 40.0)
    phase = np.concatenate([up, up[-1] + 2 * np.pi * 200.0 / RATE + down])
    base = np.sin(phase)
    return np.array([base, mass_on_a_spring(base, 60.0, 0.1)])


def test_up_and_down_in_one_recording_are_two_sweeps():
    up, down = swept_response(up_and_down(), RATE, [0], (8.0, 250.0))
    assert (up.direction, down.direction) == ("up", "down")
    assert up.time[-1] < 40.5
    assert down.time[0] > 39.5
    falling = stitched([up, down], "down")
    assert np.all(np.diff(falling.frequency) >= 0.0)
    assert falling.frequency.size == down.frequency.size
    grid = np.geomspace(20.0, 150.0, 50)
    rising_gain = np.interp(grid, up.frequency, np.abs(up.gain[1]))
    falling_gain = np.interp(grid, falling.frequency, np.abs(falling.gain[1]))
    assert_allclose(falling_gain, rising_gain, rtol=0.06)


def test_sweeps_of_two_bands_are_stitched_without_a_gap():
    sweeps = []
    for low, high in ((10.0, 60.0), (50.0, 300.0)):
        phase, _ = sweep_phase("logarithmic", low, high, 40.0)
        base = np.sin(phase)
        samples = np.array([base, mass_on_a_spring(base, 60.0, 0.05)])
        sweeps += swept_response(samples, RATE, [0], (low * 0.8, high * 1.2))
    whole = stitched(sweeps, "up")
    assert whole.frequency[0] < 11.0
    assert whole.frequency[-1] > 290.0
    assert np.diff(np.log(whole.frequency)).max() < 0.1
    wanted = closed_form(whole.frequency, 60.0, 0.05)
    assert np.median(np.abs(whole.gain[1] / wanted - 1.0)) < 0.01
    with pytest.raises(SpectrumError, match="no sweep down"):
        stitched(sweeps, "down")


def test_reading_in_parts_gives_the_same():
    samples = up_and_down()
    calls = []

    def read(start, stop):
        calls.append(stop - start)
        return samples[:, start:stop]

    lazy = swept_response(read, RATE, [0], (8.0, 250.0), n_samples=samples.shape[1])
    whole = swept_response(samples, RATE, [0], (8.0, 250.0))
    assert_allclose(lazy[0].harmonics[:, 0], whole[0].harmonics[:, 0], rtol=1e-12)
    with pytest.raises(ValueError, match="needs n_samples"):
        swept_response(read, RATE, [0], (8.0, 250.0))


def test_what_does_not_sweep_is_refused():
    t = np.arange(20_000) / RATE
    with pytest.raises(SpectrumError, match="no sweep between 20 and 200 Hz"):
        swept_response(np.sin(2 * np.pi * 50.0 * t)[None], RATE, [0], (20.0, 200.0))
    with pytest.raises(SpectrumError, match="no tone from 1200 to 1500 Hz can be followed"):
        swept_response(np.sin(2 * np.pi * 50.0 * t)[None], RATE, [0], (1200.0, 1500.0))
    with pytest.raises(SpectrumError, match="50 samples are too few"):
        swept_response(np.ones((1, 50)), RATE, [0], (20.0, 200.0))
    with pytest.raises(ValueError, match="n_harmonics must be at least 1"):
        swept_response(np.ones((1, 5000)), RATE, [0], (20.0, 200.0), n_harmonics=0)


def test_steady_tone_is_measured_to_many_digits():
    t = np.arange(9000) / RATE
    phase = 2 * np.pi * 49.9871 * t + 0.4
    control = 2.0 * np.cos(phase)
    response = 0.1 + 3.0 * np.cos(phase - 0.5) + 0.2 * np.cos(3 * phase + 1.0)
    tone = tone_response(np.array([control, response]), RATE, [0], frequency=50.1)
    assert_allclose(tone.frequency, 49.9871, rtol=1e-8)
    assert_allclose(tone.control, 2.0, rtol=1e-6)
    assert_allclose(tone.gain[1], 1.5 * np.exp(-0.5j), rtol=1e-5)
    assert_allclose(tone.harmonics[1, 2], 0.2 * np.exp(1j), rtol=1e-4)
    assert tone.residual.max() < 1e-4


@pytest.mark.parametrize("said", [85.0, 150.0])
def test_a_control_that_is_another_sine_is_refused_with_its_frequency(said):
    t = np.arange(30_000) / RATE
    samples = np.sin(2 * np.pi * 84.0 * t)[None]
    with pytest.raises(SpectrumError, match=rf"no sine of {said:g} Hz: .* 84 Hz"):
        tone_response(samples, RATE, [0], frequency=said)


def test_residual_is_the_noise():
    rng = np.random.default_rng(3)
    t = np.arange(40_000) / RATE
    samples = np.sin(2 * np.pi * 120.0 * t) + 0.3 * rng.standard_normal((1, t.size))
    tone = tone_response(samples, RATE, [0], frequency=120.2)
    assert_allclose(tone.residual, 0.3, rtol=0.02)
    assert_allclose(tone.frequency, 120.0, rtol=1e-5)
    high = tone_response(np.sin(2 * np.pi * 700.0 * t)[None], RATE, [0], frequency=700.0)
    assert np.isnan(high.harmonics[0, 1:]).all()


def test_each_dwell_of_a_stepped_sine_is_measured_once_it_has_settled():
    steps = [20.0, 40.0, 55.0, 60.0, 70.0, 120.0]
    phase = 2 * np.pi * np.cumsum(np.repeat(steps, round(4 * RATE))) / RATE
    base = np.sin(phase)
    samples = np.array([base, mass_on_a_spring(base, 60.0, 0.05)])
    tones = stepped_response(samples, RATE, [0], (15.0, 200.0))
    assert_allclose([tone.frequency for tone in tones], steps, rtol=1e-4)
    found = np.array([tone.gain[1] for tone in tones])
    assert_allclose(found, closed_form(np.array(steps), 60.0, 0.05), rtol=0.01)
    assert tones[1].start > 4 * RATE


def test_a_tone_that_cannot_be_there_is_refused():
    with pytest.raises(SpectrumError, match="cannot be measured in 40 samples"):
        tone_response(np.ones((1, 40)), RATE, [0], frequency=50.0)
    phase, _ = sweep_phase("logarithmic", 10.0, 400.0, 10.0)
    with pytest.raises(SpectrumError, match="dwells at no frequency"):
        stepped_response(np.sin(phase)[None], RATE, [0], (8.0, 500.0))


def test_spectrogram_is_scipys_and_averages_where_there_are_many():
    samples = np.random.default_rng(4).standard_normal((2, 30_000))
    ours = spectrogram(samples, RATE, segment=256, most_times=10_000)
    frequency, time, density = signal.spectrogram(
        samples, RATE, "hann", 256, 128, detrend=False
    )
    assert_allclose(ours.frequency, frequency)
    assert_allclose(ours.time, time)
    assert_allclose(ours.density, density, rtol=1e-10)
    coarse = spectrogram(samples, RATE, segment=256, most_times=29)
    assert coarse.time.size <= 29
    together = -(-time.size // 29)
    assert_allclose(coarse.density[..., 0], density[..., :together].mean(axis=-1), rtol=1e-10)
    assert_allclose(coarse.time[0], time[:together].mean())


def test_spectrogram_needs_a_segment():
    with pytest.raises(SpectrumError, match="100 samples are fewer"):
        spectrogram(np.ones((1, 100)), RATE)
    with pytest.raises(ValueError, match="overlap must be"):
        spectrogram(np.ones((1, 5000)), RATE, overlap=1024)
    with pytest.raises(ValueError, match="needs n_samples"):
        spectrogram(lambda a, b: np.ones((1, b - a)), RATE)


def test_a_sweep_is_found_behind_a_quiet_lead_in_and_a_knock():
    phase, _ = sweep_phase("logarithmic", 20.0, 200.0, 20.0)
    rng = np.random.default_rng(5)
    base = np.concatenate([np.zeros(round(2.0 * RATE)), np.sin(phase)])
    base[round(0.2 * RATE) : round(0.2 * RATE) + 4] = 1.0
    samples = np.array([base, mass_on_a_spring(base, 60.0, 0.1)])
    samples += 1e-4 * rng.standard_normal(samples.shape)
    (sweep,) = swept_response(samples, RATE, [0], (15.0, 250.0))
    assert sweep.direction == "up"
    assert sweep.time[0] > 1.9
    inner = slice(5, -5)
    wanted = closed_form(sweep.frequency[inner], 60.0, 0.1)
    assert_allclose(np.abs(sweep.gain[1][inner]), np.abs(wanted), rtol=0.08)


def test_noise_is_no_sweep():
    noise = np.random.default_rng(6).standard_normal((2, 200_000))
    with pytest.raises(SpectrumError, match="no sweep between"):
        swept_response(noise, RATE, [0], (5.0, 300.0))


def test_a_slow_sweep_has_no_more_points_than_its_windows_resolve():
    phase, _ = sweep_phase("logarithmic", 20.0, 200.0, 3000.0)
    (sweep,) = swept_response(np.array([np.sin(phase)]), RATE, [0], (15.0, 250.0))
    assert sweep.frequency.size < 6 * MOST_WINDOWS
    assert np.diff(np.log(sweep.frequency)).max() < 2.0 * SMEAR
