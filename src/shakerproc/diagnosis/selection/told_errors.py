"""The errors of a verdict: as candidates are judged, and as `compare` tells them."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from shakerproc.diagnosis.compared import Comparisons
from shakerproc.diagnosis.estimate import Estimate
from shakerproc.diagnosis.found import Found
from shakerproc.diagnosis.result import Errors, Finding, Pair
from shakerproc.diagnosis.selection.each_test import Simulated, simulated_by
from shakerproc.diagnosis.selection.errors import error_of_scored
from shakerproc.diagnosis.selection.scores import Score
from shakerproc.diagnosis.updated import model_with


def simulated(found: Found, chosen: Score) -> tuple[Simulated, Simulated]:
    """Return tests as the model as it is simulates them, and as what was chosen does."""
    data, form = found.data, found.form
    return simulated_by(data.plain, form, found.before), simulated_by(data, form, chosen.fit)


def errors_among(found: Found, before: Simulated, after: Simulated, chosen: Score) -> Errors:
    """Return errors as candidates are judged: of the model as it is, and of what was chosen.

    Those of the model as it is are of tests as recorded.

    `before` is by the model as it is in the tests of the search, `after` by what was chosen.
    """
    form, data, alone = found.form, found.data, found.left_by(found.linear)
    if found.as_recorded is not data:
        before = simulated_by(found.as_recorded.plain, form, found.before)
    fitted, held_out = map(error_of_scored, before)
    return Errors(
        Pair(fitted, error_of_scored(after[0])),
        Pair(held_out, found.left_by(chosen)),
        found.floor_under(chosen),
        {test.name: form.horizon for test in data.tests},
        alone if chosen.fit.hypothesis.added and np.isfinite(alone) else None,
    )


def errors_told(
    found: Found, effects: Sequence[Finding], linear: Mapping[str, Estimate], own: Errors,
    comparisons: Comparisons | None,
) -> Errors:  # fmt: skip
    """Return the errors as `compare` tells them of the model that is proposed; else `own`."""
    if comparisons is None:
        return own
    known = found.before.hypothesis.model
    fit = found.linear.fit
    bare = replace(fit.hypothesis.model_at(fit.x), modes=known.modes) if effects else known
    return comparisons.errors(known, model_with(known, effects, linear), bare, own)
