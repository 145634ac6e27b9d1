"""Structures: every effect in every joint races, held to what sensors tell of the motion.

A window that begins anew has a start for every mode, more of them than there are sensors; a
model that is held needs none.
"""

from collections.abc import Callable
from typing import Final

from shakerproc.diagnosis.campaign import RUNS_AWAY, Campaign
from shakerproc.diagnosis.estimation.beginnings import as_in
from shakerproc.diagnosis.estimation.least_squares import fit
from shakerproc.diagnosis.estimation.linear_model import LinearModel
from shakerproc.diagnosis.hypotheses.hypothesis import hypothesis_of
from shakerproc.diagnosis.hypotheses.joints import Known
from shakerproc.diagnosis.nudged.ladder import ladder_of
from shakerproc.diagnosis.nudged.many_joints import entered
from shakerproc.diagnosis.nudged.race import Raced, race
from shakerproc.errors import DiagnosisError

MOST: Final = 4
"""Hypotheses that go on from one rate to the next at most [-]."""


def raced(
    campaign: Campaign,
    linear_model: LinearModel,
    known: Known,
    say: Callable[[str], None],
) -> Raced:
    """Return the effects that last in a race on top of a model as the lowest level tells it.

    Parameters
    ----------
    campaign : Campaign
        The tests.
    linear_model : LinearModel
        Numbers of joints and modes, from which all begin.
    known : mapping of joint to mapping of str to Identification
        The effects that take part in each joint.
    say : callable
        Called with what is being tried.

    Raises
    ------
    DiagnosisError
        If the motion of the model runs away.
    """
    data = campaign.data
    none, ladder = hypothesis_of(data.model), ladder_of(data)
    x = as_in(none, linear_model.model)
    on = fit(data, none, x, ladder[0].windows, rounds=0)
    if on is None:
        raise DiagnosisError(f"{data.model.title}: {RUNS_AWAY}")
    return race(on, known, ladder, say, enter=entered, most=MOST)
