"""Densities against limits: what is judged does not depend on the segment."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc import spectra
from shakerproc.spectra.profiles import surely_beyond

RATE, N = 5000.0, 30_000  # Hz, 6 s
SEGMENTS = (256, 512, 1024, 2048, 4096)
ALLOWED = 0.05


def density(seed, segment, gain_db=0.0, band=(0.0, np.inf)):
    """White noise of density 1, raised in a band by dB, from 20 to 2000 Hz."""
    rng = np.random.default_rng(seed)
    frequency = np.fft.rfftfreq(N, 1.0 / RATE)
    raised = np.where((frequency > band[0]) & (frequency < band[1]), gain_db, 0.0)
    white = np.fft.rfft(rng.standard_normal(N) * np.sqrt(RATE / 2.0))
    samples = np.fft.irfft(white * 10.0 ** (raised / 20.0), N)
    cross = spectra.cross_spectra(
        [samples[np.newaxis]], RATE, segment=segment, overlap=segment // 2, window="hann"
    )
    inside = (cross.frequency > 80.0) & (cross.frequency < 1940.0)
    return spectra.psd(cross)[0, inside], cross


def shares(values, cross, limit_db):
    """Shares beyond an upper and a lower limit."""
    factor = 10.0 ** (limit_db / 10.0)
    return (
        float(surely_beyond(values / factor, cross, above=True).mean()),
        float(surely_beyond(values * factor, cross, above=False).mean()),
    )


@pytest.mark.parametrize("segment", SEGMENTS)
def test_a_tenth_of_the_band_that_is_too_high_is_seen_and_a_right_run_is_not(segment):
    """2.2 dB against 1.5 dB from 300 to 500 Hz; and 0 and 1 dB, which are within it."""
    found = [shares(*density(seed, segment, 2.2, (300.0, 500.0)), 1.5)[0] for seed in range(6)]
    assert sum(share > ALLOWED for share in found) >= len(found) - 1  # 99 of 100 at 4096
    assert_allclose(np.mean(found), 200.0 / 1860.0, atol=0.04)  # the sure part of it
    for gain in (0.0, 1.0, -1.0):
        right = [max(shares(*density(seed, segment, gain), 1.5)) for seed in range(4)]
        assert max(right) < ALLOWED


@pytest.mark.parametrize("segment", SEGMENTS)
def test_of_a_density_at_a_limit_chance_counts_five_percent_of_the_lines_at_most(segment):
    """40 runs: three standard deviations of the mean share are 0.02."""
    found = [shares(*density(seed, segment), 0.0) for seed in range(40)]
    assert (np.mean(found, axis=0) < ALLOWED).all()


@pytest.mark.parametrize("segment", [256, 4096])
def test_a_density_at_an_abort_limit_is_kept_in_nineteen_of_twenty_runs(segment):
    """60 runs of 5 %: three standard deviations are 5."""
    broken = sum(
        surely_beyond(values, cross, above=True, anywhere=True).any()
        for values, cross in (density(seed, segment) for seed in range(60))
    )
    assert broken <= 3 + 5


def test_a_tone_that_is_far_beyond_carries_no_more_than_the_lines_it_stands_in():
    values, cross = density(1, 1024)
    values[100:103] *= 1000.0
    share, _ = shares(values, cross, 1.5)
    assert share == pytest.approx(3.0 / values.size)


def test_single_lines_keep_their_own_confidence_limit():
    """A line of 4 times the limit is beyond it where 4 averages would rarely show as much."""
    values, cross = density(2, 1024)
    quiet = np.full(values.size, 0.5)
    quiet[50] = 4.0
    assert list(np.flatnonzero(surely_beyond(quiet, cross, above=True))) == [50]
    loud = np.full(values.size, 2.0)
    loud[50] = 0.1
    assert list(np.flatnonzero(surely_beyond(loud, cross, above=False))) == [50]
