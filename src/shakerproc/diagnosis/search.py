"""The search: linear model, screening, growing windows, the horizon, held-out scores."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from shakerproc.diagnosis.campaign import Campaign, campaign_of
from shakerproc.diagnosis.data import Test
from shakerproc.diagnosis.data.sensor_faults import hum_of
from shakerproc.diagnosis.estimation.correction import (
    corrected,
    explains,
    is_unusual,
    residuals_of,
    turned,
    without_hum,
)
from shakerproc.diagnosis.estimation.form import ROUNDS, Form
from shakerproc.diagnosis.estimation.growth import grown
from shakerproc.diagnosis.estimation.least_squares import Fit, fit
from shakerproc.diagnosis.estimation.linear import LinearModel, fit_linear, polarity
from shakerproc.diagnosis.estimation.one_more import OneMore, as_in, grouped, own_start
from shakerproc.diagnosis.estimation.windows import whole_tests
from shakerproc.diagnosis.found import Found
from shakerproc.diagnosis.horizon import along, as_sampled, compared
from shakerproc.diagnosis.hypotheses.hypothesis import addition, hypothesis_of
from shakerproc.diagnosis.rigid import rigid_joints
from shakerproc.diagnosis.screening import Start, free_laws, screen
from shakerproc.diagnosis.screening.pairs import both_at_once, screen_pairs
from shakerproc.diagnosis.selection.scores import (
    ranked,
)
from shakerproc.errors import DiagnosisError
from shakerproc.models import Element, Model

FIRSTS: Final = 2
"""Single effects that a second one is sought beside, and pairs that go to the horizon [-]."""

AT_ONCE: Final = 4
"""Pairs of effects that are fitted because they explain most together [-]."""

SECONDS: Final = 24
"""Starts of a second effect that are looked at [-]."""


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
    """
    say("linear model")
    signs = polarity(model, tests)
    found = _with_chain(model, turned(tests, signs), say)
    return replace(found, signs=tuple(map(float, signs)))


def _with_chain(model: Model, tests: Sequence[Test], say: Callable[[str], None]) -> Found:
    """Return the same for sensors the right way round, corrected where that is better."""
    linear = fit_linear(model, tests)
    residuals = residuals_of(linear, tests)
    hums = hum_of(residuals, [test.sample_rate for test in tests])
    if hums:
        say("the hum of the mains taken away")
        rest = _with_chain(model, without_hum(tests, residuals, hums), say)
        return replace(rest, hums=(*hums, *rest.hums))
    if not is_unusual(linear):
        return _searched(model, linear, tests, say)
    found: list[Found] = []
    for correct in (True, False) if explains(linear) else (False, True):
        if correct:
            say("the chain of measurement corrected")
        own = corrected(tests, linear) if correct else tests
        found.append(replace(_searched(model, linear, own, say), corrected=correct))
        if found[-1].rigid or found[-1].explained:
            return found[-1]
    return min(found, key=lambda one: one.left)


def _searched(
    original: Model,
    linear_model: LinearModel,
    tests: Sequence[Test],
    say: Callable[[str], None],
) -> Found:
    """Return what explains tests on top of a linear model.

    Raises
    ------
    DiagnosisError
        If the model runs away in every test.
    """
    model = replace(original, modes=linear_model.model.modes)
    campaign = campaign_of(model, tests)
    data, stages = campaign.data, campaign.stages
    say("the model's own numbers")
    none = hypothesis_of(model)
    nothing = np.zeros(none.size)
    linear = grown(data, none, nothing, stages)
    if linear is None:
        whole = whole_tests(data, held_out=False)
        linear = fit(data, none, nothing, whole, rounds=ROUNDS)
    if linear is None:
        raise DiagnosisError(
            f"{model.title}: its motion runs away in every test; check stiffness, damping and "
            "masses of the model."
        )
    rigid = rigid_joints(data)
    say(f"{' and '.join(rigid[0])} held in every test" if rigid else "screening")
    known = {} if rigid else campaign.known
    starts = screen(model, campaign.fitted, tuple(known), known) if known else ()
    other = as_in(none, linear_model.model)
    one_more = OneMore(data, linear, campaign.known, stages, linear=other, say=say)
    singles = one_more.found(starts)
    say("at the horizon")
    campaign = as_sampled(campaign, [linear, *singles])
    forms, base, effects = compared(campaign, linear, singles)
    found = Found(
        data=campaign.sampled,
        linear_model=linear_model,
        form=forms[-1],
        before=as_it_is(original, linear),
        linear=base,
        effects=tuple(ranked(effects)),
        free=None,
        ruled_out=ruled_out(starts, singles),
        failed=one_more.failed,
        rigid=rigid,
    )
    return (
        found
        if rigid or found.explained
        else _with_more(found, campaign, forms, (linear, singles), say)
    )


def as_it_is(original: Model, linear: Fit) -> Fit:
    """Return the fit that is none: the numbers of the model file, perfect sensors."""
    none = hypothesis_of(original)
    return replace(
        linear, hypothesis=none, x=np.zeros(none.size), gain=np.ones_like(linear.gain),
        delay=np.zeros_like(linear.delay),
    )  # fmt: skip


def _with_more(
    found: Found,
    campaign: Campaign,
    forms: Sequence[Form],
    fits: tuple[Fit, Sequence[Fit]],
    say: Callable[[str], None],
) -> Found:
    """Return what pairs of effects, and a force without a name, explain beyond singles."""
    data, (linear, singles) = campaign.data, fits
    pairs: list[Fit] = []
    failed = dict(found.failed)
    for first in singles[:FIRSTS]:
        say(f"a second effect beside {first.hypothesis.kinds[0]}")
        one = first.hypothesis.added[0]
        values = {**one.fixed, **one.values(first.hypothesis.parts(first.x)[1])}
        starts = screen_pairs(
            campaign.data.model,
            campaign.fitted,
            campaign.known,
            (one.kind, one.between, values),
        )
        second = OneMore(
            data, first, campaign.known, campaign.stages,
            linear=first.hypothesis.parts(first.x)[0], say=lambda _: None,
        )  # fmt: skip
        pairs += second.found(starts[:SECONDS])
        failed |= {f"{one.kind}+{name}": why for name, why in second.failed.items()}
    say("two effects at once")
    pairs += _at_once(campaign, linear)
    pairs.sort(key=lambda pair: pair.level)
    scores = along(campaign, pairs[:FIRSTS], forms)
    say("a force without a name")
    free = along(campaign, _free(campaign, found.linear.fit), forms)
    return replace(
        found,
        effects=tuple(ranked([*found.effects, *scores])),
        free=free[0] if free else None,
        failed=failed,
    )


def _at_once(campaign: Campaign, linear: Fit) -> list[Fit]:
    """Return the pairs that explain most together, fitted to windows that grew."""
    model, data = campaign.data.model, campaign.data
    found = []
    for one, other in both_at_once(model, campaign.fitted, campaign.known, AT_ONCE):
        first = addition(
            one.kind, one.between, campaign.known[one.between][one.kind], one.values
        )
        on = replace(
            linear,
            hypothesis=linear.hypothesis.with_added(first),
            x=np.concatenate([linear.x, first.transformed(one.values)]),
        )
        own = np.zeros(len(linear.hypothesis.own))
        second = OneMore(
            data, on, campaign.known, campaign.stages, linear=own, say=lambda _: None
        )
        found += second.found([other])
    return found


def _free(campaign: Campaign, linear: Fit) -> list[Fit]:
    """Return the missing force as a smooth table in the joint that it explains most of."""
    laws = free_laws(campaign.data.model, campaign.fitted, tuple(campaign.known))
    if not laws:
        return []
    element = Element(laws[0].effect, laws[0].between)
    model = replace(campaign.data.model, elements=(*campaign.data.model.elements, element))
    hypothesis = hypothesis_of(model)
    start = Start(
        "table", laws[0].between, {}, laws[0].stiffness, laws[0].damping, laws[0].explained,
        laws[0].predicted, laws[0].t, laws[0].left,
    )  # fmt: skip
    return [replace(linear, hypothesis=hypothesis, x=own_start(hypothesis, start))]


def ruled_out(starts: Sequence[Start], singles: Sequence[Fit]) -> tuple[Start, ...]:
    """Return the best start of each effect and joint that was not fitted to longer windows."""
    tried = {(one.hypothesis.kinds[0], one.hypothesis.added[0].between) for one in singles}
    first = [own[0] for own in grouped(starts).values()]
    return tuple(start for start in first if (start.kind, start.between) not in tried)
