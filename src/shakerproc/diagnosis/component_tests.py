"""Component tests: the motion is imposed, so that every law's force along it is known.

Where to start is told by a regression of the measured force on each law's; there is no motion
to predict, so that whole tests are the only form and no window needs a start.
"""

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from shakerproc.comparison.free_run_error import in_band
from shakerproc.data import FloatArray
from shakerproc.diagnosis.campaign import Campaign
from shakerproc.diagnosis.data import models_of
from shakerproc.diagnosis.estimation.beginnings import own_start
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.form import Form
from shakerproc.diagnosis.estimation.growth import Stages
from shakerproc.diagnosis.estimation.least_squares import Fit, fit
from shakerproc.diagnosis.estimation.levels import level_at
from shakerproc.diagnosis.estimation.windows import whole_tests
from shakerproc.diagnosis.hypotheses.hypothesis import hypothesis_of
from shakerproc.diagnosis.hypotheses.joints import Joint, joints_of
from shakerproc.diagnosis.screening import Start
from shakerproc.diagnosis.screening.laws import Law, laws_of
from shakerproc.diagnosis.screening.shared import linear_parts
from shakerproc.models.conditions import share_of
from shakerproc.models.identification import Identification

ROUNDS: Final = 25
"""Steps of a fit: ten are too few for a slider behind a spring, 25 enough (IDENTIFICATION.md)
[-]."""

SAMPLES: Final = 20000
"""Samples that the regression looks at of each test: more tell a start no better [-]."""


def form_of(data: DataSet) -> Form:
    """Return whole tests, what is fitted to and what is held out."""
    fitted = whole_tests(data, held_out=False)
    return Form(None, fitted, fitted, whole_tests(data, held_out=True))


def stages_of(form: Form) -> Stages:
    """Return the stages of a search: whole tests, roughly and to the end."""
    return Stages((form.fitted, form.fitted), (ROUNDS, ROUNDS))


def linear_fit(data: DataSet, form: Form) -> Fit | None:
    """Return the model's own numbers, fitted alone; None where nothing can be simulated.

    From those of the file or from a regression, whichever leave less: the slope along the
    logarithm of a damping that is far too small is next to nothing.
    """
    none = hypothesis_of(data.model)
    tried = np.zeros(none.size), own_start(none, _linear_start(data))
    x = min(tried, key=lambda one: level_at(data, none, one, form.fitted))
    return fit(data, none, x, form.fitted, rounds=ROUNDS)


def _linear_start(data: DataSet) -> Start:
    """Return stiffness and damping of every joint by a regression of the force."""
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
    return Start(
        "", joints[0], {}, tuple(stiffness), tuple(damping), 0.0, predicted=0.0, t=0.0, left=1.0
    )


def starts_of(
    campaign: Campaign, sought: Mapping[Joint, Mapping[str, Identification]]
) -> list[Start]:
    """Return starts of effects in joints, those first whose force explains the measured best.

    Parameters
    ----------
    campaign : Campaign
        The tests.
    sought : mapping of joint to mapping of str to Identification
        Every effect that may be missing there.
    """
    found = []
    for joint, known in sought.items():
        laws = laws_of(campaign.data.model, joint, known)
        if laws:
            found += _regressed(campaign.data, joint, laws)
    return sorted(found, key=lambda start: -start.explained)


def _regressed(data: DataSet, joint: Joint, laws: Sequence[Law]) -> list[Start]:
    """Return a start for every law: its amplitude, with what of spring and damper goes with it.

    Laws whose force would have to turn round are left out.
    """
    chosen = _fitted(data)
    models = models_of(data.model, data.tests)
    motions = data.across(joint)
    force = _force(data, chosen)
    linear = np.array([
        _column(data, chosen, [getattr(motions[i], name) for i in chosen])
        for name in ("displacement", "velocity")
    ])
    known = [
        np.array(linear_parts(models[i], joint))
        @ np.array([motions[i].displacement, motions[i].velocity])
        for i in chosen
    ]
    own = force - _column(data, chosen, known)
    whole = _left(own, linear)
    out = []
    for law in laws:
        rows = [
            share_of(law.identification.scaled_by, data.tests[i].conditions)
            * law.effect.force_along(
                motions[i].displacement, motions[i].velocity, data.tests[i].sample_rate
            )
            for i in chosen
        ]
        column = _column(data, chosen, rows)
        found, *_ = np.linalg.lstsq(np.vstack([column, linear]).T, own, rcond=None)
        amplitude = float(found[0])
        if law.one_sign and amplitude <= 0.0:
            continue
        left = float(np.sum((own - found @ np.vstack([column, linear])) ** 2))
        out.append(_start(data, law, found, 1.0 - left / whole))
    return out


def _start(data: DataSet, law: Law, amplitudes: FloatArray, explained: float) -> Start:
    """Return the start that the amplitudes of a law, a spring and a damper mean."""
    joints = joints_of(data.model)
    changes = []
    for k, more in enumerate(amplitudes[1:]):
        own = [linear_parts(data.model, joint)[k] for joint in joints]
        changes.append(
            tuple(
                float(more) / size if joint == law.between and size > 0.0 else 0.0
                for joint, size in zip(joints, own, strict=True)
            )
        )
    return Start(
        law.kind, law.between, law.scaled(float(amplitudes[0])), changes[0], changes[1],
        explained, predicted=explained, t=np.inf, left=1.0 - explained,
    )  # fmt: skip


def _fitted(data: DataSet) -> list[int]:
    """Return which tests may be fitted to."""
    return [i for i, test in enumerate(data.tests) if not test.arrays.hold_out]


def _force(data: DataSet, chosen: Sequence[int]) -> FloatArray:
    """Return the measured force of several tests as one [N]."""
    return _column(data, chosen, [data.tests[i].responses.sum(axis=0) for i in chosen])


def _left(rows: FloatArray, linear: FloatArray) -> float:
    """Return the square of what spring and damper alone leave of a force."""
    found, *_ = np.linalg.lstsq(linear.T, rows, rcond=None)
    return max(float(np.sum((rows - found @ linear) ** 2)), 1e-300)


def _column(data: DataSet, chosen: Sequence[int], rows: Sequence[FloatArray]) -> FloatArray:
    """Return rows of several tests as one, within the compared band of each."""
    parts = []
    for i, row in zip(chosen, rows, strict=True):
        test = data.tests[i]
        part = slice(test.start, min(test.stop, test.start + SAMPLES))
        parts.append(in_band(np.nan_to_num(row), test.sample_rate, test.band)[part])
    return np.concatenate(parts)
