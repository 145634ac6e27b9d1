"""Limits of the shaker in the log, and the tests that a diagnosis asks for."""

import json
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from tests.in_process import run

from shakerproc.data import STANDARD_GRAVITY as G
from shakerproc.errors import LogError, ShakerprocError
from shakerproc.planning import (
    RandomInput,
    ShakerLimits,
    SineInput,
    plan_test,
    suggested_tests,
)
from shakerproc.planning.plan import PlanWish
from shakerproc.testlog import read_testlog

LOG = """\
testlog: 1
shaker: {stroke: 25.4 mm, velocity: 1 m/s, acceleration: 50 g, force: 500 N, moving_mass: 5 kg}
tests:
  - {id: 1, joint: r, clearance: 0.1 mm, excitation: sine sweep, level: 1 g, from: 2 Hz,
     to: 500 Hz, rate: 1 oct/min}
  - {id: 2, joint: r, clearance: 0.1 mm, excitation: sine, level: 9 g, frequency: 200 Hz}
  - {id: 3, joint: r, clearance: 0.1 mm, excitation: random, level: 0.001 g^2/Hz, from: 20 Hz,
     to: 1000 Hz}
  - {id: 4, joint: r, clearance: 0.1 mm, excitation: sine, level: 600 N, frequency: 50 Hz}
"""
DIAGNOSIS = {
    "schema": "shakerproc-diagnosis/1",
    "next_test": [
        {"excitation": "random", "level": "0.05 g^2/Hz", "separates": ["gap", "stop"]},
        {"excitation": "1", "level": "2 g rms", "separates": []},
    ],
}


@pytest.fixture
def log(tmp_path):
    (tmp_path / "log.yaml").write_text(LOG)
    return read_testlog(tmp_path / "log.yaml")


def test_the_log_says_what_the_shaker_can_do(log):
    shaker = log.shaker
    assert_allclose(
        [shaker.stroke, shaker.velocity, shaker.acceleration, shaker.force, shaker.moving_mass],
        [0.0254, 1.0, 50.0 * G, 500.0, 5.0],
    )


def test_each_limit_is_told_of_the_test_that_breaks_it(log, tmp_path, capsys):
    assert run("plan", tmp_path / "log.yaml", "--out", tmp_path / "out", "--no-figures") == 0
    told = capsys.readouterr().out
    assert "test 1: displacement 62.1 mm (amplitude) is above the shaker's 12.7 mm" in told
    lowest = np.sqrt(G / 12.7e-3) / (2.0 * np.pi)
    assert f"possible from {lowest:.4g} Hz" in told
    assert "test 2: force" not in told
    assert "test 3: force" not in told  # 3 sigma: 5 kg at 2.97 g is 146 N
    assert "test 4: force 600 N (amplitude) is above the shaker's 500 N" in told


def test_options_set_the_log_aside(tmp_path, log, capsys):
    options = ("--max-displacement-mm", "70", "--out", tmp_path / "out", "--no-figures")
    assert run("plan", tmp_path / "log.yaml", *options) == 0
    told = capsys.readouterr().out
    assert "test 1: displacement" not in told
    assert "test 4: force 600 N" in told


def test_force_over_mass_is_an_acceleration():
    limits = ShakerLimits(acceleration=50.0 * G, force=500.0, moving_mass=5.0)
    assert_allclose(limits.largest_acceleration(np.array([100.0])), 100.0)
    assert not limits.exceeded_by(SineInput(99.9, 10.0, 500.0))
    assert "to move 5 kg" in limits.exceeded_by(SineInput(100.1, 10.0, 500.0))[0]
    assert limits.exceeded_by(RandomInput((34.0**2) / 990.0, 10.0, 1000.0))
    assert not limits.exceeded_by(RandomInput((33.0**2) / 990.0, 10.0, 1000.0))


@pytest.mark.parametrize("wrong", ["stroke: 25.4", "force: 3 kg", "speed: 1 m/s"])
def test_a_wrong_limit_is_told_with_its_place(tmp_path, wrong):
    (tmp_path / "log.yaml").write_text(LOG.replace("stroke: 25.4 mm", wrong))
    with pytest.raises(ShakerprocError, match=r"log\.yaml:2:"):
        read_testlog(tmp_path / "log.yaml")


def test_a_diagnosis_becomes_tests_like_those_of_the_log(log):
    first, second = suggested_tests(DIAGNOSIS, log, "d.json")
    assert (first.id, first.from_hz, first.to_hz) == ("next 1", 20.0, 1000.0)
    assert_allclose(first.level, 0.05 * G**2)
    assert first.comment == "separates gap and stop"
    assert first.clearance == 1e-4
    assert second.excitation == "sine sweep"
    assert_allclose(second.level, 2.0 * np.sqrt(2.0) * G)
    planned = plan_test(second, PlanWish(limits=ShakerLimits(velocity=1.0)))
    assert any("velocity" in text for text in planned.warnings)


def test_an_excitation_that_the_log_never_used_has_its_own_band(tmp_path):
    (tmp_path / "log.yaml").write_text(LOG)
    log = read_testlog(tmp_path / "log.yaml")
    log = replace(log, tests=tuple(t for t in log.tests if t.excitation == "random"))
    wanted = {"excitation": "sine sweep", "level": "2 g", "band_hz": [30.0, 800.0], "like": ""}
    (test,) = suggested_tests({**DIAGNOSIS, "next_test": [wanted]}, log, "d.json")
    assert (test.excitation, test.from_hz, test.to_hz) == ("sine sweep", 30.0, 800.0)
    assert_allclose(test.level, 2.0 * G)


def test_plan_takes_a_diagnosis(tmp_path, log, capsys):
    (tmp_path / "d.json").write_text(json.dumps(DIAGNOSIS))
    arguments = ("plan", tmp_path / "log.yaml", "--diagnosis", tmp_path / "d.json")
    assert run(*arguments, "--out", tmp_path / "out", "--no-figures") == 0
    assert "test next 1: force" in capsys.readouterr().out
    assert "next 2" in (tmp_path / "out" / "plan.csv").read_text()
    (tmp_path / "d.json").write_text("{")
    assert run(*arguments) == 1
    assert "no JSON" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("document", "message"),
    [
        ([], "expected a diagnosis"),
        ({"schema": "other/1"}, "expected a diagnosis"),
        ({"schema": "shakerproc-diagnosis/1", "next_test": "x"}, "no list of tests"),
        ({**DIAGNOSIS, "next_test": [{"excitation": "shock", "level": "1 g"}]}, "'shock'"),
        ({**DIAGNOSIS, "next_test": [{"excitation": "random", "level": "1 s"}]}, 'got "1 s"'),
        ({**DIAGNOSIS, "next_test": [{"excitation": "sine", "level": "1 g^2/Hz"}]}, "no level"),
    ],
)
def test_what_is_no_diagnosis_is_refused(log, document, message):
    with pytest.raises(LogError, match=message):
        suggested_tests(document, log, "d.json")
