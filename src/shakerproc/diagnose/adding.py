"""One effect fitted beside the model, and the element that goes into the model file."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from shakerproc.diagnose.arrays import no_correction
from shakerproc.diagnose.candidates import sought
from shakerproc.diagnose.decide import error_of, estimates, kinds, linear_estimates
from shakerproc.diagnose.fit import Fit
from shakerproc.diagnose.free_run import friction_fits
from shakerproc.diagnose.pipeline import Stage, screened
from shakerproc.diagnose.problem import Parameters
from shakerproc.diagnose.search import DRY, Context, annealed, refit
from shakerproc.diagnose.translate import Skeleton, skeleton, start_parameters
from shakerproc.diagnosis.adding import NO_START, Added, shortened
from shakerproc.diagnosis.data.from_files import arrays, tests_of
from shakerproc.diagnosis.result import Errors, Pair
from shakerproc.diagnosis.updated import effect_of, with_numbers
from shakerproc.errors import DiagnosisError
from shakerproc.models import BASE, EFFECTS, Element, Model
from shakerproc.models.identification import Values
from shakerproc.testlog import TestLog


def add(
    kind: str,
    model: Model,
    log: TestLog,
    *,
    between: Sequence[str] | None = None,
    start: Values = NO_START,
    force: bool = False,
    progress: Callable[[str], None] | None = None,
) -> Added:
    """Return an effect fitted jointly with the linear model to the tests of a log.

    Raises
    ------
    DiagnosisError
        If the effect is unknown to the search, does not fit these tests at all, or is no gain.
    """
    if start:
        raise DiagnosisError("this search takes no numbers to start from; leave --start out.")
    found = _fitted(kind, model, log, between, progress)
    if found.worse and not force:
        places = " and ".join(found.element.between)
        raise DiagnosisError(f"{kind} between {places}: {found.worse}.")
    return found


def _fitted(
    kind: str,
    model: Model,
    log: TestLog,
    between: Sequence[str] | None,
    progress: Callable[[str], None] | None,
) -> Added:
    if kind not in EFFECTS:
        raise DiagnosisError(f"no effect {kind!r}; there are {', '.join(EFFECTS)}.")
    if kind not in sought():
        raise DiagnosisError(
            f"{kind} is not fitted; write it into the model file by hand, its numbers are in "
            f"`shakerproc effects {kind}`."
        )
    for place in between or ():
        if place not in {BASE, *model.masses}:
            there = ", ".join([BASE, *model.masses])
            raise DiagnosisError(f"{model.title}: no place {place!r}; there are {there}.")
    say = progress or (lambda _text: None)
    usable = tests_of(log, model)
    measured = usable.tests
    known = skeleton(model, tuple(measured[0].sensors))
    tests = tuple(arrays(m) for m in measured)
    base, start = start_parameters(known)
    say("linear model and screening")
    stage = screened(known.structure, tests, no_correction(len(known.sensors)), start)
    wanted = [
        s for s in stage.starts
        if s.last.candidate.kind == kind
        and (between is None or _same(known, s.last.joint, between))
    ]  # fmt: skip
    if not wanted:
        raise DiagnosisError(
            f"{kind} explains nothing of these tests with physical numbers in any joint the "
            "sensors can judge; see `shakerproc diagnose` for what does."
        )
    none = stage.at.fit(base, stage.p, stage.bench.short, 0)
    if none is None:
        raise DiagnosisError(f"{model.title}: the model is unstable; check its stiffness.")
    say("the effect")
    final, fits = annealed(stage.at, none, wanted, stage.remaining(wanted), (start,))
    say("whole tests")
    if kind in DRY:
        final, fits = _without_correction(final, fits, stage, start, none)
    bench = final.bench
    fits = refit(final, fits[:1], bench.fitted(), 3, sensors=True)
    if not fits:
        raise DiagnosisError(f"{kind} cannot be fitted to these tests; its motion runs away.")
    fit = fits[0]
    kept = bench.kept()
    numbers = estimates(fit, len(fit.hypothesis.terms) - 1)
    term = fit.hypothesis.terms[-1]
    errors = [
        [error_of(final, hypothesis, p, part) for part in (bench.fitted(), kept)]
        for hypothesis, p in ((base, start), (fit.hypothesis, fit.parameters))
    ]
    before, after = errors[0][1], errors[1][1]
    linear = {
        f"{name} {'-'.join(known.between(i))}": one
        for i, both in enumerate(linear_estimates(fit))
        for name, one in zip(("stiffness", "damping"), both, strict=True)
    }
    element = Element(
        effect_of(kind, {n: replace(e, value=shortened(e)) for n, e in numbers.items()}),
        known.between(term.joint),
    )
    own = {name: replace(one, value=shortened(one)) for name, one in linear.items()}
    updated = with_numbers(model, own)
    return Added(
        model=replace(updated, elements=(*updated.elements, element)),
        element=element,
        parameters=numbers,
        linear=linear,
        errors=Errors(Pair(errors[0][0], errors[1][0]), Pair(before, after), float("nan")),
        tests=tuple(m.name for m in measured if not m.test.hold_out),
        left_out=usable.left_out,
        worse=_worse(final, none, fit, before, after),
        sha256={m.name: m.sha256 for m in measured},
    )


def _worse(at: Context, none: Fit, fit: Fit, before: float, after: float) -> str:
    """Return why an effect is no gain: over the model as it is, or with its numbers fitted.

    Over the fitted model the squares of the error must fall by more than their standard error
    over the pieces that took no part in the fit.
    """
    if not after < before:
        return f"the held-out error does not fall, {before:.3g} -> {after:.3g}"
    alone = refit(at, [none], at.bench.fitted(), 3, sensors=True)
    if not alone:
        return ""
    kept = at.bench.kept()
    left = np.array([
        [error_of(at, one.hypothesis, one.parameters, (piece,)) for piece in kept]
        for one in (alone[0], fit)
    ])
    gains = left[0] ** 2 - left[1] ** 2
    spread = float(gains.std(ddof=1) / np.sqrt(gains.size)) if gains.size > 1 else 0.0
    if gains.mean() > spread:
        return ""
    fitted = error_of(at, alone[0].hypothesis, alone[0].parameters, kept)
    return (
        f"the held-out error falls no further than without it, {before:.3g} -> {fitted:.3g} "
        f"with the model's own numbers fitted, {after:.3g} with the effect"
    )


def _without_correction(
    at: Context, fits: list[Fit], stage: Stage, start: Parameters, base: Fit
) -> tuple[Context, list[Fit]]:
    """Return the same dry friction by free runs, where they tell it more closely."""
    found = friction_fits(stage.bench, start, base, fits)
    if found is None or not fits:
        return at, fits
    free, rubbed = found
    own = [fit for fit in rubbed if kinds(fit) == kinds(fits[0])]
    if not own:
        return at, fits
    left = [
        error_of(one, fit.hypothesis, fit.parameters, one.bench.short, robust=True)
        for one, fit in ((at, fits[0]), (free, own[0]))
    ]
    return (free, own) if left[1] < left[0] else (at, fits)


def _same(known: Skeleton, joint: int, between: Sequence[str]) -> bool:
    return set(known.between(joint)) == set(between)
