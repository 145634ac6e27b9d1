"""The verdict where nothing is named, and what is said of that."""

from collections.abc import Mapping, Sequence

import numpy as np

from shakerproc.diagnosis import number_wording, wording
from shakerproc.diagnosis.estimate import Estimate
from shakerproc.diagnosis.estimation.intervals import numbers_off
from shakerproc.diagnosis.found import Found
from shakerproc.diagnosis.joint_outcomes import Outside
from shakerproc.diagnosis.result import Errors, Finding
from shakerproc.diagnosis.selection.choice import bare, leaves_more
from shakerproc.diagnosis.selection.proposing import Unexercised
from shakerproc.diagnosis.selection.scores import Score
from shakerproc.models.effects import Table


def nothing_named(
    found: Found,
    chosen: Score,
    errors: Errors,
    unclosed: Unexercised | None,
    far: Mapping[str, tuple[float, Estimate]],
    *,
    apart: Sequence[str],
) -> tuple[str, str]:
    """Return the verdict where nothing was found: a clearance may never have been closed.

    `apart` are sentences on where it does not hold.
    """
    which = "the fitted model" if chosen is found.linear else "the model as it is in its file"
    unnamed = wording.unnamed_sentence(errors.among, which, _least(found))
    known = np.isfinite(errors.noise_floor)
    if known and leaves_more(found, chosen):
        return "cannot tell", unnamed
    if far:
        return "cannot tell", wording.far_sentence(far)
    if unclosed is not None:
        sentence = wording.unexercised_sentence(
            unclosed.clearance, unclosed.reach, found.data.model.motion
        )
        return "cannot tell", sentence
    if not known:
        return "cannot tell", unnamed
    if apart:
        sentence = f"{unnamed} {apart[0]}"
        return "cannot tell", sentence
    complete = found.is_explained_by(chosen)
    said = [wording.nothing_sentence(errors, which, complete=complete)]
    if chosen is found.linear:
        said += number_wording.off_sentences(numbers_off(chosen.fit))
    said += wording.noise_sentences(errors)
    return "nothing missing", " ".join(said)


def outside_sentence(found: Found, effects: Sequence[Finding], errors: Errors) -> str:
    """Return the verdict that no effect will do, and which one to add meanwhile."""
    free = found.free or found.best
    return wording.outside_sentence(
        found.left_by(free), _least(found)[1], found.floor, effects, errors
    )


def _least(found: Found) -> tuple[str, float]:
    """Return the name of what leaves least of all that was tried, and what it leaves [-]."""
    best = min((bare(found), found.linear, *found.effects), key=found.left_by)
    kinds = " and ".join(kind.replace("_", " ") for kind in best.fit.hypothesis.kinds)
    return kinds or "the fitted model", found.left_by(best)


def outside_curve(found: Found) -> Outside | None:
    """Return the force without a name as a curve [N] over motion [m], [m/s]."""
    if found.free is None:
        return None
    element = found.free.fit.hypothesis.model.elements[-1]
    table = element.effect
    if not isinstance(table, Table):
        return None
    band = table.band or tuple(tuple(0.0 for _ in row) for row in table.force)
    motion = found.data.model.motion
    return Outside(
        element.between, table.displacement, table.velocity, table.force, band, motion
    )
