"""The one residual: what was measured less what the free-running model says, over the noise.

Whole tests from rest, windows with starts of their own and component tests are all rows of one
table of windows; what differs is where a window begins and whether its start is fitted.
"""

from dataclasses import dataclass
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.data_set import DataSet, Windows
from shakerproc.models import Model
from shakerproc.models.effects import AttachedMode
from shakerproc.simulate import Runs, free_runs, motions_of

TOLERANCE: Final = 1e-6
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
    starts : (n_windows, 2 n_masses) array or None
        Motion where they begin.
    offset : (n_offsets,) array, optional
        Constant of the input of each test, over its rms [-].

    Raises
    ------
    ModelError
        If the model cannot be assembled.
    """
    inputs = data.inputs if offset is None else data.inputs_with(offset)
    runs = Runs(inputs, windows.table, _with_states(model, starts))
    found = free_runs(model, runs, tolerance=TOLERANCE, means=not data.points)
    return Predicted(found.outputs, found.failed)


def _with_states(model: Model, starts: FloatArray | None) -> FloatArray | None:
    """Return starts with the memory of the laws, which begins with none.

    What comes of that is not counted (see `Windows`).
    """
    if starts is None:
        return None
    missing = len(motions_of(model)) - starts.shape[1]
    return np.hstack([starts, np.zeros((len(starts), missing))])


def moved_along(model: Model, rows: FloatArray) -> FloatArray:
    """Return motions of the masses with those of attached and further modes, as they begin.

    At first a mode moves with the places that it takes part in.

    Parameters
    ----------
    model : Model
        Says which modes there are.
    rows : (..., 2 n_masses) array
        Displacements [m], then velocities [m/s].

    Returns
    -------
    (..., 2 n_motions) array
        The same of the masses, the attached modes and the modes, in the engine's order.
    """
    masses = list(model.masses)
    hosts = [e.between[1] for e in model.elements if e.effect.kind == AttachedMode.kind]
    shares = [{host: 1.0} for host in hosts]
    shares += [dict(mode.participation) for mode in model.modes]
    along = np.array([[share.get(mass, 0.0) for mass in masses] for share in shares])
    whole = np.vstack([np.eye(len(masses)), along.reshape(-1, len(masses))])
    x, v = rows[..., : len(masses)], rows[..., len(masses) :]
    return np.concatenate([x @ whole.T, v @ whole.T], axis=-1)
