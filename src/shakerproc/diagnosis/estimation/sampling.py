"""How the recorder took accelerations: as values at the samples, or filtered."""

from typing import Final

import numpy as np

from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.least_squares import Fit, fit
from shakerproc.diagnosis.estimation.residual_slopes import FARTHEST_STEP
from shakerproc.diagnosis.selection.scores import SURE, Score, as_fitted, gain
from shakerproc.simulation import is_smooth

ROUNDS: Final = 10
"""Steps of both fits: what is compared has to arrive first [-]."""


def as_recorded(data: DataSet, found: Fit) -> DataSet:
    """Return the tests with accelerations compared as the recorder took them.

    A recorder with a filter hears of a jump or a kink what lies below half the sample rate:
    means over a sample alias next to nothing. One without takes values at the samples, in
    which they alias; so does then the simulation. Smooth motion is the same in both.

    Parameters
    ----------
    data : DataSet
        As they are compared so far: those that are compared as values already stay so, and
        those of a smooth motion.
    found : Fit
        A model fitted to any windows. It is fitted anew in both ways, as neither tells much
        before it arrives; the values win where they are surely better. Where they are worse
        where it stands, it is not: what folds back is larger than what is off by it.
    """
    if data.points or is_smooth(found.hypothesis.model_at(found.x)):
        return data
    values = data.as_values()
    if not _certainty(as_fitted(values, found), as_fitted(data, found)) > 0.0:
        return data
    first = _fitted(data, found)
    second = None if first is None else _fitted(values, first)
    if first is None or second is None:
        return data
    certainty = _certainty(as_fitted(values, second), as_fitted(data, first))
    return values if certainty > SURE else data


def _fitted(data: DataSet, found: Fit) -> Fit | None:
    """Return a fit that goes on to where it arrives, as accelerations are compared now."""
    return fit(
        data, found.hypothesis, found.x, found.windows, rounds=ROUNDS,
        channels=found.channels, starts=found.starts, step=FARTHEST_STEP,
    )  # fmt: skip


def _certainty(values: Score | None, means: Score | None) -> float:
    """Return by how many standard errors values are better than means."""
    return -np.inf if values is None or means is None else gain(values, means).t
