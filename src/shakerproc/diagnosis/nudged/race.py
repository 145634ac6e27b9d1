"""The race: every law is fitted while it is held, and goes on as long as it keeps up."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.least_squares import Fit, fit
from shakerproc.diagnosis.estimation.point import Channels
from shakerproc.diagnosis.estimation.residual_slopes import FARTHEST_STEP
from shakerproc.diagnosis.estimation.sampling import as_recorded
from shakerproc.diagnosis.hypotheses.hypothesis import Hypothesis
from shakerproc.diagnosis.hypotheses.joints import Joint, Known
from shakerproc.diagnosis.nudged.entering import entered
from shakerproc.diagnosis.nudged.ladder import Rung, ladder_of
from shakerproc.diagnosis.nudged.starts import Group
from shakerproc.diagnosis.selection.errors import LONGER, error_of
from shakerproc.diagnosis.selection.scores import FAR, SURE, as_fitted, worth_a_fit
from shakerproc.errors import DiagnosisError
from shakerproc.numerals import numeral

ENTERED: Final = 8
"""Pieces in which each law is first fitted [-]."""

MOST: Final = 6
"""Hypotheses that go on from one rate to the next at most, beside the best in every joint
[-]."""

FIRST: Final = 2
"""Steps of the first fit of each law: what it is worth shows by then [-]."""

RUNS_AWAY: Final = (
    "its motion runs away in every test; check stiffness, damping and masses of the model."
)
"""What is said of a model that cannot be fitted."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Raced:
    """Candidates that a race leaves.

    Attributes
    ----------
    base : Fit
        The hypothesis that effects were added to, at the last rate; its tests have
        accelerations compared as the recorder took them.
    fits : tuple of Fit
        Those that kept up until then, the best first.
    left : tuple of Fit
        The best fit of each effect in each joint, at the rate at which it left the race.
    failed : mapping of str to str
        Effects that could not be simulated, with the reason.
    """

    base: Fit
    fits: tuple[Fit, ...]
    left: tuple[Fit, ...]
    failed: Mapping[str, str] = field(default_factory=dict)


def raced(
    data: DataSet,
    hypothesis: Hypothesis,
    x: FloatArray,
    known: Known,
    say: Callable[[str], None],
    *,
    channels: Channels | None = None,
    n_rates: int | None = None,
) -> Raced:
    """Return the effects that last in a race on top of a hypothesis.

    Parameters
    ----------
    data : DataSet
        The tests.
    hypothesis : Hypothesis
        What effects are added to.
    x : (n_x,) array
        Its coordinates, from which all begin [-].
    known : mapping of joint to mapping of str to Identification
        The effects that take part in each joint.
    say : callable
        Called with what is being tried.
    channels : Channels, optional
        Gains, delays and numbers of tests to start from.
    n_rates : int, optional
        Nudging rates after which the race ends; all by default.

    Raises
    ------
    DiagnosisError
        If the motion of the hypothesis runs away.
    """
    ladder = ladder_of(data)[:n_rates]
    on = fit(data, hypothesis, x, ladder[0].windows, rounds=0, channels=channels)
    if on is None:
        raise DiagnosisError(f"{data.model.title}: {RUNS_AWAY}")
    return race(on, known, ladder, say)


def race(on: Fit, known: Known, ladder: Sequence[Rung], say: Callable[[str], None]) -> Raced:
    """Return the remaining effects on top of a fit as the nudging rate falls.

    Parameters
    ----------
    on : Fit
        The hypothesis, at the first rate.
    known : mapping of joint to mapping of str to Identification
        The effects that take part in each joint.
    ladder : sequence of Rung
        The rates.
    say : callable
        Called with what is being tried.
    """
    first = _again(on, replace(ladder[0], windows=ladder[0].windows.some(ENTERED))) or on
    begun, failed = entered(first, known, say)
    left = {_group(one): one for one in begun.values()}
    near = _going_on(first, list(left.values()), known, behind=np.inf)
    base, fits = _as_recorded(first, chosen(near, MOST))
    least = np.inf
    for rung in ladder:
        say(f"held at {numeral(rung.rate)} per s")
        beside, there = _again(base, rung), [_again(one, rung) for one in fits]
        now = [one for one in there if one is not None]
        if beside is None or _lost([base, *fits], [beside, *now]):
            break
        if rung.judged:
            best = min((beside, *now), key=lambda one: one.level)
            error = error_of(best.data, best, rung.windows)
            if error > LONGER * least and not best.follows_most:
                break
            least = min(least, error)
        left |= {_group(one): one for one in now}
        base, fits = beside, chosen(_going_on(beside, now, known), MOST)
    last = _going_on(base, fits, known, behind=SURE)
    return Raced(base, tuple(last), _best_of_each(list(left.values())), failed)


def held(data: DataSet, hypothesis: Hypothesis, x: FloatArray) -> Fit | None:
    """Return a hypothesis fitted while it is held ever less; None where it runs away at first.

    Parameters
    ----------
    data : DataSet
        The tests.
    hypothesis : Hypothesis
        What is fitted.
    x : (n_x,) array
        Its coordinates at first [-].
    """
    first, *others = ladder_of(data)
    found = fit(data, hypothesis, x, first.windows, rounds=first.rounds, step=FARTHEST_STEP)
    for rung in others:
        found = None if found is None else _again(found, rung) or found
    return found


def _lost(before: Sequence[Fit], now: Sequence[Fit]) -> bool:
    """Return whether the motion cannot be predicted as far ahead: none follows it any more."""
    followed = any(one.follows_most for one in before)
    return followed and not any(one.follows_most for one in now)


def _as_recorded(base: Fit, fits: list[Fit]) -> tuple[Fit, list[Fit]]:
    """Return fits with accelerations compared as the recorder took them.

    The best of them tells, if it explains anything (see `sampling.as_recorded`).
    """
    best = min(fits, key=lambda one: one.level, default=base)
    data = as_recorded(base.data, best) if best.level < base.level else base.data
    if data is base.data:
        return base, fits

    def again(one: Fit) -> Fit:
        found = fit(
            data, one.hypothesis, one.x, one.windows, rounds=FIRST, channels=one.channels,
            step=FARTHEST_STEP,
        )  # fmt: skip
        return one if found is None else found

    return again(base), [again(one) for one in fits]


def _group(one: Fit) -> Group:
    added = one.hypothesis.added[-1]
    return added.kind, added.between, tuple(added.words.values())


def _best_of_each(fits: Sequence[Fit]) -> tuple[Fit, ...]:
    best: dict[tuple[str, Joint], Fit] = {}
    for one in fits:
        key = _group(one)[:2]
        if key not in best or one.level < best[key].level:
            best[key] = one
    return tuple(best.values())


def _again(found: Fit, rung: Rung) -> Fit | None:
    return fit(
        found.data, found.hypothesis, found.x, rung.windows, rounds=rung.rounds,
        channels=found.channels, step=found.steps,
    )  # fmt: skip


def _going_on(
    base: Fit, fits: Sequence[Fit], known: Known, *, behind: float = FAR
) -> list[Fit]:
    """Return the fits that may be the best where runs are held less.

    Those that stand so many standard errors `behind` [-] are left.
    """
    scores = [s for s in (as_fitted(one.data, one) for one in fits) if s is not None]
    own = as_fitted(base.data, base)
    return worth_a_fit(scores, known, beside=[] if own is None else [own], behind=behind)


def chosen(fits: Sequence[Fit], most: int) -> list[Fit]:
    """Return the best fits, so many at most, and the best in every joint."""
    order = sorted(fits, key=lambda one: one.level)
    first = {one.hypothesis.added[-1].between: one for one in reversed(order)}
    return [one for one in order if one in order[:most] or one in first.values()]
