"""Further linear modes of the specimen that show only beside an effect."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from shakerproc.diagnosis.campaign import Campaign
from shakerproc.diagnosis.data import PreparedTest
from shakerproc.diagnosis.estimation.correction import without_driven
from shakerproc.diagnosis.estimation.form import Form, carried
from shakerproc.diagnosis.estimation.further_modes import APART, MOST, WIDEST
from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.estimation.linear import fit_linear
from shakerproc.diagnosis.estimation.linear_model import LinearModel
from shakerproc.diagnosis.estimation.linear_response import poles_of
from shakerproc.diagnosis.horizon import scored_at
from shakerproc.diagnosis.hypotheses.joints import Known
from shakerproc.diagnosis.nudged.race import Raced, raced
from shakerproc.diagnosis.outcome import Outcome
from shakerproc.diagnosis.progress import Progress
from shakerproc.diagnosis.selection.errors import takes_most
from shakerproc.diagnosis.selection.scores import (
    SURE,
    Score,
    as_fitted,
    best_of,
    gain,
    leaves_something,
)
from shakerproc.models import Mode
from shakerproc.models.effects import AttachedMode

FASTEST: Final = 0.4
"""Highest frequency of a mode that is tried, over the sample rate: filters of recorders end
there [-]."""

N_RATES: Final = 2
"""Nudging rates at which a mode is sought, the highest: it is far above all of them [-]."""

STARTS: Final = 64
"""Frequencies at which a mode is tried [-]."""

MASS: Final = 0.02
"""Mass of a mode that is tried, over that of its place; a fit goes on from there [-]."""

DAMPING_RATIO: Final = 0.01
"""Damping ratio of a mode that is tried, likewise [-]."""


def with_modes_beside(
    outcome: Outcome,
    linear_model: LinearModel,
    tests: Sequence[PreparedTest],
    say: Progress,
) -> tuple[LinearModel, Sequence[PreparedTest]] | None:
    """Return a linear model with modes that the best hypothesis with an effect lacks.

    And the tests that it is to explain; None where no mode is missing.

    Parameters
    ----------
    outcome : Outcome
        What is left of the hypotheses.
    linear_model : LinearModel
        What they stand on.
    tests : sequence of PreparedTest
        What they explain.
    say : Progress
        Called with what is being tried, and asked whether there is time for it.
    """
    best = best_of([outcome.linear, *outcome.effects])
    known = len(outcome.campaign.data.model.modes) + len(linear_model.driven)
    if not leaves_something(best) or not best.fit.hypothesis.added or known >= MOST:
        return None
    if not say.has_time_for("a further mode beside the effect"):
        return None
    found = _driven_beside(outcome)
    if found is not None:
        driven = (*linear_model.driven, *found.driven)
        return replace(linear_model, driven=driven), without_driven(tests, found)
    mode = _attached_beside(outcome, best)
    return None if mode is None else (linear_model.with_mode(mode), tests)


def _driven_beside(outcome: Outcome) -> LinearModel | None:
    """Return the modes that the drive alone excites beside an effect; None without any.

    What the best effect that is no mode itself adds to the linear response, whole tests
    simulated, hides them no longer. Without them it has to predict surely better, and leave
    little of what it left.
    """
    campaign, form = outcome.campaign, outcome.forms[-1]
    data = campaign.data
    effects = [one for one in outcome.effects if not _has_mode(one)]
    if data.model.structures or not effects:
        return None
    best = best_of(effects)
    model = best.fit.hypothesis.model_at(best.fit.x)
    found = fit_linear(model, data.tests, own_numbers=False)
    if not found.driven:
        return None
    clean = replace(campaign, data=replace(data, tests=without_driven(data.tests, found)))
    there = carried(clean.data, best.fit, [form])
    is_one = there is not None and _tells(clean, best, there, form)
    return found if is_one else None


def _has_mode(score: Score) -> bool:
    return AttachedMode.kind in score.fit.hypothesis.kinds


def _attached_beside(outcome: Outcome, best: Score) -> Mode | None:
    """Return an attached mode that a hypothesis with an effect lacks; None without one.

    A strong effect hides it in spectra. While it is held an attached mode is fitted beside all
    numbers of the effect, far above the model's own modes (see `further_modes.APART`); at the
    horizon it has to take most of what is left beyond the noise. Where noise alone is left
    there is nothing to take.
    """
    campaign, form = outcome.campaign, outcome.forms[-1]
    known = _modes(campaign)
    if not known:
        return None
    on = best.fit
    modes = raced(
        campaign.data, on.hypothesis, on.x, known, lambda _: None, channels=on.channels,
        n_rates=N_RATES,
    )  # fmt: skip
    if not _gains_while_held(modes):
        return None
    there = carried(campaign.data, modes.fits[0], [form])
    is_one = (
        there is not None and _is_mode(campaign, there) and _tells(campaign, best, there, form)
    )
    return _as_mode(there) if there is not None and is_one else None


def _gains_while_held(modes: Raced) -> bool:
    """Return whether the best mode of a race leaves surely less than the model without it."""
    held = [as_fitted(one.data, one) for one in (*modes.fits[:1], modes.base)]
    scores = [score for score in held if score is not None]
    return len(scores) == 2 and gain(*scores).t > SURE


def _lowest(campaign: Campaign) -> float:
    """Return above which frequency a mode is a further one; infinite without any [Hz]."""
    own = poles_of(replace(campaign.data.model, modes=()))
    return APART * float(max(own.frequencies, default=np.inf))


def _modes(campaign: Campaign) -> Known:
    """Return where the search for a mode begins, on every mass."""
    data = campaign.data
    lowest = _lowest(campaign)
    highest = FASTEST * min(test.sample_rate for test in data.tests)
    if lowest >= highest or data.model.structures:  # whose own modes are numbers of the fit
        return {}
    kind = AttachedMode.kind
    places = {j[1]: j for j, own in campaign.known.items() if kind in own}
    frequencies = np.geomspace(lowest, highest, STARTS)
    return {
        joint: {
            kind: replace(
                campaign.known[joint][kind],
                starts=tuple(_tried(data.model.masses[at], float(f)) for f in frequencies),
            )
        }
        for at, joint in places.items()
        if at in data.model.masses
    }


def _tried(mass: float, frequency: float) -> dict[str, float]:
    return {"mass": MASS * mass, "frequency": frequency, "damping_ratio": DAMPING_RATIO}


def _values(found: Fit) -> tuple[str, float, float, float]:
    """Return place, mass [kg], frequency [Hz] and damping ratio of the mode in a fit."""
    last = found.hypothesis.added[-1]
    values = last.values(found.hypothesis.parts(found.x)[-1])
    return last.between[1], values["mass"], values["frequency"], values["damping_ratio"]


def _is_mode(campaign: Campaign, found: Fit) -> bool:
    """Return whether what was fitted lies where a further mode may, and is one."""
    place, _, frequency, damping_ratio = _values(found)
    fits = _as_mode(found).mass < campaign.data.model.rigid_masses[place]
    return fits and frequency > _lowest(campaign) and damping_ratio < WIDEST


def _tells(campaign: Campaign, best: Score, found: Fit, form: Form) -> bool:
    """Return whether a mode surely predicts better, and takes most of what is left."""
    scores = scored_at(campaign, [found], form)
    return (
        bool(scores)
        and gain(scores[0], best).t > SURE
        and takes_most(best.fit, found, form.held_out)
    )


def _as_mode(found: Fit) -> Mode:
    """Return the mode of a fit: of a place whose mass is given it takes a part of that.

    An attached mode adds to it.
    """
    place, mass, frequency, damping_ratio = _values(found)
    rest = found.hypothesis.model_at(found.x).rigid_masses[place]
    held = 1.0 if found.hypothesis.frees_masses else rest / (rest + mass)
    return Mode(frequency, damping_ratio, held * mass, {place: 1.0})
