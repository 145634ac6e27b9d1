"""WAV in every width, cut, packed and of other bytes.

Oracles: Python's ``wave``, scipy's reader, and files that are put together here by hand.
"""

import struct
import wave
from datetime import UTC, datetime

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from scipy.io import wavfile

from shakerproc.data import STANDARD_GRAVITY, ChannelUse
from shakerproc.errors import RecordingError
from shakerproc.recordings import Sampling, open_recording

RATE = 5000
COUNTS = np.random.default_rng(44).integers(-(2**31), 2**31, (60, 3), np.int64).astype("i4")
PCM = bytes.fromhex("0100000000001000800000aa00389b71")


def chunk(name, content, order="<"):
    return struct.pack(f"{order}4sI", name, len(content)) + content + b"\0" * (len(content) % 2)


def file_of(content, *, kind=b"RIFF", order="<"):
    return struct.pack(f"{order}4sI", kind, len(content) + 4) + b"WAVE" + content


def head(bits, channels=3, order="<", tag=1, frame=0, per_second=0):
    frame = frame or channels * bits // 8
    return struct.pack(
        f"{order}HHIIHH", tag, channels, RATE, per_second or RATE * frame, frame, bits
    )


@pytest.fixture
def write(tmp_path):
    def write(content, name="run.wav"):
        (tmp_path / name).write_bytes(content)
        return tmp_path / name

    return write


def samples(path, **options):
    with open_recording(path, **options) as recording:
        assert recording.sample_rate == RATE
        return recording.samples()


@pytest.mark.parametrize("kind", ["u1", "i2", "i4", "f4", "f8"])
def test_samples_are_those_that_scipy_reads_over_full_scale(tmp_path, kind):
    path, width = tmp_path / "run.wav", np.dtype(kind).itemsize
    shares = COUNTS / 2.0**31
    written = (
        shares.astype(kind) if kind[0] == "f" else (COUNTS >> (32 - 8 * width)).astype(kind)
    )
    wavfile.write(path, RATE, written + (128 if kind == "u1" else 0))
    read = wavfile.read(path)[1].T.astype(float)
    full = {"u1": 128.0, "i2": 2.0**15, "i4": 2.0**31}.get(kind, 1.0)
    assert_array_equal(samples(path), (read - 128.0 * (kind == "u1")) / full)


@pytest.mark.parametrize("width", [1, 2, 3, 4])
def test_samples_are_those_that_the_standard_library_reads(tmp_path, width):
    path = tmp_path / "run.wav"
    raw = COUNTS.view("u1").reshape(-1, 4)[:, 4 - width :].tobytes()
    with wave.open(str(path), "wb") as file:
        file.setparams((3, width, RATE, 0, "NONE", ""))
        file.writeframes(raw)
    with wave.open(str(path)) as file:
        frames = file.readframes(file.getnframes())
    each = [frames[at : at + width] for at in range(0, len(frames), width)]
    numbers = [int.from_bytes(one, "little", signed=width > 1) for one in each]
    shares = (np.array(numbers, float) - 128.0 * (width == 1)) / 2.0 ** (8 * width - 1)
    assert_array_equal(samples(path), shares.reshape(-1, 3).T)


def test_a_slice_of_some_channels_is_that_of_all(write):
    path = write(file_of(chunk(b"fmt ", head(32)) + chunk(b"data", COUNTS.tobytes())))
    with open_recording(path) as recording:
        assert_array_equal(recording.samples(7, 31), recording.samples()[:, 7:31])


def test_long_files_big_endian_files_and_the_extensible_form_are_the_same_samples(write):
    data = COUNTS.tobytes()
    plain = samples(write(file_of(chunk(b"fmt ", head(32)) + chunk(b"data", data))))
    extended = head(32, tag=0xFFFE) + struct.pack("<HHI", 22, 32, 0) + PCM
    assert_array_equal(
        samples(write(file_of(chunk(b"fmt ", extended) + chunk(b"data", data)))), plain
    )
    turned = chunk(b"fmt ", head(32, order=">"), ">") + chunk(
        b"data", COUNTS.astype(">i4").tobytes(), ">"
    )
    turned = file_of(turned, kind=b"RIFX", order=">")
    assert_array_equal(samples(write(turned)), plain)
    whole = 4 + 36 + 24 + 8 + len(data)
    sizes = chunk(b"ds64", struct.pack("<QQQI", whole, len(data), len(COUNTS), 0))
    long = struct.pack("<4sI", b"RF64", 0xFFFFFFFF) + b"WAVE" + sizes
    long += chunk(b"fmt ", head(32)) + struct.pack("<4sI", b"data", 0xFFFFFFFF) + data
    assert_array_equal(samples(write(long, "run.rf64")), plain)


def test_the_log_says_what_full_scale_and_a_volt_stand_for(write):
    path = write(file_of(chunk(b"fmt ", head(32)) + chunk(b"data", COUNTS.tobytes())))
    uses = [
        ChannelUse(1, "response", unit="10 V", sensitivity="100 mV/g"),
        ChannelUse(2, "response", unit="5 g"),
        ChannelUse(3, "voltage", unit="10 V"),
    ]
    shares = COUNTS.T / 2.0**31
    wanted = shares * np.array([[100.0 * STANDARD_GRAVITY], [5.0 * STANDARD_GRAVITY], [10.0]])
    np.testing.assert_allclose(samples(path, uses=uses), wanted, rtol=1e-14)
    with pytest.raises(RecordingError, match=r"run.wav: channel 'channel 1' has no unit"):
        samples(path, uses=[ChannelUse(1, "response")])


def test_a_broadcast_file_says_when_it_began_and_what_it_is_called(write):
    content = chunk(b"fmt ", head(32)) + chunk(b"LIST", b"INFO" + chunk(b"INAM", b"rig 3"))
    for since, microsecond in ((int((3600 * 7 + 5.25) * RATE), 250_000), (17, 0)):
        date = b"2026-11-27" + b"07:00:05" + struct.pack("<Q", since)
        bext = b"\0" * 320 + date + b"\0" * 256
        path = write(file_of(content + chunk(b"bext", bext) + chunk(b"data", COUNTS.tobytes())))
        with open_recording(path) as recording:
            begun = datetime(2026, 11, 27, 7, 0, 5, microsecond, tzinfo=UTC)
            assert recording.start_time == begun
            assert any("(INAM): 'rig 3'" in note for note in recording.notes)


def test_a_file_that_is_cut_is_a_prefix_and_incomplete(write):
    content = file_of(chunk(b"fmt ", head(32)) + chunk(b"data", COUNTS.tobytes()))
    with open_recording(write(content[:-30])) as recording:
        assert (recording.n_samples, recording.expected_samples) == (57, 60)
        assert_array_equal(recording.samples(), COUNTS[:57].T / 2.0**31)


@pytest.mark.parametrize("size", [0, 0xFFFFFFFF])
def test_a_recorder_that_never_wrote_the_length_leaves_an_incomplete_file(write, size):
    content = chunk(b"fmt ", head(32)) + struct.pack("<4sI", b"data", size) + COUNTS.tobytes()
    with open_recording(write(file_of(content))) as recording:
        assert recording.incomplete
        assert_array_equal(recording.samples(), COUNTS.T / 2.0**31)
        assert any("never wrote how long" in note for note in recording.notes)


DATA = chunk(b"data", COUNTS.tobytes())


@pytest.mark.parametrize(
    ("content", "match"),
    [
        (b"", "the file is empty|byte 0: '' begins no WAV file"),
        (b"\xd0\xcf\x11\xe0" * 9, "byte 0: .* begins no WAV file"),
        (file_of(DATA), "the chunk 'fmt ' is missing"),
        (file_of(chunk(b"fmt ", head(32))), "the chunk 'data' is missing"),
        (file_of(chunk(b"fmt ", b"\0" * 9) + DATA), "byte 20: .* has 9 bytes, not 16"),
        (file_of(chunk(b"fmt ", head(8, tag=6)) + DATA), "packed as A-law"),
        (file_of(chunk(b"fmt ", head(32, tag=0x1234)) + DATA), "packed as type 0x1234"),
        (file_of(chunk(b"fmt ", head(32, frame=10)) + DATA), "3 channels of 32 bits cannot"),
        (file_of(chunk(b"fmt ", head(16, tag=3)) + DATA), "of 16 bits cannot stand in 6"),
        (file_of(chunk(b"fmt ", head(32, 0, frame=4)) + DATA), "0 channels"),
        (file_of(chunk(b"fmt ", head(32, per_second=7)) + DATA), "contradicts itself: 5000"),
        (
            file_of(chunk(b"fmt ", head(32)) + DATA[:4] + b"\x10\0\0\0" + DATA[8:]),
            r"byte 60: .* is no chunk, so that the one before",
        ),
    ],
)  # fmt: skip
def test_what_is_no_recording_is_refused_in_one_line(write, content, match):
    with pytest.raises(RecordingError, match=rf"run.wav: .*({match})") as caught:
        open_recording(write(content))
    assert str(caught.value).isprintable()


def test_a_rate_that_the_file_contradicts_is_set_aside_by_the_log(write):
    path = write(file_of(chunk(b"fmt ", head(32, per_second=7)) + DATA))
    assert samples(path, sample_rate=Sampling(RATE, override=True)).shape == (3, 60)
