"""A level is compared in its own unit, on the channels that measure it."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.data import Channel, recording_of_arrays
from shakerproc.runs import process_recording, summary_of
from shakerproc.testlog import Processing, Test

RATE, SECONDS, RMS = 1000.0, 20.0, 12.4
FORCE = Channel("force", "N", "force", "N", "force")
CONTROL = Channel("table", "m/s^2", "table", "g", "control")
RESPONSE = Channel("ch3", "m/s^2", "ch3", "g", "response")


def processed(channels, level, unit, processing=Processing(crop=None)):  # noqa: B008 - frozen
    """Return white noise of 12.4 rms in every channel, processed against a level of the log."""
    n = round(RATE * SECONDS)
    rows = RMS * np.random.default_rng(4).standard_normal((len(channels), n))
    test = Test(
        1, excitation="random", level=level, level_unit=unit, from_hz=5.0, to_hz=495.0,
        processing=processing,
    )  # fmt: skip
    return process_recording(recording_of_arrays("run", channels, rows, RATE), test)


def kinds(result):
    return {flag.kind for flag in result.flags}


@pytest.mark.parametrize("channels", [[FORCE, RESPONSE], [CONTROL, FORCE, RESPONSE]])
def test_a_level_in_newtons_is_that_of_the_force(channels):
    result = processed(channels, RMS, "N rms")
    value, unit = result.averages.measured_level.shown
    assert unit == "N rms"
    assert_allclose(value, RMS * np.sqrt(490.0 / 500.0), rtol=0.02)
    assert "level" not in kinds(result)
    (flag,) = [f for f in processed(channels, 37.0, "N rms").flags if f.kind == "level"]
    assert "the force channels saw a mean rms of 12." in flag.message
    assert "N rms, -67% from the 37 N rms of the log" in flag.message


def test_a_density_of_a_force_is_held_to_its_limits():
    white = RMS**2 / (RATE / 2.0)
    assert not {"level", "control density"} & kinds(
        processed([FORCE, RESPONSE], white, "N^2/Hz")
    )
    far = kinds(processed([FORCE, RESPONSE], 10.0 * white, "N^2/Hz"))
    assert {"level", "control density"} <= far


@pytest.mark.parametrize("unit", ["N rms", "N^2/Hz", "N"])
def test_a_level_that_no_channel_measures_is_not_compared_and_says_so(unit):
    result = processed([CONTROL, RESPONSE], RMS, unit)
    assert result.averages.measured_level is None
    assert not {"level", "control density", "control level"} & kinds(result)
    assert "The level is not checked: the log demands 12.4 N" in result.notes[-1]
    kept = summary_of(result, "1", {}, "r.tdms", "0" * 64)
    assert result.notes[-1] in kept.remarks
    assert kept.alarm is None


def test_forces_without_a_control_are_the_inputs():
    (note,) = processed([FORCE, RESPONSE], None, None).notes
    assert "The response functions are those against the force" in note
    result = processed([FORCE, replace(FORCE, name="other"), RESPONSE], None, None)
    assert result.averages.against is None
    (note,) = result.notes
    assert "those against each of the forces force, other, where it moves" in note
    assert processed([RESPONSE], None, None).notes == ()
    assert processed([CONTROL, RESPONSE], None, None).notes == ()
    (note,) = processed([RESPONSE, RESPONSE], None, None).notes
    assert "no channel has the role control. Give it to the channel that" in note


def test_a_level_of_blows_is_no_amplitude_of_a_vibration():
    samples = np.zeros((2, 4000))
    samples[0, 500:510] = 150.0
    samples[1, 500:2000] = np.exp(-np.arange(1500) / 200.0) * np.sin(np.arange(1500))
    recording = recording_of_arrays("run", (FORCE, RESPONSE), samples, 1000.0)
    test = Test(1, excitation="hammer", level=150.0, level_unit="N", level_text="150 N")
    assert process_recording(recording, test).averages.measured_level is None
