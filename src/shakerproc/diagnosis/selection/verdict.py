"""The verdict: which hypothesis stands, which stand beside it, and what is said of the rest."""

from collections.abc import Mapping, Sequence

import numpy as np

from shakerproc.comparison.noise import LEFT
from shakerproc.diagnosis import headline, wording
from shakerproc.diagnosis.estimate import Estimate
from shakerproc.diagnosis.estimation.intervals import (
    estimates,
    far_numbers,
    known_of,
    linear_estimates,
    numbers_off,
)
from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.estimation.of_tests import drift_of, weights_of
from shakerproc.diagnosis.found import Found
from shakerproc.diagnosis.further_ahead import ahead, falls_short
from shakerproc.diagnosis.hypotheses.joints import Joint, carried_force, joints_of
from shakerproc.diagnosis.joint_outcomes import FurtherMode, Locked, mode_notes
from shakerproc.diagnosis.result import Diagnosis, Errors, Finding, Tried, Where
from shakerproc.diagnosis.selection.choice import (
    bare,
    further,
    is_at_fault,
    is_outside,
    leaves_more,
    standing_of,
)
from shakerproc.diagnosis.selection.each_test import (
    Simulated,
    shown_by_one,
    unexplained_tests,
)
from shakerproc.diagnosis.selection.errors import error_of
from shakerproc.diagnosis.selection.faults import doubted, faults_of
from shakerproc.diagnosis.selection.hidden import hidden_of
from shakerproc.diagnosis.selection.next_test import Laboratory
from shakerproc.diagnosis.selection.probability import probability_of, scores_of
from shakerproc.diagnosis.selection.proposing import as_good, proposed, unexercised
from shakerproc.diagnosis.selection.scores import Score
from shakerproc.diagnosis.selection.tried import (
    errors_among,
    errors_told,
    holds_in_whole_tests,
    nothing_named,
    outside_curve,
    outside_text,
    over_whole_tests,
    tried,
    untried,
)
from shakerproc.diagnosis.selection.where import failed_tests, where_it_fails
from shakerproc.diagnosis.selection.which_joint import joint_notes, shared, ties
from shakerproc.diagnosis.updated import Comparisons
from shakerproc.models.effects.base import AbstractEffect, AbstractMemorylessEffect
from shakerproc.testlog import Shaker


def judged(
    found: Found, *, clearances: Sequence[float], shaker: Shaker, seed: int,
    comparisons: Comparisons | None = None,
) -> Diagnosis:  # fmt: skip
    """Return the verdict on what the search found.

    Parameters
    ----------
    found : Found
        All hypotheses, scored.
    clearances : sequence of float
        Free play that the log says the specimens have [m].
    shaker : Shaker
        Limits that a proposed test keeps to.
    seed : int
        Of the tests that are proposed.
    comparisons : Comparisons, optional
        What tells the errors of the model that is proposed, as `compare` does.
    """
    standing = standing_of(found)
    chosen = standing[0] if standing else bare(found)
    data, fit = found.data, ahead(found.data, chosen.fit, found.form)
    (before, after), own = errors_among(found, chosen)
    (alike, tied), (faults, open_ones, at_fault) = ties(standing), _faults(found, chosen)
    far, effects = {} if found.rigid else far_numbers(fit), _effects(fit)
    linear, locked, unclosed = linear_estimates(fit), _locked(found, fit, effects), None
    laboratory = Laboratory(data.tests, data.model, shaker, seed)
    outside = not at_fault and is_outside(found)
    missing = outside or (np.isfinite(found.floor) and leaves_more(found, chosen))
    told_by = None if outside or locked or faults or found.rigid else comparisons
    errors = errors_told(found, effects, linear, own, told_by)
    apart = _doubts(found, chosen, after, errors)
    complete = not (leaves_more(found, chosen) or apart)
    left = Where() if complete else _where(found, chosen, after)
    if outside:
        verdict, sentence, effects = "outside library", outside_text(found, effects, own), []
    elif locked:
        verdict, sentence, effects = "cannot tell", wording.locked_sentence(locked), []
    elif effects:
        verdict, said = "effect found", wording.found_sentence(effects, faults, errors, tied)
        sentence = _with_rest(said, found, chosen, errors, left, after=after, apart=apart)
    elif faults and (at_fault or not missing):
        verdict = "measurement fault"
        sentence = wording.fault_sentence(faults, errors, alone=not missing)
    else:
        unclosed = unexercised(found, clearances)
        verdict, sentence = nothing_named(found, chosen, errors, unclosed, far, apart=apart)
        errors = errors if verdict == "nothing missing" else own
    asked, told = _asked_next(found, chosen, standing, verdict)
    scores, sure = scores_of(found, standing, own), complete and _has_odds(found, chosen)
    return Diagnosis(
        verdict=verdict,  # type: ignore[arg-type]
        sentence=sentence,
        effects=(*effects, *faults),
        indistinguishable=alike if effects else (),
        errors=errors,
        candidates=_candidates(found, chosen, standing),
        where=_where(found, chosen, before),
        next_test=proposed(
            found, standing, laboratory, verdict=verdict, locked=locked, unclosed=unclosed
        ),
        complete=complete,
        left=left,
        locked=locked,
        outside=outside_curve(found) if outside else None,
        linear=linear,
        known_together=() if found.rigid else known_of(fit),
        modes=_further_modes(found),
        further=asked,
        notes=_notes(found, chosen, verdict, told, far, doubted=open_ones, missing=missing),
        hidden=hidden_of(found, fit, (effects, linear), told_by, verdict, seed=seed),
        confidence=shared(probability_of(scores), standing) if sure else None,
        scores=scores,
        seed=seed,
    )


def _has_odds(found: Found, chosen: Score) -> bool:
    """Return whether draws tell how probable a verdict is: not where noise is what is left."""
    known = all(test.noise_density.input_source != LEFT for test in found.data.tests)
    return known and not found.data.model.excitation.imposed and found.is_explained_by(chosen)


def _doubts(found: Found, chosen: Score, after: Simulated, errors: Errors) -> list[str]:
    """Return the sentences on a test, and on times ahead, of which more than noise is left."""
    apart = unexplained_tests(found, chosen, after)
    told = [headline.unexplained_sentence(one) for one in apart[:1]]
    if not leaves_more(found, chosen) and falls_short(found, chosen):
        told.append(headline.short_sentence(found.form.horizon))
    whole = over_whole_tests(found, chosen, errors)
    if not holds_in_whole_tests(whole, effects=bool(chosen.fit.hypothesis.added)):
        told.append(headline.whole_sentence(whole))
    return told


def _faults(found: Found, chosen: Score) -> tuple[list[Finding], list[Finding], bool]:
    """Return faults of the sensors, those in doubt, and whether they explain most."""
    seen = faults_of(found, chosen.fit)
    open_ones = doubted(found, chosen, seen)
    faults = [fault for fault in seen if fault not in open_ones]
    return faults, open_ones, bool(faults) and is_at_fault(found, chosen)


def _with_rest(
    said: str, found: Found, chosen: Score, errors: Errors, left: Where,
    *, after: Simulated, apart: Sequence[str],
) -> str:  # fmt: skip
    """Return the sentence on effects that were found, what no test tells, and what is left."""
    beside = headline.known_sentences(known_of(chosen.fit))
    alone = shown_by_one(found, after)
    if alone is not None:
        beside.append(headline.shown_by_one_sentence(alone))
    if found.is_explained_by(chosen):
        beside += wording.noise_sentences(errors)
    else:
        beside.append(wording.more_sentence(errors, left, found.data.model.motion))
    if not leaves_more(found, chosen):
        beside += apart
    return " ".join([said, *beside])


def _candidates(found: Found, chosen: Score, standing: Sequence[Score]) -> tuple[Tried, ...]:
    """Return all that was tried, by what it leaves, with intervals of what stands."""
    stands, order = [chosen, *as_good(standing)], sorted(found.effects, key=found.left_by)
    fitted = (tried(found, score, stands=score in stands) for score in order)
    return (*fitted, *untried(found))


def _effects(fit: Fit) -> list[Finding]:
    """Return the effects of a fit with their intervals."""
    return [
        Finding(one.kind, one.between, estimates(fit, i), one.identification.scaled_by)
        for i, one in enumerate(fit.hypothesis.added)
    ]


def _joint(found: Found, chosen: Score) -> Joint:
    """Return the joint in question: of the effect that was chosen, else the first one."""
    added = chosen.fit.hypothesis.added
    return added[0].between if added else joints_of(found.data.model)[0]


def _further_modes(found: Found) -> tuple[FurtherMode, ...]:
    """Return the modes that were fitted as linear and are not the model's."""
    known = len(found.before.hypothesis.model.modes)
    return tuple(map(FurtherMode.of, found.data.model.modes[known:]))


def _where(found: Found, chosen: Score, parts: Simulated) -> Where:
    """Return where a model fails, by tests as it simulates them, fitted and held out."""
    return where_it_fails(failed_tests(found.data, _joint(found, chosen), parts))


def _locked(found: Found, fit: Fit, effects: Sequence[Finding]) -> tuple[Locked, ...]:
    """Return the joints with a dry friction that never slipped.

    A force that is above what the joint carries has no upper bound in the tests; one below may
    have none either, where they are short, but a joint slips at it.
    """
    model, tests = fit.hypothesis.model, found.data.tests
    unit = model.unit_of("N")
    out = [Locked(joint, carried_force(model, tests, joint), unit) for joint in found.rigid]
    _own, *parts = fit.hypothesis.parts(fit.x)
    for one, part, effect in zip(fit.hypothesis.added, parts, effects, strict=True):
        numbers = effect.parameters.values()
        forces = [(float(n.value), n.high) for n in numbers if n.unit == unit]
        unbounded = forces and all(high is None for _, high in forces)
        carries = carried_force(model, tests, one.between)
        slips = max((force for force, _ in forces), default=0.0) < carries
        if unbounded and not slips and _is_dry(one.element(part).effect):
            out.append(Locked(one.between, carries, unit))
    return tuple(out)


def _is_dry(effect: AbstractEffect) -> bool:
    """Return whether a force jumps where the velocity turns."""
    return isinstance(effect, AbstractMemorylessEffect) and any(
        switch.variable == "velocity" for switch in effect.switches()
    )


def _notes(
    found: Found, chosen: Score, verdict: str, told: Sequence[str],
    far: Mapping[str, tuple[float, Estimate]], *, doubted: Sequence[Finding], missing: bool,
) -> tuple[str, ...]:  # fmt: skip
    """Return remarks beside the verdict; `told` are notes made before."""
    notes = mode_notes(_further_modes(found), found.linear_model.driven, found.data.tests)
    if found.data.plain is not found.data:
        notes.append(_own_note(found, chosen))
    if found.data.points:
        notes.append(
            "Accelerations are compared as values at the samples: the recorder took jumps "
            "without a filter."
        )
    if not any(test.arrays.hold_out for test in found.data.tests):
        notes.append(
            "No test is marked hold_out: true; the held-out error is of a third of the "
            "tests, in blocks, which took no part in the fit."
        )
    notes += [f"Left out: {name} ({why})." for name, why in found.failed.items()]
    if far and verdict != "cannot tell":
        notes.append(wording.far_sentence(far))
    if verdict == "effect found":
        notes += headline.off_sentences(numbers_off(chosen.fit))
    notes += told
    if verdict == "measurement fault" and missing:
        notes.append(wording.unnamed_note(found.left_by(chosen), found.floor_under(chosen)))
    if doubted:
        notes.append(wording.doubted_note(doubted))
    return tuple(notes)


def _own_note(found: Found, chosen: Score) -> str:
    """Return the numbers of each test alone, and the error where tests are taken as alike."""
    data, of_tests = found.data, found.of_tests_under(chosen.fit)
    left = error_of(data.plain, chosen.fit, found.form.held_out)
    return wording.own_note(weights_of(data, of_tests), drift_of(data, of_tests), left)


def _asked_next(
    found: Found, stands: Score, standing: Sequence[Score], verdict: str
) -> tuple[tuple[str, ...], list[str]]:
    """Return the kinds to add next, and the notes on joints and on what is left."""
    elsewhere = joint_notes(found, standing)
    if verdict in {"cannot tell", "measurement fault"}:
        return (), elsewhere
    if verdict == "outside library" and stands.fit.hypothesis.added:
        return stands.fit.hypothesis.kinds, elsewhere
    more = further(found, stands)
    if more is None:
        return (), elsewhere
    kinds = tuple(kind for kind, _ in more.fit.hypothesis.names - stands.fit.hypothesis.names)
    left = found.left_by(stands), found.left_by(more)
    return kinds, [*elsewhere, wording.further_note(kinds, *left)]
