"""Data and model that all hypotheses about a campaign share."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from shakerproc.diagnosis.data import PreparedTest
from shakerproc.diagnosis.estimation.beginnings import as_in
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.form import forms_of
from shakerproc.diagnosis.estimation.least_squares import Fit, fit, perfect
from shakerproc.diagnosis.estimation.linear_model import LinearModel
from shakerproc.diagnosis.estimation.residual_slopes import RUNAWAY
from shakerproc.diagnosis.hypotheses.hypothesis import hypothesis_of
from shakerproc.diagnosis.hypotheses.joints import Known, identifications, joints_of, scales_of
from shakerproc.diagnosis.nudged.race import RUNS_AWAY, Raced, held, raced
from shakerproc.errors import DiagnosisError
from shakerproc.models import Model, Scale


@final
@dataclass(frozen=True, slots=True, eq=False)
class Campaign:
    """Data and model that all hypotheses share.

    Attributes
    ----------
    data : DataSet
        The tests, and the model with its further modes, as it is fitted.
    fitted : tuple of PreparedTest
        Those that may be fitted to.
    known : mapping of joint to mapping of str to Identification
        What each effect says of each joint.
    """

    data: DataSet
    fitted: tuple[PreparedTest, ...]
    known: Known


def campaign_of(
    model: Model, tests: Sequence[PreparedTest], scaled_by: Scale | None = None
) -> Campaign:
    """Return the shared data of hypotheses, from a model with further modes and the tests.

    `scaled_by` is the condition that scales every effect that may be missing.
    """
    data = DataSet(model, tuple(tests))
    motions = {joint: data.across(joint) for joint in joints_of(model)}
    return Campaign(
        data=data,
        fitted=tuple(test for test in tests if not test.arrays.hold_out),
        known={
            j: identifications(scales_of(model, tests, j, own), scaled_by)
            for j, own in motions.items()
        },
    )


ROUNDS: Final = 1
"""Steps of the model without effects on whole tests: its linear model explains them, or an
effect is missing [-]."""


def own_numbers(campaign: Campaign, linear_model: LinearModel | None = None) -> Fit:
    """Return the model's own numbers, fitted alone.

    To whole tests from its linear model where there is one; else, and where it runs away in
    them, held to the measured motion ever less.

    Raises
    ------
    DiagnosisError
        If it runs away in every test.
    """
    data = campaign.data
    none = hypothesis_of(data.model)
    x, found = np.zeros(none.size), None
    if linear_model is not None:
        x = as_in(none, linear_model.model)
        found = fit(data, none, x, forms_of(data)[-1].fitted, rounds=ROUNDS)
    found = held(data, none, x) if found is None else found
    if found is None:
        raise DiagnosisError(f"{data.model.title}: {RUNS_AWAY}")
    return found


def raced_alone(
    campaign: Campaign, linear_model: LinearModel, known: Known, say: Callable[[str], None]
) -> Raced:
    """Return the effects that last in a race on top of the linear model, of those known."""
    none = hypothesis_of(campaign.data.model)
    return raced(campaign.data, none, as_in(none, linear_model.model), known, say)


def as_it_is(original: Model, linear: Fit) -> Fit:
    """Return the fit that is none: the numbers of the model file, perfect sensors."""
    none = hypothesis_of(original)
    nothing = np.zeros(none.size)
    found = fit(linear.data, none, nothing, linear.windows, rounds=0)
    if found is not None:
        return found
    gain, delay, of_tests = perfect(linear.data)
    rows = np.full_like(linear.rows, RUNAWAY**2)
    return replace(
        linear, hypothesis=none, x=nothing, gain=gain, delay=delay, of_tests=of_tests, rows=rows
    )
