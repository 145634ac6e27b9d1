"""The search: linear model, screening, growing windows, the horizon, held-out scores."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Final, final

from shakerproc.diagnosis.beside import with_all, with_pairs_ahead
from shakerproc.diagnosis.campaign import Campaign, campaign_of, own_numbers
from shakerproc.diagnosis.data import Test
from shakerproc.diagnosis.data.sensor_faults import hum_of
from shakerproc.diagnosis.differing import alone, scales_between, where_tests_differ
from shakerproc.diagnosis.estimation.beginnings import as_in
from shakerproc.diagnosis.estimation.correction import (
    corrected,
    explains,
    is_unusual,
    residuals_of,
    turned,
    turned_and_late,
    without_driven,
    without_hum,
)
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.form import usable_forms
from shakerproc.diagnosis.estimation.growth import Condition
from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.estimation.linear import (
    LINEAR_ENOUGH,
    fit_linear,
)
from shakerproc.diagnosis.estimation.linear_model import LinearModel
from shakerproc.diagnosis.estimation.one_more import OneMore
from shakerproc.diagnosis.found import Found
from shakerproc.diagnosis.horizon import is_mostly_noise
from shakerproc.diagnosis.hypotheses.joints import Known
from shakerproc.diagnosis.mode_beside import with_modes_beside
from shakerproc.diagnosis.more_effects import hidden_pairs, with_more
from shakerproc.diagnosis.nudged.many_joints import raced
from shakerproc.diagnosis.outcome import Outcome, at_the_horizon, told, widened
from shakerproc.diagnosis.rigid import rigid_joints
from shakerproc.diagnosis.screening import Start, in_likely_joints, known_of, screen, widening
from shakerproc.diagnosis.selection.choice import needs_none, wants_more
from shakerproc.diagnosis.selection.each_test import doubtful
from shakerproc.diagnosis.selection.errors import error_of
from shakerproc.models import Model, Scale

MUCH: Final = 0.5
"""Level (see `Fit`) over that of the model without any effect below which an effect explains
enough to be judged before others are tried [-]."""


def search(model: Model, tests: Sequence[Test], say: Callable[[str], None]) -> Found:
    """Return which effects explain the tests, and how well.

    Parameters
    ----------
    model : Model
        The model as it is.
    tests : sequence of Test
        Those that are held out are only scored.
    say : callable
        Called with what is being tried.

    Raises
    ------
    DiagnosisError
        If the tests leave nothing to judge by; before the long work.
    """
    usable_forms(DataSet(model, tuple(tests)))
    if model.excitation.role is None:
        return _begun(model, fit_linear(model, tests), tests, say).ended(say)
    say("linear model")
    signs, late = turned_and_late(model, tests)
    found = _with_chain(model, turned(tests, signs, late), say)
    return replace(
        found,
        signs=tuple(map(float, signs)),
        late=tuple(map(float, late)),
        recorded=tuple(tests),
    )


def _with_chain(model: Model, tests: Sequence[Test], say: Callable[[str], None]) -> Found:
    """Return the search for sensors the right way round, corrected where that is better."""
    linear = fit_linear(model, tests)
    tests = without_driven(tests, linear)
    residuals = residuals_of(linear, tests)
    hums = hum_of(residuals, [test.sample_rate for test in tests])
    if hums:
        say("the hum of the mains taken away")
        tests = without_hum(tests, residuals, hums)
        linear = replace(fit_linear(model, tests), driven=linear.driven)
    return replace(_corrected_or_not(model, linear, tests, say), hums=hums)


def _corrected_or_not(
    model: Model,
    linear: LinearModel,
    tests: Sequence[Test],
    say: Callable[[str], None],
) -> Found:
    """Return the search with the tests as recorded or corrected, whichever leaves less.

    Where tests differ in a condition, with effects that it scales as well, if those that are
    the same in all tests leave more than noise, and much more than these.
    """
    corrections: tuple[bool, ...] = (False,)
    if is_unusual(linear):
        corrections = (True, False) if explains(linear) else (False, True)
    ways: list[Begun] = []
    for scale in (None, *scales_between(tests)):
        begun: list[Begun] = []
        for correct in corrections:
            if correct:
                say("the chain of measurement corrected")
            own = corrected(tests, linear) if correct else tests
            one = _begun(model, linear, own, say, scale)
            begun.append(replace(one, found=replace(one.found, corrected=correct)))
            if begun[-1].is_enough:
                return begun[-1].ended(say)
        ways.append(min(begun, key=lambda one: one.found.left))
    alike, least = ways[0], min(ways, key=lambda one: one.found.left)
    return (least if least.found.left < MUCH * alike.found.left else alike).ended(say)


@final
@dataclass(frozen=True, eq=False)
class Begun:
    """Findings with one effect at most, and the state from which the search goes on.

    Attributes
    ----------
    found : Found
        Without and with one effect, or two that hide each other.
    outcome : Outcome
        The same at the horizon.
    every : callable
        Returns every effect as far as it was fitted, those that seemed not worth it, too.
    known : mapping of joint to mapping of str to Identification
        Laws that may be missing.
    """

    found: Found
    outcome: Outcome
    every: Callable[[], Sequence[Fit]] = tuple
    known: Known = field(default_factory=dict)

    @cached_property
    def is_enough(self) -> bool:
        """Whether no more is to be looked for."""
        found = self.found
        return bool(found.rigid) or (
            found.is_enough and not wants_more(found) and not doubtful(found)
        )

    def ended(self, say: Callable[[str], None]) -> Found:
        """Return the findings with pairs of effects, where these are to be looked for."""
        found, first = self.found, self.outcome
        campaign, alone = first.campaign, bool(found.data.model.structures)
        if not self.is_enough and not needs_none(found) and not alone:
            found, campaign, forms = with_more(found, campaign, first.forms, first.singles, say)
            found = with_all(found, campaign, forms, self.every, say, known=self.known)
        return with_pairs_ahead(found, campaign, self.known, say)


def _begun(
    original: Model,
    linear_model: LinearModel,
    tests: Sequence[Test],
    say: Callable[[str], None],
    scaled_by: Scale | None = None,
) -> Begun:
    """Return the explanations of tests on top of a linear model.

    `scaled_by` is the condition that scales every effect that may be missing.

    Raises
    ------
    DiagnosisError
        If the model runs away in every test, or the tests are too short.
    """
    model = replace(original, modes=linear_model.model.modes)
    campaign = campaign_of(model, tests, scaled_by)
    forms = usable_forms(campaign.data)
    if scaled_by is not None:
        say(f"effects scaled by {scaled_by.condition}")
    say("the model's own numbers")
    linear = own_numbers(campaign, linear_model)
    rigid = rigid_joints(campaign.data)
    if rigid:
        say(f"{' and '.join(rigid[0])} held in every test")
        outcome = at_the_horizon(campaign, linear, [], say)
        one = told(original, linear_model, outcome, {}, ())
        return Begun(replace(one, rigid=rigid), outcome)
    is_near = not original.structures or (
        error_of(campaign.data, linear, forms[-1].held_out) < LINEAR_ENOUGH
    )
    campaign, explained = alone(campaign, linear, forms[-1]) if is_near else (campaign, False)
    if original.structures:
        return _in_structures(
            original, linear_model, campaign, linear, say, explained=explained
        )
    say("screening")
    known = campaign.known
    starts = screen(model, campaign.fitted, tuple(known), known, explained=explained)
    one_more = OneMore(
        campaign.data,
        linear,
        known,
        campaign.stages,
        linear=as_in(linear.hypothesis, linear_model.model),
        say=say,
        condition=Condition(explained=explained),
    )
    begun: list[Begun] = []
    near = in_likely_joints(starts, known)
    for outcome in _outcomes(campaign, linear, near, one_more, say):
        one = told(original, linear_model, outcome, one_more.failed, starts)
        begun.append(Begun(one, outcome, lambda: one_more.every(near), known_of(near, known)))
        if begun[-1].is_enough:
            break
    last = begun[-1]
    other = where_tests_differ(last.outcome, say, explained=last.found.explained)
    if other is not None:
        one = told(original, linear_model, other, one_more.failed, starts)
        last = replace(last, found=one, outcome=other)
    if last.is_enough or needs_none(last.found):
        return last
    more = with_modes_beside(last.outcome, linear_model, tests, say)
    return last if more is None else _begun(original, *more, say, scaled_by)


def _in_structures(
    original: Model,
    linear_model: LinearModel,
    campaign: Campaign,
    linear: Fit,
    say: Callable[[str], None],
    *,
    explained: bool,
) -> Begun:
    """Return the hypotheses that explain tests of structures; none where the model does."""
    if explained:
        outcome = at_the_horizon(campaign, linear, [], say)
        return Begun(told(original, linear_model, outcome, {}, ()), outcome)
    one = raced(campaign, linear_model, campaign.known, say)
    campaign = replace(campaign, data=one.base.data)
    outcome = at_the_horizon(campaign, one.base, one.fits, say)
    return Begun(told(original, linear_model, outcome, one.failed, ()), outcome)


def _outcomes(
    campaign: Campaign,
    linear: Fit,
    starts: Sequence[Start],
    one_more: OneMore,
    say: Callable[[str], None],
) -> Iterator[Outcome]:
    """Yield findings as the circle of effects that are tried widens; all at last."""
    first = None
    explained = one_more.condition.explained
    for circle in () if explained else widening(starts, campaign.known):
        singles = one_more.found(circle)
        if first is not None and set(singles) <= set(first.singles):
            continue
        if any(one.level < MUCH * linear.level for one in singles):
            here = replace(campaign, data=one_more.data)
            first = widened(first, singles) if first is not None else None
            first = first or at_the_horizon(here, linear, singles, say, one_more=one_more)
            yield first
    singles = one_more.found(starts)
    campaign, hidden = replace(campaign, data=one_more.data), list[Fit]()
    best = min((linear, *singles), key=lambda one: one.level)
    if not is_mostly_noise(campaign, best):
        left = min((start.left for start in starts), default=0.0)
        hidden = hidden_pairs(campaign, linear, one_more.least, left, say)
        campaign = replace(campaign, data=hidden[0].data) if hidden else campaign
    first = widened(first, singles) if first is not None and not hidden else None
    yield first or at_the_horizon(
        campaign, linear, singles, say, one_more=one_more, hidden=hidden
    )
