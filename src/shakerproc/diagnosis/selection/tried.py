"""The hypotheses that were tried, as a diagnosis lists them."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from shakerproc.diagnosis import headline, wording
from shakerproc.diagnosis.estimate import Estimate
from shakerproc.diagnosis.estimation.intervals import estimates, numbers, numbers_off
from shakerproc.diagnosis.found import Found, is_within
from shakerproc.diagnosis.further_ahead import ahead
from shakerproc.diagnosis.joint_outcomes import Outside
from shakerproc.diagnosis.result import BeforeAfter, Errors, Finding, Tried
from shakerproc.diagnosis.selection.choice import NEGLIGIBLE, SHARE, bare, leaves_more
from shakerproc.diagnosis.selection.each_test import Simulated, simulated_by
from shakerproc.diagnosis.selection.errors import (
    beyond_noise,
    error_of,
    error_of_scored,
    floors_of,
    pooled_floor,
    scored_tests,
)
from shakerproc.diagnosis.selection.proposing import Unexercised
from shakerproc.diagnosis.selection.scores import Score
from shakerproc.diagnosis.updated import Comparisons, elements_of, model_with
from shakerproc.models.effects import Table


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
    """Return effects that fell behind, with what they left where runs were held as then."""
    return [
        Tried(
            "+".join(one.hypothesis.kinds), last.between, None, None,
            {name: Estimate(word, None, None, "") for name, word in last.words.items()},
            float(np.sqrt(one.chi_square)),
        )
        for one in sorted(found.behind, key=lambda one: one.chi_square)
        for last in one.hypothesis.added[-1:]
    ]  # fmt: skip


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
        BeforeAfter(fitted, error_of_scored(after[0])),
        BeforeAfter(held_out, found.left_by(chosen)),
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


def holds_in_whole_tests(errors: Errors, *, effects: bool) -> bool:
    """Return whether whole tests are explained, too, as `compare` runs them.

    By the rule for candidates, which are judged over as long as motions can be predicted: of
    the error beyond the noise effects leave half at most. Without any no more than noise may be
    left, or what sensors are calibrated to.
    """
    if errors.of_candidates is None:
        return True
    left, floor = errors.held_out.after, errors.noise_floor
    if not effects:
        return left <= NEGLIGIBLE or not np.isfinite(floor) or is_within(left, floor)
    without = errors.held_out.before if errors.without is None else errors.without
    beyond, was = (beyond_noise(one, floor) for one in (left, without))
    return beyond <= max(NEGLIGIBLE, SHARE * was)


def over_whole_tests(found: Found, chosen: Score, errors: Errors) -> Errors:
    """Return the errors of whole tests with all that is fitted and that `compare` has not.

    Further modes, what each test has of its own, and corrections of sensors are no finding. The
    errors are those of `compare` where there is none of that, and where no whole test can be
    run.
    """
    modes = len(found.data.model.modes) > len(found.before.hypothesis.model.modes)
    differs = found.data.plain is not found.data or found.as_recorded is not found.data
    run = found.free_run(chosen) if modes or differs else None
    if run is None or errors.of_candidates is None:
        return errors
    alone = found.free_run(found.linear) if chosen.fit.hypothesis.added else None
    return replace(
        errors,
        held_out=BeforeAfter(
            errors.held_out.before, error_of(found.data, run.fit, found.whole)
        ),
        noise_floor=pooled_floor(floors_of(found.data, run.fit, found.whole)),
        without=None if alone is None else error_of(found.data, alone.fit, found.whole),
    )


def nothing_named(
    found: Found,
    chosen: Score,
    errors: Errors,
    unclosed: Unexercised | None,
    far: Mapping[str, tuple[float, Estimate]],
    *,
    apart: Sequence[str],
) -> tuple[str, str]:
    """Return the verdict where nothing was found: a clearance may never have been closed.

    `apart` are sentences on where it does not hold.
    """
    which = "the fitted model" if chosen is found.linear else "the model as it is in its file"
    unnamed = wording.unnamed_sentence(errors.among, which, _least(found))
    known = np.isfinite(errors.noise_floor)
    if known and leaves_more(found, chosen):
        return "cannot tell", unnamed
    if far:
        return "cannot tell", wording.far_sentence(far)
    if unclosed is not None:
        sentence = wording.unexercised_sentence(
            unclosed.clearance, unclosed.reach, found.data.model.motion
        )
        return "cannot tell", sentence
    if not known:
        return "cannot tell", unnamed
    if apart:
        sentence = f"{unnamed} {apart[0]}"
        return "cannot tell", sentence
    complete = found.is_explained_by(chosen)
    said = [wording.nothing_sentence(errors, which, complete=complete)]
    if chosen is found.linear:
        said += headline.off_sentences(numbers_off(chosen.fit))
    return "nothing missing", " ".join(said)


def outside_text(found: Found, effects: Sequence[Finding], errors: Errors) -> str:
    """Return the verdict that no effect will do, and which one to add meanwhile."""
    free = found.free or found.best
    return wording.outside_sentence(
        found.left_by(free), _least(found)[1], found.floor, effects, errors
    )


def _least(found: Found) -> tuple[str, float]:
    """Return the name of what leaves least of all that was tried, and what it leaves [-]."""
    best = min((bare(found), found.linear, *found.effects), key=found.left_by)
    kinds = " and ".join(kind.replace("_", " ") for kind in best.fit.hypothesis.kinds)
    return kinds or "the fitted model", found.left_by(best)


def outside_curve(found: Found) -> Outside | None:
    """Return the force without a name as a curve [N] over motion [m], [m/s]."""
    if found.free is None:
        return None
    element = found.free.fit.hypothesis.model.elements[-1]
    table = element.effect
    if not isinstance(table, Table):
        return None
    band = table.band or tuple(tuple(0.0 for _ in row) for row in table.force)
    motion = found.data.model.motion
    return Outside(
        element.between, table.displacement, table.velocity, table.force, band, motion
    )
