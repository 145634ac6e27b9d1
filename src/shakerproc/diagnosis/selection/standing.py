"""Which hypotheses are worth a fit to longer windows."""

from collections.abc import Sequence

from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.hypotheses.joints import Known
from shakerproc.diagnosis.selection.scores import LEAST, SURE, Score, as_fitted, gain


def worth_a_fit(standing: Sequence[Fit], known: Known) -> list[Fit]:
    """Return the fits that may be the best where the windows are longer.

    A law that contains another one that it does not outdo is left out: the simpler stands in.
    The model without any is contained in all; beside it the best effect always stays.
    """
    scores = [s for one in standing if (s := as_fitted(one.data, one)) is not None]
    bare = [score for score in scores if not score.fit.hypothesis.added]
    effects = [score for score in scores if score.fit.hypothesis.added]
    best = min(effects, key=lambda score: score.mean, default=None)
    near = [
        s
        for s in effects
        if best is not None
        and gain(best, s).t < SURE
        and all(gain(s, none).mean > LEAST for none in bare)
        and not any(_contains(s, other, known) for other in effects)
    ]
    if best is not None and not near:
        near = [best]
    return [score.fit for score in (*bare, *near)]


def _contains(richer: Score, simpler: Score, known: Known) -> bool:
    """Return whether a law has another one as a limit, and predicts no better."""
    one, other = richer.fit.hypothesis.added[-1], simpler.fit.hypothesis.added[-1]
    limits = [c.kind for c in known[one.between][one.kind].contains if c.limit]
    nested = other.kind in limits and other.between == one.between
    return nested and richer.mean >= simpler.mean - LEAST
