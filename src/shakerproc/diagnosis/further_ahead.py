"""Beyond the horizon: whether what was chosen predicts there, and with which numbers."""

from collections.abc import Iterator
from weakref import WeakKeyDictionary

import numpy as np

from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.form import Form, carried
from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.estimation.windows import whole_tests
from shakerproc.diagnosis.found import Found, is_within
from shakerproc.diagnosis.horizon import PREDICTED
from shakerproc.diagnosis.selection.choice import NEGLIGIBLE
from shakerproc.diagnosis.selection.errors import (
    LONGER,
    PARTED,
    error_of,
    floors_of,
    pooled_floor,
)
from shakerproc.diagnosis.selection.scores import Score
from shakerproc.models import Model
from shakerproc.simulation.assembly import assemble

_THERE: WeakKeyDictionary[Fit, dict[Form, Fit | None]] = WeakKeyDictionary()


def carried_on(data: DataSet, found: Fit, form: Form) -> Iterator[tuple[Form, Fit | None]]:
    """Yield the longer forms, and a fit carried over from one to the next; each once."""
    here: Fit | None = found
    for beyond in form.beyond:
        if here is not None:
            there = _THERE.setdefault(here, {})
            if beyond not in there:
                there[beyond] = carried(data, here, [beyond])
            here = there[beyond] or here
            yield beyond, there[beyond]


def falls_short(found: Found, score: Score) -> bool:
    """Return whether a hypothesis fails further ahead, where noise lets predict.

    By what sensors can tell: a motion that parts quickly multiplies what is left of it.
    """
    for beyond, there in carried_on(found.data, score.fit, found.form):
        if there is None:
            return True
        left = error_of(found.data, there, beyond.held_out)
        if left <= max(NEGLIGIBLE, LONGER * found.left_by(score)):
            continue
        floor = pooled_floor(floors_of(found.data, there, beyond.held_out.some(PREDICTED)))
        if floor > PARTED or not is_within(left, floor):
            return floor <= PARTED
    return False


def ahead(data: DataSet, found: Fit, form: Form) -> Fit:
    """Return a fit with the numbers that predict whole tests best.

    Numbers of a law that is not all that is missing depend on how far it has to predict: those
    of a form are best as far as it reaches, and may lead astray in whole tests. Where a free
    body drifts with the constant of a force, whole tests do not tell.
    """
    if not form.beyond or not _is_held(data.model):
        return found
    fits = [found, *(one for _, one in carried_on(data, found, form) if one is not None)]
    driven = data.model.excitation.role is not None
    whole = whole_tests(data, held_out=True) if driven else form.beyond[-1].held_out
    return min(fits, key=lambda one: error_of(data.plain, one, whole))


def _is_held(model: Model) -> bool:
    """Return whether springs hold every mass."""
    n = model.n_coordinates
    return bool(np.linalg.matrix_rank(assemble(model).machine.matrix[:n, :n]) == n)
