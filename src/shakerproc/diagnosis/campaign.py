"""Data and model that all hypotheses about a campaign share."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from shakerproc.diagnosis.data import Test
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.growth import Stages, stages_of
from shakerproc.diagnosis.hypotheses.joints import Known, identifications, joints_of, scales_of
from shakerproc.models import Model


@final
@dataclass(frozen=True, slots=True, eq=False)
class Campaign:
    """Data and model that all hypotheses share.

    Attributes
    ----------
    data : DataSet
        The tests, and the model with its further modes, as it is fitted.
    fitted : tuple of Test
        Those that may be fitted to.
    known : mapping of joint to mapping of str to Identification
        What each effect says of each joint.
    stages : Stages
        Windows that grow.
    """

    data: DataSet
    fitted: tuple[Test, ...]
    known: Known
    stages: Stages


def campaign_of(model: Model, tests: Sequence[Test]) -> Campaign:
    """Return the shared data of hypotheses, from a model with further modes and the tests."""
    data = DataSet(model, tuple(tests))
    motions = {joint: data.across(joint) for joint in joints_of(model)}
    return Campaign(
        data=data,
        fitted=tuple(test for test in tests if not test.arrays.hold_out),
        known={
            j: identifications(scales_of(model, tests, j, own)) for j, own in motions.items()
        },
        stages=stages_of(data),
    )
