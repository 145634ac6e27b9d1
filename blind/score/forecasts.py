"""Whether `confidence` is the probability that it says it is.

An outcome is right where verdict, kinds and joints are exactly right. The calibration error is
the mean, over ten bins of equally many trials in order of confidence, of the distance between
mean confidence and share of right ones, weighted by the trials of a bin. A perfect one is
simulated: outcomes are drawn with the confidences given, and the 95th percentile of its
calibration error is what the measured one is to stay below.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from blind.judging import exact
from blind.score.bounds import clopper_pearson
from blind.trial import Trial

BINS, SIMULATED = 10, 4000
"""Bins of a reliability diagram, and simulated sets of outcomes."""
SURE, SURE_AND_RIGHT = 0.9, 0.93
"""Of those with at least this confidence, this share is to be right [-]."""


def pairs(trials: Sequence[Trial]) -> tuple[np.ndarray, np.ndarray]:
    """Return confidence and outcome of the trials whose document says a confidence."""
    said = [t for t in trials if not t.problem and t.document.get("confidence") is not None]
    confidence = np.array([float(t.document["confidence"]) for t in said])
    return confidence, np.array([exact(t) for t in said], float)


def calibration_error(confidence: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Return the calibration error; outcomes are (..., n_trials), in order of confidence."""
    parts = np.array_split(np.arange(confidence.size), min(BINS, confidence.size))
    gaps = [
        part.size * np.abs(np.mean(right[..., part], axis=-1) - np.mean(confidence[part]))
        for part in parts
    ]
    total: np.ndarray = np.sum(gaps, axis=0) / confidence.size
    return total


def reliability(confidence: np.ndarray, right: np.ndarray) -> list[dict[str, Any]]:
    """Return the reliability diagram: a bin of equally many trials a line."""
    order = np.argsort(confidence, kind="stable")
    out = []
    for part in np.array_split(order, min(BINS, order.size)):
        successes = int(np.sum(right[part]))
        low, high = clopper_pearson(successes, part.size)
        out.append({
            "trials": int(part.size),
            "confidence": float(np.mean(confidence[part])),
            "right": successes / part.size,
            "low": low,
            "high": high,
        })
    return out


def judged(confidence: np.ndarray, right: np.ndarray, seed: int = 0) -> dict[str, Any]:
    """Return every figure of a set of forecasts with their outcomes."""
    order = np.argsort(confidence, kind="stable")
    confidence, right = confidence[order], right[order]
    rng = np.random.default_rng(seed)
    perfect = (rng.random((SIMULATED, confidence.size)) < confidence).astype(float)
    limit = float(np.quantile(calibration_error(confidence, perfect), 0.95))
    error = float(calibration_error(confidence, right))
    sure = confidence >= SURE
    successes, count = int(np.sum(right[sure])), int(np.sum(sure))
    low, high = clopper_pearson(successes, count) if count else (0.0, 1.0)
    return {
        "trials": int(confidence.size),
        "sure": {"right": successes, "trials": count, "low": low, "high": high,
                 "met": high >= SURE_AND_RIGHT},
        "calibration_error": error,
        "perfect_forecaster_95": limit,
        "met": error <= limit,
        "brier": float(np.mean((confidence - right) ** 2)),
        "reliability": reliability(confidence, right),
    }  # fmt: skip


def figures(trials: Sequence[Trial]) -> dict[str, Any]:
    """Return every figure of the forecast; empty where no document says a confidence."""
    confidence, right = pairs(trials)
    return judged(confidence, right) if confidence.size else {}


def text(trials: Sequence[Trial]) -> str:
    """Return the figures as text."""
    found = figures(trials)
    if not found:
        return "confidence: no document says one"
    sure = found["sure"]
    share = sure["right"] / sure["trials"] if sure["trials"] else float("nan")
    lines = [
        f"confidence at {SURE} and more: right {sure['right']}/{sure['trials']} = {share:.1%}"
        f" ({sure['low']:.1%}-{sure['high']:.1%}), goal {SURE_AND_RIGHT:.0%}",
        f"calibration error {found['calibration_error']:.4f}, 95th percentile of a perfect"
        f" forecaster {found['perfect_forecaster_95']:.4f}: "
        + ("met" if found["met"] else "NOT MET"),
        f"Brier score {found['brier']:.4f}",
        "reliability: trials, mean confidence, share right, 95 % bounds",
    ]
    lines += [
        f"  {b['trials']:4d} {b['confidence']:.3f} {b['right']:.3f}"
        f" {b['low']:.3f}-{b['high']:.3f}"
        for b in found["reliability"]
    ]
    return "\n".join(lines)
