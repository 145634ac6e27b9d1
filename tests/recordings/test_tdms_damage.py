"""Damaged TDMS files: refused in one line, or read as an exact prefix that is marked so."""

import math
import struct
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from tests.recordings import tdms_bytes
from tests.recordings.tdms_bytes import Builder, index, listed, metadata, segment

from shakerproc.data import STANDARD_GRAVITY, Channel, ChannelUse, recording_of_arrays
from shakerproc.errors import RecordingError
from shakerproc.recordings import open_recording, write_tdms
from shakerproc.recordings.tdms import objects, walk


@pytest.fixture
def write(tmp_path):
    def write(content, name="run.tdms"):
        path = tmp_path / name
        path.write_bytes(content)
        return path

    return write


def two_channels(n_segments=3, count=10, **options):
    builder = Builder(["f8", "f8"])
    rng = np.random.default_rng(1)
    for number in range(n_segments):
        builder.add(rng, count, meta="full" if number == 0 else "same", **options)
    return builder


def refused(path, match, **options):
    with pytest.raises(RecordingError, match=match) as caught, open_recording(path, **options):
        pass
    message = str(caught.value)
    assert message.startswith(path.name)
    assert message.isprintable()
    return message


@pytest.mark.parametrize("interleaved", [False, True])
def test_every_truncation_is_an_exact_prefix_and_marked(write, interleaved):
    builder = two_channels(interleaved=interleaved)
    whole = builder.rows() * STANDARD_GRAVITY
    read, refusals = 0, []
    for size in range(1, len(builder.content), 1 + interleaved):
        path = write(builder.content[:size])
        try:
            with open_recording(path) as recording:
                samples = recording.samples()
        except RecordingError as error:
            refusals.append((size, str(error)))
            continue
        read += 1
        assert_array_equal(samples, whole[:, : samples.shape[1]])
        if size in builder.starts:  # a whole number of segments: nobody can tell
            assert not recording.incomplete
            assert samples.shape[1] == 10 * builder.starts.index(size)
        else:
            assert recording.incomplete
            assert recording.expected_samples > recording.n_samples
            assert any("not whole" in note for note in recording.notes)
    assert read > 150
    assert all(size < builder.starts[1] for size, _ in refusals)  # nothing complete yet
    assert all(message.isprintable() for _, message in refusals)


def test_every_complete_row_of_a_cut_chunk_is_kept(write):
    builder = Builder(["i2", "f8"]).add(np.random.default_rng(1), 100, interleaved=True)
    data = len(builder.content) - 1000
    with open_recording(write(builder.content[: data + 10 * 37 + 9])) as recording:
        assert (recording.n_samples, recording.expected_samples) == (37, 100)
    builder = Builder(["i2", "f8"]).add(np.random.default_rng(1), 100)
    with open_recording(write(builder.content[: data + 200 + 8 * 37 + 7])) as recording:
        assert (recording.n_samples, recording.expected_samples) == (37, 100)


def test_a_channel_that_is_not_used_costs_no_rows(write):
    builder = Builder(["f8", "f8"]).add(np.random.default_rng(1), 100)
    path = write(builder.content[:-400])
    with open_recording(path, uses=[ChannelUse("ch1", "control")]) as recording:
        assert recording.n_samples == 100
        assert any("not whole" in note for note in recording.notes)
    with open_recording(path) as recording:
        assert recording.n_samples == 50


def test_a_segment_that_was_never_closed_is_read_and_marked(write):
    builder = two_channels(1)
    content = bytearray(builder.content)
    content[12:20] = b"\xff" * 8
    with open_recording(write(bytes(content))) as recording:
        assert_array_equal(recording.samples(), builder.rows() * STANDARD_GRAVITY)
        assert recording.incomplete


def test_daqmx_data_cut_short_are_a_prefix(write):
    content, expected = tdms_bytes.daqmx_file(np.random.default_rng(3), 3)
    with open_recording(write(content[:-61])) as recording:
        assert_array_equal(recording.samples(), expected[:, :89])
        assert recording.expected_samples == 100


@pytest.mark.parametrize("name", ["foreign", "empty", "stale"])
def test_an_index_file_beside_it_is_never_read(write, name):
    builder = two_channels()
    other = Builder(["f8", "f8"], rate=10.0).add(np.random.default_rng(9), 4)
    index_file = {
        "foreign": other.content.replace(b"TDSm", b"TDSh"),
        "empty": b"",
        "stale": builder.content[: builder.starts[1]].replace(b"TDSm", b"TDSh"),
    }[name]
    write(index_file, "run.tdms_index")
    with open_recording(write(builder.content)) as recording:
        assert recording.sample_rate == 1000.0
        assert_array_equal(recording.samples(), builder.rows() * STANDARD_GRAVITY)


def test_an_index_file_itself_is_refused(write):
    refused(write(two_channels().content.replace(b"TDSm", b"TDSh")), "give the .tdms file")


@pytest.mark.parametrize(("change", "match"), [(-8, "bytes too early|changed"), (8, "changed")])
def test_a_file_that_changes_while_open_is_refused(write, change, match):
    content = two_channels().content
    path = write(content)
    recording = open_recording(path)
    path.write_bytes(content[:change] if change < 0 else content + b"\0" * change)
    with pytest.raises(RecordingError, match=match):
        recording.samples()
    with pytest.raises(RecordingError, match="changed"):
        recording.__exit__(None)


@pytest.mark.parametrize("rate", [1e-300, 1e-12, 1e300])
def test_a_start_time_beside_an_absurd_rate_is_no_error(tmp_path, rate):
    start = datetime(2024, 5, 6, tzinfo=UTC)
    channels = [Channel(name, "m/s^2", name, "g") for name in ("a", "b")]
    one = recording_of_arrays("run", channels, np.ones((2, 30)), rate)
    write_tdms(tmp_path / "run.tdms", replace(one, start_time=start))
    with open_recording(tmp_path / "run.tdms") as recording:
        assert recording.sample_rate == pytest.approx(rate)
        assert recording.start_time == start


def test_a_closed_recording_says_so(write):
    with open_recording(write(two_channels().content)) as recording:
        pass
    with pytest.raises(RecordingError, match="closed"):
        recording.samples()


def test_samples_that_are_not_there_are_the_callers_error(write):
    with (
        open_recording(write(two_channels().content)) as recording,
        pytest.raises(ValueError, match="samples 0 to 31 of 30"),
    ):
        recording.samples(0, 31)


@pytest.mark.parametrize(
    ("step", "match"),
    [
        (0.0, "wf_increment is 0 s"),
        (-0.001, "wf_increment is -0.001 s"),
        (math.nan, "wf_increment is nan s"),
        (math.inf, "wf_increment is inf s"),
        (5e-324, "wf_increment is"),
        ("0.001", "wf_increment is '0.001'"),
    ],
)
def test_an_impossible_increment_tells_what_to_put_in_the_log(write, step, match):
    path = write(
        Builder(["f8"], extra={"wf_increment": step}).add(np.random.default_rng(1), 9).content
    )
    message = refused(path, match)
    assert "processing: {sample_rate: 5688.9 Hz}" in message
    with open_recording(path, sample_rate=100.0) as recording:
        assert recording.sample_rate == 100.0
        assert "The sample rate of 100 Hz is taken as given" in recording.notes[0]


def objects_file(paths, **values):
    objects = [listed(path, index("f8", 2), {"wf_increment": 1.0, **values}) for path in paths]
    return segment(metadata(objects), bytes(16 * len(paths)), 2 + 4 + 8)


@pytest.mark.parametrize(
    ("content", "match"),
    [
        (b"", "empty"),
        (b"\0" * 4096, "should begin here with b'TDSm'"),
        (b"RIFF" + bytes(60), "begins like a file of the ending .wav"),
        (objects_file(["/'g'/'a'", "/'g'/'a'"]), "listed twice"),
        (objects_file(["g/a"]), "not the path of a group or channel"),
        (objects_file(["/'g'/'a'/'b'"]), "not the path of a group or channel"),
        (objects_file(["/'" + "x" * 5000 + "'"]), "not the path of a group or channel"),
        (objects_file(["/'g'/'a'"], NI_Number_Of_Scales=2**31 + 1), "NI_Number_Of_Scales"),
        (
            objects_file(
                ["/'g'/'a'"],
                **{
                    "NI_Number_Of_Scales": 1,
                    "NI_Scale[0]_Scale_Type": "Linear",
                    "NI_Scale[0]_Linear_Slope": 1.0,
                    "NI_Scale[0]_Linear_Y_Intercept": 0.0,
                    "NI_Scale[0]_Linear_Input_Source": 0,
                },
            ),
            "can only use one before it",
        ),
        (
            objects_file(
                ["/'g'/'a'"],
                **{
                    "NI_Number_Of_Scales": 1,
                    "NI_Scale[0]_Scale_Type": "Polynomial",
                    "NI_Scale[0]_Polynomial_Coefficients_Size": 2**31,
                },
            ),
            "Coefficients_Size",
        ),
        (
            objects_file(
                ["/'g'/'a'"], **{"NI_Number_Of_Scales": 1, "NI_Scale[0]_Scale_Type": "Lineal"}
            ),
            "npTDMS warns: 'Unsupported scale type: Lineal'",
        ),
        (
            objects_file(
                ["/'g'/'a'"], **{"NI_Number_Of_Scales": 1, "NI_Scale[0]_Scale_Type": "Linear"}
            ),
            "reading the scales",
        ),
        (
            objects_file(["/'g'/'a'"], **{"NI_Scale[999999999]_Scale_Type": "Linear"}),
            "beyond the 64 that there should be",
        ),
        (segment(metadata([], padding=8) + b"\1", b"", 6), "left over that belong to nothing"),
        (segment(metadata([]), b"", 6), "lists no groups"),
        (segment(b"", b"12345678", 8), "lists no channels"),
        (segment(metadata([]), b"12345678", 6 + 8), "belong to no channel"),
        (
            segment(metadata([listed("/'g'/'a'", index("f8", 1))]), bytes(8), 6),
            "its flags say none",
        ),
        (
            segment(metadata([listed("/'g'/'a'", index("f8", 3))]), bytes(20), 6 + 8),
            "no whole number of rows",
        ),
        (segment(metadata([listed("/'g'/'a'", 0)]), b"", 6), "nothing came before"),
        (
            segment(metadata([listed("/'g'/'a'", index("f8", 1))]), bytes(8), 14, version=4711),
            "version 4711",
        ),
        (
            segment(metadata([listed("/'g'/'a'", index("f8", 1))]), bytes(8), 14, to_next=2),
            "behind its end",
        ),
        (
            segment(
                metadata([listed("/'g'/'a'", index("f8", 1).replace(b"\x0a", b"\x77", 1))]),
                bytes(8),
                14,
            ),
            "data type 0x77",
        ),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(write, content, match):
    refused(write(content), match)


def test_more_of_anything_than_a_recording_has_is_refused(write, monkeypatch):
    many = {f"p{i}": 1.0 for i in range(60)}
    path = write(Builder(["f8"] * 3, extra=many).add(np.random.default_rng(1), 5).content)
    monkeypatch.setattr(objects, "MOST_PROPERTIES", 100)
    refused(path, "more than 100 properties")
    monkeypatch.setattr(objects, "MOST_PROPERTIES", 999)
    monkeypatch.setattr(objects, "MOST_OBJECTS", 2)
    refused(path, "more than 2 channels")
    path = write(two_channels(5).content)
    monkeypatch.setattr(objects, "MOST_OBJECTS", 99)
    monkeypatch.setattr(walk, "MOST_SEGMENTS", 4)
    refused(path, "more than 4 segments")
    monkeypatch.setattr(walk, "MOST_METADATA", 100)
    refused(path, "of metadata, which is no recording")


def test_a_wrong_length_that_swallows_the_next_segment_is_found(write):
    builder = two_channels()
    content = bytearray(builder.content)
    content[12:20] = struct.pack("<Q", 1 << 40)
    refused(write(bytes(content)), "another begins inside it at byte")
    content[12:20] = struct.pack("<Q", 1 << 60)
    refused(write(bytes(content)), "says that it is")


def test_a_wrong_text_length_puts_no_raw_bytes_on_the_terminal(write):
    path = "/'\x1b[31mred\x07'/'a'"
    content = segment(metadata([listed(path, index("f8", 2))]), bytes(16), 14)
    refused(write(content), "no sample rate")
    refused(write(content.replace(b"\x1b[31", b"\xff\xfe31")), "is not text")


def test_header_padding_with_zeros_is_allowed(write):
    builder = two_channels(2, padding=4096)
    with open_recording(write(builder.content)) as recording:
        assert recording.n_samples == 20
        assert not recording.notes


def test_text_that_is_not_utf8_in_a_property_is_noted(write):
    builder = Builder(["f8"], extra={"comment": b"20 \xb0C"}).add(np.random.default_rng(1), 5)
    with open_recording(write(builder.content)) as recording:
        assert "not UTF-8" in recording.notes[0]


def test_properties_that_only_nptdms_understands_fail_in_one_line(write):
    raw = tdms_bytes.text("when") + struct.pack("<IQq", 0x44, 0, 2**62)
    head = tdms_bytes.text("/'g'/'a'") + index("f8", 2) + struct.pack("<I", 1) + raw
    refused(
        write(segment(struct.pack("<I", 1) + head, bytes(16), 14)), "sample rate|properties"
    )


def test_signalexpress_says_itself_that_it_did_not_finish(write):
    root = listed("/", 0xFFFFFFFF, {"recording-complete": False, "log-duration": 0.3})
    channel = listed("/'x - All Data'/'a'", index("f8", 10), {"wf_increment": 0.01})
    content = segment(metadata([root, channel]), bytes(80), 14)
    with open_recording(write(content)) as recording:
        assert (recording.n_samples, recording.expected_samples) == (10, 30)
