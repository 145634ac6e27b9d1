"""The calibration, on outcomes drawn from a logistic law that is known."""

import numpy as np
import pytest
from blind.trial import Trial, append_trial, read_trials, remaining_tasks
from numpy.testing import assert_allclose

from blind import calibrate

JOINT = ["base", "coupon"]


def drawn(n, rng):
    """Trials that are right with the probability 1 / (1 + exp(-1 - 2 x))."""
    effect = {"kind": "gap", "between": JOINT, "parameters": {}}
    out = []
    for seed in range(n):
        x = rng.standard_normal()
        right = rng.random() < 1.0 / (1.0 + np.exp(-1.0 - 2.0 * x))
        said = [{"kind": "gap" if right else "stop", "between": JOINT, "parameters": {}}]
        scores = {"margin": 5.0 + 3.0 * x, "nothing": rng.standard_normal()}
        document = {"verdict": "effect found", "effects": said, "scores": scores}
        truth = {"effects": [effect], "fault": None}
        out.append(Trial(seed, "gap", 40.0, 0.01, truth, document, 1.0, 1.0))
    return out


def test_the_law_that_outcomes_were_drawn_from_is_found():
    trials = drawn(3000, np.random.default_rng(4))
    found = calibrate.document(trials, "2026-11-22")
    assert found["features"] == ["margin", "nothing"]
    margin, nothing = np.array(found["coefficients"]) / np.array(found["scale"])
    assert margin == pytest.approx(2.0 / 3.0, rel=0.1)
    assert abs(nothing) < 0.15
    assert found["cross_validated"]["calibration_error"] < 0.04
    assert (
        found["cross_validated"]["log_loss"] < found["cross_validated"]["log_loss_of_the_rate"]
    )


def test_a_missing_feature_counts_as_its_mean():
    rows = np.array([[1.0, 2.0], [2.0, np.nan], [3.0, 4.0], [5.0, 1.0]])
    fitted = calibrate.fit(rows, np.array([0.0, 1.0, 1.0, 0.0]), 1.0)
    mean = np.nanmean(rows[:, 1])
    assert_allclose(
        fitted.probability(np.array([[2.0, np.nan]])),
        fitted.probability(np.array([[2.0, mean]])),
    )


def test_fresh_seeds_are_calibrated_on_only_once_they_were_scored():
    assert calibrate.is_taken(50, [])
    assert not calibrate.is_taken(520000, [])
    assert calibrate.is_taken(520007, [520000, 530000])
    assert not calibrate.is_taken(540000, [520000, 530000])


def test_classes_count_alike_where_so_many_of_each_are_taken():
    trials = drawn(5, np.random.default_rng(0))
    assert [t.seed for t in calibrate.first_of_each(trials, 2)] == [0, 1]


def test_documents_without_scores_are_told():
    with pytest.raises(ValueError, match="no document of these trials has scores"):
        calibrate.table([Trial(1, "gap", 40.0, 0.01, {}, {}, 1.0, 1.0)])


def test_records_are_read_back_without_a_line_that_was_cut(tmp_path):
    trials = drawn(3, np.random.default_rng(1))
    path = tmp_path / "trials.json"
    for trial in trials:
        append_trial(path, trial)
    assert read_trials(path) == trials
    path.write_text(path.read_text()[:-40])
    assert read_trials(path) == trials[:2]
    append_trial(path, trials[2])
    assert read_trials(path) == trials
    assert remaining_tasks([(0, "gap"), (9, "gap")], trials) == [(9, "gap")]
