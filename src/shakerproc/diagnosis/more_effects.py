"""Residual of one effect of the library: two of them, or a force without a name."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import permutations
from typing import Final

from shakerproc.diagnosis.campaign import Campaign
from shakerproc.diagnosis.estimation.beginnings import as_table
from shakerproc.diagnosis.estimation.form import Form
from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.found import Found
from shakerproc.diagnosis.horizon import along, compared
from shakerproc.diagnosis.hypotheses.joints import Known
from shakerproc.diagnosis.nudged.race import raced
from shakerproc.diagnosis.progress import Progress
from shakerproc.diagnosis.screening import free_laws
from shakerproc.diagnosis.selection.scores import (
    LEAST,
    Score,
    best_of_each,
    contains,
    simplest_alike,
)
from shakerproc.diagnosis.simpler_laws import simpler_laws

FIRSTS: Final = 2
"""Single effects that a second one is sought beside, and pairs that go to the horizon [-]."""


def with_more(
    found: Found,
    campaign: Campaign,
    forms: Sequence[Form],
    singles: Sequence[Fit],
    say: Progress,
) -> tuple[Found, Campaign, Sequence[Form]]:
    """Return pairs of effects, and a force without a name, that explain beyond singles.

    In tests and forms as they tell.

    A second effect is sought beside the best of all, then beside the best that is another law,
    until no more than noise is left.
    """
    for first in _unlike(found, singles, campaign.known)[:FIRSTS]:
        if not say.has_time_for(f"a second effect beside {first.hypothesis.kinds[0]}"):
            continue
        pairs, failed = _pairs(campaign, first, say)
        for pair in pairs[:FIRSTS]:
            pairs += simpler_laws(pair.data, pair, campaign.known)
        pairs = _with_limits(_not_outdone(pairs, campaign.known), campaign.known)
        found, campaign, forms = _judged(found, campaign, forms, singles, pairs)
        found = replace(found, failed={**found.failed, **failed})
        if found.is_enough:
            return found, campaign, forms
    say("a force without a name")
    laws = _free(campaign, found.linear.fit)
    free = along(campaign, laws, forms, beside=found.best.fit)
    return replace(found, free=free[0] if free else None), campaign, forms


def _judged(
    found: Found, campaign: Campaign, forms: Sequence[Form], singles: Sequence[Fit],
    pairs: Sequence[Fit],
) -> tuple[Found, Campaign, Sequence[Form]]:  # fmt: skip
    """Return the result with pairs at the horizon, in tests and forms as they tell.

    Pairs that told how the recorder took accelerations are compared so, and all others anew.
    """
    if pairs and pairs[0].data.points != campaign.data.points:
        campaign, forms, linear, scores = compared(
            replace(campaign, data=pairs[0].data), found.linear.fit, [*singles, *pairs]
        )
        found = replace(found, data=campaign.data, form=forms[-1], linear=linear, effects=())
    else:
        scores = along(campaign, pairs, forms[-2:], beside=found.best.fit)
    scores += along(campaign, parts_of([*found.effects, *scores], singles), forms[-2:])
    effects = tuple(best_of_each([*found.effects, *scores]))
    return replace(found, effects=effects), campaign, forms


def _unlike(found: Found, singles: Sequence[Fit], known: Known) -> list[Fit]:
    """Return single effects none of which contains another, the best first.

    Of those that contain one another the simplest that predicts as well as the best of them.
    """
    left = [score for score in found.effects if len(score.fit.hypothesis.added) == 1]
    unlike: list[Fit] = []
    while left:
        family = [s for s in left if s is left[0] or _are_alike(s.fit, left[0].fit, known)]
        unlike.append(simplest_alike(family)[0].fit)
        left = [score for score in left if score not in family]
    for one in singles:
        names = one.hypothesis.names
        if not any(names == u.hypothesis.names or _are_alike(one, u, known) for u in unlike):
            unlike.append(one)
    return unlike


def _are_alike(one: Fit, other: Fit, known: Known) -> bool:
    return contains(one, other, known) or contains(other, one, known)


def _pairs(
    campaign: Campaign, first: Fit, say: Callable[[str], None]
) -> tuple[list[Fit], dict[str, str]]:
    """Return second effects that last in a race beside one, the best first.

    And why others failed.
    """
    one = raced(
        campaign.data, first.hypothesis, first.x, campaign.known, say, channels=first.channels
    )
    kind = first.hypothesis.kinds[0]
    return list(one.fits), {f"{kind} and {name}": why for name, why in one.failed.items()}


def _not_outdone(pairs: Sequence[Fit], known: Known) -> list[Fit]:
    """Return the best fit of each pair, but for those that leave no less than a limit does."""
    each = {pair.hypothesis.names: pair for pair in sorted(pairs, key=lambda p: -p.level)}
    outdone = [
        richer for richer, simpler in permutations(each.values(), 2)
        if contains(richer, simpler, known) and richer.level > simpler.level - LEAST
    ]  # fmt: skip
    left = [pair for pair in each.values() if pair not in outdone]
    return sorted(left, key=lambda pair: pair.level)


def _with_limits(pairs: Sequence[Fit], known: Known) -> list[Fit]:
    """Return the best pairs, and those of simpler laws that they contain."""
    best = list(pairs[:FIRSTS])
    return best + [
        pair for pair in pairs[FIRSTS:] if any(contains(one, pair, known) for one in best)
    ]


def parts_of(scores: Sequence[Score], singles: Sequence[Fit]) -> list[Fit]:
    """Return single effects of pairs that have no score yet: what a pair is compared with."""
    done = [score.fit.hypothesis.names for score in scores]
    within = {name for names in done if len(names) > 1 for name in names}
    named = [(one, one.hypothesis.names) for one in singles]
    return [one for one, names in named if names <= within and names not in done]


def _free(campaign: Campaign, linear: Fit) -> list[Fit]:
    """Return the missing force as a smooth table in the joint that it explains most of."""
    laws = free_laws(campaign.data.model, campaign.fitted, tuple(campaign.known))
    if not laws:
        return []
    begun = as_table(campaign.data.model, laws[0])
    return [] if begun is None else [replace(linear, hypothesis=begun[0], x=begun[1])]
