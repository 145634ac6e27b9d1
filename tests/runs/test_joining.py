"""One test of several files: in sequence, and recorders side by side with their own clocks."""

import re
from dataclasses import replace
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from nptdms import ChannelObject, TdmsWriter
from numpy.testing import assert_allclose, assert_array_equal
from tests.in_process import run

from shakerproc.campaign.jobs import at_hand
from shakerproc.data import Channel, recording_of_arrays
from shakerproc.errors import ShakerprocError
from shakerproc.recordings import write_tdms
from shakerproc.runs import open_test
from shakerproc.testlog import read_testlog

RATE = 1000.0
BEGIN = datetime(2018, 6, 5, 8, 12, tzinfo=UTC)
RNG = np.random.default_rng(8)
LINES, PHASES = RNG.uniform(5.0, 180.0, (2, 200)) * np.array([[1.0], [np.pi / 90.0]])
HEAD = """\
testlog: 1
recordings: r
channels: {base: {role: control}, tip: {role: response}}
processing: {crop: none, welch: {segment: 256}}
tests:
"""


def motion(time, shift=0.0):
    terms = np.cos(2.0 * np.pi * np.outer(LINES, time) + PHASES[:, np.newaxis] + shift)
    return terms.sum(axis=0) / 10.0


TIME = np.arange(20_000) / RATE
ROWS = np.array([motion(TIME), 2.0 * motion(TIME, 1.0)])


def written(folder, name, rows, start=None, names=("base", "tip"), rate=RATE):
    path = folder / "r" / name
    path.parent.mkdir(exist_ok=True)
    channels = [Channel(n, "m/s^2", n, "m/s^2") for n in names]
    recording = recording_of_arrays(name, channels, np.asarray(rows), rate)
    if start is not None:
        recording = replace(recording, start_time=BEGIN + timedelta(seconds=start))
    write_tdms(path, recording)


def opened(folder, test):
    (folder / "testlog.yaml").write_text(HEAD + f"  - {{id: 1, {test}}}\n")
    log = read_testlog(folder / "testlog.yaml")
    return open_test(log, log.tests[0])


SEQUENCE = "recording: a.tdms, continued: [b.tdms, c.tdms]"
CUTS = (0, 7000, 7900, 20_000)


def in_parts(folder, starts):
    for name, low, high, start in zip("abc", CUTS, CUTS[1:], starts, strict=False):
        written(folder, f"{name}.tdms", ROWS[:, low:high], start)


@pytest.mark.parametrize("starts", [(None,) * 3, (0.0, 7.0, 7.9)])
def test_files_in_sequence_are_one_recording(tmp_path, starts):
    in_parts(tmp_path, starts)
    with opened(tmp_path, SEQUENCE) as recording:
        assert_array_equal(recording.samples(), ROWS)
        assert_array_equal(recording.samples(6990, 7910), ROWS[:, 6990:7910])
        assert_array_equal(recording.select([1]).samples(7999, 8000), ROWS[1:, 7999:8000])
        assert "3 files in sequence: a.tdms, b.tdms, c.tdms" in recording.notes[0]


def test_a_batch_knows_every_file_of_a_test(tmp_path):
    in_parts(tmp_path, (0.0, 7.0, 7.9))
    opened(tmp_path, SEQUENCE).source.close()
    log = tmp_path / "testlog.yaml"
    options = ("--no-figures", "--workers", 1, "--out", tmp_path / "out")
    assert run("batch", log, *options) == 0
    before = (tmp_path / "out" / "manifest.json").read_bytes()
    assert run("batch", log, *options) == 0
    assert (tmp_path / "out" / "manifest.json").read_bytes() == before
    written(tmp_path, "c.tdms", ROWS[:, :12_100], 7.9)
    assert run("batch", log, *options) == 1  # another file of the test has changed


@pytest.mark.parametrize(
    ("starts", "match"),
    [
        ((0.0, 7.5, 8.4), "a gap: b.tdms begins 0.5 s after a.tdms ends. Correct the order"),
        ((0.0, 7.0, 7.4), "an overlap: c.tdms begins 0.5 s before b.tdms ends"),
    ],
)
def test_files_that_overlap_or_leave_a_gap_are_refused(tmp_path, starts, match):
    in_parts(tmp_path, starts)
    with pytest.raises(ShakerprocError, match=match):
        opened(tmp_path, SEQUENCE)


def test_files_of_another_rate_or_that_are_missing_are_refused(tmp_path):
    in_parts(tmp_path, (None,) * 3)
    written(tmp_path, "b.tdms", ROWS, rate=500.0)
    with pytest.raises(
        ShakerprocError, match=r"b\.tdms has 500 samples per second, a\.tdms 1000"
    ):
        opened(tmp_path, SEQUENCE)
    (tmp_path / "r" / "c.tdms").unlink()
    with pytest.raises(ShakerprocError, match=r"no recording .*c\.tdms"):
        opened(tmp_path, SEQUENCE)


BESIDE = (
    "recording: a.tdms, beside: [{recording: o.tdms, common: {base: table}, "
    "channels: {table: {role: response}, rim: {role: response}}}]"
)


@pytest.mark.parametrize(
    ("offset", "drift", "rate"), [(1.25, 90e-6, 1000.0), (-0.7, -60e-6, 1600.0)]
)
def test_recorders_side_by_side_have_offset_and_drift_corrected_and_told(
    tmp_path, offset, drift, rate
):
    written(tmp_path, "a.tdms", ROWS, 0.0)
    time = np.arange(int(17.0 * rate)) / rate / (1.0 + drift) + offset
    rows = [0.5 * motion(time), motion(time, 2.0)]
    written(tmp_path, "o.tdms", rows, 3.0, ("table", "rim"), rate)
    with opened(tmp_path, BESIDE) as recording:
        assert [c.name for c in recording.channels] == ["base", "tip", "table", "rim"]
        began = (recording.start_time - BEGIN).total_seconds()
        times = began + np.arange(recording.n_samples) / RATE
        assert recording.duration > 15.0
        samples = recording.samples()
        expected = np.array([
            motion(times), 2.0 * motion(times, 1.0), 0.5 * motion(times), motion(times, 2.0)
        ])  # fmt: skip
        assert_allclose(samples, expected, atol=0.01 * np.std(expected[0]))
        assert_array_equal(recording.select([3, 0]).samples(50, 90), samples[[3, 0], 50:90])
        told = re.search(
            r"began (\S+) s (\w+) and its clock is (\S+) parts in a million (\w+)",
            recording.notes[0],
        )
        assert float(told[1]) == pytest.approx(abs(offset), abs=1e-5)
        assert float(told[3]) == pytest.approx(1e6 * abs(drift), abs=1.0)
        assert told.group(2, 4) == (("later", "fast") if offset > 0 else ("earlier", "slow"))


def test_a_common_channel_that_is_none_is_refused(tmp_path):
    written(tmp_path, "a.tdms", ROWS)
    noise = RNG.standard_normal((2, 9000))
    written(tmp_path, "o.tdms", noise, names=("table", "rim"))
    with pytest.raises(
        ShakerprocError, match=r"common: base of a.tdms and table of o.tdms: no"
    ):
        opened(tmp_path, BESIDE)
    with pytest.raises(ShakerprocError, match=r"common: no channel 'mast' in use in a\.tdms"):
        opened(tmp_path, BESIDE.replace("base: table", "mast: table"))
    with pytest.raises(ShakerprocError, match=r"testlog.yaml:\d+:\d+: .*expected common"):
        opened(tmp_path, BESIDE.replace("common: {base: table}, ", ""))


def test_two_groups_of_one_file_at_two_rates_have_one_clock(tmp_path):
    (tmp_path / "r").mkdir()
    slow = np.arange(2000) / 100.0
    with TdmsWriter(tmp_path / "r" / "a.tdms") as writer:
        for group, name, values, step in (
            ("fast", "base", ROWS[0], 1e-3),
            ("fast", "tip", ROWS[1], 1e-3),
            ("slow", "load", np.cos(2.0 * np.pi * 3.0 * slow), 1e-2),
            ("spare", "tip", np.cos(slow), 1e-2),
        ):
            unit = "N" if group == "slow" else "m/s^2"
            known = {"wf_increment": step, "wf_samples": 1, "unit_string": unit}
            writer.write_segment([ChannelObject(group, name, values, known)])
    test = (
        "recording: a.tdms, processing: {group: fast}, "
        "beside: [{group: slow, channels: {load: {role: force}}}]"
    )
    with opened(tmp_path, test) as recording:
        rows = recording.samples()
        first = int(np.argmin(np.abs(ROWS[0] - rows[0, 0])))
        times = (first + np.arange(recording.n_samples)) / RATE
        assert recording.duration > 19.0
        assert_allclose(rows[0], motion(times), atol=1e-9)
        assert_allclose(rows[2], np.cos(2.0 * np.pi * 3.0 * times), atol=1e-3)
        assert [one.name for one in recording.unused] == ["spare/tip"]
        assert "they have one clock; its 100 Hz were brought to 1000 Hz" in recording.notes[0]


def test_a_test_of_several_files_is_not_sent_elsewhere(tmp_path):
    in_parts(tmp_path, (None,) * 3)
    opened(tmp_path, SEQUENCE).source.close()
    log = read_testlog(tmp_path / "testlog.yaml")
    with pytest.raises(ShakerprocError, match=r"test 1: has several files, which are joined"):
        at_hand(log, str(tmp_path / "r")).__enter__()
