"""Response of a model to noise of its input: small, but where trajectories diverge."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.comparison.prediction import DRAWS
from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.hidden_motion import completed
from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.estimation.parts import Windows
from shakerproc.diagnosis.estimation.residuals import Predicted, predict
from shakerproc.diagnosis.estimation.run_in import with_starts_fitted
from shakerproc.errors import ModelError
from shakerproc.simulation import has_jumps

FEW: Final = 4
"""Draws that tell how far noise carries a motion: their mean square over all windows is known
to a few per cent [-]."""

NEARBY: Final = 1e-3
"""Change of a coordinate within which a residual has to follow its slope, as no model is held
to less (see `MODEL_SHARE`) [-]."""

DIRECTIONS: Final = 2
"""Directions of all numbers in which that is tried: their mean square over many samples [-]."""


FOLDED: Final = 0.25
"""Share of what folds back of jumps that is left of it: up to a quarter, as was measured beside
the recorders of `blind` [-]."""


def prediction_of(
    data: DataSet, found: Fit, windows: Windows, *, plain: bool = False
) -> Predicted | None:
    """Return the prediction of a fit in windows, from its starts there; None without one.

    With `plain`, means keep what folds back of jumps.
    """
    try:
        model = found.hypothesis.model_at(found.x)
        return predict(data, model, windows, found.starts, found.of_tests, plain=plain)
    except ModelError:
        return None


def under_noise(
    data: DataSet,
    found: Fit,
    windows: Windows,
    *,
    n_draws: int = DRAWS,
    starts: bool = False,
) -> Iterator[Predicted]:
    """Yield predictions with as much noise again, drawn afresh each time.

    Parameters
    ----------
    data, found, windows
        As for `prediction_of`; the starts of the fit are those of these windows.
    n_draws : int
        How many, `DRAWS` at most.
    starts : bool
        Whether what noise of the responses makes of the starts of windows counts too.
    """
    for shaken in data.shaken[:n_draws]:
        settled = found
        if starts and windows.run_in is not None:
            settled = with_starts_fitted(shaken, found, windows, near=found.starts) or found
        noisy = prediction_of(shaken, settled, windows)
        if noisy is not None:
            yield noisy


def with_passed_noise(data: DataSet, found: Fit, windows: Windows) -> Windows:
    """Return windows that know where the motion of a fit cannot be predicted.

    Two motions of a contact that is just missed part. There a residual tells little of a
    hypothesis, and its slopes hold for next to no change of the numbers. So what noise of the
    input becomes in each window counts as noise there, and so does what the residual departs
    from its slopes for a small change of each number, and what folds back of jumps.

    Parameters
    ----------
    data : DataSet
        The tests.
    found : Fit
        Whose model it is.
    windows : Windows
        Those that are to be fitted or scored.
    """
    settled = with_starts_fitted(data, found, windows)
    if settled is None:
        return windows
    if windows.run_in is None and not windows.from_rest:
        model = found.hypothesis.model_at(found.x)
        settled = replace(
            settled, starts=completed(data, model, windows.table, settled.of_tests)
        )
    still = prediction_of(data, settled, windows)
    few = under_noise(data, settled, windows, n_draws=FEW)
    noisy = list(few) if still is not None else []
    if still is None or not noisy:
        return windows
    passed = []
    bent = _bent(data, settled, windows, still)
    folded = _folded(data, settled, windows, still)
    for i, outputs in enumerate(still.outputs):
        test = int(windows.table[i, 0])
        squares = np.mean([(one.outputs[i] - outputs) ** 2 for one in noisy], axis=0)
        passed.append(_envelope(data, test, squares + bent[i] + folded[i]))
    return replace(windows, passed=tuple(passed))


def with_open_numbers(data: DataSet, found: Fit, windows: Windows) -> Windows:
    """Return held-out windows that know how open the numbers of a fit are.

    What a standard error along each axis of their covariance makes of the motion there counts
    as noise: two laws that explain a few periods alike predict the rest by chance. Not of a law
    that is off: what it leaves of its own tests is no scatter of its numbers.

    Parameters
    ----------
    data, found, windows
        As for `with_passed_noise`, which comes before.
    """
    settled = with_starts_fitted(data, found, windows) if found.follows_most else None
    still = None if settled is None else prediction_of(data, settled, windows)
    if settled is None or still is None or windows.passed is None:
        return windows
    apart = (replace(settled, x=x) for x in found.numbers_apart())
    each = [prediction_of(data, one, windows) for one in apart]
    moved = [one for one in each if one is not None]
    if not moved:
        return windows
    passed = []
    for i, (outputs, own) in enumerate(zip(still.outputs, windows.passed, strict=True)):
        squares = np.sum([(one.outputs[i] - outputs) ** 2 for one in moved], axis=0)
        passed.append(np.hypot(own, _envelope(data, int(windows.table[i, 0]), squares)))
    return replace(windows, passed=tuple(passed))


def _bent(data: DataSet, found: Fit, windows: Windows, still: Predicted) -> list[FloatArray]:
    """Return the squares of what outputs depart from their slopes, in every window.

    All numbers change at once, up or down by chance: each departure of one shows on average,
    whatever their number.
    """
    bent = [np.zeros_like(outputs) for outputs in still.outputs]
    signs = np.random.default_rng(0).choice((-1.0, 1.0), (DIRECTIONS, found.x.size))
    for change in NEARBY * signs:
        both = [
            prediction_of(data, replace(found, x=found.x + sign * change), windows)
            for sign in (1.0, -1.0)
        ]
        if both[0] is not None and both[1] is not None:
            for i, outputs in enumerate(still.outputs):
                apart = 0.5 * (both[0].outputs[i] + both[1].outputs[i]) - outputs
                bent[i] += apart**2 / DIRECTIONS
    return bent


def _folded(data: DataSet, found: Fit, windows: Windows, still: Predicted) -> list[FloatArray]:
    """Return the squares of what may be left of what folds back of jumps, in every window."""
    folds = not data.points and has_jumps(found.hypothesis.model_at(found.x))
    kept = prediction_of(data, found, windows, plain=True) if folds else None
    if kept is None:
        return [np.zeros_like(outputs) for outputs in still.outputs]
    return [
        (FOLDED * (one - other)) ** 2
        for one, other in zip(kept.outputs, still.outputs, strict=True)
    ]


def _envelope(data: DataSet, test: int, squares: FloatArray) -> FloatArray:
    """Return the root of squares, evened out over a block of a test in time."""
    length = max(1, round(data.lengths.block_s * data.tests[test].sample_rate))
    even = scipy.ndimage.uniform_filter1d(squares, length, axis=1, mode="nearest")
    return np.asarray(np.sqrt(np.maximum(even, 0.0)))
