"""Residual of one effect of the library: two of them, or a force without a name."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import permutations
from typing import Final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.campaign import Campaign
from shakerproc.diagnosis.estimation.beginnings import as_table, grouped
from shakerproc.diagnosis.estimation.form import Form
from shakerproc.diagnosis.estimation.growth import Condition
from shakerproc.diagnosis.estimation.least_squares import Fit, fit
from shakerproc.diagnosis.estimation.one_more import FIRST_ROUNDS, OneMore
from shakerproc.diagnosis.found import Found
from shakerproc.diagnosis.horizon import along, compared
from shakerproc.diagnosis.hypotheses.hypothesis import (
    Addition,
    addition,
)
from shakerproc.diagnosis.hypotheses.joints import Known
from shakerproc.diagnosis.screening import free_laws, with_limits
from shakerproc.diagnosis.screening.pairs import both_at_once, screen_pairs
from shakerproc.diagnosis.selection.scores import (
    LEAST,
    Score,
    best_of_each,
    contains,
    simplest_alike,
)
from shakerproc.diagnosis.simpler_laws import simpler_laws
from shakerproc.simulation import has_jumps

FIRSTS: Final = 2
"""Single effects that a second one is sought beside, and pairs that go to the horizon [-]."""

SECONDS: Final = 6
"""Effects, each in one joint, that are tried as a second one: those that explain most [-]."""

AT_ONCE: Final = 4
"""Pairs of effects that are fitted because they explain most together [-]."""

MUCH_LESS: Final = 0.5
"""Share of what the best single effect leaves in the screening that two may leave at once, to
be worth a fit before it is known how far the single one carries [-]."""

EXPLAINED: Final = 0.25
"""Share of what the first leaves that a second explains at least, in the screening to be worth
a fit, and in the shortest windows to be fitted to longer ones. Of five tuning draws of pairs
the true one explained 0.41 to 0.999 in the screening, of five campaigns with nuisances alone
the best law, but for a mode apart, 0.01 to 0.33. Beside a force that jumps the screening tells
too little (a cubic spring beside Coulomb friction 0.04, tuning seed 62): all are fitted [-]."""


def hidden_pairs(
    campaign: Campaign,
    linear: Fit,
    least: float,
    left: float,
    say: Callable[[str], None],
) -> list[Fit]:
    """Return pairs that explain much more than any one effect, fitted to windows that grew.

    Those that already in the shortest windows explain less than one effect does are left.

    Parameters
    ----------
    campaign : Campaign
        The tests.
    linear : Fit
        The model without any effect.
    least : float
        Least level (see `Fit`) that one effect reached in the shortest windows [-].
    left : float
        What the best single effect leaves in the screening, 0 where there is nothing to
        explain [-].
    say : callable
        Called with what is being tried.
    """
    model, data = campaign.data.model, campaign.data
    if left <= 0.0:
        return []
    say("two effects at once")
    found = list[Fit]()
    for one, other in both_at_once(model, campaign.fitted, campaign.known, AT_ONCE):
        if one.left > MUCH_LESS * left:
            continue
        known = campaign.known[one.between][one.kind]
        first = addition(one.kind, one.between, known, one.values)
        on = _beside(linear, first, linear.x, first.transformed(one.values))
        own = np.zeros(len(linear.hypothesis.own))
        second = OneMore(
            data, on, campaign.known, campaign.stages, linear=own, say=lambda _: None,
            condition=Condition(below=least),
        )  # fmt: skip
        found += second.found([other])
    found.sort(key=lambda pair: pair.level)
    for pair in found[:FIRSTS]:
        found += simpler_laws(pair.data, pair, campaign.known)
    return _not_outdone(found, campaign.known)


def _beside(linear: Fit, one: Addition, own: FloatArray, x: FloatArray) -> Fit:
    """Return the model with an effect that is known, to seek another one beside it."""
    return replace(
        linear, hypothesis=linear.hypothesis.with_added(one), x=np.concatenate([own, x])
    )


def with_more(
    found: Found,
    campaign: Campaign,
    forms: Sequence[Form],
    singles: Sequence[Fit],
    say: Callable[[str], None],
) -> tuple[Found, Campaign, Sequence[Form]]:
    """Return pairs of effects, and a force without a name, that explain beyond singles.

    In tests and forms as they tell.

    A second effect is sought beside the best of all, then beside the best that is another law,
    until no more than noise is left.
    """
    for first in _unlike(found, singles, campaign.known)[:FIRSTS]:
        say(f"a second effect beside {first.hypothesis.kinds[0]}")
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
    campaign: Campaign,
    first: Fit,
    say: Callable[[str], None],
) -> tuple[list[Fit], dict[str, str]]:
    """Return second effects beside one, those that explain most and what they contain.

    The best first; and why others failed.
    """
    one = first.hypothesis.added[0]
    values = {**one.fixed, **one.values(first.hypothesis.parts(first.x)[1])}
    starts = screen_pairs(
        campaign.data.model,
        campaign.fitted,
        campaign.known,
        (one.kind, one.between, values),
    )
    jumps = has_jumps(first.hypothesis.model_at(first.x))
    best = dict.fromkeys(
        (kind, joint)
        for (kind, joint, _), own in grouped(starts).items()
        if jumps or max(start.explained for start in own) >= EXPLAINED
    )
    starts = with_limits(starts, list(best)[:SECONDS], campaign.known)
    if not starts:
        return [], {}
    second = OneMore(
        campaign.data, first, campaign.known, campaign.stages,
        linear=first.hypothesis.parts(first.x)[0],
        say=lambda what: say(f"{what}, beside {one.kind}"),
        condition=Condition(below=_explaining(campaign, first)),
    )  # fmt: skip
    pairs = second.found(starts)
    return pairs, {f"{one.kind}+{name}": why for name, why in second.failed.items()}


def _explaining(campaign: Campaign, first: Fit) -> float:
    """Return the level in the shortest windows below which a second effect explains enough."""
    windows = campaign.stages.windows[0]
    there = fit(
        campaign.data, first.hypothesis, first.x, windows, rounds=FIRST_ROUNDS,
        channels=first.channels,
    )  # fmt: skip
    return np.inf if there is None else there.level + float(np.log(1.0 - EXPLAINED))


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
