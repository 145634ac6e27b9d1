"""The line of numbers that a verdict opens with."""

import re
from dataclasses import replace

import pytest

from shakerproc.diagnosis.estimate import Estimate
from shakerproc.diagnosis.headline import headline, probability_text
from shakerproc.diagnosis.result import BeforeAfter, Diagnosis, Errors, Finding, Where
from shakerproc.diagnosis.wording import found_sentence, more_sentence
from shakerproc.testlog import Test

ERRORS = Errors(BeforeAfter(0.8, 0.01), BeforeAfter(0.9, 0.011), 0.01)
GAP = Finding(
    "gap",
    ("base", "coupon"),
    {
        "stiffness": Estimate(5e4, 4.9e4, 5.1e4, "N/m"),
        "clearance": Estimate(5e-5, 4.9e-5, 5.1e-5, "m"),
    },
)
FOUND = Diagnosis("effect found", "", (GAP,), (), ERRORS, (), Where(), (), confidence=0.968)


@pytest.mark.parametrize(("per_side", "total"), [(5e-5, "0.100"), (1.25e-4, "0.250")])
def test_a_clearance_stands_per_side_and_in_total_beside_that_of_the_log(per_side, total):
    gap = replace(GAP, parameters={"clearance": Estimate(per_side, 1e-5, 1e-3, "m")})
    told = headline(replace(FOUND, effects=(gap,)), [Test(id=1, clearance=1e-4), Test(id=2)])
    side = float(re.search(r"clearance ([\d.]+) mm", told)[1])
    assert side == pytest.approx(1e3 * per_side, rel=5e-3)
    assert f"(per side, {total} mm in total; the log says 0.10 mm)" in told


def test_kind_joint_numbers_and_probability_are_in_one_line():
    told = headline(FOUND, [])
    assert told == (
        "gap between base and coupon: clearance 0.0500 mm (per side, 0.100 mm in total), "
        "stiffness 50000 N/m; probability 0.97."
    )


def test_what_tests_and_calibration_leave_open_stands_beside_a_number_and_what_no_test_tells():
    numbers = {
        "clearance": Estimate(5e-5, 4.9e-5, 5.1e-5, "m", 0.003, 0.01),
        "stiffness": Estimate(5e4, 4.9e4, 5.1e4, "N/m", 0.012, 2e-6),  # no length in its unit
        "exponent": Estimate(2.0, None, None, "1"),
        "force": Estimate(3.0, 2.0, None, "N"),
    }
    assert headline(replace(FOUND, effects=(replace(GAP, parameters=numbers),)), []) == (
        "gap between base and coupon: clearance 0.0500 mm +- 0.3 % by these tests, +- 1 % by "
        "calibration (per side, 0.100 mm in total), stiffness 50000 N/m +- 1.2 % by these "
        "tests, exponent 2, which no test tells, force 3 N, without upper bound; probability "
        "0.97."
    )


@pytest.mark.parametrize(
    ("left", "floor", "words"),
    [
        (0.3, 0.01, "more is missing than the library explains"),
        (0.009, 0.001, "more than noise is left"),
        (0.3, float("nan"), "the noise is not known"),
    ],
)
def test_why_there_is_no_probability_is_said_in_few_words(left, floor, words):
    errors = Errors(BeforeAfter(0.9, left), BeforeAfter(0.9, left), floor)
    open_one = replace(FOUND, errors=errors, complete=False, confidence=None)
    assert probability_text(open_one) == f"no probability: {words}"
    noise = Errors(BeforeAfter(0.9, 0.01), BeforeAfter(0.9, 0.01), 0.01)
    of_component_test = replace(open_one, errors=noise, complete=True)
    assert probability_text(of_component_test) == ""
    assert probability_text(FOUND) == "exactly right with a probability of 97 %"


def test_a_stop_has_one_side_and_a_fault_no_joint():
    side = Estimate("positive", None, None, "")
    numbers = {"clearance": Estimate(3e-5, 2e-5, 4e-5, "m"), "side": side}
    stop = Finding("stop", ("base", "tip"), numbers)
    fault = Finding("sensor_polarity", ("ch3",), {})
    told = headline(replace(FOUND, effects=(stop, fault), confidence=None), [])
    assert told == (
        "stop between base and tip: clearance 0.0300 mm, side positive; sensor polarity of ch3."
    )
    assert headline(replace(FOUND, effects=()), []) == ""


@pytest.mark.parametrize(("after", "said"), [(0.05, "to 0.05"), (0.09, "not in free runs")])
def test_an_error_that_rises_in_free_runs_is_not_said_to_fall(after, said):
    judged = Errors(BeforeAfter(0.08, 0.04), BeforeAfter(0.08, 0.04), 0.01, {"1": 0.8})
    errors = Errors(
        BeforeAfter(0.08, after), BeforeAfter(0.08, after), 0.01, {"1": None}, None, judged
    )
    sentence = found_sentence([Finding("gap", ("base", "mass"), {})], (), errors, ())
    assert said in sentence
    assert ("falls from" in sentence) == (after < 0.08)
    left = more_sentence(errors, Where(), "translation")
    assert left.startswith("Judged 0.8 s ahead: more is missing: 0.04 is left")
