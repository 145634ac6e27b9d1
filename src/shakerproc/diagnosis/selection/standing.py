"""Which hypotheses are worth a fit to longer windows."""

from collections.abc import Sequence

from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.hypotheses.joints import Known
from shakerproc.diagnosis.selection.scores import LEAST, SURE, Score, gain


def worth_a_fit(scores: Sequence[Score], known: Known) -> list[Fit]:
    """Return the fits that may be the best where the windows are longer, by their scores.

    A law that contains another one that it does not outdo is left out: the simpler stands in;
    where it does, the simpler may just not have arrived, and stays: where the richer turns
    out to have more numbers than it can account for, the simpler is asked for.
    The model without any is contained in all; beside it the best effect always stays.
    """
    bare = [score for score in scores if not score.fit.hypothesis.added]
    effects = [score for score in scores if score.fit.hypothesis.added]
    best = min(effects, key=lambda score: score.mean, default=None)
    unmatched = [
        s
        for s in effects
        if all(gain(s, none).mean > LEAST for none in bare)
        and not any(
            contains(s.fit, other.fit, known) and _no_better(s, other) for other in effects
        )
    ]
    near = [s for s in unmatched if best is not None and gain(best, s).t < SURE]
    near += [
        s
        for s in unmatched
        if s not in near and any(contains(other.fit, s.fit, known) for other in near)
    ]
    if best is not None and not near:
        near = [best]
    return [score.fit for score in (*bare, *near)]


def contains(richer: Fit, simpler: Fit, known: Known) -> bool:
    """Return whether a law has another one, in the same joint, as a limit."""
    if not (richer.hypothesis.added and simpler.hypothesis.added):
        return False
    one, other = richer.hypothesis.added[-1], simpler.hypothesis.added[-1]
    limits = [c.kind for c in known[one.between][one.kind].contains if c.limit]
    return other.kind in limits and other.between == one.between


def _no_better(richer: Score, simpler: Score) -> bool:
    return richer.mean >= simpler.mean - LEAST
