"""Forecasts of simulated campaigns against closed forms of linear random vibration."""

import json

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import signal
from typer.testing import CliRunner

import shakerproc
from shakerproc.cli import build_app
from shakerproc.errors import DiagnosisError, LogError
from shakerproc.model_files import read_model
from shakerproc.planning.drive import drive_of_test
from shakerproc.testlog import read_testlog

RATE, SECONDS = 2000.0, 6.0
MASS, FREQUENCY, RATIO = 0.5, 120.0, 0.03
OMEGA = 2.0 * np.pi * FREQUENCY
LOW, HIGH = 20.0, 700.0
DENSITIES = (1e-3, 4e-3, 1.6e-2)  # [g^2/Hz]
G = 9.80665
MODEL = f"""\
model: 1
title: coupon
masses: {{coupon: {MASS} kg}}
elements:
  - {{kind: spring, between: [base, coupon], stiffness: {1.04 * MASS * OMEGA**2:.8g} N/m}}
  - {{kind: damper, between: [base, coupon], damping: {2.2 * RATIO * MASS * OMEGA:.8g} N s/m}}
excitation: {{base: acceleration}}
sensors: {{ch3: {{at: coupon, measures: acceleration}}}}
"""


def transmissibility(f, damping=RATIO):
    ratio = f / FREQUENCY
    return (1.0 + 2j * damping * ratio) / (1.0 - ratio**2 + 2j * damping * ratio)


def response_of(base, damping=RATIO):
    """Return the absolute acceleration of an oscillator, by its transfer function."""
    n = base.size
    gain = transmissibility(np.fft.rfftfreq(2 * n, 1.0 / RATE), damping)
    return np.fft.irfft(gain * np.fft.rfft(base, 2 * n), 2 * n)[:n]


def exact(density):
    """Return rms of response [m/s^2] and of stretch [m] under a flat density [g^2/Hz]."""
    f = np.linspace(LOW, HIGH, 400_000)
    ratio = f / FREQUENCY
    gain = np.abs((1.0 + 2j * RATIO * ratio) / (1.0 - ratio**2 + 2j * RATIO * ratio)) ** 2
    stretch = np.abs(1.0 / (OMEGA**2 - (2.0 * np.pi * f) ** 2 + 2j * RATIO * OMEGA * 2.0
                            * np.pi * f)) ** 2  # fmt: skip
    return [np.sqrt(density * G**2 * np.trapezoid(one, f)) for one in (gain, stretch)]


def write(folder, densities=DENSITIES, tests="", limits="{}", volts=()):
    """Write a campaign: CSV recordings of band-limited noise and the response to it.

    Where tests are at so many volts, each adds 1 % to a damping ratio of 2 %.
    """
    rows, generator = [], np.random.default_rng(3)
    (folder / "recordings").mkdir(parents=True)
    n = round(SECONDS * RATE)
    for i, density in enumerate(densities, 1):
        f = np.fft.rfftfreq(n, 1.0 / RATE)
        spectrum = generator.standard_normal((2, f.size)).T @ [1.0, 1.0j]
        spectrum[(f < LOW) | (f > HIGH)] = 0.0
        base = np.fft.irfft(spectrum, n)
        base *= G * np.sqrt(density * (HIGH - LOW)) / np.std(base)
        base[: n // 10] = base[-n // 20 :] = 0.0
        damping = 0.02 + 0.01 * volts[i - 1] if volts else RATIO
        both = np.array([base, response_of(base, damping)])
        both += 1e-3 * both.std(axis=1)[:, None] * generator.standard_normal(both.shape)
        table = np.column_stack([np.arange(n) / RATE, *(both / G)])
        np.savetxt(folder / "recordings" / f"{i}.csv", table, delimiter=",", comments="",
                   header="time [s],control [g],response [g]")  # fmt: skip
        rows.append(f"  - {{id: {i}, recording: {i}.csv, excitation: random, "
                    f"level: {density} g^2/Hz, from: {LOW} Hz, to: {HIGH} Hz"
                    + (f", conditions: {{voltage: {volts[i - 1]} V}}}}" if volts else "}")
                    )  # fmt: skip
    log = folder / "log.yaml"
    head = (
        "testlog: 1\nchannels:\n  control: {role: control}\n  response: {role: response, "
        f"name: ch3}}\nprocessing: {{crop: {{from: 0.7 s, to: 5.6 s}}}}\nlimits: {limits}\n"
    )
    log.write_text(head + "tests:\n" + "\n".join(rows) + f"\n{tests}", encoding="utf-8")
    (folder / "model.yaml").write_text(MODEL, encoding="utf-8")
    return folder / "model.yaml", log


PLANNED = (
    f"  - {{id: 9, planned: true, excitation: random, level: 0.064 g^2/Hz, from: {LOW} Hz, "
    f"to: {HIGH} Hz, duration: 20 s}}\n"
)


def run(*arguments):
    return CliRunner().invoke(build_app(), ["forecast", *map(str, arguments)])


@pytest.mark.slow
def test_a_linear_model_is_forecast_as_the_closed_form_says(tmp_path):
    rms, stretch = exact(0.064)
    crossings = 2.0 * FREQUENCY * 20.0
    largest = np.sqrt(2.0 * np.log(crossings)) + 0.5772 / np.sqrt(2.0 * np.log(crossings))
    limit = 1e3 * 1.4 * largest * stretch
    limits = f"{{ch3: {0.8 * largest * rms / G} g peak, joint base-coupon: {limit} mm}}"
    model, log = write(tmp_path / "c", tests=PLANNED, limits=limits)
    out, target = tmp_path / "out", tmp_path / "f.json"
    found = run(model, log, "--out", out, "--json", target)
    assert found.exit_code == 0, found.output
    assert found.stdout.startswith("no-go: test 9 exceeds ch3 peak")
    document = json.loads(target.read_text(encoding="utf-8"))
    assert document["schema"] == "shakerproc-forecast/1"
    (test,) = document["tests"]
    assert (test["id"], test["level"], test["go"]) == (9, "0.064 g^2/Hz", False)
    ch3 = test["responses"]["ch3"]
    assert_allclose(ch3["rms"]["value"], rms, rtol=0.03)
    assert ch3["rms"]["low"] < rms < ch3["rms"]["high"]
    assert_allclose(ch3["rms"]["linear"], rms, rtol=0.1)
    assert_allclose(ch3["peak_frequency_hz"]["value"], FREQUENCY, rtol=0.01)
    davenport = largest * rms  # some 5 % above narrow-band motion, whose peaks come in groups
    assert 0.9 * davenport < ch3["peak"]["value"] < 1.02 * davenport
    moved = test["joints"]["base-coupon"]["displacement"]
    assert 0.9 * largest * stretch < moved["value"] < 1.02 * largest * stretch
    first, second = test["limits"]
    assert first["probability"] > 0.95
    assert second["probability"] < 0.05
    assert float(first["level_at_5_percent"].split()[0]) < 0.064
    assert (out / "report.html").is_file()
    assert (out / "forecast_9_ch3.png").is_file()
    header, row, *_ = (out / "forecast.csv").read_text(encoding="utf-8").splitlines()
    assert header == "test,of,name,what,value,low,high,linear,unit"
    assert row.startswith("9,response,ch3,rms,")


@pytest.mark.long
@pytest.mark.slow
def test_each_test_is_forecast_under_its_own_condition(tmp_path):
    """Run at 0 and 2 V, planned at 4 V, where the damping ratio is 6 %; at 0 V it is 2 %."""
    planned = PLANNED.replace("20 s}", "10 s, conditions: {voltage: 4 V}}")
    model, log = write(tmp_path / "c", tests=planned, volts=(0, 2, 0))
    coil = f"damping: {2.2 * 0.02 * MASS * OMEGA:.8g} N s/m, scaled_by: {{voltage: 2 V}}}}"
    text = model.read_text("utf-8").replace(
        "excitation:", f"  - {{kind: damper, between: [base, coupon], {coil}\nexcitation:"
    )
    model.write_text(text, "utf-8")
    out, target = tmp_path / "out", tmp_path / "f.json"
    found = run(model, log, "--out", out, "--json", target, "--no-figures")
    assert found.exit_code == 0, found.output
    document = json.loads(target.read_text("utf-8"))
    assert "test 9 is at a voltage of 4 V, which no test was run at or beyond" in str(
        document["notes"]
    )
    ch3 = document["tests"][0]["responses"]["ch3"]
    f = np.linspace(LOW, HIGH, 400_000)
    gain = np.abs(transmissibility(f, 0.06)) ** 2
    rms = np.sqrt(0.064 * G**2 * np.trapezoid(gain, f))
    assert_allclose(ch3["rms"]["value"], rms, rtol=0.03)
    assert ch3["rms"]["low"] < rms < ch3["rms"]["high"]
    assert ch3["rms"]["linear"] > 1.5 * rms


def test_a_planned_test_that_says_no_condition_is_refused(tmp_path):
    model, log = write(tmp_path / "c", tests=PLANNED, volts=(0, 2, 0))
    text = model.read_text("utf-8").replace("N s/m}", "N s/m, scaled_by: {voltage: 2 V}}")
    model.write_text(text, "utf-8")
    found = run(model, log)
    assert found.exit_code == 1
    assert "test 9 says no voltage; add conditions: {voltage: 2 V} to it" in str(
        found.exception
    )


def exact_rms(profile):
    """Return the rms response to a density of breakpoints, by its integral [m/s^2]."""
    f = np.linspace(LOW, HIGH, 400_000)
    corners = [one["frequency_hz"] for one in profile]
    levels = [one["level_g2_per_hz"] for one in profile]
    density = G**2 * np.exp(np.interp(np.log(f), np.log(corners), np.log(levels)))
    return np.sqrt(np.trapezoid(np.abs(transmissibility(f)) ** 2 * density, f))


@pytest.mark.long
@pytest.mark.slow
def test_the_notched_profile_of_a_linear_model_keeps_its_limit_and_takes_no_more(tmp_path):
    """The rms under the notched profile, in closed form: at the limit but for the band."""
    limit = 0.6 * exact(0.064)[0]
    model, log = write(tmp_path / "c", tests=PLANNED, limits=f"{{ch3: {limit / G} g rms}}")
    out, target = tmp_path / "out", tmp_path / "f.json"
    found = run(model, log, "--notch", "--no-figures", "--out", out, "--json", target)
    assert found.exit_code == 0, found.output
    assert "notched, each limit is kept with 95 %" in found.stdout.splitlines()[0]
    (test,) = json.loads(target.read_text(encoding="utf-8"))["tests"]
    rms, band = exact_rms(test["notch"]), test["responses"]["ch3"]["rms"]
    above = band["high"] / band["value"]  # 95 % of what the bands leave open
    assert limit / above / 1.06 < rms < limit
    plan = test["notch_plan"]
    assert plan["exceeded"][0]["probability"] <= 0.05
    cost = 20.0 * np.log10(exact(0.064)[0] / rms)
    assert_allclose(plan["cost"]["ch3"]["rms_db"], cost, atol=0.3)
    corners = [(one["frequency_hz"], one["level_g2_per_hz"]) for one in test["notch"]]
    (f, level) = np.array(corners).T
    slopes = 10.0 * np.diff(np.log10(level)) / np.diff(np.log2(f))
    assert np.abs(slopes).max() < 24.5
    assert (out / "notched_9.yaml").is_file()
    assert (out / "notched_9.csv").is_file()


SWEPT = (
    f"  - {{id: 9, planned: true, excitation: sine sweep, level: 1 g, from: {LOW} Hz, "
    "to: 700 Hz, rate: 8 oct/min}\n"
)


@pytest.mark.long
@pytest.mark.slow
def test_a_notched_sweep_passes_the_resonance_at_its_limit_over_the_amplification(tmp_path):
    limit = 8.0  # of some 16.7 g without notches
    model, log = write(tmp_path / "c", tests=SWEPT, limits=f"{{ch3: {limit} g peak}}")
    found = shakerproc.forecast(read_model(model), read_testlog(log), notch=True)
    (test,) = found.as_json()["tests"]
    f = np.array([one["frequency_hz"] for one in test["notch"]])
    level = np.array([one["level_g"] for one in test["notch"]])
    at = np.geomspace(30.0, 600.0, 3000)
    ratio = at / FREQUENCY
    gain = np.abs((1.0 + 2j * RATIO * ratio) / (1.0 - ratio**2 + 2j * RATIO * ratio))
    steady = gain * np.exp(np.interp(np.log(at), np.log(f), np.log(level)))
    assert 0.85 * limit < steady.max() < 1.02 * limit
    assert level[0] == pytest.approx(1.0, abs=1e-4)
    assert level[-1] == pytest.approx(1.0, abs=1e-4)


@pytest.mark.parametrize(
    ("planned", "limits", "told"),
    [
        (PLANNED, "{}", "the log has none; add limits"),
        ("  - {id: 9, planned: true, excitation: sine, level: 1 g, frequency: 120 Hz, "
         "duration: 5 s}\n", "{ch3: 4 g peak}", "notches are planned for random and sine"),
    ],
)  # fmt: skip
def test_notches_that_cannot_be_planned_are_told_before_long_work(
    tmp_path, planned, limits, told
):
    model, log = write(tmp_path / "c", (1e-3, 4e-3), planned, limits)
    with pytest.raises(LogError, match=told):
        shakerproc.forecast(read_model(model), read_testlog(log), notch=True)


@pytest.mark.parametrize(
    ("densities", "tests", "limits", "told", "kind"),
    [
        ((1e-3,), PLANNED, "{}", "one level only", DiagnosisError),
        ((1e-3, 4e-3), "", "{}", "no test is planned", LogError),
        ((1e-3, 4e-3), PLANNED.replace("700.0 Hz", "900 Hz"), "{}", "expected a band within",
         LogError),
        ((1e-3, 4e-3), PLANNED, "{joint base-bracket: 1 mm}", "expected a joint of the model",
         LogError),
        ((1e-3, 4e-3), PLANNED, "{control: 1 g}", "expected a sensor of the model", LogError),
        ((1e-3, 4e-3), PLANNED, "{joint base-coupon: 1 mm rms}", "expected a peak", LogError),
        ((1e-3, 4e-3), PLANNED, "{shaker: {force: 1 kN}}", "moving_mass", LogError),
        ((1e-3, 4e-3), PLANNED, "{ch3: 1 mm}", "expected a limit in m/s", LogError),
    ],
)  # fmt: skip
def test_what_cannot_be_forecast_is_told_before_long_work(
    tmp_path, densities, tests, limits, told, kind
):
    model, log = write(tmp_path / "c", densities, tests, limits)
    with pytest.raises(kind, match=told):
        shakerproc.forecast(read_model(model), read_testlog(log))


def test_a_wrong_level_is_wrong_usage(tmp_path):
    model, log = write(tmp_path / "c", (1e-3, 4e-3))
    found = run(model, log, "--level", "3 mm", "--out", tmp_path / "out")
    assert found.exit_code == 2
    assert "--level" in found.output


def test_how_notches_are_planned_without_notches_is_wrong_usage(tmp_path):
    model, log = write(tmp_path / "c", (1e-3, 4e-3))
    found = run(model, log, "--probability", "0.9", "--out", tmp_path / "out")
    assert found.exit_code == 2
    assert "--notch" in found.output


def test_planned_tests_are_left_out_of_a_comparison_with_one_line(tmp_path):
    model, log = write(tmp_path / "c", (1e-3, 4e-3), PLANNED)
    found = shakerproc.compare(read_model(model), read_testlog(log)).found
    assert [test.measured.name for test in found.tests] == ["1", "2"]
    assert found.left_out == (
        "test 9 is planned and not run yet: left out here; `shakerproc forecast` says what it "
        "will do",
    )


PROFILE = """\
testlog: 1
profiles:
  q: {breakpoints: [[20 Hz, 0.01 g^2/Hz], [80 Hz, 0.04 g^2/Hz], [350 Hz, 0.04 g^2/Hz], [700 Hz, 0.02 g^2/Hz]]}
  s: {breakpoints: [[20 Hz, 1 g], [80 Hz, 4 g], [200 Hz, 4 g]]}
tests:
  - {id: 1, planned: true, excitation: random, profile: q, duration: 60 s}
  - {id: 2, planned: true, excitation: sine sweep, profile: s, rate: 10 oct/min}
"""  # noqa: E501 - YAML


def test_a_planned_test_is_shaken_by_its_profile(tmp_path):
    path = tmp_path / "log.yaml"
    path.write_text(PROFILE, encoding="utf-8")
    noise, sweep = read_testlog(path).planned
    samples = drive_of_test(noise, 60.0, RATE, np.random.default_rng(0)) / G
    f, density = signal.welch(samples, RATE, nperseg=2000)
    for low, high, wanted in (
        (85.0, 345.0, 0.04),
        (22.0, 24.0, 0.0115),
        (495.0, 497.0, 0.0282),
    ):
        inside = (f >= low) & (f <= high)
        assert_allclose(np.mean(density[inside]), wanted, rtol=0.15)
    seconds = 60.0 * np.log2(10.0) / 10.0
    driven = drive_of_test(sweep, seconds, RATE, np.random.default_rng(0)) / G
    time = np.arange(driven.size) / RATE
    frequency = 20.0 * 10.0 ** (time / seconds)
    near = {at: np.abs(frequency / at - 1.0) < 0.02 for at in (40.0, 150.0)}
    assert_allclose(driven[near[40.0]].max(), 2.0, rtol=0.03)
    assert_allclose(driven[near[150.0]].max(), 4.0, rtol=0.03)
