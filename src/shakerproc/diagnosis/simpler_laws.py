"""The simpler hypotheses that a fitted one contains, begun where it ended."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize

from shakerproc.data import FloatArray
from shakerproc.diagnosis.campaign import Campaign
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.form import ROUNDS, Form
from shakerproc.diagnosis.estimation.least_squares import Fit, fit, gone_on
from shakerproc.diagnosis.estimation.levels import level_at
from shakerproc.diagnosis.estimation.richer_laws import FIRST_ROUNDS
from shakerproc.diagnosis.horizon import scored_at
from shakerproc.diagnosis.hypotheses.hypothesis import Addition, Hypothesis, addition
from shakerproc.diagnosis.hypotheses.joints import Joint, Known
from shakerproc.diagnosis.nudged.ladder import ladder_of
from shakerproc.diagnosis.nudged.race import ENTERED
from shakerproc.diagnosis.selection.scores import (
    FAR,
    Score,
    as_fitted,
    best_of,
    best_of_each,
    gain,
)
from shakerproc.errors import ModelError
from shakerproc.models.identification import Contained, Identification, Values
from shakerproc.simulation import motions_of


def with_simpler(
    campaign: Campaign, form: Form, bare: Score, effects: Sequence[Score]
) -> tuple[Score, list[Score]]:
    """Return the score without effects, and those with, of what the best of these contains.

    A law that was tried alone has no rival of fewer numbers, and the model without any may have
    stopped at a least value that its own numbers lead out of.
    """
    if not effects:
        return bare, []
    data, best = campaign.data, best_of(effects).fit
    found = scored_at(campaign, simpler_laws(data, best, campaign.known), form)
    alone = scored_at(campaign, [_without_effects(data, best)], form)
    return best_of([bare, *alone]), best_of_each([*effects, *found])


def _without_effects(data: DataSet, found: Fit) -> Fit | None:
    """Return the model alone, begun with its own numbers in a fit; None if far behind that."""
    none = replace(found.hypothesis, added=())
    own = found.hypothesis.parts(found.x)[0]
    try:
        starts = starts_with(found, none, own)
    except ModelError:  # no model stands so without its effect
        return None
    first = fit(
        data, none, own, found.windows, rounds=FIRST_ROUNDS, channels=found.channels,
        starts=starts,
    )  # fmt: skip
    is_near = first is not None and not _is_far_behind(data, first, found)
    return gone_on(first, rounds=ROUNDS) if first is not None and is_near else None


def simpler_laws(data: DataSet, found: Fit, known: Known) -> list[Fit]:
    """Return a fit with each law that an effect contains in its place, and without one of two.

    The richer law may have been fitted alone, or have reached a least value that the simpler
    one missed: that begins with the numbers whose richer law is nearest, or from a start of
    its own, whichever leaves less while it is held. One that is far behind after a few steps
    is left out.

    Parameters
    ----------
    data : DataSet
        The tests.
    found : Fit
        One or more effects.
    known : mapping of joint to mapping of str to Identification
        Laws that may be missing.
    """
    waiting, fits = [found], dict[frozenset[tuple[str, Joint]], Fit]()
    held = ladder_of(data)[0].windows.some(ENTERED)
    tried = {found.hypothesis.names}
    while waiting:
        richer = waiting.pop()
        for hypothesis, begun in _contained(richer, known):
            if hypothesis.names in tried:
                continue
            tried.add(hypothesis.names)
            levels = [level_at(data, hypothesis, one, held, richer.channels) for one in begun]
            x = begun[int(np.argmin(levels))]
            try:
                starts = starts_with(richer, hypothesis, x)
            except ModelError:  # no model can begin so
                continue
            first = fit(
                data, hypothesis, x, found.windows, rounds=FIRST_ROUNDS,
                channels=richer.channels, starts=starts,
            )  # fmt: skip
            if first is None:
                continue
            waiting.append(first)
            if not _is_far_behind(data, first, found):
                waiting[-1] = fits[hypothesis.names] = gone_on(first, rounds=ROUNDS)
    return list(fits.values())


def _contained(found: Fit, known: Known) -> Iterator[tuple[Hypothesis, list[FloatArray]]]:
    """Yield a hypothesis with a simpler law or none in place of one effect; where it begins.

    With the numbers whose richer law is nearest, and with its own starts.
    """
    own, *parts = found.hypothesis.parts(found.x)
    added = found.hypothesis.added
    for i, (richer, x) in enumerate(zip(added, parts, strict=True)):
        if len(added) > 1:
            without = replace(found.hypothesis, added=added[:i] + added[i + 1 :])
            yield without, [np.concatenate([own, *parts[:i], *parts[i + 1 :]])]
        laws = known.get(richer.between, {})
        for law in laws[richer.kind].contains if richer.kind in laws else ():
            if law.kind not in laws:
                continue
            values = _nearest(laws[law.kind], law, richer, x)
            one = addition(law.kind, richer.between, laws[law.kind], values)
            hypothesis = replace(found.hypothesis, added=(*added[:i], one, *added[i + 1 :]))
            yield (
                hypothesis,
                [
                    np.concatenate([own, *parts[:i], one.transformed(v), *parts[i + 1 :]])
                    for v in (values, *laws[law.kind].starts)
                    if {**v, **one.fixed} == v
                ],
            )


def _is_far_behind(data: DataSet, one: Fit, found: Fit) -> bool:
    """Return whether a fit surely leaves far more than another one of the same windows."""
    own, best = as_fitted(data, one), as_fitted(data, found)
    return own is None or (best is not None and gain(best, own).t > FAR)


def starts_with(found: Fit, other: Hypothesis, x: FloatArray) -> FloatArray | None:
    """Return the starts of a fit for another hypothesis: masses as there, memory as if new.

    Raises
    ------
    ModelError
        If no model can have the numbers of that.
    """
    if found.starts is None:
        return None
    had = motions_of(found.hypothesis.model_at(found.x))
    wanted = motions_of(other.model_at(x))
    starts = np.zeros((len(found.starts), len(wanted)))
    for i, name in enumerate(wanted):
        if name in had and not name.startswith("state"):
            starts[:, i] = found.starts[:, had.index(name)]
    return starts


def _nearest(
    simpler: Identification, law: Contained, richer: Addition, x: FloatArray
) -> Values:
    """Return the numbers of a simpler law whose richer law is nearest a fitted one.

    By the squares of the differences of its coordinates.
    """

    def values(at: FloatArray, start: Values) -> Values:
        free = zip(simpler.free.items(), at, strict=True)
        return {**start, **{name: one.from_fitted(float(v)) for (name, one), v in free}}

    def apart(at: FloatArray, start: Values) -> float:
        there = [richer.transformed(one) for one in law.extend(values(at, start))]
        return min((float(np.sum((one - x) ** 2)) for one in there), default=np.inf)

    begun = [
        (np.array([one.to_fitted(float(start[n])) for n, one in simpler.free.items()]), start)
        for start in simpler.starts
    ]
    first, start = min(begun, key=lambda one: apart(*one))
    return values(minimize(apart, first, (start,), method="Nelder-Mead").x, start)
