"""Effects of decays, sought as far ahead as noise lets predict: by the error each takes."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final, TypeVar

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.campaign import Campaign
from shakerproc.diagnosis.estimation.form import ROUNDS, Form, carried
from shakerproc.diagnosis.estimation.least_squares import Fit, fit
from shakerproc.diagnosis.found import Found
from shakerproc.diagnosis.further_ahead import carried_on, falls_short
from shakerproc.diagnosis.horizon import along, scored_at
from shakerproc.diagnosis.hypotheses.joints import Known
from shakerproc.diagnosis.nudged.base import Base, Moved
from shakerproc.diagnosis.nudged.race import chosen
from shakerproc.diagnosis.nudged.starts import Tried, own_starts
from shakerproc.diagnosis.progress import Progress
from shakerproc.diagnosis.selection.choice import (
    TENTH,
    bare,
    is_outside,
    leaves_more,
    standing_of,
    wants_more,
)
from shakerproc.diagnosis.selection.each_test import doubtful
from shakerproc.diagnosis.selection.errors import PARTED, error_of, parted
from shakerproc.diagnosis.selection.scores import (
    LEAST,
    SURE,
    Score,
    as_fitted,
    best_of,
    best_of_each,
    gain_of,
    is_better,
    simplest_alike,
)
from shakerproc.diagnosis.simpler_laws import simpler_laws, starts_with, with_simpler
from shakerproc.errors import ModelError

MOST: Final = 8
"""Effects left behind that are carried to the horizon at most, beside the best in every joint:
what leaves more in short windows seldom leaves less in long ones [-]."""


def with_all(
    found: Found,
    campaign: Campaign,
    forms: Sequence[Form],
    say: Progress,
) -> Found:
    """Return the result with what fell behind, where nothing that explains more can be named.

    And more than noise is left, or a force without a name explains more than any that was
    fitted, or what stands leaves noise of what was held out and more of a test (`doubtful`).
    """
    if not (doubtful(found) or wants_more(found) or is_outside(found)):
        return found
    scores = list(found.effects)
    for one in chosen(found.behind, MOST):
        if not say.has_time_for(f"{one.hypothesis.kinds[0]}, left behind so far"):
            continue
        scores += along(campaign, [one], forms, beside=found.best.fit)
    scores = best_of_each(scores)
    if scores and best_of(scores) not in found.effects:
        bare, scores = with_simpler(campaign, forms[-1], found.linear, scores)
        found = replace(found, linear=bare)
    return found.with_effects(scores)


LOOKED_AT: Final = 8
"""Windows in which starts are compared [-]."""

WEAK: Final = 0.01
"""Force of a start, over that of a start while runs are held [-]."""

FITTED: Final = 6
"""Effects that are fitted, of those that take most away. All of one number are fitted as well:
they take least time, and starts tell little where the fit does not follow the motion [-]."""

FEWEST: Final = 2
"""Numbers that two effects have at least [-]."""

FEW: Final = 2
"""Of these so many that go on; pairs of which simpler ones are sought [-]."""


def with_pairs_ahead(found: Found, campaign: Campaign, known: Known, say: Progress) -> Found:
    """Return the hypotheses with one and two effects of decays that are judged further ahead.

    Where what stands leaves more than noise, there or at its own horizon. Where it is one law,
    and leaves noise alone, pairs of no more numbers are tried: they may do as well. In short
    windows a slow change of amplitude shows as little as any; a whole decay tells it, and has
    few windows. (Of a driven gap beside an attached mode it cost as much as all else, 95 s, and
    found no more: pair:gap+attached_mode*90.)
    """
    is_decay = campaign.data.model.excitation.role is None
    if not is_decay or found.rigid or not known:
        return found
    most = _most_numbers(found)
    if most < found.linear.fit.hypothesis.size + FEWEST:
        return found
    if not say.has_time_for("effects further ahead"):
        return found
    *_, form = forms = _predicted(found, campaign)
    before = [carried(campaign.data, one.fit, forms) for one in (found.linear, *found.effects)]
    linear = before[0]
    if linear is None:
        return found
    singles = beside(campaign, linear, form, known, most=most - 1)
    had = [one for one in before[1:] if one is not None]
    firsts = _worth_their_numbers([
        one for one in (*had, *singles) if one.hypothesis.size < most
    ])
    pairs = list[Fit]()
    for first in firsts:
        if say.has_time_for(f"an effect beside {first.hypothesis.kinds[0]} further ahead"):
            pairs += beside(campaign, first, form, known, most=most)[:FEW]
    pairs.sort(key=lambda pair: pair.level)
    pairs += [one for pair in pairs[:FEW] for one in simpler_laws(campaign.data, pair, known)]
    every = list(dict.fromkeys([*had, *firsts, *singles[:FEW], *pairs]))
    every = _lasting(campaign, every, [found.form, *forms[:-1]])
    scores = best_of_each(scored_at(campaign, every, form))
    bared = scored_at(campaign, [linear], form)
    if not scores or not bared or not _is_taken(found, form, [*bared, *scores], most):
        return found
    there = replace(
        found, data=campaign.data, form=form, linear=bared[0], free=None,
        _left={}, _floors={}, _free_runs={},
    )  # fmt: skip
    return there.with_effects(scores)


def beside(
    campaign: Campaign, on: Fit, form: Form, known: Known, *, most: float = np.inf
) -> list[Fit]:
    """Return effects beside a fit to a form, fitted there, the best first.

    Each start is simulated once; the numbers of the fit move along their slopes with it. What
    has more than `most` numbers in all is not tried.
    """
    looked_at = on.windows.some(LOOKED_AT)
    base = Base(on, looked_at)
    best: list[Moved] = []
    for starts in own_starts(on, known).values():
        own = [one for one in starts if _goes_on(on, one[1]) and one[0].size <= most]
        best += base.best([*own, *map(_weaker, own)])[:1]
    ranked = _simplest_first([(one, one.logs) for one in best])
    simple = [one for one in ranked[FITTED:] if one.hypothesis.size == on.hypothesis.size + 1]
    begun = [
        fit(campaign.data, one.hypothesis, one.x, looked_at, rounds=0, channels=on.channels)
        for one in (*ranked[:FITTED], *simple)
    ]
    there = [_carried(campaign, on, one, form) for one in begun if one]
    scores = [as_fitted(campaign.data, one) for one in there if one is not None]
    return _simplest_first([(one.fit, one.logs) for one in scores if one is not None])


def _carried(campaign: Campaign, on: Fit, begun: Fit, form: Form) -> Fit | None:
    """Return a start carried to a form; begun at the fit itself where it leaves more than that.

    With no force the effect leaves what the fit does.
    """
    there = carried(campaign.data, begun, [form], begun=True)
    if there is not None and there.level <= on.level:
        return there
    none, x = _weaker((begun.hypothesis, np.concatenate([on.x, begun.x[on.x.size :]])))
    try:
        starts = starts_with(on, none, x)
    except ModelError:  # no model can begin so
        return there
    again = fit(
        campaign.data, none, x, form.fitted, rounds=ROUNDS, channels=on.channels, starts=starts
    )
    left = [one for one in (there, again) if one is not None]
    return min(left, key=lambda one: one.level, default=None)


_Tried = TypeVar("_Tried", Moved, Fit)


def _simplest_first(tried: Sequence[tuple[_Tried, FloatArray]]) -> list[_Tried]:
    """Return starts or fits, given with the logarithms of what they leave, the best first.

    Those that leave no more than the best, for sure, by the count of their numbers: where an
    effect is weak, laws of many numbers may all do.
    """
    least = min((logs for _, logs in tried), key=np.mean, default=np.zeros(0))

    def rank(one: tuple[_Tried, FloatArray]) -> tuple[bool, int, float]:
        behind = gain_of(least, one[1]).t > SURE
        return behind, 0 if behind else one[0].hypothesis.size, float(np.mean(one[1]))

    return [one for one, _ in sorted(tried, key=rank)]


def _weaker(start: Tried) -> Tried:
    """Return a start with a force that free runs follow along a straight line."""
    hypothesis, x = start
    last, n = hypothesis.added[-1], len(hypothesis.added[-1].names)
    values = last.values(x[-n:])
    for name in last.identification.scaled:
        values[name] *= WEAK
    return hypothesis, np.concatenate([x[:-n], last.transformed({**last.fixed, **values})])


def _goes_on(on: Fit, x: FloatArray) -> bool:
    """Return whether a start has the numbers of the fit."""
    return np.array_equal(x[: on.x.size], on.x)


def _lasting(campaign: Campaign, fits: Sequence[Fit], shorter: Sequence[Form]) -> list[Fit]:
    """Return the fits that no law of as few numbers surely predicts better than less far ahead.

    One long decay has many least values: a law that follows its phase by chance, as stiffness
    that drifts does where the amplitude falls, fails in shorter parts.
    """
    left = list(fits)
    for form in shorter:
        there = [carried(campaign.data, one, [form]) for one in left]
        scores = [scored_at(campaign, [one], form) if one else [] for one in there]
        left = [
            one
            for one, own in zip(left, scores, strict=True)
            if own and not any(_is_beaten(own[0], other[0]) for other in scores if other)
        ]
    return left


def _is_beaten(score: Score, other: Score) -> bool:
    few = other.fit.hypothesis.size <= score.fit.hypothesis.size
    return few and is_better(other, score)


def _is_taken(found: Found, form: Form, scores: Sequence[Score], most: float) -> bool:
    """Return whether something new surely predicts better at a form, or as well and simpler.

    With fewer numbers than all before, or no more than `most` where that bounds what is tried.
    """
    names = [one.fit.hypothesis.names for one in (found.linear, *found.effects)]
    had = [one for one in scores if one.fit.hypothesis.names in names]
    reached, best = simplest_alike(had)[0], simplest_alike(scores)[0]
    if best in had:
        return False
    left = [error_of(found.data, one.fit, form.held_out) for one in (best, reached)]
    surely = is_better(best, reached) and left[0] <= (1.0 - TENTH) * left[1]
    simple = most if np.isfinite(most) else reached.fit.hypothesis.size - 1
    return surely or best.fit.hypothesis.size <= simple


def _most_numbers(found: Found) -> float:
    """Return how many numbers a hypothesis may have to be tried beside the standing one.

    Any number where that leaves more than noise, there or further ahead. Else as many as it,
    if it is one law, and fewer if it is two.
    """
    standing = standing_of(found)
    chosen = standing[0] if standing else bare(found)
    leaves = leaves_more(found, chosen) or falls_short(found, chosen)
    own = chosen.fit.hypothesis
    return np.inf if leaves else own.size + 1 - len(own.added)


def _predicted(found: Found, campaign: Campaign) -> list[Form]:
    """Return the longer forms up to the last one that noise lets predict, else the form.

    With any of the hypotheses that predict as well as the best, which may run away.
    """
    alike = simplest_alike(list(dict.fromkeys([found.best, *found.effects])))
    longest = max((_followed(found, campaign, one.fit) for one in alike), key=len)
    return [form.knowing(campaign.data, there) for form, there in longest] or [found.form]


def _followed(found: Found, campaign: Campaign, leading: Fit) -> list[tuple[Form, Fit]]:
    """Return the longer forms that noise lets a hypothesis predict, each with it there."""
    followed = list[tuple[Form, Fit]]()
    for form, there in carried_on(campaign.data, leading, found.form):
        if there is None or parted(campaign.data, there, form.held_out) > PARTED:
            break
        followed.append((form, there))
    return followed


def _worth_their_numbers(fits: Sequence[Fit]) -> list[Fit]:
    """Return single effects, the fewest numbers first, that leave less than all of no more."""
    single = [one for one in fits if len(one.hypothesis.added) == 1]
    worth = list[Fit]()
    for one in sorted(single, key=lambda one: (one.hypothesis.size, one.level)):
        if not worth or one.level < worth[-1].level - LEAST:
            worth.append(one)
    return worth
