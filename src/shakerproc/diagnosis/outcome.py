"""Remaining hypotheses at the longest horizon at which they can be told apart."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import final

from shakerproc.diagnosis.beside import FEW, beside
from shakerproc.diagnosis.campaign import Campaign, as_it_is
from shakerproc.diagnosis.estimation.form import (
    ROUNDS,
    Form,
    arrived,
    carried,
    usable_forms,
)
from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.estimation.linear_model import LinearModel
from shakerproc.diagnosis.estimation.richer_laws import richer_laws
from shakerproc.diagnosis.found import Found
from shakerproc.diagnosis.horizon import Reached, along, compared, scored_at
from shakerproc.diagnosis.more_effects import parts_of
from shakerproc.diagnosis.progress import Progress
from shakerproc.diagnosis.selection.scores import (
    Score,
    best_of,
    best_of_each,
    leaves_something,
    ranked,
)
from shakerproc.diagnosis.simpler_laws import with_simpler
from shakerproc.models import Model


@final
@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """Remaining hypotheses at the longest horizon at which they can be told apart."""

    campaign: Campaign
    forms: Sequence[Form]
    linear: Score
    effects: Sequence[Score]
    singles: Sequence[Fit]


def at_the_horizon(
    campaign: Campaign,
    linear: Fit,
    singles: Sequence[Fit],
    say: Progress,
) -> Outcome:
    """Return the model without and with effects there, and with the parts of pairs.

    A law that leaves something there, or needs numbers that are not the model's any more, no
    longer stands in for those that contain it.
    """
    say("at the horizon")
    campaign, forms, base, effects = compared(campaign, linear, singles)
    if _is_told_late(campaign, forms[-1], base) and say.has_time_for(
        "all effects at the horizon"
    ):
        every = beside(campaign, base.fit, forms[-1], campaign.known)[:FEW]
        effects = best_of_each([*effects, *scored_at(campaign, every, forms[-1])])
    effects += along(campaign, parts_of(effects, singles), forms)
    best = best_of([base, *effects])
    wanting = leaves_something(best) or best.fit.is_far
    if best.fit.hypothesis.added and wanting:
        effects = _with_richer(campaign, forms[-1], effects, best, say)
    base, effects = with_simpler(campaign, forms[-1], base, effects)
    return Outcome(campaign, forms, base, ranked(effects), singles)


def _is_told_late(campaign: Campaign, last: Form, base: Score) -> bool:
    """Return whether the last horizon tells of an effect, and the next shorter one of none.

    What is held, too, told little then: the effects that lasted did so by chance.
    """
    if last.horizon is None or Reached(campaign, last, [base]).is_noise:
        return False
    lengths_s = [(one.horizon or math.inf, one) for one in usable_forms(campaign.data)]
    shorter = [one for length_s, one in lengths_s if length_s < last.horizon]
    if not shorter:
        return False
    there = carried(campaign.data, base.fit, shorter[-1:])
    before = scored_at(campaign, [there], shorter[-1])
    return bool(before) and Reached(campaign, shorter[-1], before).is_noise


def _with_richer(
    campaign: Campaign, form: Form, effects: Sequence[Score], best: Score,
    say: Callable[[str], None],
) -> list[Score]:  # fmt: skip
    """Return scores with those of laws that contain the best, until one leaves noise alone."""
    found = {score.fit.hypothesis.names: score for score in effects}
    richer = richer_laws(
        campaign.data, campaign.known, best.fit, form.fitted, rounds=ROUNDS, say=say
    )
    for one in richer:
        for score in scored_at(campaign, [arrived(campaign.data, one, form)], form):
            found[one.hypothesis.names] = score
            if not leaves_something(score):
                return list(found.values())
    return list(found.values())


def told(
    original: Model,
    linear_model: LinearModel,
    outcome: Outcome,
    failed: Mapping[str, str],
    behind: Sequence[Fit],
) -> Found:
    """Return the findings, with candidates that failed or fell behind so far."""
    return Found(
        data=outcome.campaign.data,
        linear_model=linear_model,
        form=outcome.forms[-1],
        before=as_it_is(original, outcome.linear.fit),
        linear=outcome.linear,
        effects=tuple(outcome.effects),
        free=None,
        behind=tuple(behind),
        failed=failed,
    ).with_effects(outcome.effects)
