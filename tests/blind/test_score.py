"""The score, on verdicts made up so that it is known."""

import json
import sys

import numpy as np
import pytest
from blind.__main__ import main
from blind.judging import exact as hit
from blind.judging import tied
from blind.score import coverage, forecasts
from blind.score.bounds import clopper_pearson
from blind.trial import Trial, append_trial
from scipy import stats

from blind import score

JOINT = ["base", "coupon"]


def document(verdict, *effects, ties=(), parameters=None, before=0.3, after=0.012):
    return {
        "verdict": verdict,
        "effects": [
            {"kind": kind, "between": between, "parameters": parameters or {}}
            for kind, between in effects
        ],
        "indistinguishable": list(ties),
        "errors": {"held_out": {"before": before, "after": after}, "noise_floor": 0.01},
    }


def trial(kind, said, hidden=(), fault=None, seconds=10.0):
    effects = [
        {"kind": name, "between": JOINT, "parameters": {"clearance": 5e-5}, "main": "clearance"}
        for name in hidden
    ]
    return Trial(
        1, kind, 40.0, 0.01, {"effects": effects, "fault": fault}, said, seconds, seconds
    )


def test_the_first_name_and_its_place_decide():
    here, there = ("gap", JOINT), ("gap", ["coupon", "rim"])
    assert hit(trial("gap", document("effect found", here), ["gap"]))
    assert hit(trial("gap", document("effect found", ("gap", JOINT[::-1])), ["gap"]))
    assert not hit(trial("gap", document("effect found", there), ["gap"]))
    also = trial("gap", document("effect found", here, ("sensor_gain", ["ch3"])), ["gap"])
    assert not hit(also)


def test_a_declared_tie_counts_as_one():
    said = document("effect found", ("power_law", JOINT), ties=["gap"])
    assert not hit(trial("gap", said, ["gap"]))
    assert tied(trial("gap", said, ["gap"]))
    assert not tied(trial("stop", said, ["stop"]))


def test_any_name_is_a_false_alarm_where_nothing_is_missing():
    assert hit(trial("none", document("nothing missing")))
    assert not hit(trial("none", document("cannot tell")))
    assert not hit(trial("none", document("outside library")))
    assert not hit(trial("none", document("effect found", ("gap", JOINT))))
    assert not hit(trial("none", document("measurement fault", ("sensor_gain", ["ch3"]))))


def test_refusing_means_saying_so():
    hidden = ["parametric"]
    assert hit(trial("outside", document("outside library"), hidden))
    assert not hit(trial("outside", document("cannot tell"), hidden))


def test_not_named_is_enough_where_the_gap_never_closed():
    assert hit(trial("unexercised", document("cannot tell"), ["unexercised"]))
    assert hit(trial("unexercised", document("nothing missing"), ["unexercised"]))
    said = document("effect found", ("gap", JOINT))
    assert not hit(trial("unexercised", said, ["unexercised"]))


def test_a_pair_needs_both_in_any_order():
    both = document("effect found", ("sensor_delay", ["ch3"]), ("gap", JOINT))
    fault = {"kind": "sensor_delay", "channel": "ch3"}
    assert hit(trial("pair", both, ["gap"], fault))
    assert not hit(trial("pair", document("effect found", ("gap", JOINT)), ["gap"], fault))


def test_intervals_of_every_parameter_are_counted():
    numbers = {"clearance": {"value": 5.1e-5, "low": 4.9e-5, "high": 5.3e-5}}
    wide = trial("gap", document("effect found", ("gap", JOINT), parameters=numbers), ["gap"])
    narrow = {"clearance": {"value": 4.8e-5, "low": 4.7e-5, "high": 4.9e-5}}
    off = trial(
        "gap", document("effect found", ("gap", JOINT), parameters=narrow, after=0.4), ["gap"]
    )
    open_end = {"clearance": {"value": None, "low": 4.0e-5, "high": None}}
    unseen = trial(
        "gap", document("effect found", ("gap", JOINT), parameters=open_end), ["gap"]
    )
    figures = score.summary([wide, off, unseen])
    found = figures["intervals"]["without_nuisances"]
    assert (found["holding"], found["intervals"]) == (1, 2)
    assert (found["not_exercised"], found["bounds_that_hold"]) == (1, 1)
    assert found["error_median"] == pytest.approx(0.03)
    assert figures["errors"]["above_before"] == 1
    assert figures["rows"][0]["rate"] == 1.0


def test_conventions_of_parameters_are_settled():
    effect = {
        "kind": "power_law",
        "between": JOINT,
        "parameters": {"force": 2.0, "reference_displacement": 1e-4, "exponent": 3.5},
    }
    said = {
        "kind": "power_law",
        "between": JOINT,
        "parameters": {
            "force": {"value": 2.0 * 2.0**3.5, "low": 22.0, "high": 23.0},
            "reference_displacement": {"value": 2e-4, "low": None, "high": None},
            "exponent": {"value": 3.5, "low": 3.4, "high": 3.6},
        },
    }
    found = Trial(
        1, "power_law", 40.0, 0.01, {"effects": [effect], "fault": None},
        document("effect found") | {"effects": [said]}, 1.0, 1.0,
    )  # fmt: skip
    force, exponent = coverage.intervals(found)
    assert force.truth == pytest.approx(2.0 * 2.0**3.5)
    assert force.holds
    assert exponent.error == pytest.approx(0.0)


def test_bounds_are_those_of_the_binomial_distribution():
    """At each bound the tail beyond what was counted is 2.5 %; none of n is 1 - 0.025^(1/n)."""
    low, high = clopper_pearson(7, 9)
    assert stats.binom.sf(6, 9, low) == pytest.approx(0.025)
    assert stats.binom.cdf(7, 9, high) == pytest.approx(0.025)
    assert clopper_pearson(0, 20) == (0.0, pytest.approx(1.0 - 0.025 ** (1.0 / 20.0)))
    assert clopper_pearson(4, 4)[1] == 1.0


def test_a_perfect_forecaster_passes_and_a_boaster_does_not():
    rng = np.random.default_rng(3)
    confidence = rng.uniform(0.5, 1.0, 400)
    right = (rng.random(400) < confidence).astype(float)
    assert forecasts.judged(confidence, right)["met"]
    assert not forecasts.judged(0.5 + 0.5 * confidence, right)["met"]
    assert forecasts.calibration_error(np.full(10, 0.7), np.ones(10)) == pytest.approx(0.3)


LOCKED = "coulomb_friction:locked:sweep"


def locked(bound, verdict="cannot tell", effects=()):
    said = document(verdict) | {
        "effects": list(effects),
        "locked": [{"between": JOINT, "holds_at_least": {"value": bound, "unit": "N"}}],
    }
    effect = {
        "kind": "coulomb_friction",
        "between": JOINT,
        "parameters": {"sliding_force": 9.7},
    }
    truth = {"effects": [effect], "fault": None}
    return Trial(1, LOCKED, 40.0, 0.01, truth, said, 1.0, 1.0)


def test_a_locked_joint_is_to_be_said_with_a_bound_below_the_truth():
    assert hit(locked(3.7))
    assert hit(locked(3.7, "nothing missing"))
    assert not hit(locked(12.0))
    open_end = {"sliding_force": {"value": None, "low": 3.7, "high": None}}
    friction = {"kind": "stribeck_friction", "between": JOINT, "parameters": open_end}
    assert hit(locked(3.7, "effect found", [friction]))
    sure = {"sliding_force": {"value": 4.0, "low": 3.9, "high": 4.1}}
    assert not hit(locked(3.7, "effect found", [friction | {"parameters": sure}]))
    assert not hit(locked(3.7, "outside library"))


def test_the_report_shows_every_miss():
    said = document("effect found", ("cubic_stiffness", JOINT), ties=["power_law"])
    text = score.report([trial("gap", said, ["gap"]), trial("none", document("cannot tell"))])
    assert "MISS gap seed 1 (40 dB): hidden gap; said effect found: cubic_stiffness" in text
    assert "cubic_stiffness 1" in text
    assert "nothing missing                         0/1" in text


def test_two_sets_are_compared_on_the_same_draws():
    right = trial("gap", document("effect found", ("gap", JOINT)), ["gap"])
    wrong = trial("gap", document("outside library"), ["gap"])
    other = trial("stop", document("effect found", ("stop", JOINT)), ["stop"])
    assert "WORSE" in score.tables.against([wrong, other], [right])
    assert "stop" not in score.tables.against([wrong, other], [right])


def test_a_file_of_trials_is_scored_without_drawing(tmp_path, monkeypatch, capsys):
    path, figures = tmp_path / "trials.json", tmp_path / "summary.json"
    append_trial(path, trial("gap", document("effect found", ("gap", JOINT)), ["gap"]))
    words = ["blind", "--score", str(path), "--against", str(path), "--summary", str(figures)]
    monkeypatch.setattr(sys, "argv", words)
    main()
    assert "single effect exact                     1/1    100.0%" in capsys.readouterr().out
    assert json.loads(figures.read_text())["trials"] == 1
