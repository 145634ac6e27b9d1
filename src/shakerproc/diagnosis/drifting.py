"""Springs that are not equally stiff in every test: of the linear model, before any effect."""

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np

from shakerproc.diagnosis.campaign import Campaign
from shakerproc.diagnosis.estimation.form import ROUNDS, Form, carried
from shakerproc.diagnosis.estimation.least_squares import Fit, fit
from shakerproc.diagnosis.estimation.linear import UNUSUAL
from shakerproc.diagnosis.estimation.of_tests import spreads_of
from shakerproc.diagnosis.horizon import scored_at
from shakerproc.diagnosis.outcome import Outcome, at_the_horizon
from shakerproc.diagnosis.selection.errors import error_of
from shakerproc.diagnosis.selection.scores import (
    MOSTLY_NOISE,
    SURE,
    as_fitted,
    best_of,
    gain,
    is_better,
)

FIRST_ROUNDS: Final = 2
"""Steps after which a model that needs nothing but springs that drift is near the truth: it is
next to linear in them [-]."""

NEAR: Final = 0.5
"""Level (see `Fit`) over that with springs that do not drift up to which it is near, or one of
next to noise [-]."""


def alone(campaign: Campaign, linear: Fit, form: Form) -> tuple[Campaign, bool]:
    """Return the campaign, and whether its model leaves no more than noise without any effect.

    Springs drift from then on where that is surely better, and leaves noise: what every joint
    does is no finding.

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
    score = None if there is None else as_fitted(campaign.data, there)
    if there is None or score is None:
        return campaign, False
    drifting = replace(campaign, data=campaign.data.with_drift())
    found = _with_drift(drifting, there)
    own = None if found is None else as_fitted(drifting.data, found)
    if own is not None and own.is_noise and is_better(own, score):
        return drifting, True
    return campaign, score.is_noise


def _with_drift(campaign: Campaign, there: Fit) -> Fit | None:
    """Return a fit whose springs drift besides; None if that does not bring it near."""
    here: Fit | None = there
    near = max(NEAR * there.level, MOSTLY_NOISE)
    for rounds in (FIRST_ROUNDS, ROUNDS):
        if here is None:
            return None
        here = fit(
            campaign.data, here.hypothesis, here.x, here.windows, rounds=rounds,
            channels=here.channels, starts=here.starts,
        )  # fmt: skip
        if here is None or here.level > near or _is_unusual(here):
            return None
    return here


def with_drift(outcome: Outcome, say: Callable[[str], None]) -> Outcome | None:
    """Return what is left of the same hypotheses if springs have a stiffness in each test.

    None where the best of them does not surely predict better then, with a smaller error, or
    only if springs change by more than they do by themselves.
    """
    if outcome.campaign.data.drifting:
        return None
    campaign = replace(outcome.campaign, data=outcome.campaign.data.with_drift())
    best, form = best_of([outcome.linear, *outcome.effects]), outcome.forms[-1]
    scores = scored_at(campaign, [carried(campaign.data, best.fit, [form])], form)
    if not scores or gain(scores[0], best).t <= SURE or _is_unusual(scores[0].fit):
        return None
    before = error_of(outcome.campaign.data, best.fit, form.held_out)
    if error_of(campaign.data, scores[0].fit, form.held_out) >= before:
        return None
    say("springs that drift")
    fits = [score.fit for score in outcome.effects]
    return at_the_horizon(campaign, outcome.linear.fit, fits, say)


def _is_unusual(found: Fit) -> bool:
    """Return whether springs change by more than their prior expects."""
    return bool(np.any(np.abs(found.of_tests) > UNUSUAL * spreads_of(found.data)))
