from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import scipy.signal
from numpy.testing import assert_allclose
from tests.in_process import run
from tests.small_campaign import CHANNELS, RATE, samples, write_campaign

from shakerproc.data import STANDARD_GRAVITY, recording_of_arrays
from shakerproc.errors import LogError, RecordingError, SpectrumError
from shakerproc.runs import (
    UnitOption,
    find_crop,
    open_path,
    open_test,
    process_recording,
    process_test,
    tables,
    usual_roles,
)
from shakerproc.runs.analyses import tones
from shakerproc.runs.panels import envelope
from shakerproc.testlog import Processing, Test, ThresholdCrop, TimeCrop, Welch, read_testlog

RANDOM = Test(
    "r",
    excitation="random",
    level=0.0005 * STANDARD_GRAVITY**2,
    level_unit="(m/s^2)^2/Hz",
    from_hz=5.0,
    to_hz=800.0,
)
RANDOM = replace(
    RANDOM,
    processing=replace(
        RANDOM.processing,
        crop=ThresholdCrop(threshold=0.2 * STANDARD_GRAVITY),
        welch=Welch(segment=512, overlap=256),
    ),
)


def with_roles(rows):
    roles = ("control", "control", "response", "response")
    channels = [replace(c, role=role) for c, role in zip(CHANNELS, roles, strict=True)]
    return recording_of_arrays("run", channels, rows, RATE)


def test_a_known_oscillator_is_found_with_its_frequency_and_damping():
    result = process_recording(with_roles(samples(250.0, damping=0.05, seconds=30.0)), RANDOM)
    for i in result.responses:
        assert (
            abs(result.averages.psd_peaks[i][0].peak.frequency - 250.0)
            < result.spectra.bin_width
        )
    damping = result.averages.response_peaks[2][0].damping
    assert_allclose(damping.frequency, 250.0, rtol=2e-3)
    assert damping.ratio is not None
    assert_allclose(damping.ratio, 0.05, rtol=0.05)


def test_the_measured_level_is_that_of_the_base():
    result = process_recording(with_roles(samples(250.0)), RANDOM)
    value, unit = result.averages.measured_level.shown
    assert unit == "g²/Hz"
    assert_allclose(value, 0.0005, rtol=0.15)
    assert "level" not in {flag.kind for flag in result.flags}


def test_a_level_that_the_table_missed_is_flagged():
    quiet = replace(RANDOM, level=4.0 * RANDOM.level)
    result = process_recording(with_roles(samples(250.0)), quiet)
    (flag,) = [flag for flag in result.flags if flag.kind == "level"]
    assert "dB" in flag.message


def test_swept_tests_miss_their_duration():
    sweep = replace(
        RANDOM, excitation="sine sweep", rate_oct_per_min=1.0, level=None, level_unit=None
    )
    result = process_recording(with_roles(samples(250.0)), sweep)
    assert "duration" in {flag.kind for flag in result.flags}


def test_a_tone_is_taken_out_of_the_responses_only():
    rows = samples(250.0, seconds=12.0)
    time = np.arange(rows.shape[1]) / RATE
    rows[2:] += 30.0 * np.sin(2.0 * np.pi * 50.0 * time)
    result = process_recording(with_roles(rows), replace(RANDOM, notch_hz=50.0))
    notch = result.over_time.notch
    near = np.argmin(np.abs(result.spectra.frequency - 50.0))
    beside = np.argmin(np.abs(result.spectra.frequency - 100.0))
    assert notch.psd[0, near] < 1e-3 * result.averages.psd[2, near]
    assert_allclose(notch.psd[0, beside], result.averages.psd[2, beside], rtol=0.3)
    assert_allclose(notch.time[-1] - notch.time[0], 0.04, rtol=0.05)
    assert np.ptp(notch.after[0]) < np.ptp(notch.before[0])


def test_one_channel_without_a_control_still_has_a_density():
    recording = with_roles(samples(250.0)).select([2])
    result = process_recording(recording, replace(RANDOM, processing=_cropped(None)))
    assert result.averages.against is None
    assert result.averages.response_peaks == ((),)
    assert (
        abs(result.averages.psd_peaks[0][0].peak.frequency - 250.0) < result.spectra.bin_width
    )


def _cropped(crop):
    return replace(RANDOM.processing, crop=crop)


def test_crops_by_time_and_not_at_all():
    recording = with_roles(samples(250.0))
    timed = process_recording(
        recording, replace(RANDOM, processing=_cropped(TimeCrop(2.0, 4.0)))
    )
    assert (timed.crop.start, timed.crop.stop) == (2 * RATE, 4 * RATE)
    whole = process_recording(recording, replace(RANDOM, processing=_cropped(None)))
    assert whole.crop.n_samples == recording.n_samples


def test_what_goes_wrong_names_the_run():
    recording = with_roles(samples(250.0))
    high = replace(RANDOM, processing=_cropped(ThresholdCrop(threshold=1e4)))
    with pytest.raises(SpectrumError, match=r"run: the threshold of .* is never reached"):
        process_recording(recording, high)
    lost = replace(RANDOM, processing=_cropped(ThresholdCrop(channel="table")))
    with pytest.raises(
        LogError, match=r"no channel 'table' to crop by\. The recording has control"
    ):
        process_recording(recording, lost)
    beyond = replace(RANDOM, from_hz=1500.0, to_hz=2000.0)
    with pytest.raises(SpectrumError, match="does not lie below half the sample rate"):
        process_recording(recording, beyond)


@pytest.mark.parametrize(
    ("channels", "roles"),
    [
        ("a b c d e f g h", "c c r r r r r r"),
        ("a b", "c r"),
        ("only", "r"),
        ("Response_X Control_A x", "r c r"),
        ("a:g b:g T:degC c:g", "c c i r"),
        ("force:N a:g b:g", "f r r"),
        ("a:g b:g x:mm v:mm/s", "c r d v"),
        ("Drive:V base:g top:g", "i c r"),
        ("a:V b:V c:V", "c c r"),
        ("a:Acceleration b:EU c:EU", "c c r"),
        ("a:g T:degC b:g", "c c r"),  # refused when its unit is read, never skipped
    ],
)
def test_every_channel_gets_a_role_where_no_log_says_one(channels, roles):
    pairs = [text.partition(":")[::2] for text in channels.split()]
    letters = {"c": "control", "r": "response", "i": "ignore", "f": "force"}
    letters |= {"d": "displacement", "v": "velocity"}
    found = usual_roles([name for name, _ in pairs], [unit for _, unit in pairs])
    assert found == tuple(letters[letter] for letter in roles.split())


def test_a_test_of_a_log_opens_with_its_roles(tmp_path):
    log = read_testlog(write_campaign(tmp_path, 1))
    with open_test(log, log.tests[0]) as recording:
        assert [c.role for c in recording.channels] == ["control"] * 2 + ["response"] * 2
        assert [c.name for c in recording.channels][2:] == ["ch3", "ch4"]
        assert {c.unit for c in recording.channels} == {"m/s^2"}
    result = process_test(log, log.tests[0])
    assert (
        abs(result.averages.psd_peaks[2][0].peak.frequency - 360.0) < result.spectra.bin_width
    )


@pytest.mark.parametrize("block", [1, 7, 64, 1000])
@pytest.mark.parametrize("n_slices", [1, 10, 999, 5000])
def test_the_envelope_is_that_of_the_whole_whatever_the_blocks(block, n_slices):
    x = np.random.default_rng(3).standard_normal((2, 1000))
    found = envelope((x[:, i : i + block] for i in range(0, 1000, block)), 1000, 10.0, n_slices)
    n = min(n_slices, 1000)
    edges = [i * 1000 // n for i in range(n + 1)]
    expected = [x[:, a:b].max(axis=1) for a, b in pairwise(edges)]
    assert_allclose(found.high, np.transpose(expected))
    assert_allclose(found.low[:, 0], x[:, : edges[1]].min(axis=1))


def test_damping_is_read_from_longer_segments_where_these_do_not_resolve_it():
    """The truth is the oscillator's own; only steady excitation is looked at again."""
    rows = samples(250.0, damping=0.005, seconds=40.0)
    result = process_recording(with_roles(rows), RANDOM)
    damping = result.averages.response_peaks[2][0].damping
    assert damping.bin_width < result.spectra.bin_width / 3.0
    assert_allclose(damping.ratio, 0.005, rtol=0.05)
    assert damping.ratio_low < 0.005 < damping.ratio_high
    sweep = replace(RANDOM, excitation="sine sweep", level=None, level_unit=None)
    swept = process_recording(with_roles(rows), sweep)
    assert swept.averages.response_peaks[2][0].damping.bin_width == swept.spectra.bin_width


def test_a_long_notch_is_cut_from_the_middle_and_says_so(monkeypatch):
    monkeypatch.setattr(tones, "FILTERED", round(10.0 * RATE))
    rows = samples(250.0, seconds=20.0)
    rows[2:] += 30.0 * np.sin(2.0 * np.pi * 50.0 * np.arange(rows.shape[1]) / RATE)
    result = process_recording(with_roles(rows), replace(RANDOM, notch_hz=50.0))
    assert "only 10 s from the middle" in result.over_time.notch_problem
    assert 9.5 < result.over_time.notch.time.mean() < 10.5
    near = np.argmin(np.abs(result.spectra.frequency - 50.0))
    assert result.over_time.notch.psd[0, near] < 1e-3 * result.averages.psd[2, near]


def test_every_table_of_a_recording_that_was_cut_says_how_much_is_there():
    recording = replace(with_roles(samples(250.0)), expected_samples=round(9.0 * RATE))
    result = process_recording(recording, replace(RANDOM, notch_hz=50.0))
    for columns in (tables.spectra_columns(result), tables.notch_columns(result)):
        told = set(columns["incomplete"])
        assert told == {"6.00 of 9.00 s"}
    whole = process_recording(with_roles(samples(250.0)), RANDOM)
    assert "incomplete" not in tables.spectra_columns(whole)


def test_controls_can_be_named_and_units_given_where_no_log_speaks(tmp_path):
    rows = np.random.default_rng(1).standard_normal((3, 4000))
    text = [
        "time [s],table,left,right",
        *(f"{i / 1000.0},{a},{b},{c}" for i, (a, b, c) in enumerate(rows.T)),
    ]
    path = tmp_path / "plain.csv"
    path.write_text("\n".join(text), encoding="utf-8")
    with pytest.raises(RecordingError, match="has no unit"):
        open_path(path, Test("t"))
    with open_path(path, Test("t"), controls=["left"], unit=UnitOption("g")) as recording:
        assert [c.role for c in recording.channels] == ["response", "control", "response"]
        assert {c.unit for c in recording.channels} == {"m/s^2"}
    with open_path(path, Test("t"), controls=[], unit=UnitOption("g")) as recording:
        assert {c.role for c in recording.channels} == {"response"}
    with pytest.raises(LogError, match=r"no channel .top. to be a control. It has table, left"):
        open_path(path, Test("t"), controls=["top"], unit=UnitOption("g"))
    with pytest.raises(LogError, match=r"Did you mean 'table'\? It has .*; name one of these"):
        open_path(path, Test("t"), controls=["tabel"], unit=UnitOption("g"))


def test_a_knock_that_the_crop_leaves_out_is_no_flag_any_more():
    log = read_testlog(Path(__file__).parents[2] / "sample_data" / "testlog.yaml")
    test, kinds = log.find("13"), {}
    for hold in (0.0, 0.05):
        crop = replace(test.processing.crop, hold=hold)
        chosen = replace(test, processing=replace(test.processing, crop=crop))
        kinds[hold] = {flag.kind for flag in process_test(log, chosen).flags}
    assert {"transient", "crop", "duration"} <= kinds[0.0]
    assert not kinds[0.05]


def test_a_force_that_cannot_be_cropped_by_is_told_the_option_that_works(tmp_path, capsys):
    rng = np.random.default_rng(1)
    path = tmp_path / "hammer.csv"
    rows = np.column_stack([np.arange(4096) / 2048.0, rng.standard_normal((4096, 2))])
    head = "time [s],F [N],a [g]"
    np.savetxt(path, rows, fmt="%.9g", delimiter=",", header=head, comments="")
    quiet = ("--no-figures", "--out", tmp_path / "out")
    assert run("process", path, *quiet) == 1
    assert "(or --no-crop)" in capsys.readouterr().err
    assert run("process", path, "--no-crop", *quiet) == 0


@pytest.mark.parametrize("n_samples", [1024, 1200, 1535])
def test_a_run_of_one_segment_has_spectra_and_no_coherence(n_samples):
    """One segment: |H1| is the quotient of two transforms; Parseval gives the density."""
    rng = np.random.default_rng(3)
    rows = rng.standard_normal((4, n_samples))
    test = replace(RANDOM, processing=Processing(crop=None, welch=Welch()))
    result = process_recording(with_roles(rows), test)
    window = scipy.signal.get_window("hamming", 1024, fftbins=False)
    transforms = np.fft.rfft(rows[:, :1024] * window)
    expected = transforms[2] / transforms[:2].mean(axis=0)
    assert_allclose(result.averages.against.h1[0], expected, rtol=1e-6)
    assert np.isnan(result.averages.against.coherence).all()
    assert all(len(found) == 1 for found in result.averages.psd_peaks)
    assert "one average has no coherence and no damping" in result.notes[-1]
    assert all(
        peak.damping is None for found in result.averages.response_peaks for peak in found
    )


@pytest.mark.parametrize("offset", [-1.0, 0.0, 1.0])
def test_an_offset_above_the_threshold_does_not_decide_the_crop(offset, tmp_path):
    """Rest, 10 s of noise, rest: known samples."""
    rng = np.random.default_rng(12)
    moving = np.zeros(15_000)
    moving[2_500:12_500] = rng.normal(size=10_000)
    np.savetxt(
        tmp_path / "a.csv", (moving + offset)[:, np.newaxis], header="control [g]", comments=""
    )
    (tmp_path / "log.yaml").write_text(
        "testlog: 1\nrecordings: .\n"
        "processing: {sample_rate: 1000 Hz, crop: {threshold: 0.45 g}}\n"
        "channels: {control: {role: control}}\n"
        "tests: [{id: 1, recording: a.csv, excitation: random, from: 5 Hz, to: 400 Hz}]\n"
    )
    log = read_testlog(tmp_path / "log.yaml")
    with open_test(log, log.active[0]) as recording:
        crop = find_crop(recording, log.active[0])
    assert crop.start == 2_500 + int(np.argmax(moving[2_500:] >= 0.45))
    assert crop.stop == 1 + int(np.flatnonzero(moving >= 0.45)[-1])
    assert (crop.warning is not None) == (offset != 0.0)
