"""Lines above a table of text: comments, a rate, a start, units; none of them is a sample.

Oracle: the numbers that were written, and the rate that the line says.
"""

from datetime import UTC, datetime

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.data import STANDARD_GRAVITY
from shakerproc.errors import RecordingError
from shakerproc.recordings import open_recording

VALUES = np.random.default_rng(7).standard_normal((2, 60)).round(4)
TIMES = np.arange(60) / 2000.0
ROWS = "".join(f"{a:.4f},{b:.4f}\n" for a, b in VALUES.T)
TIMED = "".join(f"{t:.4f},{a:.4f},{b:.4f}\n" for t, (a, b) in zip(TIMES, VALUES.T, strict=True))
SIGNS = ["#", "%", ";", "!", "//", "'", "REM ", "rem ", "*", "**", "--"]


@pytest.fixture
def read(tmp_path):
    def read(text, **options):
        path = tmp_path / "run.csv"
        path.write_text(text)
        with open_recording(path, **options) as recording:
            return recording, recording.samples()

    return read


@pytest.mark.parametrize("sign", [*SIGNS, '"'])
def test_comments_of_every_sign_are_neither_names_nor_rows(read, sign):
    end = '"' if sign == '"' else ""
    note = f"{sign}bench 3, of 5 parts{end}\n"
    below = f"{sign}s, g and g are the units{end}\n"
    for text in (note * 2 + "time,a (g),b (g)\n" + TIMED, f"time,a (g),b (g)\n{below}{TIMED}"):
        recording, samples = read(text)
        assert [c.name for c in recording.channels] == ["a", "b"]
        assert recording.sample_rate == 2000.0
        assert_allclose(samples, VALUES * STANDARD_GRAVITY, rtol=1e-12)


@pytest.mark.parametrize("sign", SIGNS)
def test_names_in_a_comment_are_names_where_no_other_line_is(read, sign):
    recording, samples = read(f"{sign}time,a (g),b (g)\n{TIMED}{sign}end of file\n")
    assert [c.name for c in recording.channels] == ["a", "b"]
    assert_allclose(samples, VALUES * STANDARD_GRAVITY, rtol=1e-12)


@pytest.mark.parametrize(
    "above",
    [
        "Sample Rate (Hz),2000\nstart,0.5\na (g),b (g)\n",
        '"Sample Rate (Hz)","2000"\n"a (g)","b (g)"\n',
        "Sampling frequency [kHz],2.0\nChannels,2\na (g),b (g)\n",
        "Sample rate: 2000 Hz\nStart: 0.5 s\na (g),b (g)\n",
        "# fs = 2000\n# a (g),b (g)\n",
        "! Abtastrate 1\n% Samples per second: 2000\na (g),b (g)\n",
        "Sample interval (ms),0.5\na (g),b (g)\n",
        "dt,0.0005\na,b\ng,g\n",
        "start,rate\n0.5,2000\na (g),b (g)\n",
        "1709633472,2000\na (g),b (g)\n",
    ],
)
def test_a_rate_above_a_table_is_used_and_nothing_above_it_is_a_sample(read, above):
    rate = 2000.0 if "1709633472" in above else None
    recording, samples = read(above + ROWS, sample_rate=rate)
    assert_allclose(samples, VALUES * STANDARD_GRAVITY, rtol=1e-12)
    assert [c.name for c in recording.channels] == ["a", "b"]
    assert recording.sample_rate == 2000.0


@pytest.mark.parametrize("end", [",", ",,"])
def test_separators_at_the_ends_of_all_lines_change_nothing(read, end):
    text = "Sample Rate (Hz),2000\na (g),b (g)\n" + ROWS
    recording, samples = read(text.replace("\n", f"{end}\n"))
    assert_allclose(samples, VALUES * STANDARD_GRAVITY, rtol=1e-12)
    assert recording.sample_rate == 2000.0


@pytest.mark.parametrize("above", ["2000,0.5\n", "2000,0.5\n60,1\n"])
def test_numbers_without_a_name_above_a_table_without_headers_are_told_and_no_samples(
    read, above
):
    recording, samples = read(above + ROWS, sample_rate=2000.0)
    assert_allclose(samples, VALUES, rtol=1e-12)
    assert any("is no sample" in note for note in recording.notes)


def test_numbers_in_one_column_below_a_rate_are_the_only_samples(read):
    _, samples = read("2000\n0.5\n" + "".join(f"{a:.4f}\n" for a in VALUES[0]), sample_rate=2e3)
    assert_allclose(samples, VALUES[:1], rtol=1e-12)


def test_rows_that_are_printed_alike_are_all_samples(read):
    _, samples = read(ROWS, sample_rate=2000.0)
    assert_allclose(samples, VALUES, rtol=1e-12)


def test_a_comment_between_rows_is_refused_and_never_bridged(read):
    lines = ROWS.splitlines(keepends=True)
    text = "a (g),b (g)\n" + "".join([*lines[:30], "# door closed\n", *lines[30:]])
    with pytest.raises(RecordingError, match="line 32"):
        read(text, sample_rate=2000.0)
    _, samples = read(text, sample_rate=2000.0, bad_rows="skip")
    assert_allclose(samples, VALUES * STANDARD_GRAVITY, rtol=1e-12)


def test_two_rates_that_contradict_each_other_are_told(read):
    with pytest.raises(RecordingError, match=r"1000 Hz .*2000 Hz|2000 Hz .*1000 Hz"):
        read("Sample Rate (Hz),1000\ntime,a (g),b (g)\n" + TIMED)


@pytest.mark.parametrize("above", ["time_ms,a [g]", "# Time [min],a [g]"])
def test_two_headers_that_give_the_time_in_two_units_are_no_rate(tmp_path, above):
    """As `make fuzz` found it: a second header with seconds, and 1000 Hz were 1 Hz."""
    rows = "\n".join(f"{i},{i % 7}.5" for i in range(40))
    path = tmp_path / "run.csv"
    path.write_text(f"{above}\nt [s],a [g]\n{rows}\n")
    with pytest.raises(RecordingError, match=r"line 1 names the time .* Delete the header"):
        open_recording(path)
    path.write_text(f"time [sec],a [g]\nt [s],a [g]\n{rows}\n")
    with open_recording(path) as recording:
        assert recording.sample_rate == 1.0


DOMAIN = "# domain;unit=seconds;resolution={};delta={};origin={};starting_tick={};\n"
DAY = datetime(2024, 5, 6, 7, 8, 9, tzinfo=UTC)


@pytest.mark.parametrize(
    ("resolution", "delta", "origin", "tick"),
    [
        ("1/2000", 1, "1970-01-01T00:00:00", round(DAY.timestamp()) * 2000),
        ("1/1000000", 500, "2024-05-06T07:08:00Z", 9_000_000),
        ("3/6000", 1, "N/A", 12),
    ],
)
def test_what_opendaq_says_of_the_times_is_used(read, resolution, delta, origin, tick):
    """Its recorder of several signals states the step and the first tick above the headers."""
    text = DOMAIN.format(resolution, delta, origin, tick) + '"a (g)","b (g)"\n' + ROWS
    recording, samples = read(text)
    assert [c.name for c in recording.channels] == ["a", "b"]
    assert recording.sample_rate == 2000.0
    assert recording.start_time == (None if origin == "N/A" else DAY)
    assert_allclose(samples, VALUES * STANDARD_GRAVITY)


@pytest.mark.parametrize("name", ["Domain", "Time AI 1"])
def test_a_column_of_ticks_of_opendaq_is_its_time(read, name):
    first = round(DAY.timestamp()) * 51_200
    ticks = [f"{first + 2 * i},{a:.4f}\n" for i, a in enumerate(VALUES[0])]
    head = f"{name} (s * 51200),a (g)\n"
    above = ""
    if name == "Domain":
        head, above = 'Domain,"a (g)"\n', DOMAIN.format("1/51200", 2, "1970-01-01", first)
    recording, _ = read(above + head + "".join(ticks))
    assert [c.name for c in recording.channels] == ["a"]
    assert recording.sample_rate == 25_600.0
    assert recording.start_time == DAY
    with pytest.raises(RecordingError, match="does not advance evenly"):
        read(above + head + "".join(ticks[:20] + ticks[23:]))
