"""The race: every law is fitted while it is held, and goes on as long as it keeps up."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.campaign import Campaign
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.form import Form
from shakerproc.diagnosis.estimation.least_squares import Fit, fit
from shakerproc.diagnosis.estimation.parts import Windows
from shakerproc.diagnosis.estimation.passed_noise import with_passed_noise
from shakerproc.diagnosis.estimation.residual_slopes import (
    FARTHEST_STEP,
)
from shakerproc.diagnosis.hypotheses.hypothesis import (
    Hypothesis,
    addition,
    hypothesis_of,
)
from shakerproc.diagnosis.hypotheses.joints import Joint, has_limit
from shakerproc.diagnosis.hypotheses.joints import Known as Laws
from shakerproc.diagnosis.nudged.known import Known
from shakerproc.diagnosis.nudged.pieces import pieces
from shakerproc.diagnosis.selection.errors import error_of, floors_of, pooled_floor
from shakerproc.diagnosis.selection.scores import Score, as_fitted, best_of, gain, scored
from shakerproc.models.identification import Contained, Values

LADDER: Final = ((1.0, 0.03), (0.3, 0.05), (0.1, 0.08), (0.03, 0.1), (0.01, 0.15), (0.0, 1.0))
"""Nudging rates over the angular frequency of the joint's motion, each a third of the last, and
the share of the tests that is fitted to at each [-]. At last runs are free."""

SCORED: Final = 4.0
"""Share of what is held out that is scored over the share of the rest that is fitted to [-]."""

LOOKED_AT: Final = 4
"""Pieces in which starts are compared [-]."""

FEW: Final = 2
"""Starts of a law that are fitted, of those that leave least [-]."""

FIRST: Final = 2
"""Steps of the first fit of each law: what it is worth shows by then [-]."""

ROUNDS: Final = 3
"""Steps of a fit at each rate: the next one goes on [-]."""

BEHIND: Final = 6.0
"""Standard errors by which a law may be behind the best and still goes on: once in 10^9 by
chance [-]."""

KEPT: Final = 2
"""Laws that go on however far behind [-]."""

Key = tuple[str, Joint, tuple[str, ...]]
"""Kind of an effect, its joint, and the words of its variant."""


@final
@dataclass(frozen=True, eq=False)
class Rung:
    """What a race was at one rate.

    Attributes
    ----------
    data : DataSet
        The tests.
    rate : float
        Nudging rate; 0 where the runs are free [1/s].
    form : Form
        What was fitted to and what was held out.
    base : Score
        What is left of the model without an effect.
    scores : tuple of Score
        The same of each law, the best first.
    """

    data: DataSet
    rate: float
    form: Form
    base: Score
    scores: tuple[Score, ...]

    @property
    def best(self) -> Score:
        """The law, or the model without one, that leaves least."""
        return best_of((self.base, *self.scores))

    @cached_property
    def error(self) -> float:
        """Error of the best in what was held out [-]."""
        return error_of(self.data, self.best.fit, self.form.held_out)

    @cached_property
    def floor(self) -> float:
        """What noise alone makes of it [-]."""
        return pooled_floor(floors_of(self.data, self.best.fit, self.form.held_out))


def race(campaign: Campaign, say: Callable[[str], None]) -> list[Rung]:
    """Return what is left of laws at each rate, until they run freely or all run away."""
    data = campaign.data
    none = hypothesis_of(data.model)
    rungs: list[Rung] = []
    live: list[Fit | None]
    for share, part in LADDER:
        rate = share * 2.0 * np.pi * data.frequency
        say(f"held at {rate:.3g} per s" if rate else "free runs")
        form = _form(data, rate, part)
        if rungs:
            rounds = ROUNDS if rate else 0
            base = _again(rungs[-1].base.fit, form, rounds)
            live = [_again(score.fit, form, rounds) for score in _survivors(rungs[-1])]
        else:
            base = fit(data, none, np.zeros(none.size), form.fitted, rounds=2 * ROUNDS)
            live = [] if base is None else [*_laws(campaign, base, form.fitted, say)]
        rung = None if base is None else _rung(data, rate, form, base, live)
        if rung is None:
            break
        rungs.append(rung)
    return rungs


def _form(data: DataSet, rate: float, share: float) -> Form:
    own = pieces(data, rate, share, held_out=False)
    scored_share = min(1.0, SCORED * share)
    held_out = pieces(data, rate, scored_share, held_out=True)
    return Form(1.0 / rate if rate else None, own, own, held_out)


def _again(found: Fit, form: Form, rounds: int) -> Fit | None:
    return fit(
        found.data, found.hypothesis, found.x, form.fitted, rounds=rounds,
        channels=found.channels, step=found.steps,
    )  # fmt: skip


def _rung(
    data: DataSet, rate: float, form: Form, base: Fit, fits: Sequence[Fit | None]
) -> Rung | None:
    live = [one for one in fits if one is not None]
    best = min((base, *live), key=lambda one: one.level)
    held_out = with_passed_noise(data, best, form.held_out)
    own = scored(data, base, held_out)
    scores = [s for s in (scored(data, one, held_out) for one in live) if s is not None]
    if own is None:
        return None
    ordered = tuple(sorted(scores, key=lambda s: s.mean))
    return Rung(data, rate, replace(form, held_out=held_out), own, ordered)


def _survivors(rung: Rung) -> list[Score]:
    best = rung.best
    out: list[Score] = []
    for score in rung.scores:
        if len(out) < KEPT or gain(best, score).t < BEHIND:
            out.append(score)
    return out


def _laws(
    campaign: Campaign, base: Fit, windows: Windows, say: Callable[[str], None]
) -> list[Fit]:
    """Return the best fit of every law in every joint, the simple ones first."""
    found: dict[Key, Fit] = {}
    known = Known(base, windows.some(LOOKED_AT))
    groups: dict[Key, list[tuple[Hypothesis, FloatArray]]] = {}
    for joint, laws in campaign.known.items():
        for kind, one in laws.items():
            for start in one.starts:
                words = tuple(v for v in start.values() if isinstance(v, str))
                groups.setdefault((kind, joint, words), []).append(
                    _begun(campaign, base, kind, joint, start)
                )
    size = {key: own[0][0].size for key, own in groups.items()}
    for key in sorted(groups, key=lambda key: size[key]):
        kind, joint, _ = key
        say(f"{kind} between {' and '.join(joint)}")
        starts = groups[key]
        for contained in campaign.known[joint][kind].contains:
            starts += _from_simpler(campaign, key, contained, found)
        best = _best(known, starts, windows)
        if best is not None:
            found[key] = best
    ahead = _ahead(list(found.values()), campaign.known)
    return [more for more in map(_more, ahead) if more is not None]


def _ahead(fits: Sequence[Fit], laws: Laws) -> list[Fit]:
    """Return the fits that are not far behind the best, and laws that are limits of those.

    A richer law begins where the simpler one ended, and is some steps ahead of it.
    """
    scores = [s for s in (as_fitted(one.data, one) for one in fits) if s is not None]
    scores.sort(key=lambda s: s.mean)
    ahead = [s.fit for i, s in enumerate(scores) if i < KEPT or gain(scores[0], s).t < BEHIND]
    leading = [_name(one) for one in ahead]
    limits = (
        s.fit
        for s in scores[len(ahead) :]
        if any(has_limit(laws, name, _name(s.fit)) for name in leading)
    )
    return [*ahead, *limits]


def _name(one: Fit) -> tuple[str, Joint]:
    added = one.hypothesis.added[-1]
    return added.kind, added.between


def _more(one: Fit) -> Fit | None:
    """Return a fit that goes on where it is."""
    return fit(
        one.data, one.hypothesis, one.x, one.windows, rounds=ROUNDS, channels=one.channels,
        step=one.steps,
    )  # fmt: skip


def _begun(
    campaign: Campaign, base: Fit, kind: str, joint: Joint, start: Values
) -> tuple[Hypothesis, FloatArray]:
    extra = addition(kind, joint, campaign.known[joint][kind], start)
    hypothesis = base.hypothesis.with_added(extra)
    return hypothesis, np.concatenate([base.x, extra.transformed(start)])


def _from_simpler(
    campaign: Campaign, key: Key, contained: Contained, found: dict[Key, Fit]
) -> list[tuple[Hypothesis, FloatArray]]:
    kind, joint, words = key
    out = []
    for (other, there, _), one in found.items():
        if other != contained.kind or there != joint:
            continue
        extra = one.hypothesis.added[-1]
        part = one.hypothesis.parts(one.x)[-1]
        for start in contained.extend({**extra.fixed, **extra.values(part)}):
            if tuple(v for v in start.values() if isinstance(v, str)) != words:
                continue
            own = replace(one, x=one.x[: one.x.size - part.size])
            plain = replace(one.hypothesis, added=one.hypothesis.added[:-1])
            out.append(_begun(campaign, replace(own, hypothesis=plain), kind, joint, start))
    return out


def _best(
    base: Known, starts: Sequence[tuple[Hypothesis, FloatArray]], windows: Windows
) -> Fit | None:
    """Return the best of fits from the starts that leave least."""
    moved = [base.moved(*start) for start in starts]
    order = sorted(range(len(starts)), key=lambda i: moved[i][0])[:FEW]
    fits = [
        fit(
            base.fit.data, starts[i][0], moved[i][1], windows, rounds=FIRST,
            channels=base.fit.channels, step=FARTHEST_STEP,
        )
        for i in order
        if np.isfinite(moved[i][0])
    ]  # fmt: skip
    good = [one for one in fits if one is not None]
    return min(good, key=lambda one: one.level) if good else None
