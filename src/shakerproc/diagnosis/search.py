"""The search: linear model, screening, growing windows, the horizon, held-out scores."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from shakerproc.diagnosis.data import Test, joint_motions
from shakerproc.diagnosis.estimation.correction import corrected, is_unusual
from shakerproc.diagnosis.estimation.form import Form, at_horizon, forms_of
from shakerproc.diagnosis.estimation.growth import dominant_frequency, grown, stages_of
from shakerproc.diagnosis.estimation.least_squares import Fit, fit
from shakerproc.diagnosis.estimation.linear import LinearModel, fit_linear
from shakerproc.diagnosis.estimation.one_more import Known, OneMore, as_in, grouped
from shakerproc.diagnosis.estimation.residuals import DataSet, data_set
from shakerproc.diagnosis.estimation.windows import whole_tests
from shakerproc.diagnosis.hypotheses.hypothesis import hypothesis_of
from shakerproc.diagnosis.hypotheses.joints import identifications, joints_of, scales_of
from shakerproc.diagnosis.screening import Start, screen
from shakerproc.diagnosis.selection.scores import Score, as_fitted, gain, ranked, scored
from shakerproc.models import Model

FAR: Final = 6.0
"""Standard errors by which a hypothesis may predict worse than the best on short windows and is
still fitted at the horizon: once in 10^9 by chance [-]."""

LONGER: Final = 0.2
"""Rise of the logarithm of the residual's square that a longer horizon may cost: errors of the
numbers add up over it by as much, unpredictable motion by far more [-]."""

EXPLAINED: Final = 1.1
"""Logarithm of 1 + mean square of the residual over the noise, up to which it is noise: twice
the noise, which is known to some 3 dB [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """All that the search found.

    Attributes
    ----------
    data : DataSet
        The tests, as recorded or corrected by what is unusual of the chain of measurement.
    linear_model : LinearModel
        What effects are judged on top of.
    form : Form
        In which hypotheses are compared.
    before : Fit
        The model as it is, nothing fitted.
    linear : Score
        Nothing is missing.
    effects : tuple of Score
        Hypotheses with effects, the best first.
    ruled_out : tuple of Start
        The best start of each effect and joint that the screening ruled out.
    failed : mapping of str to str
        Hypotheses that could not be simulated, with the reason.
    """

    data: DataSet
    linear_model: LinearModel
    form: Form
    before: Fit
    linear: Score
    effects: tuple[Score, ...]
    ruled_out: tuple[Start, ...]
    failed: Mapping[str, str]

    @property
    def best(self) -> Score:
        """The hypothesis that predicts best."""
        return min((self.linear, *self.effects), key=lambda score: score.mean)

    @property
    def explained(self) -> bool:
        """Whether the best leaves no more than noise in most blocks."""
        return float(np.median(self.best.logs)) < EXPLAINED


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
    linear = fit_linear(model, tests)
    found = _searched(model, linear, tests, say)
    if not is_unusual(linear) or found.explained:
        return found
    say("the chain of measurement corrected")
    other = _searched(model, linear, corrected(tests, linear), say)
    return other if gain(other.best, found.best).t > 0.0 else found


def _searched(
    original: Model,
    linear_model: LinearModel,
    tests: Sequence[Test],
    say: Callable[[str], None],
) -> Found:
    """Return what explains tests on top of a linear model."""
    model = replace(original, modes=linear_model.model.modes)
    data = data_set(model, tests)
    joints = joints_of(model)
    motions = {joint: [] for joint in joints}
    for test in tests:
        for joint, motion in zip(joints, joint_motions(model, test, joints), strict=True):
            motions[joint].append(motion)
    frequency = max(dominant_frequency(own) for own in motions.values())
    known = {j: identifications(scales_of(model, tests, j, own)) for j, own in motions.items()}
    stages = stages_of(data, model, frequency)
    say("the model's own numbers")
    none = hypothesis_of(model)
    linear = grown(data, none, np.zeros(none.size), stages)
    if linear is None:
        linear = fit(
            data, none, np.zeros(none.size), whole_tests(data, held_out=False), rounds=4
        )
    say("screening")
    fitted = [test for test in tests if not test.arrays.hold_out]
    starts = screen(model, fitted, joints, known)
    one_more = OneMore(data, linear, known, stages, as_in(none, linear_model.model), say)
    singles = one_more.found(starts)
    form = _form(data, model, frequency, linear, singles)
    say("at the horizon")
    scores = []
    for one in _comparable(data, singles, known):
        refitted = at_horizon(data, one, form)
        score = refitted and scored(data, refitted, form.held_out)
        if score:
            scores.append(score)
    refitted = at_horizon(data, linear, form) or linear
    base = scored(data, refitted, form.held_out)
    if base is None:
        base = Score(refitted, np.full(1, np.inf))
    tried = {(one.hypothesis.kinds[0], one.hypothesis.added[0].between) for one in singles}
    others = tuple(s for s in _best_each(starts) if (s.kind, s.between) not in tried)
    before = replace(
        base.fit, hypothesis=hypothesis_of(original), x=np.zeros(none.size), gain=np.ones_like(base.fit.gain),
        delay=np.zeros_like(base.fit.delay),
    )  # fmt: skip
    return Found(
        data, linear_model, form, before, base, tuple(ranked(scores)), others, one_more.failed
    )


def _comparable(data: DataSet, singles: Sequence[Fit], known: Known) -> list[Fit]:
    """Return the fits that do not predict far worse than the best on the longest windows.

    A law that contains another one that it does not outdo is left out: the simpler stands in.
    """
    scores = [score for one in singles if (score := as_fitted(data, one)) is not None]
    best = min(scores, key=lambda score: score.mean, default=None)
    near = [s for s in scores if best is not None and (s is best or gain(best, s).t < FAR)]
    return [s.fit for s in near if not any(_contains(s, other, known) for other in near)]


def _contains(richer: Score, simpler: Score, known: Known) -> bool:
    """Return whether a law has another one as a limit, and predicts no better."""
    one, other = richer.fit.hypothesis.added[-1], simpler.fit.hypothesis.added[-1]
    limits = [c.kind for c in known[one.between][one.kind].contains if c.limit]
    nested = other.kind in limits and other.between == one.between
    return nested and richer.mean >= simpler.mean


def _best_each(starts: Sequence[Start]) -> list[Start]:
    return [own[0] for own in grouped(starts).values()]


def _form(
    data: DataSet, model: Model, frequency: float, linear: Fit, singles: Sequence[Fit]
) -> Form:
    """Return the longest horizon at which the best is predicted as well as at shorter ones."""
    forms = forms_of(data, model, frequency)
    best: tuple[float, Form] | None = None
    for form in forms:
        if not singles or not len(form.held_out) or not len(form.fitted):
            continue
        tried = [at_horizon(data, one, form) for one in (singles[0], linear)]
        scores = [scored(data, one, form.held_out) for one in tried if one is not None]
        least = min((score.mean for score in scores if score is not None), default=np.inf)
        if best is None or least < best[0] + LONGER:
            best = min(least, np.inf if best is None else best[0]), form
    return best[1] if best is not None else forms[-1]
