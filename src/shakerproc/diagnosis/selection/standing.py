"""Which hypotheses are worth a fit to longer windows."""

from collections.abc import Sequence

from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.hypotheses.joints import Known, has_limit
from shakerproc.diagnosis.selection.scores import LEAST, SURE, Score, gain


def worth_a_fit(
    scores: Sequence[Score],
    known: Known,
    *,
    beside: Sequence[Score] = (),
    behind: float = SURE,
) -> list[Fit]:
    """Return the fits that may be the best where the windows are longer, by their scores.

    A law that contains another one that it does not outdo is left out: the simpler stands in;
    where it does, the simpler may just not have arrived, and stays: where the richer turns
    out to have more numbers than it can account for, the simpler is asked for.
    The model without any is contained in all; beside it the best effect always stays.

    Parameters
    ----------
    scores : sequence of Score
        With effects and, maybe, without.
    known : mapping of joint to mapping of str to Identification
        What each effect says of each joint.
    beside : sequence of Score
        What is contained in all others besides, and does not go on.
    behind : float
        Standard errors by which one may be behind the best [-].
    """
    bare = [score for score in scores if not score.fit.hypothesis.added]
    less = [*bare, *beside]
    effects = [score for score in scores if score.fit.hypothesis.added]
    best = min(effects, key=lambda score: score.mean, default=None)
    unmatched = [
        s
        for s in effects
        if all(gain(s, none).mean > LEAST for none in less)
        and not any(
            contains(s.fit, other.fit, known) and _no_better(s, other) for other in effects
        )
    ]
    near = [s for s in unmatched if best is not None and gain(best, s).t < behind]
    near += [
        s
        for s in unmatched
        if s not in near and any(contains(other.fit, s.fit, known) for other in near)
    ]
    if best is not None and not near:
        near = [best]
    return [score.fit for score in (*bare, *near)]


def contains(richer: Fit, simpler: Fit, known: Known) -> bool:
    """Return whether one hypothesis has another as a limit: all effects alike but one.

    That one has the other's, in the same joint, as a limit.
    """
    own = richer.hypothesis.names - simpler.hypothesis.names
    others = simpler.hypothesis.names - richer.hypothesis.names
    if len(own) != 1 or len(others) != 1:
        return False
    return has_limit(known, *own, *others)


def _no_better(richer: Score, simpler: Score) -> bool:
    return richer.mean >= simpler.mean - LEAST
