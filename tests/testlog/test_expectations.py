"""Recordings against what the log says of them."""

import hashlib
import math
from dataclasses import replace

import numpy as np
import pytest

from shakerproc.data import Channel, recording_of_arrays
from shakerproc.errors import LogError
from shakerproc.recordings import WatchedFile
from shakerproc.testlog import Expectation, Test, check_expectation, nominal_duration

CHANNELS = (
    Channel("control 1", "m/s^2", "Dev1/ai0", "g", "control"),
    Channel("ch3", "m/s^2", "Dev1/ai2", "g", "response"),
)


def recording(rate=1000.0, seconds=10.0, channels=CHANNELS):
    samples = np.zeros((len(channels), round(rate * seconds)))
    return recording_of_arrays("run", channels, samples, rate)


def check(found, **expected):
    check_expectation(Test(id=7, expect=Expectation(**expected), source="log.yaml:9"), found)


def test_a_recording_that_is_as_expected_passes():
    check(recording(), duration=10.1, sample_rate=1000.05, channels=2, unit="g")
    check(recording())


@pytest.mark.parametrize(
    ("expected", "match"),
    [
        ({"duration": 360.0}, "the log expects 360 s, the recording has 10 s"),
        ({"duration": 10.1, "duration_tolerance": 0.001}, r"the log expects 10\.1 s"),
        ({"sample_rate": 1001.0}, "the log expects 1001 Hz, the recording has 1000 Hz"),
        ({"channels": 5}, "the log expects 5 channels, the recording has 2"),
        ({"unit": "m/s^2"}, r'channel "control 1" in m/s\^2, the recording has it in "g"'),
    ],
)
def test_a_recording_that_is_not_is_told_with_test_and_place(expected, match):
    with pytest.raises(LogError, match=rf"^log\.yaml:9: test 7: .*{match}"):
        check(recording(), **expected)


def test_channels_are_counted_as_the_file_holds_them():
    check(replace(recording(), in_file=4), channels=4)
    with pytest.raises(LogError, match=r"has 4 \(all of them counted; 2 are used\)"):
        check(replace(recording(), in_file=4), channels=2)
    with pytest.raises(LogError, match=r"has 2 \(all are used\)"):
        check(replace(recording(), in_file=2), channels=4)


def test_everything_that_differs_is_told_at_once():
    with pytest.raises(LogError, match=r"1 s, .*; .* 5 channels, .*; correct the log"):
        check(recording(), duration=1.0, channels=5)


def test_one_unit_may_be_written_in_several_ways():
    channels = (Channel("a", "m/s^2", "a", "m/s²"),)
    check(recording(channels=channels), unit="m/s^2")


def test_a_channel_without_a_unit_is_told():
    channels = (Channel("a", "m/s^2", "a", ""),)
    with pytest.raises(LogError, match='in g, the recording has it in ""'):
        check(recording(channels=channels), unit="g")


def test_a_recording_that_changed_is_told(tmp_path):
    path = tmp_path / "a.bin"
    path.write_bytes(b"samples")
    expected = hashlib.sha256(b"samples").hexdigest()
    with WatchedFile(path, "run", hashed=True) as file:
        check(replace(recording(), file=file), sha256=expected)
    path.write_bytes(b"Samples")
    with (
        WatchedFile(path, "run", hashed=True) as file,
        pytest.raises(LogError, match=r"the log expects SHA-256 [0-9a-f]{12}"),
    ):
        check(replace(recording(), file=file), sha256=expected)


def test_a_sweep_lasts_as_long_as_its_rate_says():
    up = Test(id=1, from_hz=5.0, to_hz=500.0, rate_oct_per_min=1.0)
    down = Test(id=1, from_hz=500.0, to_hz=5.0, rate_oct_per_min=1.0)
    assert nominal_duration(up) == pytest.approx(60.0 * math.log2(100.0))
    assert nominal_duration(down) == nominal_duration(up)
    assert nominal_duration(Test(id=1, from_hz=5.0, to_hz=15.0, rate_hz_per_s=2.0)) == 5.0
    assert nominal_duration(Test(id=1, from_hz=5.0, to_hz=15.0)) is None
    assert nominal_duration(Test(id=1)) is None
