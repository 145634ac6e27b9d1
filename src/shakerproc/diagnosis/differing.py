"""Differences between tests: their conditions, and numbers of the linear model of each."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import compress
from typing import Final

import numpy as np

from shakerproc.diagnosis.campaign import Campaign
from shakerproc.diagnosis.data import PreparedTest
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.form import ROUNDS, Form, carried
from shakerproc.diagnosis.estimation.least_squares import Fit, fit
from shakerproc.diagnosis.estimation.linear import LINEAR_ENOUGH, UNUSUAL
from shakerproc.diagnosis.estimation.of_tests import STIFFNESS_SPREAD, drift_of
from shakerproc.diagnosis.horizon import bare_and_effects, scored_at, scores_beside
from shakerproc.diagnosis.outcome import Outcome
from shakerproc.diagnosis.selection.errors import error_of, takes_most
from shakerproc.diagnosis.selection.scores import (
    MOSTLY_NOISE,
    SURE,
    as_fitted,
    best_of,
    gain,
    is_better,
    ranked,
)
from shakerproc.errors import ModelError
from shakerproc.models import Scale
from shakerproc.units import any_quantity

FIRST_ROUNDS: Final = 2
"""Steps after which a model that needs nothing but what tests have of their own is near the
truth: it is next to linear in that [-]."""

NEAR: Final = 0.5
"""Level (see `Fit`) over that with tests that are alike up to which it is near, or one of next
to noise [-]."""


def alone(campaign: Campaign, linear: Fit, form: Form) -> tuple[Campaign, bool]:
    """Return the campaign, and whether its model leaves no more than noise without any effect.

    Tests differ from then on where that is surely better, and leaves noise: what every joint
    and every table does is no finding. Noise that may hold what an effect makes of the motion
    explains nothing before effects were tried.

    Parameters
    ----------
    campaign : Campaign
        The tests.
    linear : Fit
        The model without any effect, on shorter windows.
    form : Form
        In which that is asked.
    """
    there = carried(campaign.data, linear, [form])
    if there is not None:  # noise of the input is noise, too
        there = carried(campaign.data, there, [form.knowing(campaign.data, there)], rounds=0)
    score = None if there is None else as_fitted(campaign.data, there)
    if there is None or score is None:
        return campaign, False
    differing = replace(campaign, data=campaign.data.as_differing())
    found = _fitted(differing.data, there)
    own = None if found is None else as_fitted(differing.data, found)
    if own is not None and own.is_noise and is_better(own, score):
        return differing, True
    beside = any(test.noise_density.may_be_motion for test in campaign.data.tests)
    return campaign, score.is_noise and not beside


def scales_between(tests: Sequence[PreparedTest]) -> tuple[Scale, ...]:
    """Return the conditions in which tests that are fitted differ, each at its largest.

    An effect that is missing may be scaled by one that every test says and that is never below
    0.
    """
    fitted = [not test.arrays.hold_out for test in tests]
    said = [test.conditions.values for test in compress(tests, fitted)]
    found = []
    for name in dict.fromkeys(name for values in said for name in values):
        largest = max((own[name] for own in said if name in own), key=_size)
        try:
            scale = Scale(name, largest)
            shares = np.array([scale.share(test.conditions) for test in tests])
        except (ModelError, ValueError):  # not said, below 0 or of another unit in a test
            continue
        if np.ptp(shares[fitted]) > 0.0:
            found.append(scale)
    return tuple(found)


def _size(said: str) -> float:
    """Return a condition [SI]."""
    return any_quantity(said)[0]


def _fitted(data: DataSet, there: Fit) -> Fit | None:
    """Return a fit with what tests have of their own; None if that does not bring it near."""
    here, near = there, max(NEAR * there.level, MOSTLY_NOISE)
    for rounds in (FIRST_ROUNDS, ROUNDS):
        found = fit(
            data, here.hypothesis, here.x, here.windows, rounds=rounds,
            channels=here.channels, starts=here.starts,
        )  # fmt: skip
        if found is None or found.level > near or _drifts_far(found):
            return None
        here = found
    return here


def where_tests_differ(
    outcome: Outcome, say: Callable[[str], None], *, explained: bool
) -> Outcome | None:
    """Return the error of the hypotheses if each test has numbers of its own.

    None where the best of them leaves so much that something larger is missing, does not surely
    predict better then, and take most of what is left, or only if springs change by more than
    they do by themselves. What is explained is asked only where the table rocks: what controls
    disagree by counts as noise, until it is fitted.
    """
    if outcome.campaign.data.differing:
        return None
    campaign = replace(outcome.campaign, data=outcome.campaign.data.as_differing())
    if explained and not len(campaign.data.sways.spread):
        return None
    best, form = best_of([outcome.linear, *outcome.effects]), outcome.forms[-1]
    if error_of(outcome.campaign.data, best.fit, form.held_out) > LINEAR_ENOUGH:
        return None
    there = carried(campaign.data, best.fit, [form])
    scores = scored_at(campaign, [there], form)
    if not scores or gain(scores[0], best).t <= SURE or _drifts_far(scores[0].fit):
        return None
    if not takes_most(best.fit, scores[0].fit, form.held_out):
        return None
    say("what each test has of its own")
    fits = [score.fit for score in (outcome.linear, *outcome.effects)]
    linear, effects = bare_and_effects(
        outcome.linear.fit, scores_beside(campaign, best.fit, there, fits, form)
    )
    return replace(outcome, campaign=campaign, linear=linear, effects=ranked(effects))


def _drifts_far(found: Fit) -> bool:
    """Return whether springs change by more than their prior expects."""
    drift = drift_of(found.data, found.of_tests)
    return bool(np.any(np.abs(drift) > UNUSUAL * STIFFNESS_SPREAD))
