"""The hypotheses that were tried, as a diagnosis lists them."""

import numpy as np

from shakerproc.diagnosis.estimate import Estimate
from shakerproc.diagnosis.estimation.intervals import estimates, numbers
from shakerproc.diagnosis.found import Found
from shakerproc.diagnosis.result import Tried
from shakerproc.diagnosis.screening import Start
from shakerproc.diagnosis.selection.errors import error_of_scored, scored_tests
from shakerproc.diagnosis.selection.scores import Score


def tried(found: Found, score: Score, *, stands: bool) -> Tried:
    """Return a hypothesis that was fitted, with its errors and numbers.

    The numbers have intervals where it stands: those of a law that is refuted are of nothing.
    """
    fit, windows = score.fit, found.form.scored_fitted
    near = fit.starts if np.array_equal(fit.windows.table, windows.table) else None
    of_effect = estimates if stands else numbers
    own: dict[str, Estimate] = {}
    for i, one in enumerate(fit.hypothesis.added):
        before = f"{one.kind} " if len(fit.hypothesis.added) > 1 else ""
        own |= {before + k: v for k, v in of_effect(fit, i).items()}
    return Tried(
        "+".join(fit.hypothesis.kinds),
        fit.hypothesis.added[-1].between,
        error_of_scored(scored_tests(found.data, fit, windows, near=near)),
        found.left_by(score),
        own,
    )


def untried(found: Found) -> list[Tried]:
    """Return candidates that were not fitted to the end, with their errors so far."""
    return [
        Tried(one.kind, one.between, None, None, _words(one), float(np.sqrt(one.left)))
        for one in sorted(found.ruled_out, key=lambda one: one.left)
    ]


def _words(start: Start) -> dict[str, Estimate]:
    """Return words that distinguish variants of an effect: the side of a stop."""
    words = {name: value for name, value in start.values.items() if isinstance(value, str)}
    return {name: Estimate(word, None, None, "") for name, word in words.items()}
