"""Effects that others seemed to explain more than, fitted where nothing else can be named."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from shakerproc.diagnosis.campaign import Campaign
from shakerproc.diagnosis.estimation.form import Form
from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.found import Found
from shakerproc.diagnosis.horizon import along
from shakerproc.diagnosis.selection.choice import wants_more
from shakerproc.diagnosis.selection.scores import ranked


def with_all(
    found: Found,
    campaign: Campaign,
    forms: Sequence[Form],
    every: Callable[[], Sequence[Fit]],
    say: Callable[[str], None],
) -> Found:
    """Return the same with every effect, where none of those that explain more can be named.

    And more than noise is left.
    """
    if not wants_more(found):
        return found
    names = [score.fit.hypothesis.names for score in found.effects]
    rest = [one for one in every() if one.hypothesis.names not in names]
    scores = list(found.effects)
    for one in rest:
        say(f"{one.hypothesis.kinds[0]}, left behind so far")
        scores += along(campaign, [one], forms, beside=found.best.fit)
    known = {name for score in scores for name in score.fit.hypothesis.names}
    return replace(
        found,
        effects=tuple(ranked(scores)),
        ruled_out=tuple(s for s in found.ruled_out if (s.kind, s.between) not in known),
    )
