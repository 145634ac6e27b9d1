"""LVM as its definition allows: several writes under one header, a header before each.

What is right is known: the files are written here, number by number.
"""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from shakerproc.data import STANDARD_GRAVITY
from shakerproc.errors import RecordingError
from shakerproc.recordings import FilePart, open_recording
from shakerproc.recordings.lvm_heads import heads_of

STEP = 1.0 / 1024.0
VALUES = np.random.default_rng(39).standard_normal((2, 64)).round(6)


def file_head(*, headings="Yes", columns="No", separator="Tab", decimal="."):
    return [
        "LabVIEW Measurement", "Writer_Version\t2", "Reader_Version\t2",
        f"Separator\t{separator}", f"Decimal_Separator\t{decimal}",
        f"Multi_Headings\t{headings}", f"X_Columns\t{columns}", "Time_Pref\tRelative",
        "Operator\tlab", "Date\t2024/03/05", "Time\t10:11:12.5", "***End_of_Header***\t",
    ]  # fmt: skip


def segment_head(n, start="10:11:12.5", names=("control", "ch1"), unit="g", step=STEP):
    count = len(names)

    def line(name, text):
        return name + f"\t{text}" * count + "\t"

    return [
        "\t", f"Channels\t{count}\t\t", line("Samples", n), line("Date", "2024/03/05"),
        line("Time", start), line("Y_Unit_Label", unit), line("X_Dimension", "Time"),
        line("X0", "0.0000000000000000E+0"), line("Delta_X", f"{step:.10f}"),
        "***End_of_Header***\t\t\t", "\t".join(["X_Value", *names, "Comment"]),
    ]  # fmt: skip


def rows(values, first=None):
    times = [""] * values.shape[1]
    if first is not None:
        times = [f"{first + STEP * i:.10f}" for i in range(values.shape[1])]
    return [
        "\t".join([t, *(f"{v:.6f}" for v in row)])
        for t, row in zip(times, values.T, strict=True)
    ]


@pytest.fixture
def write(tmp_path):
    def write(*parts, decimal=".", end="\r\n"):
        text = end.join(line for part in parts for line in part) + end
        if decimal == ",":
            head, mark, rest = text.partition("Decimal_Separator\t,")
            text = head + mark + rest.replace(".", ",")
        path = tmp_path / "run.lvm"
        path.write_text(text, newline="")
        return path

    return write


def segments(starts, **kind):
    cut = VALUES.shape[1] // len(starts)
    parts = [file_head(**kind)]
    for number, start in enumerate(starts):
        parts += [segment_head(cut, start), rows(VALUES[:, number * cut : (number + 1) * cut])]
    return parts


@pytest.mark.parametrize("times", [None, 0.0])
def test_several_writes_under_one_header_are_one_recording_and_told(write, times):
    path = write(file_head(headings="No"), segment_head(16), rows(VALUES, times))
    with open_recording(path) as recording:
        assert_allclose(recording.samples(), VALUES * STANDARD_GRAVITY, rtol=1e-12)
        assert recording.expected_samples is None
        assert any("several writes under one header" in note for note in recording.notes)


def test_a_last_write_under_one_header_that_is_short_marks_the_recording(write):
    path = write(file_head(headings="No"), segment_head(48), rows(VALUES))
    with open_recording(path) as recording:
        assert (recording.n_samples, recording.expected_samples) == (64, 96)


def test_a_segment_that_is_longer_than_its_own_header_says_is_refused(write):
    path = write(file_head(), segment_head(63), rows(VALUES))
    with pytest.raises(RecordingError, match="holds 64 values but Samples says 63"):
        open_recording(path)


def test_a_header_that_says_a_thing_twice_is_used_only_if_both_are_alike(write):
    """As `make fuzz` found it: a line end within `X_Dimension Time` makes a second `Time`."""
    head = segment_head(64)
    with open_recording(write(file_head(), [head[4], *head], rows(VALUES))) as recording:
        assert recording.start_time.isoformat() == "2024-03-05T10:11:12.500000+00:00"
    for torn in (["Time\t"], ["X0\t5\t5\t"]):
        with pytest.raises(RecordingError, match=r"two lines (Time|X0): .* Delete the wrong"):
            open_recording(write(file_head(), [*head[:-2], *torn, *head[-2:]], rows(VALUES)))
    with pytest.raises(RecordingError, match=r"two lines Decimal_Separator: ',' and '\.'"):
        open_recording(write(["LabVIEW Measurement", "Decimal_Separator\t,",
                              *file_head()[1:]], head, rows(VALUES)))  # fmt: skip


@pytest.mark.parametrize("decimal", [".", ","])
def test_segments_whose_times_follow_on_are_one_recording(write, decimal):
    starts = ["10:11:12.5", "10:11:12.53125"]  # 32 samples of 1/1024 s later
    path = write(*segments(starts, decimal=decimal), decimal=decimal)
    with open_recording(path) as recording:
        assert_allclose(recording.samples(), VALUES * STANDARD_GRAVITY, rtol=1e-12)
        assert_allclose(recording.sample_rate, 1024.0, rtol=1e-6)
        assert recording.start_time.isoformat() == "2024-03-05T10:11:12.500000+00:00"


@pytest.mark.parametrize("skip", ["refuse", "skip"])
def test_segments_with_a_pause_between_are_measurements_and_none_invents_samples(write, skip):
    path = write(*segments(["10:11:12.5", "10:11:42.5"]))
    with pytest.raises(RecordingError, match=r"2 measurements follow each other.*or all"):
        open_recording(path, bad_rows=skip)
    for number in (1, 2):
        part = FilePart(measurement=number)
        with open_recording(path, part=part, bad_rows=skip) as recording:
            here = VALUES[:, 32 * (number - 1) : 32 * number]
            assert_allclose(recording.samples(), here * STANDARD_GRAVITY, rtol=1e-12)
            assert recording.start_time.second == (12, 42)[number - 1]
    with open_recording(path, part=FilePart(measurement="all"), bad_rows=skip) as recording:
        assert_allclose(recording.samples(), VALUES * STANDARD_GRAVITY, rtol=1e-12)


def test_a_bad_row_at_the_end_of_a_segment_is_left_out_and_not_bridged(write):
    parts = segments(["10:11:12.5", "10:11:42.5"])
    parts[2][-1] = "\toops\toops"
    path = write(*parts)
    with pytest.raises(RecordingError, match="'oops' in column 2 is no number"):
        open_recording(path, part=FilePart(measurement="all"))
    with open_recording(path, part=FilePart(measurement=1), bad_rows="skip") as recording:
        assert_array_equal(recording.samples(), VALUES[:, :31] * STANDARD_GRAVITY)
        assert recording.skipped.bridged == 0


def test_writes_under_one_header_whose_times_begin_again_are_measurements(write):
    halves = (rows(VALUES[:, :32], 0.0), rows(VALUES[:, 32:], 0.0))
    path = write(file_head(headings="No", columns="One"), segment_head(32), *halves)
    with open_recording(path, part=FilePart(measurement=2)) as recording:
        assert_allclose(recording.samples(), VALUES[:, 32:] * STANDARD_GRAVITY, rtol=1e-12)


@pytest.mark.parametrize(
    ("change", "match"), [({"unit": "N"}, "differ in unit"), ({"step": 0.01}, "differ in rate")]
)
def test_segments_of_another_unit_or_rate_are_never_one(write, change, match):
    halves = (rows(VALUES[:, :32]), rows(VALUES[:, 32:]))
    heads = (segment_head(32), segment_head(32, "10:11:12.53125", **change))
    path = write(file_head(), heads[0], halves[0], heads[1], halves[1])
    with pytest.raises(RecordingError, match=match):
        open_recording(path, part=FilePart(measurement="all"))


def test_segments_of_other_channels_are_measurements_and_never_one(write):
    path = write(
        file_head(), segment_head(32), rows(VALUES[:, :32]),
        segment_head(32, names=("other",)), rows(VALUES[:1, 32:]),
    )  # fmt: skip
    with pytest.raises(RecordingError, match="differ in channels"):
        open_recording(path, part=FilePart(measurement="all"))
    with open_recording(path, part=FilePart(measurement=2)) as recording:
        assert [channel.name for channel in recording.channels] == ["other"]
        assert_allclose(recording.samples(), VALUES[:1, 32:] * STANDARD_GRAVITY, rtol=1e-12)


def test_an_appended_run_with_both_headers_and_notes_of_other_programs_is_read(write):
    special = ["***Start_Special***\t", "\tanything 1 2 3", "***End_Special***\t"]
    path = write(
        file_head(), special, segment_head(32), rows(VALUES[:, :32]), ["", *file_head()],
        segment_head(32, "10:11:12.53125"), rows(VALUES[:, 32:]),
    )  # fmt: skip
    with open_recording(path) as recording:
        assert_allclose(recording.samples(), VALUES * STANDARD_GRAVITY, rtol=1e-12)


def test_every_channel_has_its_own_times_where_the_header_says_so(write):
    """Two rates in one file: a user takes the channels of one."""
    head = segment_head(32)
    head[2] = "Samples\t32\t\t16\t"
    head[8] = f"Delta_X\t{STEP:.10f}\t\t{2.0 * STEP:.10f}\t"
    for at in (3, 4, 5, 6, 7):
        name, text = head[at].split("\t")[:2]
        head[at] = f"{name}\t{text}\t\t{text}\t"
    head[-1] = "X_Value\tfast\tX_Value\tslow\tComment"
    body = [
        f"{STEP * i:.10f}\t{VALUES[0, i]:.6f}\t"
        + (f"{2.0 * STEP * i:.10f}\t{VALUES[1, i]:.6f}" if i < 16 else "\t")
        for i in range(32)
    ]
    path = write(file_head(columns="Multi"), head, body)
    from shakerproc.data import ChannelUse

    for name, rate, n in (("fast", 1024.0, 32), ("slow", 512.0, 16)):
        with open_recording(path, uses=[ChannelUse(name, "response")]) as recording:
            assert_allclose(recording.sample_rate, rate, rtol=1e-5)
            assert recording.n_samples == n


def test_remarks_at_the_end_of_rows_are_no_numbers(write):
    body = rows(VALUES)
    body[0] += "\tfirst of the run, 3 g"
    body[40] += "\tdoor closed"
    path = write(file_head(), segment_head(64), body)
    with open_recording(path) as recording:
        assert_allclose(recording.samples(), VALUES * STANDARD_GRAVITY, rtol=1e-12)


def test_the_rows_of_a_table_are_where_the_text_has_them(write):
    path = write(*segments(["10:11:12.5", "10:11:42.5"]))
    lines = path.read_text().splitlines()
    heads = heads_of(path.read_bytes(), "utf-8-sig", "run")
    assert [lines[head.first - 1].split("\t")[0] for head in heads] == ["X_Value", "X_Value"]
