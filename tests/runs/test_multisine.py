"""A multisine as a run: table, figure, sentences, flags; and a real one."""

import csv
from dataclasses import replace

import numpy as np
import pytest
from configs.benchmarks import convert
from scipy import io
from tests.in_process import run

from shakerproc.data import Channel, recording_of_arrays
from shakerproc.runs import process_recording, process_test
from shakerproc.testlog import Multisine, Peaks, Processing, Test, read_testlog

RATE, N = 512.0, 1024
CHANNELS = (
    Channel("force", "N", "force", "N", "force"),
    Channel("point", "m/s^2", "point", "g", "response"),
)
G = 9.80665


def lines(seed=1, *, every=False):
    number = np.arange(11, 200, 1 if every else 2)
    rng = np.random.default_rng(seed)
    left_out = [] if every else [rng.choice(group) for group in np.array_split(number, 24)]
    return np.setdiff1d(number, left_out)


def force_of(count, periods, *, every=False, seed=1):
    """Realisations of amplitude 1 N at every line, each so many periods."""
    rng = np.random.default_rng(seed)
    number = lines(every=every)
    spectrum = np.zeros((count, N // 2 + 1), dtype=complex)
    spectrum[:, number] = 0.5 * N * np.exp(2j * np.pi * rng.random((count, number.size)))
    return np.tile(np.fft.irfft(spectrum, N, axis=1), periods).ravel()


def processed(force, law, said=None, *, noise=0.01, channels=CHANNELS, transient=0.0):
    time = np.arange(force.size) / RATE
    response = law(force) + noise * np.random.default_rng(5).standard_normal(force.size)
    response += transient * np.exp(-2.0 * time) * np.sin(300.0 * time)
    test = Test(
        1,
        excitation="multisine",
        from_hz=5.0,
        to_hz=100.0,
        multisine=said or Multisine(2.0),
        processing=Processing(crop=None),
    )
    rows = np.array([force, response])
    return process_recording(recording_of_arrays("run", channels, rows, RATE), test)


def found(result):
    (one,) = [one for one in result.analyses if one.kind == "multisine"]
    return one


def test_the_table_has_every_line_with_units_and_the_function_of_the_excited_ones():
    one = found(processed(force_of(1, 6), lambda f: 3.0 * f))
    columns = one.columns
    chosen = np.array(columns["kind"]) == "excited"
    assert list(np.array(columns["line"])[chosen]) == list(lines())
    gain = np.array(columns["magnitude_point_over_force_g_per_N"])
    assert gain[chosen] == pytest.approx(3.0 / G, rel=0.01)
    assert np.isnan(gain[~chosen]).all()
    assert columns["input_force_N"][chosen] == pytest.approx(1.0, rel=1e-6)
    noise = np.sqrt(np.mean(np.square(columns["noise_point_g"])))
    assert noise == pytest.approx(0.02 / np.sqrt(N * 6) / G, rel=0.1)
    assert one.sentences[0].startswith("point, 5.5 to 99.5 Hz: linear within 0.0")
    assert "even and 24 odd ones detect" in one.sentences[1]
    assert not one.problems


def test_even_and_odd_laws_are_named_with_their_bands():
    one = found(processed(force_of(1, 4), lambda f: 3.0 * f + 0.005 * f**2))
    assert "even distortion of" in one.sentences[0]
    assert "out of the noise from" in one.sentences[0]
    assert "odd distortion below" in one.sentences[0]
    assert one.sentences[0].endswith("a law that differs between push and pull.")
    (panel,) = one.panels
    assert [line.label for line in panel.lines] == [
        "response function", "noise", "even distortion", "odd distortion"
    ]  # fmt: skip
    one = found(processed(force_of(1, 4), lambda f: 3.0 * f + 0.001 * f**3))
    assert "odd distortion of" in one.sentences[0]
    assert "even distortion below" in one.sentences[0]


def own_lines(numbers, count, periods, draw):
    """Force of realisations, each of which excites the lines that `draw` gives it."""
    rng = np.random.default_rng(7)
    spectrum = np.zeros((count, N // 2 + 1), dtype=complex)
    for m in range(count):
        lines = draw(m, rng, numbers)
        spectrum[m, lines] = 0.5 * N * np.exp(2j * np.pi * rng.random(lines.size))
    return np.tile(np.fft.irfft(spectrum, N, axis=1), periods).ravel()


def test_realisations_with_lines_of_their_own_are_told():
    force = own_lines(
        np.arange(11, 200, 2), 3, 4, lambda _, rng, all_: all_[rng.random(all_.size) < 0.75]
    )
    one = found(processed(force, lambda f: 3.0 * f, Multisine(2.0, 4, 3)))
    assert "linear within 0.0" in one.sentences[0]
    assert "Each realisation excites lines of its own" in one.sentences[2]
    assert not one.problems
    counts = np.array(one.columns["excited_realisations"])
    assert counts.max() == 3
    scatter = np.array(one.columns["scatter_point_g"])
    assert np.array_equal(np.isnan(scatter), counts < 2)


def test_realisations_that_share_no_line_and_detect_nothing_are_a_flag():
    """Every line in turn: even and odd ones are excited, and none of them twice."""
    force = own_lines(np.arange(11, 200), 2, 4, lambda m, _, all_: all_[m::2])
    one = found(processed(force, lambda f: 3.0 * f, Multisine(2.0, 4, 2)))
    (told,) = one.problems
    assert told.startswith("no detection lines and no line excited twice: noise is known")


def test_a_transient_is_left_out_and_told():
    one = found(processed(force_of(1, 6), lambda f: 3.0 * f, transient=50.0))
    assert (
        "The first 2 of 6 periods do not repeat (a transient) and are left out."
        in one.sentences
    )
    assert one.sentences[0].startswith("point, 5.5 to 99.5 Hz: linear within 0.0")


def test_what_a_multisine_cannot_tell_is_a_flag_of_one_line():
    one = found(processed(force_of(1, 1), lambda f: 3.0 * f))
    (told,) = one.problems
    assert told.startswith("one period only: the noise is not known")
    assert one.sentences[0].endswith("of the response (rms), with the noise in them.")
    one = found(processed(force_of(1, 4, every=True), lambda f: 3.0 * f))
    (told,) = one.problems
    assert told.startswith("no detection lines and one realisation")
    assert "noise 0." in one.sentences[0]
    said = Multisine(2.0, periods=3, realisations=3)
    one = found(processed(force_of(3, 3, every=True), lambda f: 3.0 * f + 0.001 * f**3, said))
    assert not one.problems
    assert "distortion over the realisations of" in one.sentences[0]
    result = processed(force_of(1, 4), lambda f: 3.0 * f, Multisine(1.5))
    (flag,) = [flag for flag in result.flags if flag.kind == "multisine"]
    assert flag.message.startswith("the periods do not repeat")
    assert "it repeats after 2 s" in flag.message
    no_input = (Channel("a", "m/s^2", "a", "g", "response"), CHANNELS[1])
    (told,) = found(processed(force_of(1, 4), lambda f: f, channels=no_input)).problems
    assert "needs controls or one force as its input" in told


LOG = """testlog: 1
recordings: .
channels:
  f: {role: force, at: coupon, unit: N}
  x: {role: response, at: coupon, unit: m/s^2}
processing: {crop: {from: 0.5 s, to: 24.6 s}, sample_rate: 512 Hz}
tests:
  - {id: 1, recording: one.tdms, excitation: multisine, level: 20 N rms, from: 5 Hz, to: 120 Hz,
     multisine: {period: 2 s, periods: 4, realisations: 3}}
"""
MODEL = """model: 1
title: hardening coupon
masses: {coupon: 1 kg}
elements:
  - {kind: spring, between: [base, coupon], stiffness: 1e5 N/m}
  - {kind: damper, between: [base, coupon], damping: 12 N s/m}
  - {kind: cubic_stiffness, between: [base, coupon], coefficient: 1e9 N/m^3}
excitation: {force on: coupon}
sensors:
  x: {at: coupon, measures: acceleration}
"""


def test_what_simulate_plays_batch_reads(tmp_path):
    """A hardening spring is odd: the even lines stay within the noise."""
    log = tmp_path / "log.yaml"
    log.write_text(LOG)
    (tmp_path / "model.yaml").write_text(MODEL)
    assert run("plan", log, "--model", tmp_path / "model.yaml", "--out", tmp_path / "p") == 0
    assert run("simulate", tmp_path / "model.yaml", log, "--out", tmp_path) == 0
    assert run("batch", log, "--out", tmp_path / "out", "--no-figures") == 0
    with (tmp_path / "out" / "multisine.csv").open(encoding="utf-8", newline="") as file:
        (row,) = csv.DictReader(file)
    assert (row["even_stands_out"], row["odd_stands_out"]) == ("false", "true")
    assert float(row["realisations"]) == 3.0
    assert float(row["periods"]) == 3.0
    assert float(row["odd_percent"]) > 3.0 > 100.0 * float(row["even_limit_percent"])
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    for text in ("odd distortion of", "Pintelon", "(a transient) and are left out"):
        assert text in page


def test_a_period_that_no_recorder_hits_is_refused_before_anything_is_simulated(
    tmp_path, capsys
):
    (tmp_path / "log.yaml").write_text(LOG.replace("period: 2 s", "period: 2.001 s"))
    (tmp_path / "model.yaml").write_text(MODEL)
    log = tmp_path / "log.yaml"
    assert run("simulate", tmp_path / "model.yaml", log, "--out", tmp_path) == 1
    assert "a period of 2.001 s is 1024.512 samples at 512 Hz" in capsys.readouterr().err


@pytest.mark.shared
def test_nine_periods_of_an_aircraft(shared):
    """The noise of each line against numpy's: deviation of eight periods over root eight."""
    file = shared / "data" / "f16_level1" / "F16Data_FullMSine_Level1.csv"
    force, wing = np.loadtxt(file, delimiter=",", skiprows=1, usecols=(0, 3)).T
    test = Test(
        1,
        excitation="multisine",
        from_hz=2.0,
        to_hz=15.0,
        multisine=Multisine(20.48),
        processing=Processing(crop=None),
    )
    rows = recording_of_arrays("f16", CHANNELS, np.array([force, wing]), 400.0)
    one = found(process_recording(rows, test))
    assert (
        "The first 1 of 9 periods do not repeat (a transient) and are left out."
        in one.sentences
    )
    number = np.array(one.columns["line"])
    assert list(number) == list(range(41, 308))
    u, y = (np.fft.rfft(x.reshape(9, 8192)[1:])[:, number] / 4096.0 for x in (force, wing))
    rest = y - u * (y.mean(axis=0) / u.mean(axis=0))
    deviation = np.std(rest, axis=0, ddof=1) / np.sqrt(8.0) / G
    assert one.columns["noise_point_g"] == pytest.approx(deviation, rel=1e-9)
    assert one.summary[0]["noise_percent"] == pytest.approx(0.085, abs=0.001)


@pytest.mark.shared
def test_the_silverbox_is_odd(shared, tmp_path):
    """Ten realisations of odd lines only; shares by numpy from the file alone."""
    data = io.loadmat(shared / "data" / "silverbox" / "SNLS80mV.mat")
    first, step, number = round(67.1418 * 610.35), 8692, np.arange(7, 2684)
    u, y = (
        np.array([np.fft.rfft(data[name].ravel()[k : k + 8192])[number] for k in starts])
        for name in ("V1", "V2")
        for starts in [first + step * np.arange(10)]
    )
    odd = number % 2 == 1
    whole = np.mean(np.abs(y[:, odd]) ** 2)
    ratio = y[:, odd] / u[:, odd]
    scatter = np.std(ratio, axis=0, ddof=1) * np.sqrt(np.mean(np.abs(u[:, odd]) ** 2, axis=0))
    path = convert.folder_of("silverbox", tmp_path) / "multisines.yaml"
    log = read_testlog(path)
    one = found(process_test(log, log.tests[0]))
    (row,) = one.summary
    assert row["excited_lines"] == odd.sum()
    share = 100.0 * np.sqrt(np.mean(scatter**2) / whole)
    assert row["scatter_percent"] == pytest.approx(share, rel=1e-6)
    even = 100.0 * np.sqrt(np.mean(np.abs(y[:, ~odd]) ** 2) / whole)
    assert row["even_percent"] == pytest.approx(even, rel=0.2)  # ours without the input's part
    assert row["even_percent"] < 0.05 * row["scatter_percent"]
    assert row["noise_percent"] is None


def test_a_multisine_that_the_log_calls_random_is_processed_all_the_same():
    """Segments as long as its period leave holes in the spectrum, which no mode fits."""
    force = force_of(1, 4)
    time = np.arange(force.size) / RATE
    noise = 0.01 * np.random.default_rng(5).standard_normal(force.size)
    response = 3.0 * force + noise + 50.0 * np.exp(-2.0 * time) * np.sin(300.0 * time)
    test = Test(
        1,
        excitation="random",
        from_hz=40.0,
        to_hz=60.0,
        processing=Processing(crop=None, peaks=Peaks(count=4)),
    )
    channels = (replace(CHANNELS[0], role="response"), CHANNELS[1])
    rows = recording_of_arrays("run", channels, np.array([force, response]), RATE)
    assert process_recording(rows, test).averages.psd.shape[0] == 2


def test_a_base_that_shakes_is_the_mean_of_its_controls():
    force = force_of(1, 4)
    noise = 0.01 * np.random.default_rng(5).standard_normal((2, force.size))
    uneven = 0.1 * np.sin(np.arange(force.size))
    rows = np.array([force + uneven, force - uneven, 2.0 * force + noise[0]])
    channels = tuple(
        Channel(name, "m/s^2", name, "g", role)
        for name, role in (("c1", "control"), ("c2", "control"), ("ch3", "response"))
    )
    test = Test(
        1,
        excitation="multisine",
        from_hz=5.0,
        to_hz=100.0,
        multisine=Multisine(2.0),
        processing=Processing(crop=None),
    )
    one = found(process_recording(recording_of_arrays("run", channels, rows, RATE), test))
    assert [row["channel"] for row in one.summary] == ["ch3"]
    chosen = np.array(one.columns["kind"]) == "excited"
    assert one.columns["magnitude_ch3_over_controls"][chosen] == pytest.approx(2.0, rel=0.01)
