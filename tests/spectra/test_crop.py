"""Where a run begins and ends, on signals made so that the answer is known."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shakerproc.errors import SpectrumError
from shakerproc.spectra import (
    Crop,
    ThresholdNotReachedError,
    crop_by_threshold,
    crop_by_time,
)

RATE = 1000.0


def run(lead=3.0, length=5.0, tail=2.0, amplitude=2.0, frequency=50.0):
    """Silence, a sine, silence; return also the first and last sample at or above 1."""
    t = np.arange(round(length * RATE)) / RATE
    sine = amplitude * np.sin(2 * np.pi * frequency * t)
    samples = np.concatenate([np.zeros(round(lead * RATE)), sine, np.zeros(round(tail * RATE))])
    above = np.flatnonzero(samples >= 1.0)
    return samples, *((int(above[0]), int(above[-1])) if above.size else (0, 0))


def test_runs_from_the_first_to_the_last_sample_at_or_above():
    samples, first, last = run()
    assert crop_by_threshold(samples, 1.0, RATE) == Crop(first, last + 1)


def test_a_sample_exactly_at_the_threshold_counts():
    samples = np.array([0.0, 1.0, 0.0, 1.0, 0.0])
    assert crop_by_threshold(samples, 1.0, RATE) == Crop(1, 4)


def test_negative_spike_is_seen_by_the_magnitude_only():
    samples, first, last = run()
    samples[500] = -1.5
    assert crop_by_threshold(samples, 1.0, RATE) == Crop(first, last + 1)
    crop = crop_by_threshold(samples, 1.0, RATE, absolute=True)
    assert crop.start == 500
    assert (
        "first exceedance of the threshold, at 0.5 s, stands alone (1 samples" in crop.warning
    )


def test_early_spike_is_warned_of_and_skipped_or_not_held():
    samples, first, last = run()
    samples[600] = 1.2
    crop = crop_by_threshold(samples, 1.0, RATE)
    assert crop.start == 600
    assert "silence for 2.4 s" in crop.warning
    assert crop_by_threshold(samples, 1.0, RATE, skip=1.0) == Crop(first, last + 1)
    assert crop_by_threshold(samples, 1.0, RATE, hold=0.3) == Crop(first, last + 1)


def test_late_spike_is_warned_of_too():
    samples, _, last = run()
    samples[9500] = 3.0
    crop = crop_by_threshold(samples, 1.0, RATE)
    assert crop.stop == 9501
    assert "last exceedance" in crop.warning
    assert crop_by_threshold(samples, 1.0, RATE, hold=0.3).stop == last + 1


def test_a_slow_sweep_that_touches_the_threshold_is_no_spike():
    t = np.arange(20_000) / RATE
    sine = (0.97 + 0.1 * t) * np.sin(2 * np.pi * 2.0 * t)
    assert crop_by_threshold(sine, 1.0, RATE).warning is None


def test_never_reached_names_the_largest_value():
    samples, _, _ = run(amplitude=0.43)
    with pytest.raises(ThresholdNotReachedError, match=r"largest value is 0\.43 g") as error:
        crop_by_threshold(samples, 0.45, RATE, shown=("g", 1.0))
    assert error.value.largest == samples.max()
    assert error.value.threshold == 0.45


def test_offset_that_hides_the_run_can_be_removed():
    samples, _, _ = run(amplitude=0.5)
    with pytest.raises(SpectrumError, match="remove the offset"):
        crop_by_threshold(samples - 0.07, 0.45, RATE)
    assert crop_by_threshold(samples - 0.07, 0.45, RATE, remove_offset=True) == (
        crop_by_threshold(samples, 0.45, RATE)
    )
    with pytest.raises(ValueError, match="twice"):
        crop_by_threshold(iter([samples]), 0.45, RATE, remove_offset=True)


def test_never_held_says_how_long_it_was():
    samples = np.zeros(5000)
    samples[1000:1050] = 2.0
    with pytest.raises(SpectrumError, match=r"held for 0\.049 s at most, not for 1 s"):
        crop_by_threshold(samples, 1.0, RATE, hold=1.0)


def test_skipping_everything_says_so():
    with pytest.raises(SpectrumError, match="no sample is left"):
        crop_by_threshold(np.ones(100), 0.5, RATE, skip=1.0)


@given(cuts=st.lists(st.integers(0, 10_000), max_size=9), hold=st.sampled_from([0.0, 0.2]))
@settings(max_examples=60, deadline=None)
def test_does_not_depend_on_the_blocks(cuts, hold):
    samples, _, _ = run()
    samples[600] = 1.2
    whole = crop_by_threshold(samples, 1.0, RATE, hold=hold, skip=0.123)
    parts = np.split(samples, sorted(cuts))
    assert crop_by_threshold(parts, 1.0, RATE, hold=hold, skip=0.123) == whole


def test_crop_by_time():
    assert crop_by_time(10_000, RATE) == Crop(0, 10_000)
    assert crop_by_time(10_000, RATE, 2.0, 4.0) == Crop(2000, 4000)
    assert crop_by_time(10_000, RATE, 2.0, 10.0).n_samples == 8000


@pytest.mark.parametrize(
    ("start", "stop"), [(2.0, 11.0), (4.0, 4.0), (-1.0, 3.0), (10.0, None)]
)
def test_crop_outside_the_recording_is_refused(start, stop):
    with pytest.raises(SpectrumError, match="does not lie within the recording of 10 s"):
        crop_by_time(10_000, RATE, start, stop)
