"""A control is judged line by line: by how much, where, and what the plan allows."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from tests.in_process import run
from tests.small_campaign import write_campaign

from shakerproc.campaign.agreement import profiles_kept
from shakerproc.data import Channel, recording_of_arrays
from shakerproc.runs import process_recording, summary_of
from shakerproc.testlog import Processing, Profile, ProfileNotch, Test, Welch

G, RATE, N = 9.80665, 2000.0, 400_000
CHANNELS = (
    Channel("control", "m/s^2", "control", "g", "control"),
    Channel("ch3", "m/s^2", "ch3", "g", "response"),
)


def shaped(gain_db, seed=3):
    """White noise of 0.001 g^2/Hz times a gain in dB against frequency; and half of it."""
    rng = np.random.default_rng(seed)
    white = rng.standard_normal(N) * np.sqrt(0.001 * RATE / 2.0) * G
    frequency = np.fft.rfftfreq(N, 1.0 / RATE)
    spectrum = np.fft.rfft(white) * 10.0 ** (gain_db(frequency) / 20.0)
    rows = np.fft.irfft(spectrum, N)
    response = 0.5 * rows + 1e-3 * rng.standard_normal(N)
    return recording_of_arrays("run", CHANNELS, np.array([rows, response]), RATE)


def judged(gain_db, notches=()):
    profile = Profile(
        "p", "(m/s^2)^2/Hz", (20.0, 900.0), (0.001 * G**2,) * 2, (3.0, 3.0), (6.0, 6.0), notches
    )
    test = Test(
        1,
        excitation="random",
        from_hz=20.0,
        to_hz=900.0,
        profile=profile,
        processing=Processing(crop=None, welch=Welch(2000, 1000, "hann")),
    )
    result = process_recording(shaped(gain_db), test)
    return result, {str(row["line"]): row for row in result.analyses[0].summary}


def dip(f):
    return np.where((f > 200.0) & (f < 300.0), -8.0, 0.0)


def test_what_keeps_every_line_says_so_with_its_grms():
    result, lines = judged(lambda f: 0.0 * f)
    assert all(row["kept"] for row in lines.values())
    rms = np.sqrt(0.001 * 880.0)
    assert_allclose([row["demand_rms"] for row in lines.values()], rms)
    assert f"Demanded {rms:.4g} g rms from 20 to 900 Hz" in result.analyses[0].sentences[1]
    columns = result.analyses[0].columns
    assert_allclose(columns["demand_g2_per_hz"], 0.001)
    assert_allclose(columns["abort_high_g2_per_hz"], 0.001 * 10**0.6)
    assert_allclose(columns["ch3_g2_per_hz"], 0.25 * columns["control_g2_per_hz"], rtol=1e-2)


def test_a_dip_breaks_the_low_lines_by_what_it_is_deep_and_where_it_is():
    result, lines = judged(dip)
    assert {name for name, row in lines.items() if not row["kept"]} == {
        "alarm low",
        "abort low",
    }
    assert_allclose(lines["abort low"]["exceedance_db"], 8.0 - 6.0, atol=1.0)
    assert 200.0 < lines["abort low"]["at_hz"] < 300.0
    assert_allclose(lines["alarm low"]["beyond_share"], 100.0 / 880.0, atol=0.01)
    assert [f.kind for f in result.flags].count("profile") == 2


def test_a_notch_of_the_plan_allows_the_dip_and_no_more():
    assert all(row["kept"] for row in judged(dip, (ProfileNotch(195, 305, 8.0),))[1].values())
    _, lines = judged(lambda f: 2.0 * dip(f), (ProfileNotch(195.0, 305.0, 8.0),))
    assert not lines["abort low"]["kept"]


@pytest.mark.parametrize(
    ("off", "broken"), [(0.0, set()), (4.0, {"alarm high"}), (-7.0, {"alarm low", "abort low"})]
)
def test_a_sweep_is_judged_by_its_amplitude(off, broken):
    t = np.arange(120_000) / RATE
    octaves, rng = np.log2(400.0 / 10.0), np.random.default_rng(1)
    phase = (
        2 * np.pi * 10.0 * (2.0 ** (octaves * t / t[-1]) - 1.0) * t[-1] / (octaves * np.log(2))
    )
    drive = 0.5 * G * 10 ** (off / 20.0) * np.sin(phase)
    rows = np.array([drive, 2.0 * drive]) + 1e-3 * rng.standard_normal((2, t.size))
    profile = Profile("s", "m/s^2", (10.0, 400.0), (0.5 * G,) * 2, (3.0,) * 2, (6.0,) * 2)
    test = Test(
        1, excitation="sine sweep", from_hz=10.0, to_hz=400.0, profile=profile,
        processing=Processing(crop=None),
    )  # fmt: skip
    recording = recording_of_arrays("run", CHANNELS, rows, RATE)
    (analysis,) = process_recording(recording, test).analyses
    assert {row["line"] for row in analysis.summary if not row["kept"]} == broken
    beyond = next(row for row in analysis.summary if row["line"] == "alarm high")
    assert_allclose(beyond["exceedance_db"], off - 3.0, atol=0.1)
    assert_allclose(analysis.columns["ch3_g"], 2.0 * analysis.columns["control_g"], rtol=0.01)


def test_a_profile_that_no_channel_measures_is_told():
    profile = Profile("p", "N^2/Hz", (20.0, 900.0), (1.0, 1.0), (3.0, 3.0), (6.0, 6.0))
    test = Test(1, excitation="random", from_hz=20.0, to_hz=900.0, profile=profile,
                processing=Processing(crop=None))  # fmt: skip
    result = process_recording(shaped(lambda f: 0.0 * f), test)
    (flag,) = [f for f in result.flags if f.kind == "profile"]
    assert "no channel has the role force" in flag.message
    assert not summary_of(result, "1", {}, "r", "0" * 64).analyses[0].rows


@pytest.fixture(scope="module")
def batch(tmp_path_factory):
    folder = tmp_path_factory.mktemp("profiles")
    log = write_campaign(folder, 2)
    own = "level: 0.0005 g^2/Hz, from: 5 Hz, to: 800 Hz"
    text = log.read_text().replace(own, "profile: good", 1).replace(own, "profile: bad", 1)
    text = text.replace(
        "tests:",
        "profiles:\n"
        "  good: {breakpoints: [[10 Hz, 0.0005 g^2/Hz], [780 Hz, 0.0005 g^2/Hz]]}\n"
        "  bad: {breakpoints: [[10 Hz, 0.005 g^2/Hz], [780 Hz, 0.005 g^2/Hz]]}\ntests:",
    )
    log.write_text(text)
    assert run("batch", log, "--no-figures", "--out", folder / "out") == 0
    return folder


def test_check_names_every_line_that_was_not_kept(batch, capsys):
    assert run("check", batch / "out") == 1
    out = capsys.readouterr().out
    lines = {one.line: one for one in profiles_kept(batch / "out").broken}
    for name, tolerance in (("alarm low", 3.0), ("abort low", 6.0)):
        assert f"test 2: profile bad: {name} line not kept, +" in out
        assert 10.0 - tolerance < lines[name].exceedance_db < 12.5 - tolerance  # and scatter
    assert "not kept: 2 of 8 lines" in out


def test_check_and_table_say_both_rms_and_the_worst_of_each_test(batch, capsys):
    good, bad = profiles_kept(batch / "out").worst
    assert (good.kept, bad.kept, bad.unit) == (True, False, "g")
    assert bad.line == "alarm low"
    assert bad.exceedance_db == max(
        o.exceedance_db for o in profiles_kept(batch / "out").broken
    )
    assert_allclose((good.demand_rms, bad.demand_rms), np.sqrt([0.385, 3.85]), rtol=1e-12)
    assert_allclose((good.measured_rms, bad.measured_rms), np.sqrt(0.385), rtol=0.05)
    run("check", batch / "out")
    out = capsys.readouterr().out
    assert "test 1: profile good: kept, worst -" in out
    assert "demanded 1.962 g rms, measured 0.6" in out


def test_report_and_tables_hold_the_verdict(batch):
    page = (batch / "out" / "report.html").read_text()
    assert "Profile bad: NOT KEPT (alarm low, abort low)." in page
    assert "exceedance [dB]" in page
    assert (batch / "out" / "runs" / "test_2" / "profile_curves.csv").is_file()
