"""The horizon: how far ahead the tests can be predicted, and what is worth a fit there."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final, final

import numpy as np

from shakerproc.diagnosis.campaign import Campaign
from shakerproc.diagnosis.estimation.form import (
    BEST_ROUNDS,
    ROUNDS,
    Form,
    arrived,
    carried,
    usable_forms,
)
from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.estimation.sampling import as_recorded
from shakerproc.diagnosis.found import is_within
from shakerproc.diagnosis.selection.errors import (
    LONGER,
    PARTED,
    error_of,
    floors_of,
    parted,
    pooled_floor,
)
from shakerproc.diagnosis.selection.scores import (
    FAR,
    Score,
    as_fitted,
    best_of,
    gain,
    leaves_something,
    scored,
    simplest_alike,
    worth_a_fit,
)

PREDICTED: Final = 24
"""Windows that tell how far a motion can be predicted: its mean square over them [-]."""


def is_mostly_noise(campaign: Campaign, found: Fit) -> bool:
    """Return whether a fit leaves no more than noise of most of what it was fitted to."""
    score = as_fitted(campaign.data, found)
    return score is not None and score.is_mostly_noise


def compared(
    campaign: Campaign, linear: Fit, singles: Sequence[Fit]
) -> tuple[Campaign, list[Form], Score, list[Score]]:
    """Return hypotheses at the longest horizon at which the best is as good as at shorter ones.

    Its free-run error is as small there, or no more than noise makes of it.

    Parameters
    ----------
    campaign, linear : Campaign, Fit
        The tests, and the model without any effect.
    singles : sequence of Fit
        With one effect, the best first; those that fall behind are left at that horizon.

    Returns
    -------
    Campaign, list of Form, Score, list of Score
        The tests, with accelerations compared as the recorder took them: what has arrived at a
        horizon tells that best. The horizons, the last of which hypotheses are compared in; the
        model without any effect there; and those that may explain the tests.
    """
    forms = usable_forms(campaign.data)
    best = min((linear, *singles), key=lambda one: one.level)
    standing, scores = [linear, *singles], list[Score]()
    chosen, least, past = 0, np.inf, list[Reached]()
    near, whole = False, None
    for i, form in enumerate(forms):
        standing = worth_a_fit(scores, campaign.known) if scores else standing
        if not near and is_mostly_noise(campaign, best):
            near, whole = True, _at_once(campaign, best, standing, forms[-1])
            if whole is not None and whole.is_noise:
                return whole.campaign, [whole.form], *bare_and_effects(linear, whole.scores)
        here = _silent(campaign, standing, form) if i < len(forms) - 1 else None
        if here is not None and len(standing) == 1:  # the model alone goes on from there
            best = here.best
            standing = [best]
        scores = []
        if here is None:
            led = _led_there(campaign, best, standing, form, any_will_do=i == 0)
            if led is None:
                break
            sampled, forms[i], best, there = led
            scores = scores_beside(sampled, best, there, standing, forms[i])
            if not scores:
                continue
            least = least if sampled.data is campaign.data else np.inf
            campaign, here = sampled, Reached(sampled, forms[i], scores)
            best = here.best
        is_worse = not here.is_silent and here.left > LONGER * least
        if is_worse and not any(reached.is_noise for reached in (*past[-1:], here)):
            forms[chosen] = replace(forms[chosen], beyond=tuple(forms[i:]))
            break
        least = least if here.is_silent else min(least, here.left)
        past, chosen = [*past, here], i
    if whole is not None and chosen < len(forms) - 1 and whole.left <= LONGER * least:
        return whole.campaign, [whole.form], *bare_and_effects(linear, whole.scores)
    return campaign, forms[: chosen + 1], *bare_and_effects(linear, _scores_of(past, standing))


@final
@dataclass(frozen=True, eq=False)
class Reached:
    """What hypotheses leave at a horizon."""

    campaign: Campaign
    form: Form
    scores: list[Score]
    is_silent: bool = False

    @property
    def best(self) -> Fit:
        """The hypothesis that predicts best."""
        return best_of(self.scores).fit

    @cached_property
    def left(self) -> float:
        """What that leaves of what was held out [-]."""
        return error_of(self.campaign.data, self.best, self.form.held_out)

    @cached_property
    def is_noise(self) -> bool:
        """Whether that is no more than noise makes of the motion there."""
        data, windows = self.campaign.data, self.form.held_out.some(PREDICTED)
        return is_within(self.left, pooled_floor(floors_of(data, self.best, windows)))


def _scores_of(past: Sequence[Reached], standing: Sequence[Fit]) -> list[Score]:
    """Return the scores at the last horizon, of effects too where it tells of none."""
    if not past or not past[-1].is_silent:
        return past[-1].scores if past else []
    last, effects = past[-1], [one for one in standing if one.hypothesis.added]
    return [*last.scores, *scores_beside(last.campaign, last.best, None, effects, last.form)]


def _silent(campaign: Campaign, standing: Sequence[Fit], form: Form) -> Reached | None:
    """Return a horizon at which the model without any effect leaves no more than noise.

    None where it leaves more. Such a horizon tells of no effect, not even that it is not there.
    """
    bare = [one for one in standing if not one.hypothesis.added]
    scores = scored_at(campaign, [carried(campaign.data, one, [form]) for one in bare], form)
    if not scores or leaves_something(scores[0]):
        return None
    return Reached(campaign, form, scores, is_silent=True)


def _at_once(
    campaign: Campaign, best: Fit, standing: Sequence[Fit], form: Form
) -> Reached | None:
    """Return the longest horizon, if a fit leaves no more than noise there at once.

    One that leaves no more than noise of short windows may be next to the truth, and needs none
    in between to arrive; where it leaves no more at the longest either, shorter ones tell
    nothing that this one does not. All that short windows do not tell from the best are tried.
    """
    if not _is_predicted(campaign, best, form):
        return None
    for one in _as_good(campaign, best, standing):
        there, longest, fitted = _arrived(campaign, one, form)
        if fitted is not None and is_mostly_noise(there, fitted):
            scores = scores_beside(there, one, fitted, standing, longest)
            return Reached(there, longest, scores) if scores else None
    return None


def _led_there(
    campaign: Campaign, best: Fit, standing: Sequence[Fit], form: Form, *, any_will_do: bool
) -> tuple[Campaign, Form, Fit, Fit | None] | None:
    """Return the tests, a horizon, and the fit that leads there before and after.

    The best, or where noise does not let it predict so far (a law of many numbers may run
    away) the next one that surely left no more; with `any_will_do` the best in any case.
    """
    for one in _as_good(campaign, best, standing):
        rounds = BEST_ROUNDS if one.follows_most else ROUNDS
        tests, longer, there = _arrived(campaign, one, form, rounds=rounds)
        if any_will_do or (there is not None and _is_predicted(tests, there, longer)):
            return tests, longer, one, there
    return None


def _as_good(campaign: Campaign, best: Fit, standing: Sequence[Fit]) -> list[Fit]:
    """Return the fits that leave as little of the same windows as the best, which is first."""
    table = best.windows.table
    fits = [one for one in standing if np.array_equal(one.windows.table, table)]
    scores = [as_fitted(campaign.data, one) for one in fits]
    alike = simplest_alike([score for score in scores if score is not None])
    return [best, *(score.fit for score in alike if score.fit is not best)]


def _arrived(
    campaign: Campaign, best: Fit, form: Form, *, rounds: int = BEST_ROUNDS
) -> tuple[Campaign, Form, Fit | None]:
    """Return the best fit carried over to a horizon that knows where it cannot be predicted.

    And the tests, with accelerations compared as the recorder took them.
    """
    form = form.knowing(campaign.data, best)
    there = arrived(campaign.data, best, form, rounds=rounds)
    data = campaign.data if there is None else as_recorded(campaign.data, there)
    if there is not None and data is not campaign.data:
        campaign, form = replace(campaign, data=data), form.knowing(data, there)
        there = arrived(data, there, form)
    return campaign, form if there is None else form.told_by(data, there), there


def scores_beside(
    campaign: Campaign, best: Fit, there: Fit | None, standing: Sequence[Fit], form: Form
) -> list[Score]:
    """Return the scores of hypotheses at a horizon, the best of which is there already."""
    fits = [
        there
        if one is best
        else carried(campaign.data, one, [form], rounds=_rounds(campaign, best, one))
        for one in standing
    ]
    return scored_at(campaign, fits, form)


def _rounds(campaign: Campaign, best: Fit, one: Fit) -> int:
    """Return the steps that a hypothesis is worth at the next horizon, beside the best.

    None where an effect predicts far worse what both were fitted to: it is scored with the
    numbers that it has.
    """
    if not one.hypothesis.added or not np.array_equal(one.windows.table, best.windows.table):
        return ROUNDS
    own, first = as_fitted(campaign.data, one), as_fitted(campaign.data, best)
    is_far = own is not None and first is not None and gain(first, own).t > FAR
    return 0 if is_far else ROUNDS


def bare_and_effects(linear: Fit, scores: Sequence[Score]) -> tuple[Score, list[Score]]:
    """Return the score of the model without any effect, and those of all others."""
    bare = [score for score in scores if not score.fit.hypothesis.added]
    own = bare[0] if bare else Score(linear, np.full_like(scores[0].logs, np.inf))
    return own, [score for score in scores if score.fit.hypothesis.added]


def _is_predicted(campaign: Campaign, found: Fit, form: Form) -> bool:
    """Return whether noise parts the motion of a fit little enough to judge it so far ahead."""
    return parted(campaign.data, found, form.held_out.some(PREDICTED)) <= PARTED


def along(
    campaign: Campaign,
    fits: Sequence[Fit],
    forms: Sequence[Form],
    *,
    beside: Fit | None = None,
) -> list[Score]:
    """Return fits carried over to each horizon, scored at the last if they do not run away.

    Parameters
    ----------
    campaign, fits : Campaign, sequence of Fit
        The tests, and hypotheses on shorter windows.
    forms : sequence of Form
        What they are carried over to.
    beside : Fit, optional
        One that has arrived at the last: what predicts far worse than it at a horizon is
        fitted to no longer one, and is scored with the numbers that it has.
    """
    *shorter, last = forms
    standing, fallen = list(fits), list[Fit]()
    for form in shorter:
        there = [carried(campaign.data, one, [form]) for one in standing]
        standing = [one for one in there if one is not None]
        if beside is not None:
            behind = _far_behind(campaign, standing, beside, form)
            fallen += behind
            standing = [one for one in standing if one not in behind]
    there = [carried(campaign.data, one, [last]) for one in standing]
    there += [carried(campaign.data, one, [last], rounds=0) for one in fallen]
    return scored_at(campaign, there, last)


def _far_behind(campaign: Campaign, fits: Sequence[Fit], beside: Fit, form: Form) -> list[Fit]:
    """Return the fits at a horizon that predict far worse there than another one does."""
    best = scored_at(campaign, [carried(campaign.data, beside, [form], rounds=0)], form)
    scores = scored_at(campaign, fits, form) if best else []
    return [score.fit for score in scores if gain(best[0], score).t > FAR]


def scored_at(campaign: Campaign, fits: Sequence[Fit | None], form: Form) -> list[Score]:
    """Return scores of fits at one horizon; those that run away are left out."""
    scores = [scored(campaign.data, one, form.held_out) for one in fits if one is not None]
    return [score for score in scores if score is not None]
