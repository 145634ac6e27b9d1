"""The plan of whole logs: what is told of each test, and the command."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from typer.testing import CliRunner

from shakerproc.cli import build_app
from shakerproc.errors import ShakerprocError
from shakerproc.finite_elements.coupon import ThermalFit
from shakerproc.model_files import read_model
from shakerproc.planning import (
    PlanWish,
    Warming,
    displacement_of_test,
    joint_of_model,
    plan_campaign,
    play_of_test,
)
from shakerproc.testlog import Test, read_testlog

ROOT = Path(__file__).resolve().parents[2]
THESIS = ROOT / "configs" / "appendix_f.yaml"
SAMPLE = ROOT / "sample_data"
HEAD = """\
testlog: 1
channels: {control 1: {role: control}, control 2: {role: control}}
expect: {sample_rate: 5688.9 Hz}
tests:
"""


def planned(tmp_path, row, **wish):
    path = tmp_path / "log.yaml"
    path.write_text(f"{HEAD}  - {{id: 1, {row}}}\n", encoding="utf-8")
    (found,) = plan_campaign(read_testlog(path), PlanWish(**wish))
    return found


def run(*arguments):
    return CliRunner().invoke(build_app(), ["plan", *map(str, arguments)])


@pytest.fixture(scope="module")
def thesis():
    return plan_campaign(read_testlog(THESIS), PlanWish(which="nominal"))


def test_the_thesis_log_has_a_row_for_each_test(thesis):
    assert len(thesis) == 98
    assert sum(one.test.discarded for one in thesis) == 4
    assert all(one.shaken is not None for one in thesis if not one.test.discarded)


def test_double_impact_ends_where_the_amplitude_is_half_the_play(thesis):
    for one in thesis:
        if one.travel is None or one.test.excitation != "sine sweep" or not one.test.clearance:
            continue
        half = one.test.clearance / 2.0
        edge = np.sqrt(one.test.level / half) / (2.0 * np.pi)
        assert_allclose(one.travel.both_sides_to_hz, edge)
        assert_allclose(one.travel.whole_play_to_hz, edge / np.sqrt(2.0))
        ((low, high),) = one.reach.both_sides_hz
        assert_allclose((low, high), (one.test.from_hz, min(edge, one.test.to_hz)), rtol=1e-9)


def test_tone_tests_of_the_thesis_do_not_reach_double_impact_above_250_hz(thesis):
    by_id = {one.test.id: one for one in thesis}
    assert by_id[95].reach.contact == "both sides"  # 10 g at 50 Hz
    for number in (90, 91, 92, 96, 97, 99):
        assert by_id[number].reach.contact == "none"


def test_below_1_g_the_weight_of_a_part_is_told(thesis):
    """Figures 5.11 and 5.12: at 0.5 g the joint rests on one side, at 1 g it does not."""
    for one in thesis:
        if one.walls is None or one.test.excitation != "sine sweep":
            continue
        told = any("does not lift" in text for text in one.warnings)
        assert told is (one.test.level < 9.80665)


def test_a_sweep_beyond_nyquist_is_told(tmp_path):
    """Trap 56: 40 to 3000 Hz at 5688.9 Hz."""
    row = "excitation: sine sweep, level: 5 g, from: 40 Hz, to: 3000 Hz, rate: 1 oct/min"
    found = planned(tmp_path, row)
    assert any("3000 Hz lies beyond half the sample rate, 2844.4" in w for w in found.warnings)
    assert_allclose(found.duration, 60.0 * np.log2(75.0))
    found = planned(tmp_path, row.replace("3000", "2600"))
    assert any("roll-off" in text for text in found.warnings)


def test_a_fast_sweep_is_told_with_the_rate_that_would_do(tmp_path):
    joint = joint_of_model(read_model(SAMPLE / "model.yaml"))
    row = "excitation: sine sweep, level: 5 g, from: 20 Hz, to: 900 Hz, rate: {} oct/min"
    fast = planned(tmp_path, row.format(500), joint=joint)
    (told,) = [text for text in fast.warnings if "too fast" in text]
    rate = float(told.split("; ")[1].split()[0])
    slow = planned(tmp_path, row.format(rate), joint=joint)
    assert_allclose(slow.swept_peak, 0.95, atol=2e-3)
    assert fast.swept_peak < 0.8


def test_few_averages_are_told_with_the_time_that_would_do(tmp_path):
    row = "excitation: random, level: 0.01 g^2/Hz, from: 20 Hz, to: 900 Hz"
    short = planned(tmp_path, row, duration=0.6)
    (told,) = [text for text in short.warnings if "averages leave" in text]
    seconds = float(told.split("; ")[1].split()[0])
    longer = planned(tmp_path, row, duration=seconds)
    assert_allclose(longer.averaging.gain_error, 0.1, rtol=0.15)


@pytest.mark.parametrize(
    ("row", "told"),
    [
        ("excitation: shock, level: 50 g", "its width is not in the log"),
        ("comment: to do", "does not say what shakes it"),
        ("excitation: sine, level: 0.4 g, frequency: 50 Hz", "threshold of 0.45 g is above"),
        (
            "excitation: sine, level: 0.5 g, frequency: 50 Hz",
            "an offset of the sensor may hide",
        ),
        ("excitation: sine, level: 5 g, frequency: 50 Hz", "does not say its clearance"),
        (
            "excitation: sine, level: 5 g, frequency: 50 Hz, clearance: 0 mm",
            "the joint has no play (nominal)",
        ),
        ("excitation: random, level: 1 g^2/Hz, from: 5 Hz, to: 500 Hz", "where offsets leak"),
    ],
)
def test_what_to_mind_is_told(tmp_path, row, told):
    assert any(told in text for text in planned(tmp_path, row).warnings)


def test_a_force_moves_no_table(tmp_path):
    found = planned(tmp_path, "excitation: sine, level: 5 N, frequency: 50 Hz, clearance: 1 mm")
    assert found.travel is None
    assert found.reach is None


def test_out_of_plane_the_measured_axial_play_counts():
    test = Test(
        1,
        clearance=1e-4,
        actual_clearance=1.2e-4,
        actual_axial_clearance=2e-4,
        orientation="out of plane",
    )
    assert play_of_test(test).total == 2e-4
    assert play_of_test(test, "nominal").total == 1e-4
    inside = Test(1, clearance=1e-4, actual_clearance=1.2e-4, actual_axial_clearance=2e-4)
    assert play_of_test(inside).half == 0.6e-4


def test_a_plastic_hole_opens_on_a_steel_pin_and_its_plate_jams_the_bushing():
    """In plane d (alpha_p - alpha_s) dT more play, out of plane t (alpha_p - alpha_s) less."""
    hot = Warming(ThermalFit(9.9e-3, 9.8e-3, 110e-6, 12e-6), 2.5e-3, 40.0)
    inside = Test(1, actual_clearance=1e-4)
    grown = (9.9e-3 * 110e-6 - 9.8e-3 * 12e-6) * 40.0
    assert_allclose(play_of_test(inside, warming=hot).total, 1e-4 + grown, rtol=1e-10)
    axial = Test(1, actual_axial_clearance=2e-4, orientation="out of plane")
    shrunk = (2.7e-3 * 12e-6 - 2.5e-3 * 110e-6) * 40.0
    assert_allclose(play_of_test(axial, warming=hot).total, 2e-4 + shrunk, rtol=1e-10)
    very_cold = Warming(hot.fit, 2.5e-3, -250.0)
    assert play_of_test(inside, warming=very_cold).total == 0.0


def test_displacement_of_a_random_test_of_the_thesis():
    log = read_testlog(THESIS)
    travel = displacement_of_test(log.find(8))
    density = 0.0002 * 9.80665**2
    sigma = np.sqrt(density * (5.0**-3 - 1000.0**-3) / 3.0) / (2.0 * np.pi) ** 2
    assert_allclose(travel.rms_displacement, sigma)
    assert_allclose(travel.motion.displacement, 3.0 * sigma)


def test_the_command_on_the_thesis_log(tmp_path):
    done = run(THESIS, "--out", tmp_path, "--json", "-", "--no-figures", "--max-g", 50)
    assert done.exit_code == 0, done.stderr
    document = json.loads(done.stdout)
    assert document["schema"] == "shakerproc-plan/1"
    assert len(document["tests"]) == 98
    with (tmp_path / "plan.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["test"] for row in rows] == [str(one["test"]) for one in document["tests"]]
    first = document["tests"][0]
    assert_allclose(first["table_displacement_m"], 0.5 * 9.80665 / (2.0 * np.pi * 5.0) ** 2)


@pytest.mark.slow
def test_the_command_with_a_model_draws_and_tells(tmp_path):
    limits = ("--max-g", 20, "--max-velocity-m-per-s", 1, "--max-displacement-mm", 12)
    done = run(
        SAMPLE / "testlog.yaml", "--model", SAMPLE / "model.yaml", "--out", tmp_path, *limits,
        "--duration-s", 6,
    )  # fmt: skip
    assert done.exit_code == 0, done.stderr
    assert (tmp_path / "displacement.png").stat().st_size > 20_000
    assert "test 14: no contact" in done.stdout
    assert "which is beyond the shaker" in done.stdout


def test_temperature_changes_the_play(tmp_path):
    coupon = ROOT / "configs" / "coupons" / "pom_c_radial.yaml"
    plays = []
    for temperature in ("20 degC", "60 degC"):
        done = run(
            SAMPLE / "testlog.yaml", "--coupon", coupon, "--temperature", temperature,
            "--json", "-", "--no-figures", "--out", tmp_path,
        )  # fmt: skip
        assert done.exit_code == 0, done.stderr
        plays.append(json.loads(done.stdout)["tests"][2]["play_m"])
    assert_allclose(plays[0], 1e-4, rtol=1e-6)
    assert_allclose(plays[1] - plays[0], (9.9e-3 * 110e-6 - 9.8e-3 * 12e-6) * 40.0, rtol=1e-6)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("--joint", "base,coupon"), "needs --model"),
        (("--clearance", "real"), "is not one of actual, nominal"),
        (("--max-g", "-1"), "must be above 0"),
        (("--temperature", "60 degC"), "go together"),
    ],
)
def test_wrong_usage_is_told(arguments, told):
    done = run(SAMPLE / "testlog.yaml", *arguments)
    assert done.exit_code == 2
    assert told in " ".join(done.stderr.replace("│", " ").split())


def test_a_joint_that_the_model_lacks_is_told():
    done = run(SAMPLE / "testlog.yaml", "--model", SAMPLE / "model.yaml", "--joint", "base,rim")
    assert isinstance(done.exception, ShakerprocError)
    assert "nothing stands between base and rim" in str(done.exception)
