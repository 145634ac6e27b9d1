"""Joints that the recordings do not tell, and what tests leave open of their motion."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from shakerproc.comparison.hidden_joints import DRAWS, HiddenJoint, hidden_joints
from shakerproc.diagnosis.estimate import Estimate
from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.fitted_numbers import numbers_of
from shakerproc.diagnosis.result import Finding
from shakerproc.diagnosis.updated import Comparisons, elements_of, model_with
from shakerproc.errors import SimulationError
from shakerproc.models import Model


def hidden_of(
    known: Model, fit: Fit, found: tuple[Sequence[Finding], Mapping[str, Estimate]],
    comparisons: Comparisons | None, seed: int,
) -> tuple[HiddenJoint, ...]:  # fmt: skip
    """Return motion and force of hidden joints in the loudest test, of the model proposed.

    Parameters
    ----------
    known : Model
        The model of the file.
    fit : Fit
        Of the hypothesis that stands.
    found : (sequence of Finding, mapping of str to Estimate)
        Its effects, and the model's own numbers.
    comparisons : Comparisons, optional
        Models beside the tests; nothing is told without.
    seed : int
        Of the numbers that are drawn.
    """
    if comparisons is None:
        return ()
    model = model_with(known, elements_of(found[0]), found[1])
    try:
        tests = comparisons.of(model).tests
    except SimulationError:
        return ()
    loudest = max(tests, key=lambda one: float(np.std(one.prediction.input)))
    if not loudest.not_told:
        return ()
    drawn = numbers_of(fit).drawn(DRAWS, np.random.default_rng(seed))
    return hidden_joints(model, [replace(one, modes=known.modes) for one, _ in drawn], loudest)
