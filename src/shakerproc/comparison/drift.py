"""Whether the model fails more and more while a test runs."""

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.comparison.free_run_error import squares
from shakerproc.comparison.prediction import Prediction
from shakerproc.data import FloatArray

BLOCKS: Final = 24
"""Parts that a run is cut into."""

_AUDIBLE: Final = 0.05  # of the loudest block: below it there is no response to explain


@final
@dataclass(frozen=True, slots=True, eq=False)
class TimeErrors:
    """Error along one test.

    Attributes
    ----------
    time : (n_blocks,) array
        Middle of each block, from the start of the recording [s].
    error : (n_sensors, n_blocks) array
        Free-run error of the block; not a number where there is next to no response [-].
    slope : (n_sensors,) array
        Steady growth of the error over the whole test, as a share of its mean [-].
    """

    time: FloatArray
    error: FloatArray
    slope: FloatArray


def time_errors(prediction: Prediction) -> TimeErrors:
    """Return the free-run error along a test."""
    measured, counted = prediction.measured, prediction.scored.counted
    n_blocks = min(BLOCKS, prediction.input.size // 64)
    size = prediction.input.size // n_blocks
    part = slice(measured.start, measured.start + n_blocks * size)
    number = np.maximum(1, counted[part].reshape(n_blocks, size).sum(axis=1))
    left, whole = (
        np.sqrt((rows * counted)[:, part].reshape(len(rows), n_blocks, size).sum(2) / number)
        for rows in squares(prediction.scored)
    )
    heard = whole > _AUDIBLE * whole.max(axis=1, keepdims=True)
    error = np.where(heard, left / np.where(heard, whole, 1.0), np.nan)
    middle = measured.start + (np.arange(n_blocks, dtype=float) + 0.5) * size
    time: FloatArray = np.asarray(middle / measured.sample_rate, dtype=float)
    return TimeErrors(time, error, np.array([_slope(row) for row in error]))


def _slope(error: FloatArray) -> float:
    """Return the growth of a straight line through the blocks over their mean."""
    known = np.flatnonzero(np.isfinite(error))
    if known.size < 3 or not error[known].mean() > 0.0:
        return 0.0
    steepness = float(np.polyfit(known, error[known], 1)[0])
    return steepness * error.size / float(error[known].mean())
