"""The race: every law is fitted while it is held, and goes on as long as it keeps up."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final, TypeAlias, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.least_squares import Fit, fit
from shakerproc.diagnosis.estimation.residual_slopes import FARTHEST_STEP
from shakerproc.diagnosis.estimation.sampling import as_recorded
from shakerproc.diagnosis.horizon import LONGER
from shakerproc.diagnosis.hypotheses.hypothesis import Hypothesis
from shakerproc.diagnosis.hypotheses.joints import Joint, Known
from shakerproc.diagnosis.nudged.base import Base, Moved
from shakerproc.diagnosis.nudged.ladder import Rung
from shakerproc.diagnosis.nudged.starts import Group, beyond, own_starts
from shakerproc.diagnosis.selection.errors import error_of
from shakerproc.diagnosis.selection.scores import FAR, as_fitted, worth_a_fit
from shakerproc.numerals import numeral

LOOKED_AT: Final = 4
"""Pieces in which starts are compared [-]."""

ENTERED: Final = 8
"""Pieces in which each law is first fitted [-]."""

STARTED: Final = 6
"""Starts of a law that are fitted by one step, of those that leave least [-]."""

FEW: Final = 2
"""Of these so many that go on: steps tell more of a curved law than where it starts [-]."""

APART: Final = 0.2
"""Change of a coordinate from which on a start is another one [-]."""

FIRST: Final = 2
"""Steps of the first fit of each law: what it is worth shows by then [-]."""


Enter: TypeAlias = Callable[
    [Fit, Known, Callable[[str], None]], tuple[dict[Group, Fit], dict[str, str]]
]


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


def at_first(
    data: DataSet,
    hypothesis: Hypothesis,
    x: FloatArray,
    ladder: Sequence[Rung],
) -> Fit | None:
    """Return a hypothesis without more effects at the first rate; None if it runs away."""
    first = ladder[0]
    return fit(data, hypothesis, x, first.windows, rounds=2 * first.rounds)


def race(
    on: Fit,
    known: Known,
    ladder: Sequence[Rung],
    say: Callable[[str], None],
    *,
    enter: "Enter | None" = None,
    most: int | None = None,
) -> Raced:
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
    enter : callable, optional
        Returns the best fit of every effect at the first rate, and why others failed.
    most : int, optional
        So many go on from a rate to the next at most, beside the best in every joint.
    """
    first = _again(on, replace(ladder[0], windows=ladder[0].windows.some(ENTERED))) or on
    entered, failed = (enter or _entered)(first, known, say)
    base, fits = _as_recorded(first, list(entered.values()))
    left = {_group(one): one for one in fits}
    least = np.inf
    for rung in ladder:
        say(f"held at {numeral(rung.rate)} per s")
        going = chosen(_going_on(base, fits, known), most)
        beside, there = _again(base, rung), [_again(one, rung) for one in going]
        now = [one for one in there if one is not None]
        if beside is None or _lost([base, *fits], [beside, *now]):
            break
        if rung.judged:
            best = min((beside, *now), key=lambda one: one.level)
            error = error_of(best.data, best, rung.windows)
            if error > LONGER * least and not best.follows_most:
                break
            least = min(least, error)
        base, fits = beside, now
        left |= {_group(one): one for one in fits}
    fits = sorted(_going_on(base, fits, known), key=lambda one: one.level)
    return Raced(base, tuple(fits), _best_of_each(list(left.values())), failed)


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
    words = tuple(v for v in added.fixed.values() if isinstance(v, str))
    return added.kind, added.between, words


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


def _going_on(base: Fit, fits: Sequence[Fit], known: Known) -> list[Fit]:
    """Return the fits that may be the best where runs are held less."""
    scores = [s for s in (as_fitted(one.data, one) for one in fits) if s is not None]
    own = as_fitted(base.data, base)
    return worth_a_fit(scores, known, beside=[] if own is None else [own], behind=FAR)


def chosen(fits: Sequence[Fit], most: int | None) -> list[Fit]:
    """Return the best fits, so many at most, and the best in every joint."""
    order = sorted(fits, key=lambda one: one.level)
    if most is None:
        return list(fits)
    first = {one.hypothesis.added[-1].between: one for one in reversed(order)}
    return [one for one in order if one in order[:most] or one in first.values()]


def _entered(
    on: Fit, known: Known, say: Callable[[str], None]
) -> tuple[dict[Group, Fit], dict[str, str]]:
    """Return the best fit of every effect at the first rate, and why others failed.

    Those of few numbers first: richer ones begin where they ended, too.
    """
    base = Base(on, on.windows.some(LOOKED_AT))
    found: dict[Group, Fit] = {}
    failed: dict[str, str] = {}
    for group, own in own_starts(on, known).items():
        kind, joint, words = group
        say(f"{kind} between {' and '.join(joint)}")
        starts = base.best([*own, *beyond(group, known, found)])
        best = _best(base.fit, _apart(starts)[:STARTED])
        if best is None:
            failed[" ".join((kind, *words))] = "its motion runs away"
        else:
            found[group] = best
    return found, failed


def _apart(starts: Sequence[Moved]) -> list[Moved]:
    """Return starts in their order without those that are next to one before."""
    found: list[Moved] = []
    for one in starts:
        alike = (other for other in found if other[1].own == one[1].own)
        if all(float(np.max(np.abs(one[2] - other[2]))) > APART for other in alike):
            found.append(one)
    return found


def _best(on: Fit, starts: Sequence[Moved]) -> Fit | None:
    """Return the best of fits from starts."""
    first = [
        fit(
            on.data, hypothesis, x, on.windows, rounds=1, channels=on.channels,
            step=FARTHEST_STEP,
        )
        for _, hypothesis, x in starts
    ]  # fmt: skip
    near = sorted((one for one in first if one is not None), key=lambda one: one.level)[:FEW]
    fits = [
        fit(
            on.data, one.hypothesis, one.x, on.windows, rounds=FIRST, channels=one.channels,
            step=one.steps,
        )
        for one in near
    ]  # fmt: skip
    good = [*near, *(one for one in fits if one is not None)]
    return min(good, key=lambda one: one.level, default=None)
