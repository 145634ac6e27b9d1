"""Joints that the recordings do not tell, and what tests leave open of their motion."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from shakerproc.comparison.hidden_joints import DRAWS, HiddenJoint, hidden_joints
from shakerproc.diagnosis.estimate import Estimate
from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.fitted_numbers import numbers_of
from shakerproc.diagnosis.found import Found
from shakerproc.diagnosis.result import Finding
from shakerproc.diagnosis.updated import Comparisons, elements_of, model_with
from shakerproc.errors import SimulationError


def hidden_of(
    found: Found, fit: Fit, named: tuple[Sequence[Finding], Mapping[str, Estimate]],
    comparisons: Comparisons | None, verdict: str, *, seed: int,
) -> tuple[HiddenJoint, ...]:  # fmt: skip
    """Return motion and force of hidden joints in the loudest test, of the model proposed.

    Parameters
    ----------
    found : Found
        What the search found; its model without what was found is that of the file.
    fit : Fit
        Of the hypothesis that stands.
    named : (sequence of Finding, mapping of str to Estimate)
        Its effects, and the model's own numbers.
    comparisons : Comparisons, optional
        Models beside the tests; nothing is told without.
    verdict : str
        What is said: nothing is drawn where no model is proposed.
    seed : int
        Of the numbers that are drawn.
    """
    known = found.before.hypothesis.model
    is_proposed = comparisons is not None and verdict in {"effect found", "nothing missing"}
    if comparisons is None or not is_proposed or known.excitation.role is None:
        return ()  # a decay has no free run
    model = model_with(known, elements_of(named[0]), named[1])
    try:
        tests = comparisons.of(model).tests
    except SimulationError:
        return ()
    loudest = max(tests, key=lambda one: float(np.std(one.prediction.input)))
    if not loudest.not_told:
        return ()
    drawn = numbers_of(fit).drawn(DRAWS, np.random.default_rng(seed))
    return hidden_joints(model, [replace(one, modes=known.modes) for one, _ in drawn], loudest)
