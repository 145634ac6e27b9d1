"""Tests as arrays: what drives, what answers, what is held out, how noisy it is."""

from shakerproc.diagnosis.data.motion import RelativeMotion, members_of, models_of
from shakerproc.diagnosis.data.tests import (
    PreparedTest,
    TestArrays,
    check,
    prepared,
    with_noise_of,
)

__all__ = [
    "PreparedTest",
    "RelativeMotion",
    "TestArrays",
    "check",
    "members_of",
    "models_of",
    "prepared",
    "with_noise_of",
]
