"""Component tests: the motion is imposed, so that every law's force along it is known.

There is no motion to predict, so that whole tests are the only form, every nudging rate is the
same and no window needs a start.
"""

from collections.abc import Callable, Sequence
from typing import Final

import numpy as np

from shakerproc.comparison.free_run_error import in_band
from shakerproc.data import FloatArray
from shakerproc.diagnosis.campaign import Campaign
from shakerproc.diagnosis.estimation.beginnings import own_start
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.form import Form
from shakerproc.diagnosis.estimation.least_squares import Fit, fit
from shakerproc.diagnosis.estimation.levels import level_at
from shakerproc.diagnosis.estimation.windows import whole_tests
from shakerproc.diagnosis.hypotheses.hypothesis import hypothesis_of
from shakerproc.diagnosis.hypotheses.joints import joints_of, linear_parts
from shakerproc.diagnosis.nudged.ladder import Rung
from shakerproc.diagnosis.nudged.race import Raced, race

ROUNDS: Final = 25
"""Steps of a fit: ten are too few for a slider behind a spring, 25 enough (IDENTIFICATION.md)
[-]."""

SAMPLES: Final = 20000
"""Samples that the regression looks at of each test: more tell a start no better [-]."""


def form_of(data: DataSet) -> Form:
    """Return whole tests, what is fitted to and what is held out."""
    fitted = whole_tests(data, held_out=False)
    return Form(None, fitted, fitted, whole_tests(data, held_out=True))


def raced(campaign: Campaign, form: Form, linear: Fit, say: Callable[[str], None]) -> Raced:
    """Return the effects that explain the force best, fitted to whole tests."""
    return race(linear, campaign.known, (Rung(0.0, form.fitted, ROUNDS),), say)


def linear_fit(data: DataSet, form: Form) -> Fit | None:
    """Return the model's own numbers, fitted alone; None where nothing can be simulated.

    From those of the file or from a regression, whichever leave less: the slope along the
    logarithm of a damping that is far too small is next to nothing.
    """
    none = hypothesis_of(data.model)
    tried = np.zeros(none.size), own_start(none, *_linear_start(data))
    x = min(tried, key=lambda one: level_at(data, none, one, form.fitted))
    return fit(data, none, x, form.fitted, rounds=ROUNDS)


def _linear_start(data: DataSet) -> tuple[FloatArray, FloatArray]:
    """Return changes of stiffness and damping of every joint by a regression of the force."""
    chosen, joints = _fitted(data), joints_of(data.model)
    motions = [data.across(joint) for joint in joints]
    rows = [
        _column(data, chosen, [getattr(own[i], name) for i in chosen])
        for name in ("displacement", "velocity")
        for own in motions
    ]
    found, *_ = np.linalg.lstsq(np.array(rows).T, _force(data, chosen), rcond=None)
    sizes = np.array([linear_parts(data.model, joint) for joint in joints]).T.ravel()
    known = (sizes > 0.0) & (found > 0.0)
    changes = np.where(known, found / np.where(known, sizes, 1.0) - 1.0, 0.0)
    stiffness, damping = np.split(changes, 2)
    return stiffness, damping


def _fitted(data: DataSet) -> list[int]:
    """Return which tests may be fitted to."""
    return [i for i, test in enumerate(data.tests) if not test.arrays.hold_out]


def _force(data: DataSet, chosen: Sequence[int]) -> FloatArray:
    """Return the measured force of several tests as one [N]."""
    return _column(data, chosen, [data.tests[i].responses.sum(axis=0) for i in chosen])


def _column(data: DataSet, chosen: Sequence[int], rows: Sequence[FloatArray]) -> FloatArray:
    """Return rows of several tests as one, within the compared band of each."""
    parts = []
    for i, row in zip(chosen, rows, strict=True):
        test = data.tests[i]
        part = slice(test.start, min(test.stop, test.start + SAMPLES))
        parts.append(in_band(np.nan_to_num(row), test.sample_rate, test.band)[part])
    return np.concatenate(parts)
