"""The one residual: what was measured less what the free-running model says, over the noise.

Whole tests from rest, windows with starts of their own and component tests are all rows of one
table of windows; what differs is where a window begins and whether its start is fitted.
"""

from dataclasses import dataclass
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.parts import Windows
from shakerproc.models import Model
from shakerproc.simulation import Runs, free_runs

TOLERANCE: Final = 1e-5
"""Truncation of a simulation that is compared with a measurement [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Predicted:
    """What the free-running model says in every window.

    Attributes
    ----------
    outputs : tuple of (n_sensors, n_samples) array
        As the sensors record it [unit of the sensor].
    failed : (n_windows,) array of bool
        Which windows ran away.
    """

    outputs: tuple[FloatArray, ...]
    failed: NDArray[np.bool_]


def predict(
    data: DataSet,
    model: Model,
    windows: Windows,
    starts: FloatArray | None,
    offset: FloatArray | None = None,
    *,
    evened: bool = False,
    plain: bool = False,
) -> Predicted:
    """Return what the free-running model says.

    Parameters
    ----------
    data : DataSet
        The tests.
    model : Model
        What is simulated.
    windows : Windows
        Which parts.
    starts : (n_windows, n_motions) array or None
        Motion where they begin, and states of the laws.
    offset : (n_offsets,) array, optional
        Constant of the input of each test, over its rms [-].
    evened : bool
        Whether accelerations, where they are values at the samples, are to be means over the
        sample before and the one after: what is expected of a jump somewhere between them.
    plain : bool
        Whether means keep what folds back of jumps.

    Raises
    ------
    ModelError
        If the model cannot be assembled.
    """
    inputs = data.inputs if offset is None else data.inputs_with(offset)
    runs = Runs(inputs, windows.table, starts)
    means = evened or not data.points
    found = free_runs(model, runs, tolerance=TOLERANCE, means=means, plain=plain)
    outputs = found.outputs
    if evened and data.points:
        jumps = np.array([s.measures == "acceleration" for s in model.sensors.values()])
        outputs = tuple(_centred(rows, jumps) for rows in outputs)
    return Predicted(outputs, found.failed)


def _centred(rows: FloatArray, chosen: NDArray[np.bool_]) -> FloatArray:
    """Return rows, those chosen as means over the interval before and the one after."""
    before = np.concatenate([rows[:, :1], rows[:, :-1]], axis=1)
    return np.where(chosen[:, None], 0.5 * (before + rows), rows)
