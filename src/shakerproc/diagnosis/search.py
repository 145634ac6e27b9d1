"""The search: linear model, screening, growing windows, the horizon, held-out scores."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.data import Test, joint_motions
from shakerproc.diagnosis.estimation.growth import LENGTHS, Stages, dominant_frequency, grown, stages_of
from shakerproc.diagnosis.estimation.least_squares import Fit, fit
from shakerproc.diagnosis.estimation.residuals import TAPS, DataSet, Windows, data_set
from shakerproc.diagnosis.estimation.windows import whole_tests, windows_of
from shakerproc.diagnosis.hypotheses.hypothesis import Hypothesis, addition, hypothesis_of
from shakerproc.diagnosis.hypotheses.joints import Joint, identifications, joints_of, scales_of
from shakerproc.diagnosis.screening import Start, screen
from shakerproc.diagnosis.selection.scores import Score, gain, ranked, scored
from shakerproc.models import Model
from shakerproc.models.identification import Identification

STARTS: Final = 2
"""Starts from which each effect in each joint is fitted [-]."""

TRIED: Final = 7
"""Effects and joints that the screening passes on [-]."""

KEPT: Final = 5
"""Hypotheses that are fitted at the horizon [-]."""

FAR: Final = 6.0
"""Standard errors by which a hypothesis may predict worse than the best on short windows and is
still fitted at the horizon: once in 10^9 by chance [-]."""

HORIZONS: Final = (15.0, 50.0)
"""Horizons in periods of the joint's motion, beside the whole test."""

RUN_IN: Final = 2.0
"""Periods that tell the start of a window (DESIGN.md)."""

ROUNDS: Final = 10
"""Steps of the search at the horizon [-]."""


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
    data : DataSet
        The tests.
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
    singles, failed = _singles(data, none, starts, known, stages, say)
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
        base.fit, x=np.zeros(none.size), gain=np.ones_like(base.fit.gain),
        delay=np.zeros_like(base.fit.delay),
    )  # fmt: skip
    return Found(data, form, before, base, tuple(ranked(scores)), others, failed)


def _comparable(data: DataSet, singles: Sequence[Fit]) -> list[Fit]:
    """Return the fits that do not predict far worse than the best on the longest windows."""
    scores = [scored(data, one, one.windows) for one in singles]
    known = [score for score in scores if score is not None]
    best = min(known, key=lambda score: score.mean, default=None)
    return [s.fit for s in known if best is not None and (s is best or gain(best, s).t < FAR)]


def _best_each(starts: Sequence[Start]) -> list[Start]:
    found: dict[tuple[str, Joint, tuple[str, ...]], Start] = {}
    for start in starts:
        found.setdefault((start.kind, start.between, start.words), start)
    return list(found.values())


def _singles(
    data: DataSet,
    none: Hypothesis,
    starts: Sequence[Start],
    known: Mapping[Joint, Mapping[str, Identification]],
    stages: Stages,
    say: Callable[[str], None],
) -> tuple[list[Fit], dict[str, str]]:
    """Return each effect in each joint that may be, fitted to windows that grew, best first."""
    groups: dict[tuple[str, Joint, tuple[str, ...]], list[Start]] = {}
    for start in starts:
        groups.setdefault((start.kind, start.between, start.words), []).append(start)
    found, failed = [], {}
    for (kind, joint, words), own in list(groups.items())[:TRIED]:
        say(f"{kind} between {' and '.join(joint)}")
        fits = [started(data, none, s, known[joint][kind], stages) for s in own[:STARTS]]
        good = [one for one in fits if one is not None]
        if good:
            found.append(min(good, key=lambda one: one.cost))
        else:
            failed[f"{kind} {' '.join(words)}".strip()] = "its motion runs away"
    return sorted(found, key=lambda one: one.cost), failed


def started(
    data: DataSet, none: Hypothesis, start: Start, identification: Identification, stages: Stages
) -> Fit | None:
    """Return the fit of an effect from one start of the screening."""
    hypothesis = none.with_added(
        addition(start.kind, start.between, identification, start.values)
    )
    x = np.concatenate([own_start(none, start), hypothesis.added[-1].transformed(start.values)])
    return grown(data, hypothesis, x, stages)


def own_start(none: Hypothesis, start: Start) -> FloatArray:
    """Return the logarithms of the model's own numbers that go with a start."""
    joints = joints_of(none.model)
    out = []
    for number in none.own:
        element = none.model.elements[number.element]
        change = 0.0
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
    """Return the horizon at which the gain over the linear model is surest."""
    forms = forms_of(data, model, frequency)
    best: tuple[float, Form] | None = None
    for form in forms:
        if not singles or not len(form.held_out) or not len(form.fitted):
            continue
        one = fit(data, singles[0].hypothesis, singles[0].x, form.fitted, rounds=3,
                  channels=(singles[0].gain, singles[0].delay))  # fmt: skip
        scores = [scored(data, f, form.held_out) if f else None for f in (one, linear)]
        if scores[0] is None or scores[1] is None:
            continue
        t = gain(scores[0], scores[1]).t
        if best is None or t > best[0]:
            best = t, form
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


__all__ = ["LENGTHS", "Form", "Found", "at_horizon", "forms_of", "replace", "search", "started"]
