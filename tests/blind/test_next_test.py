"""The proposed test: read, carried out by the truth, judged."""

import json
from dataclasses import replace

import numpy as np
import pytest
from blind.campaigns import draw_all
from blind.excitations import Drive
from blind.judging import exact
from blind.trial import Trial

from blind import next_test

LIKE = Drive("random", 9.0, 10.0, 1000.0, True, 1.0, 0.2, (7, 1, 3))
G = 9.80665


def test_a_density_becomes_an_rms():
    asked = {"excitation": "random", "level": "0.01 g^2/Hz", "band_hz": [10.0, 510.0]}
    drive = next_test.drive_of(asked, LIKE, 5)
    assert drive.level == pytest.approx(np.sqrt(0.01 * 500.0) * G)
    assert (drive.low_hz, drive.high_hz) == (10.0, 510.0)
    assert drive.seed != LIKE.seed


@pytest.mark.parametrize(
    ("level", "expected"), [("0.5 g", 0.5 * G), ("3 m/s^2 rms", 3.0 * np.sqrt(2.0)), ("2 N", 2)]
)
def test_levels_of_a_sweep_are_amplitudes(level, expected):
    drive = next_test.drive_of({"excitation": "sine sweep", "level": level}, LIKE, 5)
    assert drive.level == pytest.approx(expected)


def test_what_cannot_be_read_is_told():
    with pytest.raises(ValueError, match="level 'louder' of the proposed test"):
        next_test.drive_of({"excitation": "random", "level": "louder"}, LIKE, 5)
    with pytest.raises(ValueError, match="proposed excitation 'hammer'"):
        next_test.drive_of({"excitation": "hammer", "level": "2 N"}, LIKE, 5)


def answer(kind, verdict, ties=()):
    effects = [{"kind": kind, "between": ["base", "coupon"], "parameters": {}}] if kind else []
    return {"verdict": verdict, "effects": effects, "indistinguishable": list(ties)}


@pytest.mark.slow
@pytest.mark.long
def test_the_truth_carries_out_what_is_proposed():
    """A gap that never closed, four times as loud: it closes, and is named."""
    drawn = draw_all(12, "unexercised")
    loudest = drawn.plan.drives[2]
    level = 4.0 * loudest.level / G
    words = f"{level:g} g" if loudest.kind == "sine sweep" else f"{4.0 * loudest.level:g} m/s^2"
    asked = {
        "excitation": loudest.kind,
        "level": words,
        "band_hz": [loudest.low_hz, loudest.high_hz],
    }
    first = Trial(
        12, "unexercised", 40.0, 0.01, drawn.campaign.truth,
        answer("", "cannot tell") | {"next_test": [asked]}, 1.0, 1.0,
    )  # fmt: skip
    assert next_test.open_ends([first, replace(first, problem="timeout")]) == [first]
    logs = []

    def judge(log, model, seed):
        logs.append(log.read_text())
        return answer("gap", "effect found")

    after = next_test.again(first, judge)
    assert logs[0].count("recording: Test_") == 5
    assert after.retest["settled"]
    assert json.dumps(after.as_json())
    assert exact(first)
    tied = next_test.again(first, lambda *_: answer("gap", "effect found", ["stop"]))
    assert not tied.retest["settled"]
