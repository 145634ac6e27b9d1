"""Measured and simulated: the one error, its floor, and where in a test a model fails."""

from shakerproc.comparison.comparison import (
    Comparison,
    TestComparison,
    compare,
    compare_tests,
    scored_alike,
)
from shakerproc.comparison.document import COLUMNS, document_of, rows_of
from shakerproc.comparison.errors import Pair, SensorErrors
from shakerproc.comparison.floor import Floor, floor_shares
from shakerproc.comparison.free_run_error import (
    Scored,
    fall,
    free_run_error,
    relative_errors,
    relative_residuals,
    standard_error,
)
from shakerproc.comparison.held_out import held_out, held_out_samples
from shakerproc.comparison.joints import JointErrors, JointMotion, NotTold, by_range
from shakerproc.comparison.measured import (
    Measured,
    Usable,
    measure,
    measured_tests,
    usable_tests,
)
from shakerproc.comparison.noise import Noise, noise_of
from shakerproc.comparison.noise_sources import Channels, Quiet, quiet_of
from shakerproc.comparison.own import as_means, at_samples
from shakerproc.comparison.prediction import Prediction, predict
from shakerproc.comparison.refit import FittedParameter, Refit, refit
from shakerproc.comparison.verdict import explained, sentence
from shakerproc.comparison.windows import EvenWindows, run_windows, windows_of

__all__ = [
    "COLUMNS",
    "Channels",
    "Comparison",
    "EvenWindows",
    "FittedParameter",
    "Floor",
    "JointErrors",
    "JointMotion",
    "Measured",
    "Noise",
    "NotTold",
    "Pair",
    "Prediction",
    "Quiet",
    "Refit",
    "Scored",
    "SensorErrors",
    "TestComparison",
    "Usable",
    "as_means",
    "at_samples",
    "by_range",
    "compare",
    "compare_tests",
    "document_of",
    "explained",
    "fall",
    "floor_shares",
    "free_run_error",
    "held_out",
    "held_out_samples",
    "measure",
    "measured_tests",
    "noise_of",
    "predict",
    "quiet_of",
    "refit",
    "relative_errors",
    "relative_residuals",
    "rows_of",
    "run_windows",
    "scored_alike",
    "sentence",
    "standard_error",
    "usable_tests",
    "windows_of",
]
