"""Beyond the horizon: whether what was chosen predicts there, and with which numbers."""

from shakerproc.comparison.free_bodies import is_held
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.form import Form, carried
from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.estimation.windows import whole_tests
from shakerproc.diagnosis.found import Found, is_within
from shakerproc.diagnosis.horizon import LONGER, PREDICTED
from shakerproc.diagnosis.selection.errors import error_of, floors_of, pooled_floor
from shakerproc.diagnosis.selection.scores import Score


def falls_short(found: Found, score: Score) -> bool:
    """Return whether a hypothesis fails at a longer horizon at which noise lets predict."""
    if not found.form.beyond:
        return False
    beyond = found.form.beyond[0]
    there = carried(found.data, score.fit, [beyond])
    if there is None:
        return True
    left = error_of(found.data, there, beyond.held_out)
    floor = pooled_floor(floors_of(found.data, there, beyond.held_out.some(PREDICTED)))
    return left > LONGER * found.left_by(score) and not is_within(left, floor)


def ahead(data: DataSet, found: Fit, form: Form) -> Fit:
    """Return a fit with the numbers that predict whole tests best.

    Numbers of a law that is not all that is missing depend on how far it has to predict: those
    of a form are best as far as it reaches, and may lead astray in whole tests. Where a free
    body drifts with the constant of a force, whole tests do not tell.
    """
    if not form.beyond or not is_held(data.model):
        return found
    fits = [found]
    for beyond in form.beyond:
        there = carried(data, fits[-1], [beyond])
        fits += [] if there is None else [there]
    driven = data.model.excitation.role is not None
    whole = whole_tests(data, held_out=True) if driven else form.beyond[-1].held_out
    return min(fits, key=lambda one: error_of(data.plain, one, whole))
