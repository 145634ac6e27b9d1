"""One effect that is asked for, fitted beside the model as the search fits all of them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import final

import numpy as np

from shakerproc.diagnosis.campaign import Campaign, campaign_of
from shakerproc.diagnosis.data import Test
from shakerproc.diagnosis.estimation.correction import corrected, is_unusual
from shakerproc.diagnosis.estimation.form import ROUNDS, Form
from shakerproc.diagnosis.estimation.growth import grown
from shakerproc.diagnosis.estimation.least_squares import Fit, fit
from shakerproc.diagnosis.estimation.linear import LinearModel, fit_linear
from shakerproc.diagnosis.estimation.one_more import OneMore, as_in, own_start
from shakerproc.diagnosis.estimation.residuals import DataSet
from shakerproc.diagnosis.estimation.windows import whole_tests
from shakerproc.diagnosis.found import EXPLAINED
from shakerproc.diagnosis.hypotheses.hypothesis import hypothesis_of
from shakerproc.diagnosis.hypotheses.joints import Joint, identifications, scales_of
from shakerproc.diagnosis.screening import Start, free_laws, screen
from shakerproc.diagnosis.search import _as_it_is, _at_horizon, _form
from shakerproc.diagnosis.selection.scores import Score, gain
from shakerproc.errors import DiagnosisError
from shakerproc.models import Element, Model
from shakerproc.models.effects import Table
from shakerproc.models.identification import Identification, Values


@final
@dataclass(frozen=True, slots=True)
class Wanted:
    """What is to be added.

    Attributes
    ----------
    kind : str
        Key of the effect.
    between : (str, str), optional
        The joint; by default the one where it fits best.
    start : mapping of str to float or str
        Coordinates to start from beside those of the screening [SI].
    """

    kind: str
    between: Joint | None = None
    start: Values = field(default_factory=lambda: MappingProxyType({}))

    @property
    def is_free_law(self) -> bool:
        """Whether it is the force without a name, which is found by regression alone."""
        return self.kind == Table.kind


@final
@dataclass(frozen=True, slots=True, eq=False)
class Fitted:
    """An effect fitted, and what it is held against.

    Attributes
    ----------
    data : DataSet
        The tests, as recorded or corrected by what is unusual of the chain of measurement.
    linear_model : LinearModel
        What it was fitted on top of.
    form : Form
        In which models are compared.
    before : Fit
        The model as it is, nothing fitted.
    without, with_effect : Score
        Its own numbers fitted, alone and with the effect.
    """

    data: DataSet
    linear_model: LinearModel
    form: Form
    before: Fit
    without: Score
    with_effect: Score

    @property
    def element(self) -> Element:
        """The effect with its fitted numbers, in its joint."""
        fit = self.with_effect.fit
        return fit.hypothesis.model_at(fit.x).elements[-1]


def fitted_effect(
    model: Model, tests: Sequence[Test], wanted: Wanted, say: Callable[[str], None]
) -> Fitted:
    """Return an effect fitted jointly with the model's own numbers.

    Where the chain of measurement is unusual and the tests are not explained as they were
    recorded, it is fitted to corrected ones too, and the better of both is returned.
    """
    say("linear model")
    linear = fit_linear(model, tests)
    found = _fitted(model, linear, tests, wanted, say)
    if not is_unusual(linear) or found.with_effect.mean < EXPLAINED:
        return found
    say("the chain of measurement corrected")
    other = _fitted(model, linear, corrected(tests, linear), wanted, say)
    return other if gain(other.with_effect, found.with_effect).t > 0.0 else found


def _fitted(
    original: Model,
    linear_model: LinearModel,
    tests: Sequence[Test],
    wanted: Wanted,
    say: Callable[[str], None],
) -> Fitted:
    """Return the effect fitted to tests on top of a linear model.

    Raises
    ------
    DiagnosisError
        If the model runs away in every test, or with the effect.
    """
    campaign = _campaign(replace(original, modes=linear_model.model.modes), tests, wanted)
    linear = _linear(campaign)
    say("screening")
    if wanted.is_free_law:
        fits = _tables(campaign, linear, wanted)
    else:
        fits = _effects(campaign, linear, linear_model, wanted, say)
    if not fits:
        where = f" between {' and '.join(wanted.between)}" if wanted.between else ""
        raise DiagnosisError(
            f"{wanted.kind}{where} cannot be fitted to these tests: its motion runs away, or "
            "it explains nothing; see `shakerproc diagnose` for what does."
        )
    say("at the horizon")
    best = min(fits, key=lambda one: one.level)
    form, done = _form(campaign, [best], linear)
    scores = [_at_horizon(campaign.data, [one], form, done) for one in (linear, best)]
    if not all(scores):
        raise DiagnosisError(
            f"{wanted.kind} cannot be fitted to these tests: the motion runs away in what was "
            "held out."
        )
    (without,), (with_effect,) = scores
    before = _as_it_is(original, linear)
    return Fitted(campaign.data, linear_model, form, before, without, with_effect)


def _campaign(model: Model, tests: Sequence[Test], wanted: Wanted) -> Campaign:
    """Return what hypotheses share, the wanted joint among the others, with its name there."""
    campaign = campaign_of(model, tests)
    joint = wanted.between
    if joint is None or any(set(joint) == set(other) for other in campaign.known):
        return campaign
    scales = scales_of(model, tests, joint, campaign.data.across(joint))
    return replace(campaign, known={**campaign.known, joint: identifications(scales)})


def _linear(campaign: Campaign) -> Fit:
    """Return the model's own numbers, fitted alone.

    Raises
    ------
    DiagnosisError
        If it runs away in every test.
    """
    data = campaign.data
    none = hypothesis_of(data.model)
    nothing = np.zeros(none.size)
    found = grown(data, none, nothing, campaign.stages)
    if found is None:
        whole = whole_tests(data, held_out=False)
        found = fit(data, none, nothing, whole, rounds=ROUNDS)
    if found is None:
        raise DiagnosisError(
            f"{data.model.title}: its motion runs away in every test; check stiffness, damping "
            "and masses of the model."
        )
    return found


def _joints(campaign: Campaign, wanted: Wanted) -> list[Joint]:
    """Return the joints in which the effect is fitted."""
    place = wanted.between
    return [j for j in campaign.known if place is None or set(j) == set(place)]


def _effects(
    campaign: Campaign,
    linear: Fit,
    linear_model: LinearModel,
    wanted: Wanted,
    say: Callable[[str], None],
) -> list[Fit]:
    """Return the best fit of the effect in each joint, after those that it contains."""
    data, known = campaign.data, campaign.known
    own = as_in(linear.hypothesis, linear_model.model)
    chosen = {
        joint: _with_contained(known[joint], wanted.kind) for joint in _joints(campaign, wanted)
    }
    sought = {joint: chosen.get(joint, {}) for joint in known}
    starts = _with_own(screen(data.model, campaign.fitted, tuple(known), sought), wanted)
    out = []
    for joint in chosen:
        one_more = OneMore(data, linear, known, campaign.stages, linear=own, say=say)
        found = one_more.found([start for start in starts if start.between == joint])
        out += [one for one in found if one.hypothesis.kinds == (wanted.kind,)][:1]
    return out


def _with_contained(
    known: Mapping[str, Identification], kind: str
) -> dict[str, Identification]:
    """Return what an effect says of a joint, and what those say that it contains."""
    found: dict[str, Identification] = {}
    waiting = [kind]
    while waiting:
        name = waiting.pop()
        if name in known and name not in found:
            found[name] = known[name]
            waiting += [one.kind for one in known[name].contains]
    return found


def _with_own(starts: Sequence[Start], wanted: Wanted) -> list[Start]:
    """Return starts of the screening, before them the best with the numbers that were given.

    Raises
    ------
    DiagnosisError
        If the effect has no number of such a name.
    """
    kept = [replace(start, kept=True) for start in starts]
    if not wanted.start:
        return kept
    own: dict[Joint, Start] = {}
    for start in kept:
        if start.kind == wanted.kind:
            own.setdefault(start.between, start)
    for start in own.values():
        unknown = [name for name in wanted.start if name not in start.values]
        if unknown:
            raise DiagnosisError(
                f"{wanted.kind} has no number {unknown[0]!r} to start from; it has "
                f"{', '.join(start.values)}."
            )
    given = [replace(start, values={**start.values, **wanted.start}) for start in own.values()]
    return [*given, *kept]


def _tables(campaign: Campaign, linear: Fit, wanted: Wanted) -> list[Fit]:
    """Return the missing force of each joint as a smooth table, grown with own numbers."""
    data, joints = campaign.data, _joints(campaign, wanted)
    laws = free_laws(data.model, campaign.fitted, tuple(campaign.known))
    law = next((law for law in laws if law.between in joints), None)
    if law is None:
        return []
    element = Element(law.effect, law.between)
    model = replace(data.model, elements=(*data.model.elements, element))
    hypothesis = hypothesis_of(model)
    start = Start(
        Table.kind, law.between, {}, law.stiffness, law.damping, law.explained,
        law.predicted, law.t, law.left,
    )  # fmt: skip
    channels = (linear.gain, linear.delay)
    found = grown(data, hypothesis, own_start(hypothesis, start), campaign.stages, channels)
    return [] if found is None else [found]
