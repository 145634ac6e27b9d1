"""Further analyses of a log: asked for, written, drawn, told; refused in one line."""

import csv
import re
from dataclasses import replace

import numpy as np
import pytest
import scipy
from numpy.testing import assert_allclose
from tests.in_process import run
from tests.small_campaign import write_campaign

from shakerproc.data import Channel, recording_of_arrays
from shakerproc.errors import SpectrumError
from shakerproc.recordings import open_recording, write_tdms
from shakerproc.report.runs.analyses import draw_analyses, page_figures
from shakerproc.runs import process_recording, summary_of
from shakerproc.runs.analyses import ANALYSES
from shakerproc.runs.analyses.waterfall import WaterfallAnalysis
from shakerproc.testlog import Processing, Profile, ResponseFunction, Test
from shakerproc.testlog.processing import (
    Distribution,
    Fatigue,
    Integration,
    Octaves,
    Shock,
    Splitting,
    Waterfall,
)

ASKED = {
    "shock": "{from: 5 Hz, to: 200 Hz, per_octave: 3}",
    "fatigue": "{from: 10 Hz, exponent: 8, per_octave: 3}",
    "integration": "{high_pass: 4 Hz, baseline: line}",
    "response_functions": "[{input: ch3, output: ch4}, {input: controls, output: ch3}]",
    "octaves": "{from: 8 Hz, to: 630 Hz}",
    "distribution": "{bins: 60}",
    "waterfall": "{spectra: 12}",
    "orders": "{tachometer: tacho, track: [0.5, 1, 1.5]}",
    "splitting": "{shortest: 1 s}",
}
"""What the log of these tests asks for, by kind; a new kind adds a line and passes them all."""

UNASKED = {
    "blows", "driving_point", "resonances", "decays", "multisine", "tones", "dwell",
    "uncertainty",
}  # fmt: skip
"""What nobody asks for: it comes with a force that drives the run, or with an excitation; and
the budgets, which have no figure: see test_uncertainty.py."""

REFUSED = {
    "response_functions: [{input: ch9, output: ch4}]": "no channel 'ch9'; the run has",
    "fatigue: {to: 205 Hz}": "above a tenth of the sample rate",
    "integration: {high_pass: 0.1 Hz}": "two periods in the run",
    "shock: {to: 300 Hz}": "above a tenth of the sample rate",
    "shock: {from: 210 Hz}": "does not lie below to",
    "orders: {}": "no channel 'tachometer'; the run has",
    "orders: {tachometer: tacho, track: [1, 4]}": "above half the sample rate of 2048 Hz",
    "orders: {tachometer: tacho, track: [1, 1.1]}": "not separable within 10 revolutions",
    "orders: {tachometer: tacho, pulses_per_revolution: 5000}": "revolutions in the run, where",
    "dwell: {}": "expected a test with excitation: sine",
    "splitting: {}": "a stationary part at least 5 s. Give splitting: {shortest: ...}",
    "octaves: {to: 1000 Hz}": "beyond 921.6 Hz, 0.45 of the sample rate",
}
"""What a recording of 2048 Hz does not allow."""

MISTAKEN = {
    "hammer: {trigger: 20 g}": "a number in N or in %",
    "hammer: {trigger: 120 %}": "between 0 and 100 %",
    "hammer: {exponential: 0 s}": "more than 0 s",
    "hammer: {exponential: 0.5}": "a number in s or in %",
    "hammer: {length: 0 s}": "more than 0",
    "hammer: {window: 5 ms}": 'unknown key "window"',
    "response_functions: [{input: ch3, output: ch3}]": "another channel than the input",
    "response_functions: [{input: ch3}]": "output",
    "fatigue: {exponent: 0}": "fatigue.exponent",
    "fatigue: {damping: 0 %}": "more than 0",
    "integration: {high_pass: 4}": "a unit",
    "integration: {baseline: cubic}": "integration.baseline",
    "octaves: {fraction: 5}": "octaves.fraction",
    "dwell: {every: 0 s}": "more than 0",
    "waterfall: {spectra: 1}": "waterfall.spectra",
    "orders: {track: []}": "orders.track",
    "orders: {track: [0]}": "orders.track",
    "orders: {pulses: 2}": 'unknown key "pulses"',
    "splitting: {crest: 1}": "splitting.crest",
    "splitting: {least: 2}": "a unit",
    "splitting: {longest: 0 s}": "more than 0",
    "distribution: {bins: 3}": "distribution.bins",
    "octaves: {from: 100 Hz, to: 50 Hz}": "expected from below to",
    "shock: {from: 20 Hz, to: 10 Hz}": "expected from below to",
    "shock: {damping: 100 %}": "a number below 1",
    "shock: {dampnig: 5 %}": 'did you mean "damping"',
}
"""What a log may not say."""


def campaign(folder, asked, more=""):
    log = write_campaign(folder, 1, seconds=4.0, more=more)
    mark = "  welch: {segment: 512, overlap: 256}\n"
    assert mark in log.read_text()
    text = log.read_text().replace(mark, mark + "".join(f"  {a}\n" for a in asked))
    log.write_text(text.replace("\nprocessing:", "\n  tacho: {role: tachometer}\nprocessing:"))
    with_tachometer(folder / "recordings" / "test_1.tdms")
    return log


def with_tachometer(path):
    """Add a shaft of 300 revolutions per second to a recording."""
    with open_recording(path) as recording:
        rows, rate = recording.samples(), recording.sample_rate
        channels = (*recording.channels, Channel("tacho", "V", "tacho", "V"))
    pulses = 5.0 * ((300.0 * np.arange(rows.shape[1]) / rate) % 1.0 < 0.5)
    write_tdms(path, recording_of_arrays(path.stem, channels, np.array([*rows, pulses]), rate))


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("analyses")
    log = campaign(folder, [f"{kind}: {how}" for kind, how in ASKED.items()])
    recording = folder / "recordings" / "test_1.tdms"
    assert run("process", recording, "--log", log, "--out", folder / "process") == 0
    assert run("batch", log, "--no-figures", "--out", folder / "batch") == 0
    return folder


def table(path):
    with path.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return {name: [row[name] for row in rows] for name in rows[0]}


def numbers(path):
    columns = {name: np.array(values) for name, values in table(path).items()}
    return {
        name: np.where(v == "", "nan", v).astype(float)
        for name, v in columns.items()
        if not name.startswith("excited")
    }


def test_every_kind_is_asked_for_here():
    assert set(ASKED) == set(ANALYSES) - {"profile"} - UNASKED


@pytest.mark.parametrize("kind", ASKED)
def test_every_kind_is_in_tables_figures_and_report(results, kind):
    assert "test" in table(results / "batch" / f"{kind}.csv")
    for folder in (results / "process", results / "batch" / "runs" / "test_1"):
        assert len(table(folder / f"{kind}_curves.csv")) >= 2
    assert list((results / "process").glob(f"{kind}*.png"))
    assert table(results / "process" / f"{kind}.csv")
    page = (results / "batch" / "report.html").read_text()
    title = r"<p class=\"made screen\">([^<]*):</p>\s*<div class=\"wide screen\">"
    titles = re.findall(title, page)
    assert len(titles) >= len(ASKED)


@pytest.mark.parametrize(("asked", "says"), REFUSED.items())
def test_what_a_recording_does_not_allow_is_one_line_and_nothing_is_written(
    tmp_path, capsys, asked, says
):
    log = campaign(tmp_path, [], more=f", processing: {{{asked}}}")
    recording = tmp_path / "recordings" / "test_1.tdms"
    assert run("process", recording, "--log", log, "--out", tmp_path / "out") == 1
    (line,) = [x for x in capsys.readouterr().err.splitlines() if x.startswith("error")]
    assert says in line
    assert not list((tmp_path / "out").glob("*.csv"))


@pytest.mark.parametrize(("asked", "says"), REFUSED.items())
def test_what_every_test_is_asked_and_one_cannot_have_is_left_out_of_it(
    tmp_path, capsys, asked, says
):
    log = campaign(tmp_path, [asked])
    recording = tmp_path / "recordings" / "test_1.tdms"
    out = ("--no-figures", "--out", tmp_path / "out")
    assert run("process", recording, "--log", log, *out) == 0
    told = [x for x in capsys.readouterr().err.splitlines() if says in x]
    assert len(told) == 1
    assert re.search("left out|shown is", told[0], re.IGNORECASE)
    assert table(tmp_path / "out" / "spectra.csv")


@pytest.mark.parametrize(("asked", "says"), MISTAKEN.items())
def test_a_mistake_in_the_log_is_told_with_its_place(tmp_path, capsys, asked, says):
    log = campaign(tmp_path, [asked])
    recording = tmp_path / "recordings" / "test_1.tdms"
    assert run("process", recording, "--log", log, "--out", tmp_path / "out") == 1
    (line,) = [x for x in capsys.readouterr().err.splitlines() if x.startswith("error")]
    assert re.search(r"testlog\.yaml:\d+:\d+:", line)
    assert says in line


def test_kinds_of_one_shock_belong_together(results):
    columns = numbers(results / "process" / "shock_curves.csv")
    omega = 2.0 * np.pi * columns["frequency_hz"]
    z = columns["relative_displacement_maximax_ch3_mm"] * 1e-3
    assert_allclose(columns["pseudo_velocity_maximax_ch3_m_per_s"], omega * z, rtol=1e-9)
    still = columns["equivalent_static_acceleration_maximax_ch3_g"] * 9.80665
    assert_allclose(still, omega**2 * z, rtol=1e-9)
    parts = ("primary_positive", "primary_negative", "residual_positive", "residual_negative")
    largest = np.max([columns[f"absolute_acceleration_{p}_ch3_g"] for p in parts], axis=0)
    assert_allclose(columns["absolute_acceleration_maximax_ch3_g"], largest, rtol=1e-12)


def test_displacement_of_a_run_is_that_of_its_density(results):
    """Rms of the displacement is the area of the density over omega^4, high-pass and all."""
    row = table(results / "process" / "integration.csv")
    spectra = numbers(results / "process" / "spectra.csv")
    f = spectra["frequency_hz"][1:]
    density = spectra["psd_ch3_g2_per_hz"][1:] * 9.80665**2
    velocity = density / (2.0 * np.pi * f) ** 2 / (1.0 + (4.0 / f) ** 8) ** 2
    rms = np.sqrt(np.sum(velocity) * f[0]) * 1e3
    i = row["channel"].index("ch3")
    assert_allclose(float(row["velocity_rms_mm_per_s"][i]), rms, rtol=0.15)  # bins of 4 Hz
    span = numbers(results / "process" / "integration_curves.csv")
    high, low = (span[f"displacement_{side}_ch3_mm"] for side in ("high", "low"))
    assert_allclose(float(row["displacement_peak_to_peak_mm"][i]), high.max() - low.min())


def test_a_function_from_the_controls_is_the_usual_one_and_one_between_responses_its_ratio(
    results,
):
    """ch4 is 0.6 ch3 + 0.4 of the base, so that ch4 / ch3 is 0.6 + 0.4 / H."""
    spectra = numbers(results / "process" / "spectra.csv")
    found = numbers(results / "process" / "response_functions_curves.csv")
    f = found["frequency_hz"]
    inside = (f > 20.0) & (f < 300.0)
    usual = spectra["h1_ch3_magnitude"][inside]
    assert_allclose(found["h1_ch3_over_controls_magnitude"][inside], usual, rtol=1e-9)
    phase = np.radians(spectra["h1_ch3_phase_deg"])
    h1 = (spectra["h1_ch3_magnitude"] * np.exp(1j * phase))[inside]
    wanted = np.abs(0.6 + 0.4 / h1)
    assert_allclose(found["h1_ch4_over_ch3_magnitude"][inside], wanted, rtol=0.05)
    rows = table(results / "process" / "response_functions.csv")
    assert rows["unit"] == ["1", "1"]
    assert rows["name"] == ["transmissibility"] * 2


@pytest.mark.parametrize("dead", ["control", "response", "both"])
def test_channels_that_do_not_measure_break_nothing(tmp_path, dead):
    """The health of the run is flagged elsewhere; no analysis ends in a traceback."""
    rng = np.random.default_rng(0)
    rows = rng.standard_normal((3, 4000))
    rows[{"control": [0], "response": [1], "both": [0, 1]}[dead]] = 0.0
    channels = (
        Channel("control", "m/s^2", "control", "g", "control"),
        Channel("ch3", "m/s^2", "ch3", "g", "response"),
        Channel("force", "N", "force", "N", "force"),
    )
    test = Test(
        1,
        excitation="random",
        from_hz=20.0,
        to_hz=900.0,
        profile=Profile("p", "(m/s^2)^2/Hz", (20.0, 900.0), (1.0, 1.0), (3.0,) * 2, (6.0,) * 2),
        processing=Processing(
            crop=None,
            shock=Shock(),
            octaves=Octaves(),
            integration=Integration(),
            distribution=Distribution(),
            waterfall=Waterfall(),
            splitting=Splitting(shortest=1.0),
            fatigue=Fatigue(),
            uncertainty=True,
            response_functions=(ResponseFunction("force", "ch3"),),
        ),
    )
    result = process_recording(recording_of_arrays("run", channels, rows, 2000.0), test)
    assert {one.kind for one in result.analyses} == set(ANALYSES) - {
        "blows",
        "decays",
        "multisine",
        "driving_point",
        "orders",
        "tones",
        "dwell",
    }
    if dead == "both":
        assert all(path.is_file() for path in draw_analyses(result, "a run", tmp_path))
    assert page_figures(summary_of(result, "1", {}, "r.tdms", "0" * 64))


def test_a_band_between_two_lines_of_a_waterfall_says_which_segment_it_takes():
    """At 2000 Hz, half a hertz takes 4000 samples."""
    rows = np.random.default_rng(0).standard_normal((2, 8000))
    channels = (
        Channel("control", "m/s^2", "control", "g", "control"),
        Channel("ch3", "m/s^2", "ch3", "g", "response"),
    )
    recording = recording_of_arrays("run", channels, rows, 2000.0)
    test = Test(1, processing=Processing(crop=None, waterfall=Waterfall()))
    result = process_recording(recording, test)
    narrow = replace(result, band=(100.2, 100.7))
    with pytest.raises(SpectrumError, match=r"holds no line .* welch.segment to 4000 samples"):
        WaterfallAnalysis().of(recording, narrow)


def test_a_sine_spends_its_time_at_its_ends_and_noise_at_its_middle():
    t = np.arange(200_000) / 2000.0
    sine = 3.0 * np.sin(2.0 * np.pi * 7.3 * t)
    noise = 2.0 * np.random.default_rng(2).standard_normal(t.size)
    channels = (
        Channel("control", "m/s^2", "control", "m/s^2", "control"),
        Channel("ch3", "m/s^2", "ch3", "m/s^2", "response"),
    )
    wish = Processing(crop=None, distribution=Distribution(bins=200))
    test = Test(1, excitation="random", from_hz=5.0, to_hz=900.0, processing=wish)
    rows = np.array([sine, noise])
    (one,) = process_recording(
        recording_of_arrays("run", channels, rows, 2000.0), test
    ).analyses
    low, high = one.columns["from_sigma"], one.columns["to_sigma"]
    for name in ("control", "ch3"):
        density = one.columns[f"density_{name}_per_sigma"]
        assert np.sum(density * (high - low)) == pytest.approx(1.0)
    within = np.abs(low) < 1.3
    arcsine = 0.5 - np.arcsin(low[within] / np.sqrt(2.0)) / np.pi
    assert_allclose(one.columns["exceedance_control"][within], arcsine, atol=2e-3)
    normal = scipy.stats.norm.sf(low)
    assert_allclose(one.columns["exceedance_ch3"], normal, atol=5e-3)
    assert one.summary[1]["beyond_3_sigma"] == pytest.approx(0.0027, rel=0.15)
    assert one.summary[0]["beyond_3_sigma"] == 0.0
    assert one.summary[0]["crest_factor"] == pytest.approx(np.sqrt(2.0), rel=1e-3)


@pytest.mark.parametrize(
    ("integration", "lost"),
    [
        (Integration("none"), 0.0),
        (Integration("none", "none"), 0.0),
        (Integration("none", "mean"), 1.0),
    ],
)
def test_the_velocity_change_of_a_half_sine_is_that_of_its_area(integration, lost):
    """2 A T / pi; a mean that is taken out takes its share of the time before the end."""
    rate, amplitude, length, start, seconds = 5120.0, 30.0 * 9.80665, 0.011, 0.1, 2.5
    time = np.arange(round(rate * seconds)) / rate
    inside = (time >= start) & (time < start + length)
    pulse = np.where(inside, amplitude * np.sin(np.pi * (time - start) / length), 0.0)
    test = Test(
        1,
        excitation="shock",
        from_hz=5.0,
        to_hz=100.0,  # no resonance is sought in the lobes above
        processing=Processing(crop=None, integration=integration),
    )
    channels = (Channel("table", "m/s^2", "table", "g", "control"),)
    result = process_recording(recording_of_arrays("run", channels, pulse[None], rate), test)
    (one,) = [one for one in result.analyses if one.kind == "integration"]
    change = 2e3 * amplitude * length / np.pi  # mm/s
    share = lost * (start + length) / seconds
    largest = one.summary[0]["velocity_peak_mm_per_s"]
    assert_allclose(largest, change * (1.0 - share), rtol=1e-3)
