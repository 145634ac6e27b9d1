"""DAQmx indexes that cannot be, digital lines, and channels of text among numbers."""

import io
import struct

import numpy as np
import pytest
from nptdms import TdmsFile
from numpy.testing import assert_array_equal
from tests.recordings.tdms_bytes import daqmx_index, index, listed, metadata, segment, text

from shakerproc.data import ChannelUse
from shakerproc.errors import RecordingError
from shakerproc.recordings import open_recording
from shakerproc.recordings.tdms.reader import read_tdms

A_SEGMENT = 2 + 4 + 8
SCALED = {"NI_Number_Of_Scales": 1, "wf_increment": 0.001}


@pytest.fixture
def write(tmp_path):
    def write(content):
        path = tmp_path / "run.tdms"
        path.write_bytes(content)
        return path

    return write


def one(data, **values):
    return listed("/'g'/'a'", data, {**SCALED, **values})


def other(data, **values):
    return listed("/'g'/'b'", data, {**SCALED, **values})


def line_index(bit: int, count: int, width: int) -> bytes:
    raw = struct.pack("<IIIQI", 0x126A, 0xFFFFFFFF, 1, count, 1)
    return raw + struct.pack("<IIIBI", 0, 0, bit, 0, 0) + struct.pack("<II", 1, width)


I2 = [("i2", 0, 0, 0)]


@pytest.mark.parametrize(
    ("objects", "match"),
    [
        ([one(daqmx_index([], 4, [2]))], "no DAQmx scaler, or one twice"),
        ([one(daqmx_index(I2, 4, [1 << 25]))], "a row of 33554432 bytes"),
        ([one(daqmx_index(I2 * 2, 4, [2]))], "no DAQmx scaler, or one twice"),
        ([one(daqmx_index([("i2", 0, 1, 0)], 4, [2]))], "reads beyond its DAQmx row"),
        ([one(daqmx_index([("i2", 1, 0, 0)], 4, [2]))], "reads beyond its DAQmx row"),
        ([one(daqmx_index(I2, 4, [2]).replace(b"\xff" * 4, b"\5\0\0\0"))], "of another type"),
        (
            [one(daqmx_index(I2, 4, [4])), other(daqmx_index([("i2", 0, 2, 0)], 4, [6]))],
            "another DAQmx row than its neighbours",
        ),
        (
            [one(daqmx_index([("i2", 0, 0, 0), ("i2", 1, 0, 1)], 4, [2, 2]))],
            "takes its scales from several buffers",
        ),
        (
            [one(daqmx_index(I2, 4, [4])), other(daqmx_index([("i2", 0, 1, 0)], 4, [4]))],
            "claims DAQmx bytes of another channel",
        ),
        (
            [one(daqmx_index(I2, 4, [2])), other(index("i2", 4))],
            "DAQmx and other channels share",
        ),
        (
            [one(daqmx_index(I2, 4, [2]).replace(struct.pack("<I", 3), b"\x63\0\0\0", 1))],
            "has the type 99",
        ),
        (
            [one(index("f8", 4).replace(b"\1\0\0\0", b"\2\0\0\0", 1))],
            "2 dimensions instead of 1",
        ),
        ([one(index("f8", 1 << 60))], "values in a chunk"),
        ([one(index("i2", 4)), one(index("i2", 4))], "listed twice"),
        (
            [
                text("/'g'/'a'")
                + index("i2", 4)
                + struct.pack("<I", 1)
                + text("p")
                + b"\x77\0\0\0"
            ],
            "property 'p' has the type 0x77",
        ),
    ],
)
def test_indexes_that_cannot_be(write, objects, match):
    path = write(segment(metadata(objects), bytes(16), A_SEGMENT))
    with pytest.raises(RecordingError, match=match):
        open_recording(path)


def test_a_channel_may_not_change_its_type(write):
    first = segment(metadata([one(index("f8", 2))]), bytes(16), A_SEGMENT)
    second = segment(metadata([one(index("i8", 2))]), bytes(16), A_SEGMENT)
    with pytest.raises(RecordingError, match="changes its data type on the way"):
        open_recording(write(first + second))


def test_the_version_may_not_change(write):
    first = segment(metadata([one(index("f8", 2))]), bytes(16), A_SEGMENT, version=4712)
    second = segment(metadata([one(index("f8", 2))]), bytes(16), A_SEGMENT, version=4713)
    with pytest.raises(RecordingError, match="the version changes from 4712 to 4713"):
        open_recording(write(first + second))


def test_interleaved_channels_must_be_alike(write):
    objects = metadata([one(index("f8", 2)), other(index("f8", 3))])
    with pytest.raises(RecordingError, match="different numbers of values"):
        open_recording(write(segment(objects, bytes(40), A_SEGMENT + 32)))


def test_channels_that_hold_the_same_numbers_are_noted(write):
    objects = [one(daqmx_index(I2, 4, [2])), other(daqmx_index(I2, 4, [2]))]
    with open_recording(write(segment(metadata(objects), bytes(8), A_SEGMENT + 128))) as found:
        assert "hold the same numbers" in found.notes[0]


def test_digital_lines_are_those_of_nptdms(write):
    rows = np.random.default_rng(1).integers(0, 256, (50, 2)).astype("u1")
    objects = metadata([one(line_index(3, 50, 2)), other(line_index(12, 50, 2))])
    content = segment(objects, rows.tobytes(), A_SEGMENT + 128)
    oracle = TdmsFile.read(io.BytesIO(content))["g"]
    with open_recording(write(content)) as found:
        samples = found.samples()
    assert_array_equal(samples[0], oracle["a"][:])
    assert_array_equal(samples[1], oracle["b"][:])
    assert_array_equal(samples[0], (rows[:, 0] >> 3) & 1)
    assert_array_equal(samples[1], (rows[:, 1] >> 4) & 1)


def text_index(words: list[bytes]) -> tuple[bytes, bytes]:
    ends = np.cumsum([len(word) for word in words]).astype("<u4").tobytes()
    raw = ends + b"".join(words)
    return struct.pack("<IIIQQ", 28, 0x20, 1, len(words), len(raw)), raw


def plain(name, data):
    return listed(f"/'g'/'{name}'", data, {"wf_increment": 0.001})


def test_channels_of_text_are_passed_over(write):
    said, raw = text_index([b"one", b"two", b"three"])
    values = np.arange(3.0)
    objects = metadata([plain("a", said), plain("b", index("f8", 3)), plain("c", said)])
    content = segment(objects, raw + values.tobytes() + raw, A_SEGMENT)
    oracle = TdmsFile.read(io.BytesIO(content))["g"]
    assert list(oracle["c"][:]) == ["one", "two", "three"]
    path = write(content)
    with open_recording(path) as found:
        assert [c.name for c in found.channels] == ["b"]
        assert_array_equal(found.samples()[0], values)
    with pytest.raises(RecordingError, match="channel 'a' cannot be used: it holds text"):
        open_recording(path, uses=[ChannelUse("a", "control")])
    for size in range(len(content) - len(raw) - 24, len(content)):
        cut = read_tdms(write(content[:size]), "cut")
        present = {c.name: c.n_samples for c in cut.groups[0].channels}
        assert present["b"] == min(3, (size - (len(content) - len(raw) - 24)) // 8)
        assert present["c"] == 0
        cut.source.close()
    objects = metadata([plain("a", said), plain("b", index("f8", 3))])
    content = segment(objects, raw + values.tobytes(), A_SEGMENT + 32)
    with pytest.raises(RecordingError, match="text stands among interleaved channels"):
        open_recording(write(content))
