"""The thesis' tables of a run: its roles, its crop and its segments, against scipy."""

import json
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import signal
from tests.small_campaign import RATE, samples, write_recording

from shakerproc.data import STANDARD_GRAVITY, Channel, ChannelUse
from shakerproc.errors import SpectrumError
from shakerproc.runs import open_path, process_recording
from shakerproc.runs.tables import thesis_names, thesis_tables_of, write_thesis_tables
from shakerproc.spectra import sample_at
from shakerproc.testlog import Test, ThresholdCrop, TimeCrop, Welch

USES = (
    ChannelUse(1, "control"),
    ChannelUse(2, "control"),
    ChannelUse(3, "response", name="ch3"),
    ChannelUse(4, "response", name="ch4"),
)
THRESHOLD = 0.2 * STANDARD_GRAVITY


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return write_recording(tmp_path_factory.mktemp("run") / "run.tdms", 300.0)


def tables(path, *, uses=USES, **processing):
    test = Test(id=1)
    chosen = {"crop": ThresholdCrop(threshold=THRESHOLD), "welch": Welch(512, 256)}
    test = replace(
        test, channels=uses, processing=replace(test.processing, **chosen | processing)
    )
    with open_path(path, test) as recording:
        return thesis_tables_of(process_recording(recording, test), recording)


def density(rows, *, segment=512, overlap=256):
    _, found = signal.welch(
        rows / STANDARD_GRAVITY,
        fs=RATE,
        window=np.hamming(segment),
        noverlap=overlap,
        detrend=False,
    )
    return found


@pytest.mark.parametrize(
    ("crop", "start", "stop"),
    [
        (None, 0, 12_288),
        (TimeCrop(1.0, 5.0), 2048, 10_240),
        (TimeCrop(1.0002, 5.0003), 2048, 10_241),  # the nearest sample; the end is left out
    ],
)
def test_the_crop_of_the_log_is_obeyed(path, crop, start, stop):
    found = tables(path, crop=crop)
    assert found.crop["start_in_file_0based"] == start
    assert found.crop["stop_in_file_0based"] == stop - 1
    part = samples(300.0)[:, start:stop]
    if part.shape[1] % 2:
        part = np.concatenate([part, part[:, -1:]], axis=1)  # as the thesis pads
    scale = found.crop["Fs"] / RATE
    wanted = density(part)[3] / scale
    assert_allclose(found.tables["psd"].columns["ch4"][1:], wanted[1:], rtol=1e-6)


def test_what_is_skipped_is_cut_off_before_the_threshold_is_looked_for(path):
    control = samples(300.0)[1]
    for skip in (0.0, 2.0):
        found = tables(path, crop=ThresholdCrop(threshold=THRESHOLD, skip=skip))
        first = round(skip * RATE)
        reached = np.flatnonzero(control[first:] >= THRESHOLD) + first
        assert found.crop["start_in_file_0based"] == reached[0]
        assert found.crop["stop_in_file_0based"] == reached[-1]


def test_roles_of_the_log_are_obeyed(path):
    uses = (ChannelUse(1, "response"), ChannelUse(3, "control"), ChannelUse(4, "response"))
    found = tables(path, uses=uses, crop=TimeCrop(1.0, 5.0)).tables
    psd = density(samples(300.0)[:, 2048:10_240])
    assert list(found["psd"].columns) == ["ch1", "ch3", "ch4"]
    assert_allclose(found["frf"].columns["ch3"], psd[0] / psd[2], rtol=1e-5)
    assert_allclose(found["frf"].columns["ch4"], psd[3] / psd[2], rtol=1e-5)


def test_segments_of_the_log_are_obeyed(path):
    found = tables(path, crop=TimeCrop(1.0, 5.0), welch=Welch(600, 450)).tables
    wanted = density(samples(300.0)[:, 2048:10_240], segment=600, overlap=450)[2]
    assert_allclose(found["psd"].columns["ch3"][1:], wanted[1:], rtol=1e-6)
    assert found["notch_psd"].index.size == 601


def test_the_files_say_which_channel_is_which(path, tmp_path):
    test = Test(id=1, channels=(ChannelUse(4, "control", name="table"), USES[2]))
    with open_path(path, test) as recording:
        test = replace(test, processing=replace(test.processing, crop=None))
        result = process_recording(recording, test)
        written = write_thesis_tables(result, recording, tmp_path)
    assert {path.name for path in written} >= {"psd.csv", "peaks.csv", "crop.json"}
    told = json.loads((tmp_path / "crop.json").read_text())
    assert told["channels"] == {"table": "response 2", "ch3": "response 1"}
    assert told["threshold"] is None


def test_a_force_cannot_be_the_control_of_the_thesis(path):
    with open_path(path, Test(id=1)) as recording:
        result = process_recording(recording, Test(id=1, channels=USES))
    force = replace(result.channels[0], unit="N")
    result = replace(result, channels=(force, *result.channels[1:]))
    with pytest.raises(
        SpectrumError, match=r"control control 1 is not one; leave --thesis out"
    ):
        thesis_tables_of(result, recording)


def channel(source, name=None):
    return Channel(name or source, "m/s^2", source, "g")


def test_channels_without_a_name_have_the_numbers_of_the_thesis():
    plain = [channel(f"ai{i}") for i in range(5)]
    assert thesis_names(plain, 2) == ["ch1", "ch2", "ch3", "ch4", "ch5"]
    assert thesis_names(plain[:3], 1) == ["ch1", "ch3", "ch4"]
    assert thesis_names(plain, 3) == ["ch1", "ch2", "ch3", "ch4", "ch5"]
    named = [channel("ai0"), channel("ai1", "ch4"), channel("ai2")]
    assert thesis_names(named, 1) == ["ch1", "ch4", "ai2"]


@pytest.mark.parametrize("rate", [5688.9, 51_200 / 9, 610.35, 2048.0])
def test_the_time_of_a_sample_means_that_sample(rate):
    for k in (0, 1, 2, 11_378, 24_067, 249_003, 22_000_000):
        assert sample_at(k / rate, rate) == k
        assert sample_at((k + 0.4) / rate, rate) == k
        assert sample_at((k + 0.6) / rate, rate) == k + 1
