"""The score, on verdicts made up so that it is known."""

import pytest
from blind.judging import exact as hit
from blind.judging import tied
from blind.trial import Trial

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
    wrong = trial("gap", document("effect found", there), ["gap"])
    assert not hit(wrong)
    assert score.misplaced(wrong)


def test_a_declared_tie_counts_as_one():
    said = document("effect found", ("power_law", JOINT), ties=["gap"])
    assert not hit(trial("gap", said, ["gap"]))
    assert tied(trial("gap", said, ["gap"]))
    assert not tied(trial("stop", said, ["stop"]))


def test_any_name_is_a_false_alarm_where_nothing_is_missing():
    assert hit(trial("none", document("nothing missing")))
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


def test_parameters_and_ladder_add_up():
    numbers = {"clearance": {"value": 5.1e-5, "low": 4.9e-5, "high": 5.3e-5}}
    wide = trial("gap", document("effect found", ("gap", JOINT), parameters=numbers), ["gap"])
    narrow = {"clearance": {"value": 4.8e-5, "low": 4.7e-5, "high": 4.9e-5}}
    off = trial(
        "gap", document("effect found", ("gap", JOINT), parameters=narrow, after=0.4), ["gap"]
    )
    figures = score.summary([wide, off])
    assert figures["main_parameter_error_median"] == pytest.approx(0.03)
    assert figures["main_parameter_coverage"] == 0.5
    assert figures["held_out_above_before"] == 1
    assert figures["goals"]["effect"] == 1.0


def test_the_report_shows_every_miss():
    said = document("effect found", ("cubic_stiffness", JOINT), ties=["power_law"])
    text = score.report([trial("gap", said, ["gap"]), trial("none", document("cannot tell"))])
    assert "gap seed 1 (40 dB): hidden gap; said effect found: cubic_stiffness" in text
    assert "cubic_stiffness 1" in text
    assert "nothing missing, and none named" in text
