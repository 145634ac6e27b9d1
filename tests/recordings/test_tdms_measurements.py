"""Measurements that were appended to the same channels of a TDMS file, written by npTDMS."""

import struct
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from nptdms import ChannelObject, TdmsFile, TdmsWriter
from numpy.testing import assert_array_equal
from tests.recordings.tdms_bytes import (
    BIG,
    METADATA,
    NEW_LIST,
    RAW,
    index,
    metadata,
    prop,
    segment,
    text,
)

from shakerproc.data import STANDARD_GRAVITY
from shakerproc.errors import RecordingError
from shakerproc.recordings import FilePart, contents, open_recording

START = datetime(2024, 6, 5, 7, 8, 9, tzinfo=UTC)
RATE, N = 1000.0, 500


def said(seconds=0.0, rate=RATE, unit="g", **more):
    """Return what a program writes of a channel whose samples start so late."""
    start = np.datetime64((START + timedelta(seconds=seconds)).replace(tzinfo=None), "us")
    return {"wf_start_time": start, "wf_increment": 1.0 / rate, "unit_string": unit, **more}


def numbers(part, channel):
    return 1000.0 * part + 100.0 * channel + np.arange(N, dtype=float) / N


@pytest.fixture
def write(tmp_path):
    def write(*parts, channels="ab"):
        """Write a segment for each part: what is said, of all channels or by channel."""
        path = tmp_path / "run.tdms"
        with TdmsWriter(path) as file:
            for number, part in enumerate(parts):
                of = part if isinstance(part, list) else [part] * len(channels)
                file.write_segment([
                    ChannelObject("group", name, numbers(number, i), properties)
                    for i, (name, properties) in enumerate(zip(channels, of, strict=True))
                ])
        return path

    return write


def refused(path, match, **options):
    with pytest.raises(RecordingError, match=match) as caught, open_recording(path, **options):
        pass
    return str(caught.value)


def served(path, **options):
    with open_recording(path, **options) as recording:
        return recording, recording.samples()


@pytest.mark.parametrize(
    ("second", "differs"),
    [
        (said(3600.0), "time"),
        (said(0.51), "time"),  # ten samples are missing
        (said(-3600.0), "time"),
        (said(3600.0, rate=2000.0), "rate"),
        (said(N / RATE, rate=2000.0), "rate"),
        (said(N / RATE, unit="m/s^2"), "unit"),
        ({"unit_string": "V"}, "unit"),
        ({"wf_increment": 0.002}, "rate"),
    ],
)
def test_another_measurement_in_the_same_channels_is_refused_with_a_choice(
    write, second, differs
):
    path = write(said(), second)
    message = refused(path, "2 measurements follow each other in the same channels")
    assert "1 (from 2024-06-05 07:08:09, 500 samples at 1000 Hz in 'g')" in message
    assert "processing: {measurement: 1} in the log or --measurement 1" in message
    assert ("or all if they are one" in message) == (differs == "time")
    (group,) = contents(path)[0]
    assert group.differs == (differs,)
    assert len(message) < 600


def test_each_measurement_is_read_alone_with_its_own_start_rate_and_unit(write):
    path = write(said(), said(3600.0, rate=2000.0, unit="m/s^2"))
    first, samples = served(path, part=FilePart(measurement=1))
    assert (first.sample_rate, first.n_samples, first.start_time) == (RATE, N, START)
    expected = np.array([numbers(0, 0), numbers(0, 1)]) * STANDARD_GRAVITY
    assert_array_equal(samples, expected)
    assert first.notes == ("Measurement 1 of 2 in the file.",)
    second, samples = served(path, part=FilePart(measurement=2))
    assert (second.sample_rate, second.n_samples) == (2000.0, N)
    assert second.start_time == START + timedelta(hours=1)
    assert [channel.source_unit for channel in second.channels] == ["m/s^2"] * 2
    assert_array_equal(samples, [numbers(1, 0), numbers(1, 1)])
    assert second.unused == ()


def test_each_measurement_is_scaled_by_its_own_scale(write):
    def scale(slope):
        return {
            "NI_Number_Of_Scales": 1,
            "NI_Scaling_Status": "unscaled",
            "NI_Scale[0]_Scale_Type": "Linear",
            "NI_Scale[0]_Linear_Slope": slope,
            "NI_Scale[0]_Linear_Y_Intercept": 0.0,
            "NI_Scale[0]_Linear_Input_Source": 0xFFFFFFFF,
        }

    path = write(said(unit="m/s^2", **scale(2.0)), scale(5.0))
    refused(path, "2 measurements")
    for number, slope in ((1, 2.0), (2, 5.0)):
        _, samples = served(path, part=FilePart(measurement=number))
        assert_array_equal(samples[0], slope * numbers(number - 1, 0))
    refused(path, "differ in scale cannot be read as one", part=FilePart(measurement="all"))


def test_a_start_that_follows_the_samples_continues_the_recording(write):
    """DAQmx counts on from its start; clocks drift, and programs write milliseconds."""
    exact = [said(i * N / RATE) for i in range(5)]
    drifting = [said(i * N / RATE * (1.0 + 9e-5)) for i in range(5)]
    rounded = [said(round(i * N / RATE, 3) + 0.0004) for i in range(5)]
    for parts in (exact, drifting, rounded, [said()] * 5, [said(), {}, {}]):
        recording, samples = served(write(*parts))
        assert recording.n_samples == N * len(parts)
        assert abs(recording.start_time - START) < timedelta(milliseconds=1)
        assert_array_equal(samples[0, -N:], numbers(len(parts) - 1, 0) * STANDARD_GRAVITY)
        assert contents(recording.path)[0][0].measurements == ()


def test_units_and_rates_that_are_the_same_continue_the_recording(write):
    again = [{"unit_string": "g's"}, {"wf_increment": 1.0 / RATE * (1.0 + 1e-12)}]
    assert served(write(said(), *again))[0].n_samples == 3 * N


def test_what_is_written_after_the_samples_is_no_measurement(tmp_path):
    path = tmp_path / "run.tdms"
    with TdmsWriter(path) as file:
        for i, properties in enumerate((said(), said(3600.0))):
            file.write_segment([ChannelObject("g", "a", numbers(i, 0), properties)])
        empty = np.array([], dtype=float)
        file.write_segment([ChannelObject("g", "a", empty, {"unit_string": "m/s^2"})])
    assert [c.unit for c in contents(path)[0][0].channels] == ["m/s^2"]
    first, _ = served(path, part=FilePart(measurement=1))
    second, _ = served(path, part=FilePart(measurement=2))
    assert [r.channels[0].source_unit for r in (first, second)] == ["g", "m/s^2"]


def test_measurements_that_are_one_after_all_are_read_as_one(write):
    path = write(said(), said(0.7), said(1.5))
    recording, samples = served(path, part=FilePart(measurement="all"))
    assert recording.n_samples == 3 * N
    assert_array_equal(samples[1], np.ravel([numbers(i, 1) for i in range(3)]) * 9.80665)
    assert "3 measurements are read as one" in recording.notes[0]
    refused(
        write(said(), said(9.0, unit="V")),
        "cannot be read as one",
        part=FilePart(measurement="all"),
    )


def test_a_measurement_that_is_not_there_is_refused(write):
    path = write(said(), said(3600.0))
    refused(path, "no measurement 3: choose from 1 to 2", part=FilePart(measurement=3))
    whole = write(said(), {})
    refused(whole, "no measurement 2: the file holds one", part=FilePart(measurement=2))
    assert served(whole, part=FilePart(measurement=1))[0].n_samples == 2 * N


def test_one_channel_that_differs_parts_its_group_and_no_other(write, tmp_path):
    path = write(said(), [{}, {"unit_string": "V"}], {})
    for number, n in ((1, N), (2, 2 * N)):
        recording, samples = served(path, part=FilePart(measurement=number))
        assert recording.n_samples == n
        assert samples.shape == (2, n)
    path = tmp_path / "two.tdms"
    with TdmsWriter(path) as file:
        for i in range(2):
            file.write_segment([
                ChannelObject("fast", "a", numbers(i, 0), said(3600.0 * i)),
                ChannelObject("slow", "b", numbers(i, 1), said(i * N / RATE)),
            ])
    assert served(path, part=FilePart("slow"))[0].n_samples == 2 * N
    refused(path, "2 measurements", part=FilePart("fast"))


def test_channels_in_segments_of_their_own_make_no_measurements_of_their_own(tmp_path):
    path = tmp_path / "run.tdms"
    with TdmsWriter(path) as file:
        for part in range(3):
            for i, name in enumerate("abc"):
                properties = said(part * 3600.0)
                file.write_segment([ChannelObject("g", name, numbers(part, i), properties)])
    for number in (1, 2, 3):
        recording, samples = served(path, part=FilePart(measurement=number))
        assert recording.start_time == START + timedelta(hours=number - 1)
        assert_array_equal(samples[2], numbers(number - 1, 2) * STANDARD_GRAVITY)


def test_a_thousand_measurements_are_counted_and_a_hundred_can_be_chosen(write):
    path = write(*(said(10.0 * i) for i in range(1000)), channels="a")
    message = refused(path, "1000 measurements follow each other")
    assert "; and 996 more. Say which" in message
    _, samples = served(path, part=FilePart(measurement=100))
    assert_array_equal(samples[0], numbers(99, 0) * STANDARD_GRAVITY)
    refused(path, "no measurement 101: choose from 1 to 100", part=FilePart(measurement=101))


@pytest.mark.parametrize("e", ["<", ">"])
def test_the_start_is_that_of_nptdms_in_either_byte_order(tmp_path, e):
    path = tmp_path / "run.tdms"
    fraction, seconds = 0x4000000000000000, 3_800_000_000
    stamp = struct.pack(
        e + ("Qq" if e == "<" else "qQ"), *(fraction, seconds)[:: 1 if e == "<" else -1]
    )
    flags = METADATA | NEW_LIST | RAW | (0 if e == "<" else BIG)
    head = text("wf_start_time", e) + struct.pack(e + "I", 0x44) + stamp
    told = struct.pack(e + "I", 2) + head + prop("wf_increment", 0.001, e)
    content = b""
    for _ in range(2):
        channel = text("/'g'/'a'", e) + index("f8", 4, e) + told
        raw = np.arange(4.0).astype(e + "f8").tobytes()
        content += segment(metadata([channel], e), raw, flags)
    path.write_bytes(content)
    oracle = TdmsFile.read_metadata(path)["g"]["a"].properties["wf_start_time"]
    recording, _ = served(path)
    assert np.datetime64(recording.start_time.replace(tzinfo=None)) == oracle
    assert recording.n_samples == 8
