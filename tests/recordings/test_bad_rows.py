"""Text recordings in which a line is no row of numbers: named and refused, or skipped."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from tests.in_process import run

from shakerproc.data import STANDARD_GRAVITY, ChannelUse
from shakerproc.errors import RecordingError
from shakerproc.recordings import health, open_recording
from shakerproc.runs import open_path
from shakerproc.testlog import read_testlog

RATE = 1000.0
WAVE = np.sin(np.arange(8000) / 7.0)


CELLS = [(f"{i / RATE:.3f}", f"{y:.6f}", f"{-2 * y:.6f}") for i, y in enumerate(WAVE)]


def rows(n=1000, delimiter=",", decimal="."):
    """The lines of a good table of time, a and b."""
    return [delimiter.join(row).replace(".", decimal) for row in CELLS[:n]]


def written(tmp_path, lines, head=("t [s],a [g],b [g]",), name="run.csv"):
    path = tmp_path / name
    path.write_text("\n".join([*head, *lines, ""]))
    return path


def refusal(path, **options):
    with pytest.raises(RecordingError) as caught, open_recording(path, **options):
        pass
    assert str(caught.value).isprintable()
    return str(caught.value)


BAD = {
    "t [s],a [g],b [g]": "'t [s]' in column 1 is no number",
    "": "it is blank",
    "0.600,OVL,1.0": "'OVL' in column 2 is no number",
    "0.600,inf,1.0": "'inf' in column 2 is no number",
    "0.600,1e999,1.0": "'1e999' in column 2 is no number",
    "0.600,nan,1.0": "'nan' in column 2 is no number",
    "0.600,1.0": "it has 2 cells",
    "0.600,1.0,2.0,3.0": "it has 4 cells",
    "0,600,1,5,2,5": "it has 6 cells",
    "0.600;1.5;2.5": "it has 1 cell",
    "0.600,1_0,2.0": "'1_0' in column 2 is no number",
    "0.600,0x1F,2.0": "'0x1F' in column 2 is no number",
    "0.600,\0,2.0": "'\\x00' in column 2 is no number",
}


@pytest.mark.parametrize("bad", BAD)
@pytest.mark.parametrize("at", [0, 600, 3999])
def test_a_line_that_is_no_row_of_numbers_is_named_wherever_it_stands(tmp_path, bad, at):
    lines = rows(4000)
    lines[at] = bad
    if at == 0 and bad in {"", "t [s],a [g],b [g]"}:
        pytest.skip("that is a header")
    if at == 3999 and not bad:
        pytest.skip("that is the end")
    message = refusal(written(tmp_path, lines))
    assert message.startswith(f"run.csv: line {at + 2}: {BAD[bad]}, where 3 numbers are wanted")
    assert message.endswith("processing: {bad_rows: skip} in the log (or --bad-rows skip).")


@pytest.mark.parametrize("at", [1, 3900])
@pytest.mark.parametrize("bad", ["0.600,OVL,1.0", "0.600,1.0", "OVL,OVL,OVL"])
def test_a_row_that_is_skipped_leaves_a_gap_in_time_which_a_straight_line_bridges(
    tmp_path, bad, at
):
    lines = rows(4000)
    lines[at] = bad
    with open_recording(written(tmp_path, lines), bad_rows="skip") as recording:
        assert (recording.n_samples, recording.sample_rate) == (4000, RATE)
        found = recording.samples()[0] / STANDARD_GRAVITY
        (flag,) = [flag for flag in health(recording) if flag.kind == "bad rows"]
        assert "1 line that is no row of numbers was skipped" in recording.notes[0]
        assert f"line {at + 2}: " in recording.notes[0]
        assert "1 sample is bridged by straight lines (as the time column says)" in flag.message
        assert flag.start <= at / RATE <= flag.stop
    expected = WAVE[:4000].round(6)
    expected[at] = (expected[at - 1] + expected[at + 1]) / 2.0
    assert_allclose(found, expected, atol=1e-12)


@pytest.mark.parametrize("bad", ["", "t [s],a [g],b [g]"])
def test_a_blank_line_or_a_header_that_is_skipped_is_no_gap(tmp_path, bad):
    lines = rows()
    lines.insert(600, bad)
    with open_recording(written(tmp_path, lines), bad_rows="skip") as recording:
        assert recording.n_samples == 1000
        assert_array_equal(recording.samples()[0], WAVE[:1000].round(6) * STANDARD_GRAVITY)
        assert "0 samples are bridged" in recording.notes[0]


def test_without_a_time_column_it_is_said_that_nothing_tells_what_was_missing(tmp_path):
    lines = [line.partition(",")[2] for line in rows()]
    lines[600] = "OVL,1.0"
    path = written(tmp_path, lines, ["a [g],b [g]"])
    with open_recording(path, bad_rows="skip", sample_rate=RATE) as recording:
        assert recording.n_samples == 1000
        assert "no time column says how many were missing" in recording.notes[0]


def test_a_second_recording_in_the_file_is_refused_even_when_bad_rows_are_skipped(tmp_path):
    lines = [*rows(600), "t [s],a [g],b [g]", *rows(400)]
    message = refusal(written(tmp_path, lines), bad_rows="skip")
    assert "time column 't' does not advance evenly" in message


def test_a_row_that_is_missing_without_a_trace_is_seen_in_the_time_column(tmp_path):
    lines = rows(8000)
    del lines[4000]
    assert "from sample 3999 to 4000 it takes 0.002 s" in refusal(written(tmp_path, lines))
    lines = rows(8000)
    lines.insert(4000, lines[4000])
    assert "from sample 4000 to 4001 it takes 0 s" in refusal(written(tmp_path, lines))


def test_many_bad_rows_are_counted_and_the_first_are_named(tmp_path):
    lines = rows()
    for at in range(100, 900, 100):
        lines[at] = "OVL,OVL,OVL"
    path = written(tmp_path, lines)
    assert "8 lines are no rows of numbers (lines 102, 202, 302, 402, 502 and so on)" in (
        refusal(path)
    )
    with open_recording(path, bad_rows="skip") as recording:
        assert recording.notes[0].startswith("8 lines that are no rows of numbers were skipped")
        assert recording.skipped.count == recording.skipped.bridged == 8


def test_channels_that_end_before_the_time_column_are_incomplete(tmp_path):
    lines = rows(8000)
    lines[6000:] = [line.partition(",")[0] + ",," for line in lines[6000:]]
    with open_recording(written(tmp_path, lines)) as recording:
        assert (recording.n_samples, recording.expected_samples) == (6000, 8000)
        assert "'a' ends after 6000 of 8000 rows." in recording.notes
        assert "incomplete" in {flag.kind for flag in health(recording)}


@pytest.mark.parametrize(("delimiter", "decimal"), [(";", ","), ("\t", "."), (" ", ".")])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_bad_rows_are_found_whatever_the_signs_and_line_ends(tmp_path, delimiter, decimal, end):
    lines = rows(3000, delimiter, decimal)
    lines[2000] = delimiter.join(["2", "OVL", "1"])
    path = tmp_path / "run.txt"
    head = delimiter.join(["t[s]", "a[g]", "b[g]"])
    path.write_bytes(end.join([head, *lines, ""]).encode())
    assert "line 2002: 'OVL' in column 2 is no number" in refusal(path)
    with open_recording(path, bad_rows="skip") as recording:
        assert recording.n_samples == 3000


def test_headers_may_be_comments_and_lines_below_them_too(tmp_path):
    path = written(tmp_path, rows(), ["# t [s],a [g],b [g]", "", "# 1,2,3"])
    with open_recording(path) as recording:
        assert [channel.name for channel in recording.channels] == ["a", "b"]
        assert (recording.n_samples, recording.sample_rate) == (1000, RATE)


@pytest.mark.parametrize(
    ("interval", "first"),
    [("Interval,0.01,0.01", None), ("Interval [ms],10", None), ("Interval,0.01 s", ""),
     ("Interval,10 ms", "count"), ("dt,0.01", "none")],
)  # fmt: skip
def test_interval_name_and_unit_may_stand_in_rows_with_labels(tmp_path, interval, first):
    """The first column holds times, nothing, a count, or is not there."""
    plain = [f"{a:.5f},{b:.5f}" for a, b in zip(WAVE, WAVE[::-1], strict=True)]
    before = {
        None: lambda i: f"{i / 100:.2f},", "": lambda _: ",", "count": lambda i: f"{i},",
        "none": lambda _: "",
    }[first]  # fmt: skip
    lines = [before(i) + line for i, line in enumerate(plain)]
    head = [interval, "Channel name,ch1,ch2", "Unit,g,mm/s^2"]
    with open_recording(written(tmp_path, lines, head)) as recording:
        assert [(c.name, c.source_unit) for c in recording.channels] == [
            ("ch1", "g"), ("ch2", "mm/s^2")
        ]  # fmt: skip
        assert recording.sample_rate == 100.0
        assert recording.samples()[1, 0] == pytest.approx(1e-3 * WAVE[-1], abs=1e-8)


@pytest.mark.parametrize(
    ("head", "name"),
    [
        ("time [K],a [g],b [g]", "time"),
        ("SampleTimeFine,a [g],b [g]", "SampleTimeFine"),
        (None, "column 1"),
    ],
)
def test_a_time_column_never_becomes_a_channel(tmp_path, head, name):
    path = written(tmp_path, rows(), [head] if head else [])
    with open_recording(path, sample_rate=RATE) as recording:
        assert len(recording.channels) == 2
        assert recording.notes[0].startswith(f"'{name}' is no channel: it ")


@pytest.mark.parametrize(
    ("unit", "seconds"),
    [("ms", 1e-3), ("us", 1e-6), ("µs", 1e-6), ("min", 60.0), ("h", 3600.0)],
)
def test_times_are_understood_in_other_units_than_seconds(tmp_path, unit, seconds):
    lines = [f"{i / RATE / seconds!r},{WAVE[i]:.6f}" for i in range(1000)]
    with open_recording(written(tmp_path, lines, [f"time [{unit}],a [g]"])) as recording:
        assert recording.sample_rate == pytest.approx(RATE, rel=1e-9)


def test_a_dat_file_is_a_table_of_text_or_refused(tmp_path):
    with open_recording(written(tmp_path, rows(), name="run.dat")) as recording:
        assert recording.n_samples == 1000
    (tmp_path / "raw.dat").write_bytes(np.arange(9000.0).astype("<f4").tobytes())
    assert "no table of numbers in the first" in refusal(tmp_path / "raw.dat")


@pytest.mark.parametrize("times", [True, False])
def test_a_column_of_the_sample_rate_is_no_channel(tmp_path, times):
    lines = [
        (f"{i / 400:.4f}," if times else "") + f"{WAVE[i]:.6f},{'400' if i < 1 else ''}"
        for i in range(1000)
    ]
    head = ("time [s]," if times else "") + "a [g],Fs"
    with open_recording(written(tmp_path, lines, [head])) as recording:
        assert [c.name for c in recording.channels] == ["a"]
        assert recording.sample_rate == 400.0
        assert [(c.name, c.why) for c in recording.unused] == [
            ("Fs", "it says the sample rate, 400 Hz")
        ]
    wrong = [lines[0][:-3] + "500", *lines[1:]]
    if times:
        assert "the file contradicts itself" in refusal(written(tmp_path, wrong, [head]))


def test_too_few_samples_for_a_segment_name_the_segment_that_would_do(tmp_path, capsys):
    path = written(tmp_path, rows(481))
    assert run("process", path, "--no-crop", "--no-figures", "--out", tmp_path / "out") == 1
    error = capsys.readouterr().err
    assert "481 samples are fewer than one segment of 1024" in error
    assert "processing: {welch: {segment: 64}}" in error


def two_rates(tmp_path):
    """A table of a at 1000 Hz and b at 500 Hz, half as long."""
    lines = [f"{i / RATE:.3f},{WAVE[i]:.6f}" for i in range(1000)]
    lines = [
        f"{line},{i / 500:.3f},{WAVE[i]:.6f}" if i < 500 else f"{line},,"
        for i, line in enumerate(lines)
    ]
    return written(tmp_path, lines, ["time 1 [s],a [g],time 2 [s],b [g]"])


def test_each_time_column_is_that_of_the_columns_behind_it(tmp_path):
    path = two_rates(tmp_path)
    assert "channel 'a' has 1000 samples per second, 'b' 500. Use only" in refusal(path)
    for name, rate, n in (("a", 1000.0, 1000), ("b", 500.0, 500)):
        with open_recording(path, uses=[ChannelUse(name, "response")]) as recording:
            assert (recording.sample_rate, recording.n_samples) == (rate, n)
            assert not recording.incomplete


LVM = (
    "LabVIEW Measurement{s}\nSeparator{s}{word}\nDecimal_Separator{s}{d}\n"
    "***End_of_Header***{s}\nChannels{s}2{s}{s}\nSamples{s}{n}{s}{n}{s}\n"
    "Y_Unit_Label{s}g{s}g{s}\nDelta_X{s}0{d}001{s}0{d}001{s}\n***End_of_Header***{s}{s}\n"
    "X_Value{s}a{s}b{s}Comment"
)


def lvm(tmp_path, lines, samples=1000, delimiter="\t", word="Tab", decimal="."):
    head = LVM.format(s=delimiter, word=word, d=decimal, n=samples).splitlines()
    return written(tmp_path, lines, head, "run.lvm")


@pytest.mark.parametrize(
    ("delimiter", "word"), [("\t", "Tab"), (",", "Comma"), (";", "Semicolon")]
)
def test_lvm_is_read_with_every_separator(tmp_path, delimiter, word):
    decimal = "," if delimiter == ";" else "."
    path = lvm(tmp_path, rows(1000, delimiter, decimal), 1000, delimiter, word, decimal)
    with open_recording(path) as recording:
        assert (recording.n_samples, recording.sample_rate) == (1000, RATE)
        assert_allclose(recording.samples()[1], -2 * WAVE[:1000] * STANDARD_GRAVITY, atol=1e-5)


def test_lvm_with_more_rows_than_samples_is_refused(tmp_path):
    message = refusal(lvm(tmp_path, rows(1000, "\t"), 999))
    assert "'a' holds 1000 values but Samples says 999" in message


@pytest.mark.parametrize("bad", ["0.600\tOVL\t1.0\t", "", "0.600\t1.0"])
def test_a_bad_row_of_lvm_is_named_or_skipped(tmp_path, bad):
    lines = rows(1000, "\t")
    lines[600] = bad
    path = lvm(tmp_path, lines)
    assert refusal(path).startswith("run.lvm: line 611: ")
    with open_recording(path, bad_rows="skip") as recording:
        assert (recording.n_samples, recording.skipped.count) == (1000, 1)


def test_a_comment_behind_the_numbers_of_lvm_is_no_bad_row(tmp_path):
    lines = [f"{line}\t" for line in rows(1000, "\t")]
    lines[600] += "overload, see photo"
    with open_recording(lvm(tmp_path, lines)) as recording:
        assert recording.n_samples == 1000


def test_the_log_says_for_all_tests_or_for_one_that_bad_rows_are_skipped(tmp_path):
    lines = rows()
    lines[600] = "0.600,OVL,1.0"
    written(tmp_path, lines)
    log = tmp_path / "log.yaml"
    log.write_text(
        "testlog: 1\nrecordings: .\nprocessing: {crop: none, bad_rows: skip}\n"
        "channels: {a: {role: control}, b: {role: response}}\ntests:\n"
        "  - {id: 1, recording: run.csv}\n"
        "  - {id: 2, recording: run.csv, processing: {bad_rows: refuse}}\n"
    )
    one, two = read_testlog(log).tests
    with open_path(one.recording, one) as recording:
        assert recording.skipped.count == 1
    with pytest.raises(RecordingError, match="line 602: 'OVL'"), open_path(two.recording, two):
        pass


def test_the_commands_that_read_a_file_skip_bad_rows_on_request(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    lines = rows(8000)
    lines[600] = "0.600,OVL,1.0"
    path = written(tmp_path, lines)
    assert run("inspect", path) == 1
    capsys.readouterr()
    assert run("inspect", path, "--bad-rows", "skip") == 0
    assert (
        "1 line that is no row of numbers was skipped (line 602: 'OVL'"
        in capsys.readouterr().out
    )
    assert run("inspect", path, "--bad-rows", "drop") == 2
    out = tmp_path / "out.tdms"
    assert run("convert", path, out) == 1
    assert run("convert", path, out, "--bad-rows", "skip") == 0
    assert run("process", path) == 1
    assert "line 602: 'OVL'" in capsys.readouterr().err
