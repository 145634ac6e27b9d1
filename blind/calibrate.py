"""python -m blind.calibrate TRIALS.json...: probabilities from the scores of a diagnosis.

A document's `scores` are numbers by name (features). A logistic regression of "verdict, kinds
and joints exactly right" on them, with a quadratic penalty chosen by cross-validation, is

    {"schema": "shakerproc-calibration/1", "event": "...", "date": "2026-11-22",
     "seeds": [first, last], "draws": 300, "right": 0.94,
     "features": ["margin", ...], "low": [...], "high": [...], "mean": [...], "scale": [...],
     "coefficients": [...], "intercept": 2.3, "penalty": 1.0,
     "cross_validated": {"brier": ..., "log_loss": ..., "calibration_error": ..., ...}}

and read as: every feature is limited to `low` and `high` (the range of the draws), its mean is
taken off, it is divided by `scale`; a feature that a document lacks counts as its mean. The
probability is 1 / (1 + exp(-(intercept + the sum of coefficients times these))). Tuning seeds
(below 100000) are taken, and with --scored those on which a frozen commit has been scored: they
are fresh no more.
"""

import argparse
import datetime
import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy import optimize, special

from blind.campaigns import TUNING_SEEDS_END
from blind.judging import exact
from blind.score import forecasts
from blind.trial import Trial, read_trials

TARGET = Path("src/shakerproc/diagnosis/selection/calibration.json")
PENALTIES = (0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0)
"""Weights of the squared coefficients that are tried, in units of one draw's log loss."""
FOLDS = 10
BLOCK = 1000
"""Seeds at most that a frozen commit is scored on, from its first."""


@dataclass(frozen=True)
class Logistic:
    """A fitted regression: scaling of the features, coefficients, penalty."""

    low: np.ndarray
    high: np.ndarray
    mean: np.ndarray
    scale: np.ndarray
    coefficients: np.ndarray
    intercept: float
    penalty: float

    def probability(self, features: np.ndarray) -> np.ndarray:
        """Return the probability for rows of features, NaN where one is missing."""
        at = _scaled(features, self.low, self.high, self.mean, self.scale)
        out: np.ndarray = special.expit(self.intercept + at @ self.coefficients)
        return out


def _scaled(
    features: np.ndarray, low: np.ndarray, high: np.ndarray, mean: np.ndarray, scale: np.ndarray
) -> np.ndarray:
    return np.nan_to_num((np.clip(features, low, high) - mean) / scale, nan=0.0)


def table(trials: Sequence[Trial]) -> tuple[list[str], np.ndarray, np.ndarray]:
    """Return names, rows of features (NaN where missing) and outcomes.

    Raises
    ------
    ValueError
        If no document has scores.
    """
    scored = [
        t for t in trials if not t.problem and t.retest is None and t.document.get("scores")
    ]
    known: list[tuple[Mapping[str, Any], bool]] = [
        (t.document["scores"], exact(t)) for t in scored
    ]
    if not known:
        raise ValueError("no document of these trials has scores: nothing to calibrate")
    names = sorted({name for row, _ in known for name in row})
    rows = np.array([[_number(row.get(name)) for name in names] for row, _ in known])
    return names, rows, np.array([right for _, right in known], float)


def _number(value: Any) -> float:
    if value is None or not np.isfinite(float(value)):
        return float("nan")
    return float(value)


def fit(rows: np.ndarray, right: np.ndarray, penalty: float) -> Logistic:
    """Return the regression; outcomes are drawn in a little, as Platt does, so that it ends.

    References
    ----------
    .. [1] J. C. Platt, "Probabilistic outputs for support vector machines and comparisons to
       regularized likelihood methods", Advances in Large Margin Classifiers, 61-74, 1999.
    """
    low, high = np.nanmin(rows, axis=0), np.nanmax(rows, axis=0)
    mean, scale = np.nanmean(rows, axis=0), np.nanstd(rows, axis=0)
    scale = np.where(scale > 0.0, scale, 1.0)
    at = _scaled(rows, low, high, mean, scale)
    hits, fails = float(np.sum(right)), float(np.sum(1.0 - right))
    target = np.where(right > 0.5, (hits + 1.0) / (hits + 2.0), 1.0 / (fails + 2.0))

    def loss(x: np.ndarray) -> tuple[float, np.ndarray]:
        line = x[0] + at @ x[1:]
        value = np.sum(np.logaddexp(0.0, line) - target * line)
        value += 0.5 * penalty * np.sum(x[1:] ** 2)
        off = special.expit(line) - target
        slope = np.concatenate([[np.sum(off)], at.T @ off + penalty * x[1:]])
        return float(value), slope

    found = optimize.minimize(loss, np.zeros(1 + at.shape[1]), jac=True, method="L-BFGS-B")
    return Logistic(low, high, mean, scale, found.x[1:], float(found.x[0]), penalty)


def cross_validated(
    rows: np.ndarray, right: np.ndarray, penalty: float, seed: int = 0
) -> np.ndarray:
    """Return the probability of every draw by a fit that did not see it."""
    order = np.random.default_rng(seed).permutation(right.size)
    out = np.empty(right.size)
    for part in np.array_split(order, min(FOLDS, right.size)):
        rest = np.setdiff1d(order, part)
        out[part] = fit(rows[rest], right[rest], penalty).probability(rows[part])
    return out


def log_loss(probability: np.ndarray, right: np.ndarray) -> float:
    """Return the mean negative logarithm of the probability of what happened."""
    p = np.clip(probability, 1e-6, 1.0 - 1e-6)
    return float(-np.mean(right * np.log(p) + (1.0 - right) * np.log(1.0 - p)))


def chosen(rows: np.ndarray, right: np.ndarray) -> tuple[Logistic, np.ndarray]:
    """Return the fit whose penalty predicts best, and its cross-validated probabilities."""
    tried = [(cross_validated(rows, right, penalty), penalty) for penalty in PENALTIES]
    best, penalty = min(tried, key=lambda pair: log_loss(pair[0], right))
    return fit(rows, right, penalty), best


def document(trials: Sequence[Trial], date: str) -> dict[str, Any]:
    """Return the calibration as it is stored."""
    names, rows, right = table(trials)
    keep = ~np.all(np.isnan(rows), axis=0)
    names, rows = [n for n, k in zip(names, keep, strict=True) if k], rows[:, keep]
    found, probability = chosen(rows, right)
    seeds = [trial.seed for trial in trials]
    return {
        "schema": "shakerproc-calibration/1",
        "event": "verdict, kinds and joints exactly right",
        "date": date,
        "seeds": [min(seeds), max(seeds)],
        "draws": int(right.size),
        "classes": len({trial.kind for trial in trials}),
        "right": float(np.mean(right)),
        "features": names,
        "low": found.low.tolist(),
        "high": found.high.tolist(),
        "mean": found.mean.tolist(),
        "scale": found.scale.tolist(),
        "coefficients": found.coefficients.tolist(),
        "intercept": found.intercept,
        "penalty": found.penalty,
        "cross_validated": _figures(probability, right),
    }


def _figures(probability: np.ndarray, right: np.ndarray) -> dict[str, float]:
    said = forecasts.judged(probability, right)
    return {
        "log_loss": log_loss(probability, right),
        "log_loss_of_the_rate": log_loss(np.full(right.size, np.mean(right)), right),
        "brier": said["brier"],
        "calibration_error": said["calibration_error"],
        "perfect_forecaster_95": said["perfect_forecaster_95"],
    }


def is_taken(seed: int, scored: Sequence[int]) -> bool:
    """Return whether a seed may be calibrated on: one for tuning, or of a scored commit."""
    return seed < TUNING_SEEDS_END or any(first <= seed < first + BLOCK for first in scored)


def first_of_each(trials: Sequence[Trial], most: int) -> list[Trial]:
    """Return so many trials of each class at most, the first ones."""
    seen: Counter[str] = Counter()
    out = []
    for trial in trials:
        seen[trial.kind] += 1
        if seen[trial.kind] <= most:
            out.append(trial)
    return out


def main() -> None:
    """Read trials, fit, write, say how well."""
    parser = argparse.ArgumentParser(prog="python -m blind.calibrate", description=__doc__)
    parser.add_argument(
        "trials", type=Path, nargs="+", help="files of `python -m blind --json`"
    )
    parser.add_argument(
        "--scored", type=int, nargs="*", default=(), help="first seeds of scored commits"
    )
    parser.add_argument(
        "--most", type=int, help="draws of a class at most, so that classes count alike"
    )
    parser.add_argument("--out", type=Path, default=TARGET, help="where it is stored")
    options = parser.parse_args()
    trials = [trial for path in options.trials for trial in read_trials(path)]
    taken = [trial for trial in trials if is_taken(trial.seed, options.scored)]
    tuning = taken if options.most is None else first_of_each(taken, options.most)
    found = document(tuning, datetime.datetime.now(datetime.UTC).date().isoformat())
    options.out.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    print(f"{options.out}: {found['draws']} draws, {found['right']:.1%} right")
    for name, value in zip(found["features"], found["coefficients"], strict=True):
        print(f"  {name:40s} {value:+.3f}")
    for name, value in found["cross_validated"].items():
        print(f"cross-validated {name.replace('_', ' ')}: {value:.4f}")


if __name__ == "__main__":
    main()
