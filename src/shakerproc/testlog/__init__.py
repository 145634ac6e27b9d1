"""The YAML log sheet of a campaign, read into a TestLog; every message with line and column.

What reads it is loaded when it is first asked for: a process that works on a test needs none.
"""

from typing import TYPE_CHECKING, Any

from shakerproc.late import loaded
from shakerproc.testlog.excitation import (
    BROADBAND,
    PULSES,
    Excitation,
    Hammer,
    Multisine,
    Profile,
    ProfileNotch,
    level_of,
    threshold_of,
)
from shakerproc.testlog.header import ChosenUnits, Shaker, chosen_units
from shakerproc.testlog.log import TestLog, facts_of
from shakerproc.testlog.one_test import Expectation, Test, check_expectation, nominal_duration
from shakerproc.testlog.processing import (
    Modal,
    Peaks,
    Processing,
    ResponseFunction,
    ThresholdCrop,
    TimeCrop,
    Welch,
)

if TYPE_CHECKING:
    from shakerproc.testlog.reading import read_testlog


def __getattr__(name: str) -> Any:
    if name != "read_testlog":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return loaded("shakerproc.testlog.reading:read_testlog")
