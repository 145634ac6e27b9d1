"""One effect that is asked for, fitted beside the model as the search fits all of them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import final

from shakerproc.diagnosis import component_tests
from shakerproc.diagnosis.campaign import (
    Campaign,
    as_it_is,
    campaign_of,
    own_numbers,
    raced_alone,
)
from shakerproc.diagnosis.data import PreparedTest
from shakerproc.diagnosis.estimation.beginnings import as_table
from shakerproc.diagnosis.estimation.correction import corrected, is_unusual, without_driven
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.form import Form
from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.estimation.linear import fit_linear
from shakerproc.diagnosis.estimation.linear_model import LinearModel
from shakerproc.diagnosis.estimation.linear_response import DrivenMode
from shakerproc.diagnosis.found import is_within
from shakerproc.diagnosis.further_ahead import ahead
from shakerproc.diagnosis.horizon import along, compared
from shakerproc.diagnosis.hypotheses.joints import identifications, scales_of
from shakerproc.diagnosis.mode_beside import with_modes_beside
from shakerproc.diagnosis.nudged.race import Raced, held
from shakerproc.diagnosis.outcome import Outcome
from shakerproc.diagnosis.progress import progress_of
from shakerproc.diagnosis.screening import free_laws
from shakerproc.diagnosis.selection.errors import error_of, floors_of, pooled_floor
from shakerproc.diagnosis.selection.scores import Score
from shakerproc.diagnosis.wanted import Wanted, joints_of, sought
from shakerproc.errors import DiagnosisError
from shakerproc.models import Element, Model
from shakerproc.models.effects import Table


@final
@dataclass(frozen=True, eq=False)
class Fitted:
    """An effect fitted, and what it is compared with.

    Attributes
    ----------
    data : DataSet
        The tests, as recorded or corrected by what is unusual of the chain of measurement.
    form : Form
        In which models are compared.
    before : Fit
        The model as it is, nothing fitted.
    without, with_effect : Score
        Its own numbers fitted, alone and with the effect.
    driven : tuple of DrivenMode
        Modes that were taken out of the tests.
    """

    data: DataSet
    form: Form
    before: Fit
    without: Score
    with_effect: Score
    driven: tuple[DrivenMode, ...] = ()

    @property
    def element(self) -> Element:
        """The effect with its fitted numbers, in its joint."""
        fit = self.fit
        return fit.hypothesis.model_at(fit.x).elements[-1]

    @cached_property
    def fit(self) -> Fit:
        """The fit whose numbers are told."""
        return ahead(self.data, self.with_effect.fit, self.form)

    @cached_property
    def left(self) -> float:
        """The held-out error with the effect [-]."""
        return error_of(self.data, self.with_effect.fit, self.form.held_out)

    @property
    def explained(self) -> bool:
        """Whether the model with the effect leaves no more than noise."""
        floors = floors_of(self.data, self.with_effect.fit, self.form.held_out)
        return is_within(self.left, pooled_floor(floors))


def fitted_effect(
    model: Model, tests: Sequence[PreparedTest], wanted: Wanted, say: Callable[[str], None]
) -> Fitted:
    """Return an effect fitted jointly with the model's own numbers.

    Where the chain of measurement is unusual and the tests are not explained as they were
    recorded, it is fitted to corrected ones too, and the better of both is returned.
    """
    say("linear model")
    if model.excitation.imposed:
        return _in_component_tests(model, tests, wanted, say)
    linear = fit_linear(model, tests)
    tests = without_driven(tests, linear)
    found = _fitted(model, linear, tests, wanted, say)
    if is_unusual(linear) and not found.explained:
        say("the chain of measurement corrected")
        other = _fitted(model, linear, corrected(tests, linear), wanted, say)
        found = min((found, other), key=lambda one: one.left)
    return found


def _fitted(
    original: Model,
    linear_model: LinearModel,
    tests: Sequence[PreparedTest],
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
    linear = own_numbers(campaign, linear_model)
    if wanted.is_free_law:
        say("a force without a name")
        fits = _tables(campaign, wanted)
    else:
        known = sought(campaign, wanted)
        fits = _of_kind(raced_alone(campaign, linear_model, known, say), wanted)
    best = _best(fits, wanted)
    say("at the horizon")
    campaign = replace(campaign, data=best.data)
    singles = [] if wanted.is_free_law else [best]
    campaign, forms, without, effects = compared(campaign, linear, singles)
    here = Outcome(campaign, forms, without, effects, singles)
    more = with_modes_beside(here, linear_model, tests, progress_of(say))
    if more is not None:
        return _fitted(original, *more, wanted, say)
    scores = [without, *(along(campaign, [best], forms) if wanted.is_free_law else effects)]
    found = _as_fitted(original, campaign, forms[-1], scores, best)
    return replace(found, driven=linear_model.driven)


def _in_component_tests(
    model: Model, tests: Sequence[PreparedTest], wanted: Wanted, say: Callable[[str], None]
) -> Fitted:
    """Return the effect fitted to tests in which a motion is imposed.

    Raises
    ------
    DiagnosisError
        If the effect cannot be fitted to them.
    """
    campaign = _campaign(model, tests, wanted)
    form = component_tests.form_of(campaign.data)
    linear = component_tests.linear_fit(campaign.data, form)
    if linear is None or wanted.is_free_law:
        raise DiagnosisError(
            f"{model.title}: {wanted.kind} cannot be fitted to tests with an imposed "
            "displacement."
        )
    campaign = replace(campaign, known=sought(campaign, wanted))
    fits = _of_kind(component_tests.raced(campaign, form, linear, say), wanted)
    best = _best(fits, wanted)
    scores = along(campaign, [linear, best], [form])
    return _as_fitted(model, campaign, form, scores, best)


def _best(fits: Sequence[Fit], wanted: Wanted) -> Fit:
    """Return the best of several fits.

    Raises
    ------
    DiagnosisError
        If there is none.
    """
    if not fits:
        where = f" between {' and '.join(wanted.between)}" if wanted.between else ""
        raise DiagnosisError(
            f"{wanted.kind}{where} cannot be fitted to these tests: its motion runs away, or "
            "it explains nothing; see `shakerproc diagnose` for what does."
        )
    return min(fits, key=lambda one: one.level)


def _as_fitted(
    original: Model, campaign: Campaign, form: Form, scores: Sequence[Score], best: Fit
) -> Fitted:
    """Return the model without and with the effect, scored in the form.

    Raises
    ------
    DiagnosisError
        If the motion runs away there.
    """
    if len(scores) < 2:  # without and with
        kinds = " and ".join(best.hypothesis.kinds) or Table.kind
        raise DiagnosisError(
            f"{kinds} cannot be fitted to these tests: the motion runs away in what was held "
            "out."
        )
    without, with_effect = scores
    before = as_it_is(original, without.fit)
    return Fitted(campaign.data, form, before, without, with_effect)


def _campaign(model: Model, tests: Sequence[PreparedTest], wanted: Wanted) -> Campaign:
    """Return shared data of hypotheses, the wanted joint among the others under its name."""
    campaign = campaign_of(model, tests, wanted.scaled_by)
    joint = wanted.between
    if joint is None or any(set(joint) == set(other) for other in campaign.known):
        return campaign
    scales = scales_of(model, tests, joint, campaign.data.across(joint))
    return replace(
        campaign, known={**campaign.known, joint: identifications(scales, wanted.scaled_by)}
    )


def _of_kind(one: Raced, wanted: Wanted) -> list[Fit]:
    """Return the fit of the effect that lasted in the race, else where it fell behind."""
    every = [*one.fits, *one.left]
    return [own for own in every if own.hypothesis.kinds == (wanted.kind,)][:1]


def _tables(campaign: Campaign, wanted: Wanted) -> list[Fit]:
    """Return the missing force as a smooth table, with own numbers, held ever less."""
    data, joints = campaign.data, joints_of(campaign, wanted)
    laws = free_laws(data.model, campaign.fitted, tuple(campaign.known))
    law = next((law for law in laws if law.between in joints), None)
    begun = None if law is None else as_table(data.model, law)
    if begun is None:
        return []
    found = held(data, *begun)
    return [] if found is None else [found]
