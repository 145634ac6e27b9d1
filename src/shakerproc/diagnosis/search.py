"""The search: linear model, the race of effects, the horizon, held-out scores."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final, final

from shakerproc.diagnosis.beside import with_all, with_pairs_ahead
from shakerproc.diagnosis.campaign import campaign_of, own_numbers, raced_alone
from shakerproc.diagnosis.data import PreparedTest
from shakerproc.diagnosis.data.sensor_faults import hum_of
from shakerproc.diagnosis.differing import alone, scales_between, where_tests_differ
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
from shakerproc.diagnosis.estimation.linear import (
    LINEAR_ENOUGH,
    fit_linear,
)
from shakerproc.diagnosis.estimation.linear_model import LinearModel
from shakerproc.diagnosis.found import Found
from shakerproc.diagnosis.mode_beside import with_modes_beside
from shakerproc.diagnosis.more_effects import with_more
from shakerproc.diagnosis.outcome import Outcome, at_the_horizon, told
from shakerproc.diagnosis.progress import Progress
from shakerproc.diagnosis.rigid import rigid_joints
from shakerproc.diagnosis.selection.choice import needs_none, wants_more
from shakerproc.diagnosis.selection.each_test import doubtful
from shakerproc.diagnosis.selection.errors import error_of
from shakerproc.models import Model, Scale

MUCH: Final = 0.5
"""Level (see `Fit`) over that of the model without any effect below which an effect explains
enough to be judged before others are tried [-]."""


def search(model: Model, tests: Sequence[PreparedTest], say: Progress) -> Found:
    """Return which effects explain the tests, and how well.

    Parameters
    ----------
    model : Model
        The model as it is.
    tests : sequence of PreparedTest
        Those that are held out are only scored.
    say : Progress
        Called with what is being tried, and asked whether there is time for more.

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


def _with_chain(model: Model, tests: Sequence[PreparedTest], say: Progress) -> Found:
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
    tests: Sequence[PreparedTest],
    say: Progress,
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
        if scale is not None and not say.has_time_for(f"effects scaled by {scale.condition}"):
            continue
        begun: list[Begun] = []
        for correct in corrections:
            way = "the chain of measurement corrected" if correct else "tests as recorded"
            if begun and not say.has_time_for(way):
                break
            if correct and not begun:
                say(way)
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
        Without and with one effect.
    outcome : Outcome
        The same at the horizon.
    """

    found: Found
    outcome: Outcome

    @cached_property
    def is_enough(self) -> bool:
        """Whether no more is to be looked for."""
        found = self.found
        return bool(found.rigid) or (
            found.is_enough and not wants_more(found) and not doubtful(found)
        )

    def ended(self, say: Progress) -> Found:
        """Return the findings with pairs of effects, where these are to be looked for."""
        found, first = self.found, self.outcome
        campaign, alone = first.campaign, bool(found.data.model.structures)
        if not self.is_enough and not needs_none(found) and not alone:
            found, campaign, forms = with_more(found, campaign, first.forms, first.singles, say)
            found = with_all(found, campaign, forms, say)
        return with_pairs_ahead(found, campaign, campaign.known, say)


def _begun(
    original: Model,
    linear_model: LinearModel,
    tests: Sequence[PreparedTest],
    say: Progress,
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
    if explained:
        outcome = at_the_horizon(campaign, linear, [], say)
        one = told(original, linear_model, outcome, {}, ())
    else:
        last = raced_alone(campaign, linear_model, campaign.known, say)
        campaign = replace(campaign, data=last.base.data)
        outcome = at_the_horizon(campaign, last.base, last.fits, say)
        one = told(original, linear_model, outcome, last.failed, last.left)
    begun = Begun(one, outcome)
    if original.structures:
        return begun
    other = where_tests_differ(outcome, say, explained=one.explained)
    if other is not None:
        one = told(original, linear_model, other, one.failed, one.behind)
        begun = Begun(one, other)
    if begun.is_enough or needs_none(begun.found):
        return begun
    more = with_modes_beside(begun.outcome, linear_model, tests, say)
    return begun if more is None else _begun(original, *more, say, scaled_by)
