"""The last step of the ladder: what was told before a test was run, and what came."""

import numpy as np
import pytest

from shakerproc.forecasts.model_error import LevelError, last_step
from shakerproc.forecasts.quantities import Quantity

RMS = Quantity("response", "ch3", "rms", "m/s^2")
PEAK = Quantity("response", "ch3", "peak", "m/s^2")


def missed(test, quantity, predicted, measured, distance):
    error = np.array([20.0 * np.log10(predicted / measured)])
    return LevelError(test, quantity, measured, distance, error, error)


ERRORS = [
    missed("1", RMS, 1.0, 1.0, 0.0),
    missed("2", RMS, 2.0, 2.0, 6.0),
    missed("3", RMS, 4.4, 4.0, 6.0),
    missed("3", PEAK, 12.0, 16.0, 6.0),
]
BEFORE = {
    "tests": [
        {"id": 3, "responses": {"ch3": {"rms": {"value": 4.1, "low": 3.9, "high": 4.3},
                                        "peak": {"value": 13.0, "low": 12.0, "high": 14.0}}}}
    ]
}  # fmt: skip


def test_without_an_earlier_forecast_the_step_is_predicted_from_the_levels_below():
    step = last_step(ERRORS, None)
    assert (step.test, step.told_before) == ("3", False)
    assert [(v.predicted, v.measured, v.held) for v in step.values] == [
        (pytest.approx(4.4), 4.0, None), (pytest.approx(12.0), 16.0, None),
    ]  # fmt: skip
    assert "missed by 2.5 dB at most (ch3)" in step.sentence  # 20 lg(16 / 12)


def test_what_was_told_before_a_test_was_run_is_held_against_what_came():
    step = last_step(ERRORS, BEFORE)
    assert step.told_before
    assert [(v.predicted, v.low, v.held) for v in step.values] == [
        (4.1, 3.9, True), (13.0, 12.0, False),
    ]  # fmt: skip
    assert "1 of 2 values lie in their 90 % bands" in step.sentence


def test_what_was_told_before_is_kept_by_the_next_document():
    rows = [
        {"response": v.response, "what": v.what, "predicted": v.predicted, "low": v.low,
         "high": v.high}
        for v in last_step(ERRORS, BEFORE).values
    ]  # fmt: skip
    later = {"tests": [], "last_step": {"test": "3", "told_before": True, "values": rows}}
    assert last_step(ERRORS, later) == last_step(ERRORS, BEFORE)


def test_a_forecast_of_another_test_is_none_of_this_one():
    other = {"tests": [{**BEFORE["tests"][0], "id": 7}]}
    assert last_step(ERRORS, other) == last_step(ERRORS, None)
    assert last_step(ERRORS[:1], BEFORE) is None


@pytest.mark.parametrize(
    "tests", [[{"id": 3}], [3], [{"id": 3, "responses": {"ch3": {"rms": 1}}}]]
)
def test_a_document_that_was_changed_by_hand_told_nothing(tests):
    assert last_step(ERRORS, {"tests": tests}) == last_step(ERRORS, None)
