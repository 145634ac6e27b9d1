"""The probability that a verdict is right: its scores, and how often such scores are right.

`python -m blind.calibrate` fits it to campaigns with a known truth and stores it beside this.
"""

import json
import math
from collections.abc import Mapping, Sequence
from functools import cache
from importlib import resources
from typing import Any, Final

import numpy as np

from shakerproc.diagnosis.found import Found
from shakerproc.diagnosis.result import Errors
from shakerproc.diagnosis.selection.choice import without_any
from shakerproc.diagnosis.selection.scores import Score, gain

STORED: Final = "calibration.json"
"""File beside this module (see `blind.calibrate` for what it holds)."""

LIMIT: Final = 50.0
"""Largest t that is told apart in the scores [-]."""


def probability_of(scores: Mapping[str, float]) -> float | None:
    """Return how probable it is that verdict, kinds and joints are exactly right [-].

    None where no calibration is stored. It was made of campaigns on a shaker, not of component
    tests.

    Parameters
    ----------
    scores : mapping of str to float
        See `scores_of`; one that is missing counts as its mean over the calibration.
    """
    known = _calibration()
    if known is None:
        return None
    line = float(known["intercept"])
    columns = ("features", "low", "high", "mean", "scale", "coefficients")
    for name, low, high, mean, scale, slope in zip(*(known[c] for c in columns), strict=True):
        value = scores.get(name, mean)
        kept = min(max(value if math.isfinite(value) else mean, low), high)
        line += slope * (kept - mean) / scale
    return 1.0 / (1.0 + math.exp(-line))


@cache
def _calibration() -> dict[str, Any] | None:
    """Return the stored calibration; None where nothing is stored."""
    place = resources.files(__package__).joinpath(STORED)
    return json.loads(place.read_text(encoding="utf-8")) if place.is_file() else None


def scores_of(found: Found, standing: Sequence[Score], errors: Errors) -> dict[str, float]:
    """Return the numbers that the probability is made of, by name [-].

    Parameters
    ----------
    found : Found
        All hypotheses, scored.
    standing : sequence of Score
        Those that predict best, the chosen one first; none where nothing stands.
    errors : Errors
        Of the chosen one.
    """
    best, bare = found.best, without_any(found, found.best)
    rest = [s for s in found.effects if s not in standing]
    nearest = min([gain(best, s).t for s in rest], default=LIMIT)
    nameless = gain(found.free, best) if found.free is not None else None
    left, floor = (
        max(errors.held_out.after, 1e-9),
        max(float(np.nan_to_num(errors.noise_floor)), 1e-9),
    )
    return {
        "gain_over_linear": gain(best, bare).mean,
        "t_over_linear": float(np.clip(gain(best, bare).t, -LIMIT, LIMIT)),
        "t_over_next": float(np.clip(nearest, -LIMIT, LIMIT)),
        "nameless_over_best": nameless.mean if nameless else 0.0,
        "t_nameless": float(np.clip(nameless.t, -LIMIT, LIMIT)) if nameless else -LIMIT,
        "alike": float(len(standing)),
        "excess": float(np.log(left / floor)),
        "left": float(np.log(left / max(errors.held_out.before, 1e-9))),
    }
