"""The one residual: what was measured less what the free-running model says, over the noise.

Whole tests from rest, windows with starts of their own and component tests are all rows of one
table of windows; what differs is where a window begins and whether its start is fitted.
"""

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import islice
from typing import Final, TypeVar, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.diagnosis.data import members_of
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.of_tests import (
    as_free,
    inputs_with,
    models_with,
    offsets_in,
)
from shakerproc.diagnosis.estimation.parts import Windows
from shakerproc.diagnosis.nudged.motion import begun, held_to
from shakerproc.models import Model
from shakerproc.simulation import FreeRuns, Runs, free_runs

TOLERANCE: Final = 1e-5
"""Truncation of a simulation that is compared with a measurement [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Predicted:
    """Prediction of the free-running model in every window.

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
    of_tests: FloatArray | None = None,
    *,
    evened: bool = False,
    plain: bool = False,
    tolerance: float = TOLERANCE,
) -> Predicted:
    """Return the prediction of the free-running model.

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
    of_tests : (n, n_tests) array, optional
        What each test has of its own (see `of_tests.spreads_of`) [-].
    evened : bool
        Whether accelerations, where they are values at the samples, are to be means over the
        sample before and the one after: what is expected of a jump somewhere between them.
    plain : bool
        Whether means keep what folds back of jumps.
    tolerance : float
        Truncation of the simulation [-].

    Raises
    ------
    ModelError
        If the model cannot be assembled.
    """
    own = as_free(data, np.zeros((0, 0)) if of_tests is None else of_tests)
    shares = offsets_in(data, own)
    off = data.offsets.moved(shares)
    held = held_to(data, model, windows, off)
    if held is not None:
        starts = begun(data, model, windows.table, off)
    runs = Runs(inputs_with(data, own), windows.table, starts, held=held)
    means = evened or not data.points
    models = models_with(data, model, own)
    found = _free_runs(models, runs, means=means, plain=plain, tolerance=tolerance)
    shown = data.offsets.shown(shares, data.n_sensors)[:, windows.table[:, 0]]
    outputs = tuple(
        rows + offset[:, None] for rows, offset in zip(found.outputs, shown.T, strict=True)
    )
    if evened and data.points:
        jumps = np.array([s.measures == "acceleration" for s in model.sensors.values()])
        outputs = tuple(_centred(rows, jumps) for rows in outputs)
    return Predicted(outputs, found.failed)


def shown(
    data: DataSet, windows: Windows, here: Predicted, number: int, step: float
) -> Predicted | None:
    """Return a prediction with one number of every test moved; None if that takes a run.

    It takes none where the number is an offset that is seen and not felt.

    Parameters
    ----------
    data : DataSet
        The tests.
    windows : Windows
        Which parts.
    here : Predicted
        The prediction from where it moves.
    number : int
        Which of the rows of `spreads_of`.
    step : float
        By how much [-].
    """
    offsets, which = data.offsets, number - int(data.has_constants)
    if not 0 <= which < len(offsets.sensors) or np.any(offsets.moves[:, which]):
        return None
    sees = np.eye(data.n_sensors)[:, offsets.sensors[which], np.newaxis]
    moved = step * offsets.sizes[which, windows.table[:, 0]]
    outputs = (rows + sees * own for rows, own in zip(here.outputs, moved, strict=True))
    return replace(here, outputs=tuple(outputs))


def _free_runs(
    models: Sequence[Model], runs: Runs, *, means: bool, plain: bool, tolerance: float
) -> FreeRuns:
    """Return free runs of each test with the model that it has."""
    failed = np.zeros(len(runs.windows), np.bool_)
    outputs: list[FloatArray] = [np.zeros((0, 0))] * failed.size
    for model, members in members_of(models, runs.windows):
        starts = None if runs.starts is None else runs.starts[members]
        own = replace(runs, windows=runs.windows[members], starts=starts)
        found = free_runs(model, own, tolerance=tolerance, means=means, plain=plain)
        failed[members] = found.failed
        for i, rows in zip(members, found.outputs, strict=True):
            outputs[i] = rows
    return FreeRuns(tuple(outputs), failed)


def _centred(rows: FloatArray, chosen: NDArray[np.bool_]) -> FloatArray:
    """Return rows, those chosen as means over the interval before and the one after."""
    before = np.concatenate([rows[:, :1], rows[:, :-1]], axis=1)
    return np.where(chosen[:, None], 0.5 * (before + rows), rows)


Given = TypeVar("Given")
Made = TypeVar("Made")

THREADS: Final = os.cpu_count() or 1
"""How many are made at once [-]."""


WORTH: Final = 30_000
"""Samples of a prediction from which on it is made at once with others: handing over takes as
long as a gap of some 20,000 [-]."""


def at_once(
    make: Callable[[Given], Made], given: Iterable[Given], n_samples: int
) -> Iterator[Made]:
    """Yield what is made of each, in order; of no more than `THREADS` at once, and kept.

    `n_samples` is how many samples each takes [-].
    """
    if n_samples < WORTH:
        yield from map(make, given)
        return
    waiting = iter(given)
    with ThreadPoolExecutor(THREADS) as pool:
        while some := list(islice(waiting, THREADS)):
            yield from pool.map(make, some)
