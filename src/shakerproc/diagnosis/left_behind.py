"""Effects that others seemed to explain more than, fitted where nothing else can be named."""

from collections.abc import Callable, Sequence
from typing import Final

import numpy as np

from shakerproc.diagnosis.campaign import Campaign
from shakerproc.diagnosis.estimation.form import Form
from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.found import Found
from shakerproc.diagnosis.horizon import along
from shakerproc.diagnosis.hypotheses.hypothesis import hypothesis_of
from shakerproc.diagnosis.hypotheses.joints import Joint, Known
from shakerproc.diagnosis.nudged.ladder import ladder_of
from shakerproc.diagnosis.nudged.race import at_first, chosen, race
from shakerproc.diagnosis.selection.choice import is_outside, wants_more
from shakerproc.diagnosis.selection.scores import Score, ranked

MOST: Final = 8
"""Effects left behind that are carried to the horizon at most, beside the best in every joint:
what leaves more in short windows seldom leaves less in long ones [-]."""


def with_all(
    found: Found,
    campaign: Campaign,
    forms: Sequence[Form],
    every: Callable[[], Sequence[Fit]],
    say: Callable[[str], None],
    *,
    known: Known,
) -> Found:
    """Return the result with every effect, where none that explains more can be named.

    And more than noise is left, or a force without a name explains more than any that was
    fitted. Those `known` race, too; none where motions are imposed, and so held already.
    """
    if not (wants_more(found) or is_outside(found)):
        return found
    names = [score.fit.hypothesis.names for score in found.effects]
    rest = [one for one in every() if one.hypothesis.names not in names]
    scores = list(found.effects)
    for one in [*chosen(rest, MOST), *chosen(_raced(campaign, known, say), MOST)]:
        say(f"{one.hypothesis.kinds[0]}, left behind so far")
        scores += along(campaign, [one], forms, beside=found.best.fit)
    return found.with_effects(best_of_each(scores))


def best_of_each(scores: Sequence[Score]) -> list[Score]:
    """Return the best score of each hypothesis."""
    best: dict[frozenset[tuple[str, Joint]], Score] = {}
    for score in ranked(scores):
        best.setdefault(score.fit.hypothesis.names, score)
    return list(best.values())


def _raced(campaign: Campaign, known: Known, say: Callable[[str], None]) -> list[Fit]:
    """Return the laws that keep up while models are held to the measured motion ever looser.

    Where windows lead astray, a model that is held finds its numbers.
    """
    data = campaign.data
    if not known:
        return []
    none, ladder = hypothesis_of(data.model), ladder_of(data)
    base = at_first(data, none, np.zeros(none.size), ladder)
    return [] if base is None else list(race(base, known, ladder, say).fits)
