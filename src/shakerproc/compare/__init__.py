"""Measured against predicted: where and by how much a model fails."""

from shakerproc.compare.comparison import (
    Comparison,
    TestComparison,
    compare,
    compare_tests,
)
from shakerproc.compare.document import COLUMNS, document_of, rows_of
from shakerproc.compare.errors import Pair, SensorErrors
from shakerproc.compare.floor import Floor
from shakerproc.compare.joints import JointErrors, JointMotion, by_range
from shakerproc.compare.measured import Measured, Usable, measure, measured_tests, usable_tests
from shakerproc.compare.prediction import Prediction, predict
from shakerproc.compare.quiet import Quiet, quiet_of
from shakerproc.compare.refit import FittedParameter, Refit, refit
from shakerproc.compare.verdict import sentence

__all__ = [
    "COLUMNS",
    "Comparison",
    "FittedParameter",
    "Floor",
    "JointErrors",
    "JointMotion",
    "Measured",
    "Pair",
    "Prediction",
    "Quiet",
    "Refit",
    "SensorErrors",
    "TestComparison",
    "Usable",
    "by_range",
    "compare",
    "compare_tests",
    "document_of",
    "measure",
    "measured_tests",
    "predict",
    "quiet_of",
    "refit",
    "rows_of",
    "sentence",
    "usable_tests",
]
