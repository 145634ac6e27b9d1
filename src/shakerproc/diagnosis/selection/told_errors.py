"""The errors of a verdict: as candidates are judged, and as `compare` tells them."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from shakerproc.diagnosis.compared import Comparisons
from shakerproc.diagnosis.estimate import Estimate
from shakerproc.diagnosis.found import Found
from shakerproc.diagnosis.further_ahead import ahead
from shakerproc.diagnosis.result import Errors, Finding, Pair
from shakerproc.diagnosis.selection.choice import NEGLIGIBLE, SHARE
from shakerproc.diagnosis.selection.each_test import Simulated, simulated_by
from shakerproc.diagnosis.selection.errors import beyond_noise, error_of_scored
from shakerproc.diagnosis.selection.scores import Score
from shakerproc.diagnosis.updated import elements_of, model_with


def errors_among(found: Found, chosen: Score) -> tuple[tuple[Simulated, Simulated], Errors]:
    """Return tests as simulated by the model as it is and by what was chosen, and the errors.

    Errors are as candidates are judged; of the model as it is, in tests as recorded.
    """
    data, form, alone = found.data, found.form, found.left_by(found.linear)
    before, after = (
        simulated_by(data.plain, form, found.before), simulated_by(data, form, chosen.fit)
    )  # fmt: skip
    recorded = before
    if found.as_recorded is not data:
        recorded = simulated_by(found.as_recorded.plain, form, found.before)
    fitted, held_out = map(error_of_scored, recorded)
    errors = Errors(
        Pair(fitted, error_of_scored(after[0])),
        Pair(held_out, found.left_by(chosen)),
        found.floor_under(chosen),
        {test.name: form.horizon for test in data.tests},
        alone if chosen.fit.hypothesis.added and np.isfinite(alone) else None,
    )
    return (before, after), errors


def errors_told(
    found: Found, effects: Sequence[Finding], linear: Mapping[str, Estimate], own: Errors,
    comparisons: Comparisons | None,
) -> Errors:  # fmt: skip
    """Return the errors as `compare` tells them of the model that is proposed; else `own`."""
    if comparisons is None:
        return own
    known = found.before.hypothesis.model
    fit = ahead(found.data, found.linear.fit, found.form)
    bare = replace(fit.hypothesis.model_at(fit.x), modes=known.modes) if effects else known
    return comparisons.errors(known, model_with(known, elements_of(effects), linear), bare, own)


def holds_in_whole_tests(errors: Errors) -> bool:
    """Return whether an effect explains most of whole tests, too, as `compare` runs them.

    By the rule for candidates, which are judged over as long as motions can be predicted: of
    the error beyond the noise it leaves half at most.
    """
    if errors.of_candidates is None:
        return True
    without = errors.held_out.before if errors.without is None else errors.without
    left, was = (
        beyond_noise(one, errors.noise_floor) for one in (errors.held_out.after, without)
    )
    return left <= max(NEGLIGIBLE, SHARE * was)
