"""An effect fitted to the tests of a log, and the model with it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import final

from shakerproc.comparison.free_run_error import fall
from shakerproc.diagnosis.data import TestArrays, check, prepared
from shakerproc.diagnosis.data.from_files import arrays, tests_of
from shakerproc.diagnosis.estimate import Estimate
from shakerproc.diagnosis.estimation.intervals import estimates, linear_estimates
from shakerproc.diagnosis.estimation.windows import whole_tests
from shakerproc.diagnosis.joint_outcomes import FurtherMode, mode_notes
from shakerproc.diagnosis.one_effect import Fitted, fitted_effect
from shakerproc.diagnosis.result import BeforeAfter, Errors
from shakerproc.diagnosis.selection.errors import (
    error_of,
    error_of_scored,
    floors_of,
    pooled_floor,
    scored_tests,
)
from shakerproc.diagnosis.updated import Comparisons, effect_of, model_with
from shakerproc.diagnosis.wanted import Wanted
from shakerproc.diagnosis.wording import whole_note
from shakerproc.errors import DiagnosisError
from shakerproc.model_files.writing import within
from shakerproc.models import EFFECTS, Element, Mode, Model
from shakerproc.models.effects import Table
from shakerproc.models.effects.base import UNSCALED
from shakerproc.models.own_effects import TYPICAL
from shakerproc.testlog import TestLog


@final
@dataclass(frozen=True, slots=True)
class Added:
    """A fitted effect and what it does to the errors.

    Attributes
    ----------
    model : Model
        The model with the effect and its own numbers as fitted, each with as many digits as its
        interval bears out.
    element : Element
        The effect as it stands in that model.
    parameters : mapping of str to Estimate
        Its numbers with 95 % intervals; none of a table, whose band tells them.
    linear : mapping of str to Estimate
        The model's own numbers, fitted with it.
    errors : Errors
        The free-run error before and after.
    without : Model
        The model with its own numbers fitted, but without the effect.
    tests : tuple of str
        Tests it was fitted to.
    modes : tuple of Mode
        Further linear modes that were fitted first and that the model has not.
    left_out : tuple of str
        Tests that took no part since a channel did not measure, a sentence each.
    worse : str
        Why the effect is no gain, in a sentence; empty where it is one.
    sha256 : mapping of str to str
        Hash of the recording of each test, as it was read.
    notes : tuple of str
        What the reader must know besides, a sentence each.
    """

    model: Model
    element: Element
    parameters: Mapping[str, Estimate]
    linear: Mapping[str, Estimate]
    errors: Errors
    without: Model
    tests: tuple[str, ...]
    modes: tuple[Mode, ...] = ()
    left_out: tuple[str, ...] = ()
    worse: str = ""
    sha256: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def add(
    wanted: Wanted,
    model: Model,
    log: TestLog,
    *,
    force: bool = False,
    progress: Callable[[str], None] | None = None,
    warn: Callable[[str], None] = lambda _text: None,
) -> Added:
    """Return a model with one effect more, fitted jointly with its own numbers to a log.

    Parameters
    ----------
    wanted : Wanted
        The effect, where it stands and where its fit starts.
    model : Model
        The model as it is.
    log : TestLog
        The tests; those with ``hold_out: true`` are only scored.
    force : bool
        Whether to return it even where it is no gain.
    progress : callable, optional
        Called with what is being done.
    warn : callable
        Told, before the work, which tests are left out and of faulty channels.

    Raises
    ------
    DiagnosisError
        If there is no such effect, it does not fit these tests, or the held-out free-run error
        does not fall by more than its standard error.
    ShakerprocError
        If a recording cannot be used.
    """
    usable = tests_of(log, model)
    usable.tell(warn)
    measured = usable.tests
    found = add_to_arrays(
        wanted,
        model,
        [arrays(m) for m in measured],
        sensors=measured[0].sensors,
        force=force,
        progress=progress,
    )
    comparisons = Comparisons(measured, progress or (lambda _text: None))
    errors = comparisons.errors(model, found.model, found.without, found.errors)
    return replace(
        found,
        errors=errors,
        tests=tuple(m.name for m in measured if not m.test.hold_out),
        left_out=usable.left_out,
        notes=(*usable.notes, *found.notes),
        sha256={m.name: m.sha256 for m in measured},
    )


def add_to_arrays(
    wanted: Wanted,
    model: Model,
    tests: Sequence[TestArrays],
    *,
    sensors: Sequence[str] | None = None,
    force: bool = False,
    progress: Callable[[str], None] | None = None,
) -> Added:
    """Return the updated model for samples in memory, responses in the order of `sensors`.

    Raises
    ------
    DiagnosisError
        If there is no such effect, it does not fit these tests, or is no gain.
    """
    _check_wanted(wanted, model, tests)
    names = tuple(model.sensors if sensors is None else sensors)
    for test in tests:
        check(test, len(names))
    known = replace(model, sensors={name: model.sensors[name] for name in names})
    say = progress or (lambda _text: None)
    fitted = fitted_effect(
        known, prepared(tests, imposed=known.excitation.imposed), wanted, say
    )
    say("errors")
    found = _added(model, fitted)
    if found.worse and not force:
        raise DiagnosisError(
            f"{wanted.kind} between {' and '.join(found.element.between)}: {found.worse}."
        )
    return found


def _check_wanted(wanted: Wanted, model: Model, tests: Sequence[TestArrays]) -> None:
    """Pass an effect and a joint that are known, scaled by a condition that tests say.

    Raises
    ------
    DiagnosisError
        If they are not, or the effect cannot be fitted or scaled.
    ModelError
        If a test does not say the condition.
    """
    kind, between, scale = wanted.kind, wanted.between, wanted.scaled_by
    if kind not in EFFECTS:
        raise DiagnosisError(f"no effect {kind!r}; there are {', '.join(EFFECTS)}.")
    if EFFECTS[kind].identification(TYPICAL) is None and kind != Table.kind:
        raise DiagnosisError(
            f"{kind} is not fitted; write it into the model file by hand, its numbers are in "
            f"`shakerproc effects {kind}`."
        )
    there = ", ".join(model.places)
    for place in between or ():
        if place not in model.places:
            raise DiagnosisError(f"{model.title}: no place {place!r}; there are {there}.")
    if between is not None and between[0] == between[1]:
        raise DiagnosisError(f"{model.title}: an effect stands between two of {there}.")
    if scale is None:
        return
    why = "it is found by regression alone" if wanted.is_free_law else UNSCALED.get(kind)
    if why is not None:
        raise DiagnosisError(f"{kind} cannot be scaled by {scale.condition}: {why}.")
    for test in tests:
        scale.share(test.conditions)


def _added(model: Model, fitted: Fitted) -> Added:
    """Return the result of a fit."""
    fit, without = fitted.fit, fitted.without.fit
    numbers = estimates(fit, -1) if fit.hypothesis.added else {}
    linear = linear_estimates(fit)
    errors, worse = _errors(fitted)
    element = _in_few_digits(fitted.element, numbers)
    modes = fitted.data.model.modes[len(model.modes) :]
    return Added(
        model=model_with(model, [element], linear),
        element=element,
        parameters=numbers,
        linear=linear,
        errors=errors,
        without=replace(without.hypothesis.model_at(without.x), modes=model.modes),
        tests=tuple(t.name for t in fitted.data.tests if not t.arrays.hold_out),
        modes=modes,
        worse=worse,
        notes=(
            *mode_notes(
                [FurtherMode.of(mode) for mode in modes], fitted.driven, fitted.data.tests
            ),
            *worse_whole(fitted),
        ),
    )


def worse_whole(fitted: Fitted) -> list[str]:
    """Return the note that whole tests from rest are predicted worse, though parts better."""
    data, horizon = fitted.data.plain, fitted.form.horizon
    if horizon is None or data.model.excitation.role is None:
        return []
    whole = whole_tests(data, held_out=True)
    was, now = (error_of(data, one, whole) for one in (fitted.before, fitted.fit))
    return [whole_note(was, now, horizon)] if now > was else []


def _errors(fitted: Fitted) -> tuple[Errors, str]:
    """Return the free-run errors before and after, and why the effect is no gain.

    It has to be one over the model as it is and over the same with its own numbers fitted.
    """
    data, form = fitted.data, fitted.form
    after = fitted.with_effect.fit
    before_held, alone, held = (
        scored_tests(data, one, form.held_out)
        for one in (fitted.before, fitted.without.fit, after)
    )
    errors = Errors(
        BeforeAfter(
            *(error_of(data, one, form.scored_fitted) for one in (fitted.before, after))
        ),
        BeforeAfter(error_of_scored(before_held), error_of_scored(held)),
        pooled_floor(floors_of(data, after, form.held_out)),
        {test.name: form.horizon for test in data.tests},
    )
    was, now, own = errors.held_out.before, errors.held_out.after, error_of_scored(alone)
    if not now < was:
        return errors, f"the held-out error does not fall, {was:.3g} -> {now:.3g}"
    if alone is None or held is None:
        return errors, ""
    less, spread = fall(tuple(alone.values()), tuple(held.values()))
    if less > spread:
        return errors, ""
    return errors, (
        f"the held-out error falls no further than without it, {was:.3g} -> {own:.3g} with the "
        f"model's own numbers fitted, {now:.3g} with the effect (standard error {spread:.2g})"
    )


def _in_few_digits(element: Element, numbers: Mapping[str, Estimate]) -> Element:
    """Return an element with as many digits as its intervals bear out, a table with six."""
    if isinstance(element.effect, Table):
        return replace(element, effect=_rounded(element.effect))
    return replace(element, effect=effect_of(element.effect.kind, numbers))


def _rounded(table: Table) -> Table:
    """Return a table with six digits of every number."""

    def row(values: Sequence[float], unit: str) -> tuple[float, ...]:
        return tuple(within(value, unit, None, None) for value in values)

    def rows(values: Sequence[Sequence[float]]) -> tuple[tuple[float, ...], ...]:
        return tuple(row(one, "N") for one in values)

    return Table(
        row(table.displacement, "m"),
        row(table.velocity, "m/s"),
        rows(table.force),
        None if table.band is None else rows(table.band),
    )
