"""A dwell of an oscillator whose stiffness drifts, against its closed form."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from tests.runs.test_sine_on_random import CHANNELS

from shakerproc.data import recording_of_arrays
from shakerproc.errors import SpectrumError
from shakerproc.runs import process_recording
from shakerproc.testlog import Processing, Test
from shakerproc.testlog.processing import Dwell

RATE, SECONDS, DRIVE, RATIO = 1024.0, 60.0, 50.0, 0.02
TIME = np.arange(int(RATE * SECONDS)) / RATE


def transmissibility(time):
    """Closed form at each time, the natural frequency falling by 3 %: slow against decay."""
    r = DRIVE / (DRIVE * (1.01 - 0.03 * time / SECONDS))
    return (1.0 + 2j * RATIO * r) / (1.0 - r**2 + 2j * RATIO * r)


def dwell_of(control, response, excitation="sine", said=None):
    test = Test(
        1,
        excitation=excitation,
        level=9.80665,
        level_unit="m/s^2",
        frequency_hz=DRIVE,
        from_hz=None if excitation == "sine" else 10.0,
        to_hz=None if excitation == "sine" else 100.0,
        processing=Processing(crop=None, dwell=said or Dwell(every=1.0)),
    )
    rows = 9.80665 * np.array([control, response])
    result = process_recording(recording_of_arrays("run", CHANNELS, rows, RATE), test)
    (one,) = [one for one in result.analyses if one.kind == "dwell"]
    return one


def test_gain_and_phase_over_time_are_those_of_the_closed_form():
    wave = np.exp(2j * np.pi * DRIVE * TIME)
    noise = 1e-3 * np.random.default_rng(1).normal(size=(2, TIME.size))
    found = dwell_of(wave.real + noise[0], (transmissibility(TIME) * wave).real + noise[1])
    expected = transmissibility(found.columns["time_s"])
    assert_allclose(found.columns["gain_ch3"], np.abs(expected), rtol=2e-3)
    assert_allclose(
        found.columns["phase_ch3_deg"], np.degrees(np.unwrap(np.angle(expected))), atol=0.2
    )
    assert_allclose(found.columns["frequency_hz"], DRIVE, atol=1e-3)
    (row,) = found.summary
    ends = transmissibility(np.array([3.0, 57.0]))
    assert row["phase_drift_deg"] == pytest.approx(
        np.degrees(np.angle(ends[1] / ends[0])), abs=1
    )
    assert "resonance" not in " ".join(found.sentences)


def test_a_frequency_that_is_tracked_downwards_is_followed():
    phase = 2.0 * np.pi * (DRIVE * TIME - 0.5 * 2.0 * TIME**2 / SECONDS)
    found = dwell_of(np.cos(phase), 20.0 * np.cos(phase - np.pi / 2.0))
    columns = found.columns
    assert_allclose(
        columns["frequency_hz"], DRIVE - 2.0 * columns["time_s"] / SECONDS, atol=5e-3
    )
    assert_allclose(columns["gain_ch3"], 20.0, rtol=1e-3)
    assert_allclose(columns["phase_ch3_deg"], -90.0, atol=0.2)


def test_stretches_in_which_the_control_rests_are_left_empty_and_counted():
    wave = np.sin(2.0 * np.pi * DRIVE * TIME)
    rests = (TIME >= 20.0) & (TIME < 25.0)
    noise = 1e-3 * np.random.default_rng(2).normal(size=TIME.size)
    found = dwell_of(np.where(rests, noise, wave), wave)
    gap = np.isnan(found.columns["gain_ch3"])
    assert np.flatnonzero(gap).tolist() == [20, 21, 22, 23, 24]
    assert "In 5 of 60 stretches the control is no sine." in found.sentences


def test_a_dwell_of_too_few_stretches_is_refused():
    wave = np.sin(2.0 * np.pi * DRIVE * TIME)
    with pytest.raises(SpectrumError, match="does not hold 2 stretches of 40 s"):
        dwell_of(wave, wave, said=Dwell(every=40.0))
