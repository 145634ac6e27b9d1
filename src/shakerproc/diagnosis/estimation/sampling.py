"""How the recorder took accelerations: as values at the samples, or filtered."""

from typing import Final

from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.least_squares import Fit, fit
from shakerproc.diagnosis.estimation.residual_slopes import FARTHEST_STEP
from shakerproc.diagnosis.selection.scores import SURE, as_fitted, gain
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
        before it arrives; the values win where they are surely better.
    """
    if data.points or is_smooth(found.hypothesis.model_at(found.x)):
        return data
    means = fit(
        data, found.hypothesis, found.x, found.windows, rounds=ROUNDS,
        channels=found.channels, starts=found.starts, step=FARTHEST_STEP,
    )  # fmt: skip
    if means is None:
        return data
    values = fit(
        data.as_values(), means.hypothesis, means.x, means.windows, rounds=ROUNDS,
        channels=means.channels, starts=means.starts, step=FARTHEST_STEP,
    )  # fmt: skip
    if values is None:
        return data
    own, other = as_fitted(values.data, values), as_fitted(data, means)
    if own is None or other is None or gain(own, other).t < SURE:
        return data
    return values.data
