"""The search: linear model, screening, growing windows, the horizon, held-out scores."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, TypeAlias, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.data import Test, joint_motions
from shakerproc.diagnosis.estimation.correction import corrected
from shakerproc.diagnosis.estimation.growth import LENGTHS, Stages, dominant_frequency, grown, stages_of
from shakerproc.diagnosis.estimation.least_squares import Fit, fit
from shakerproc.diagnosis.estimation.linear import LinearModel, fit_linear
from shakerproc.diagnosis.estimation.residuals import TAPS, DataSet, Windows, data_set
from shakerproc.diagnosis.estimation.windows import whole_tests, windows_of
from shakerproc.diagnosis.hypotheses.hypothesis import Hypothesis, addition, hypothesis_of
from shakerproc.diagnosis.hypotheses.joints import Joint, identifications, joints_of, scales_of
from shakerproc.diagnosis.screening import Start, screen
from shakerproc.diagnosis.selection.scores import Score, as_fitted, gain, ranked, scored
from shakerproc.models import Model
from shakerproc.models.identification import Contained, Identification

STARTS: Final = 6
"""Starts from which each effect in each joint is fitted to the shortest windows [-]."""

FIRST_ROUNDS: Final = 2
"""Steps of each of these fits: what they are worth shows by then [-]."""

FITTED: Final = 2
"""Of these starts those that are fitted, the best as they are [-]."""

KEPT: Final = 6
"""Hypotheses that are fitted to longer windows and at the horizon [-]."""

FAR: Final = 6.0
"""Standard errors by which a hypothesis may predict worse than the best on short windows and is
still fitted at the horizon: once in 10^9 by chance [-]."""

HORIZONS: Final = (15.0, 50.0)
"""Horizons in periods of the joint's motion, beside the whole test."""

LONGER: Final = 0.2
"""Rise of the logarithm of the residual's square that a longer horizon may cost: errors of the
numbers add up over it by as much, unpredictable motion by far more [-]."""

RUN_IN: Final = 2.0
"""Periods that tell the start of a window (DESIGN.md)."""

ROUNDS: Final = 10
"""Steps of the search at the horizon [-]."""


Group: TypeAlias = tuple[str, Joint, tuple[str, ...]]
"""Kind, joint, and the words of the variant."""

Known: TypeAlias = Mapping[Joint, Mapping[str, Identification]]


@final
@dataclass(frozen=True, slots=True, eq=False)
class Form:
    """The form of the residual in which hypotheses are compared.

    Attributes
    ----------
    horizon : float or None
        Length of the windows [s]; None where whole tests are predicted.
    fitted, scored_fitted, held_out : Windows
        What is fitted to, the same as it is scored, and what was held out.
    """

    horizon: float | None
    fitted: Windows
    scored_fitted: Windows
    held_out: Windows


@final
@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """All that the search found.

    Attributes
    ----------
    data, raw : DataSet
        The tests, corrected by what is unusual of the chain of measurement, and as recorded.
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
    raw: DataSet
    linear_model: LinearModel
    form: Form
    before: Fit
    linear: Score
    effects: tuple[Score, ...]
    ruled_out: tuple[Start, ...]
    failed: Mapping[str, str]


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
    linear_model = fit_linear(model, tests)
    raw, tests = data_set(model, tests), corrected(tests, linear_model)
    model, original = linear_model.model, model
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
        linear = fit(data, none, np.zeros(none.size), whole_tests(data, held_out=False), rounds=4)
    say("screening")
    fitted = [test for test in tests if not test.arrays.hold_out]
    starts = screen(model, fitted, joints, known)
    singles_search = Singles(data, linear, known, stages, say)
    singles = singles_search.found(starts)
    form = _form(data, model, frequency, linear, singles)
    say("at the horizon")
    scores = []
    for one in _comparable(data, singles):
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
        data, raw, linear_model, form, before, base, tuple(ranked(scores)), others, singles_search.failed
    )


def _comparable(data: DataSet, singles: Sequence[Fit]) -> list[Fit]:
    """Return the fits that do not predict far worse than the best on the longest windows."""
    scores = [as_fitted(data, one) for one in singles]
    known = [score for score in scores if score is not None]
    best = min(known, key=lambda score: score.mean, default=None)
    return [s.fit for s in known if best is not None and (s is best or gain(best, s).t < FAR)]


def _best_each(starts: Sequence[Start]) -> list[Start]:
    return [own[0] for own in grouped(starts).values()]


def grouped(starts: Sequence[Start]) -> dict[Group, list[Start]]:
    """Return starts by effect, joint and variant, each group in the order of the starts."""
    groups: dict[Group, list[Start]] = {}
    for start in starts:
        groups.setdefault((start.kind, start.between, start.words), []).append(start)
    return groups


@final
class Singles:
    """The search for one effect on top of a hypothesis."""

    def __init__(
        self, data: DataSet, on: Fit, known: Known, stages: Stages, say: Callable[[str], None]
    ) -> None:
        self.data, self.on, self.known, self.stages, self.say = data, on, known, stages, say
        self.failed: dict[str, str] = {}

    def found(self, starts: Sequence[Start]) -> list[Fit]:
        """Return the effects that may be missing, fitted to windows that grew, best first.

        Every effect is first fitted to the shortest windows, the simple ones before those
        that contain them and then begin where they ended; the best go on.
        """
        groups = grouped([start for start in starts if start.kept])
        order = sorted(groups, key=lambda group: self._size(group[0], group[1]))
        first: dict[Group, Fit] = {}
        for group in order:
            self.say(f"{group[0]} between {' and '.join(group[1])}")
            best = self._first(group, groups[group], first)
            if best is None:
                self.failed[" ".join((group[0], *group[2]))] = "its motion runs away"
            else:
                first[group] = best
        promising = sorted(first.values(), key=lambda one: one.cost)[:KEPT]
        self.say("longer windows")
        rest = replace(self.stages, windows=self.stages.windows[1:], rounds=self.stages.rounds[1:])
        grew = [
            grown(self.data, one.hypothesis, one.x, rest, (one.gain, one.delay))
            for one in promising
        ]
        return sorted([one for one in grew if one is not None], key=lambda one: one.cost)

    def _size(self, kind: str, joint: Joint) -> int:
        return len(self.known[joint][kind].free)

    def _first(
        self, group: Group, starts: Sequence[Start], simpler: Mapping[Group, Fit]
    ) -> Fit | None:
        """Return the best fit to the shortest windows from all starts."""
        kind, joint, _ = group
        identification = self.known[joint][kind]
        tried: list[tuple[Hypothesis, FloatArray]] = []
        none = self.on.hypothesis
        for start in starts[:STARTS]:
            one = addition(kind, joint, identification, start.values)
            for own in (own_start(none, start), np.zeros(len(none.own))):
                x = np.concatenate([
                    own, self.on.x[len(none.own) :], one.transformed(start.values)
                ])
                tried.append((none.with_added(one), x))
        for contained in identification.contains:
            for (other, place, _words), fitted in simpler.items():
                if other == contained.kind and place == joint:
                    tried += self._extended(group, contained, fitted)
        rough = self._fits(tried, 0)
        best = sorted(rough, key=lambda one: one.cost)[:FITTED]
        good = self._fits([(one.hypothesis, one.x) for one in best], FIRST_ROUNDS)
        return min(good, key=lambda one: one.cost) if good else None

    def _fits(self, tried: Sequence[tuple[Hypothesis, FloatArray]], rounds: int) -> list[Fit]:
        """Return fits to the shortest windows, those that run away left out."""
        channels, windows = (self.on.gain, self.on.delay), self.stages.windows[0]
        fits = [
            fit(self.data, hypothesis, x, windows, rounds=rounds, channels=channels)
            for hypothesis, x in tried
        ]
        return [one for one in fits if one is not None]

    def _extended(
        self, group: Group, contained: Contained, fitted: Fit
    ) -> list[tuple[Hypothesis, FloatArray]]:
        """Return where a richer effect may start from where one that it contains ended."""
        kind, joint, words = group
        last = fitted.hypothesis.added[-1]
        *before, own = fitted.hypothesis.parts(fitted.x)
        out = []
        for values in contained.extend({**last.fixed, **last.values(own)}):
            if tuple(v for v in values.values() if isinstance(v, str)) == words:
                one = addition(kind, joint, self.known[joint][kind], values)
                x = np.concatenate([*before, one.transformed(values)])
                out.append((self.on.hypothesis.with_added(one), x))
        return out[:STARTS]


def own_start(none: Hypothesis, start: Start) -> FloatArray:
    """Return the logarithms of the model's own numbers that go with a start."""
    joints = joints_of(none.model)
    out = []
    for number in none.own:
        change = 0.0
        if number.element is None:
            out.append(0.0)
            continue
        element = none.model.elements[number.element]
        if number.name in {"stiffness", "damping"} and tuple(element.between) in joints:
            changes = start.stiffness if number.name == "stiffness" else start.damping
            change = changes[joints.index(tuple(element.between))]
        out.append(float(np.log(np.clip(1.0 + change, 0.05, 20.0))))
    return np.array(out)


def at_horizon(data: DataSet, found: Fit, form: Form) -> Fit | None:
    """Return a fit carried over to the windows of the horizon."""
    return fit(
        data, found.hypothesis, found.x, form.fitted, rounds=ROUNDS,
        channels=(found.gain, found.delay),
    )  # fmt: skip


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


def forms_of(data: DataSet, model: Model, frequency: float) -> list[Form]:
    """Return windows of every horizon, and whole tests where they begin at rest."""
    rate = data.tests[0].sample_rate
    found = []
    for periods in HORIZONS:
        run_in = TAPS + int(RUN_IN * rate / frequency)
        length = run_in + int(periods * rate / frequency)
        parts = [
            windows_of(data, model, length, held_out=kept, most=most, run_in=own)
            for kept, most, own in ((False, 40, 0), (False, 40, run_in), (True, 80, run_in))
        ]
        found.append(Form(length / rate, *parts))
    if all(test.at_rest for test in data.tests):
        whole = whole_tests(data, held_out=False)
        found.append(Form(None, whole, whole, whole_tests(data, held_out=True)))
    return found


__all__ = ["LENGTHS", "Form", "Found", "at_horizon", "forms_of", "search"]
