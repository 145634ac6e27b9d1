"""Motion of the model from its sensors: target of nudged runs, and their start."""

from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.parts import Windows
from shakerproc.diagnosis.estimation.resting_places import resting_places
from shakerproc.diagnosis.nudged.observing import Seen, seen_by, seen_of
from shakerproc.models import Model
from shakerproc.models.coordinates import coordinates_of
from shakerproc.simulation import Held, largest_states
from shakerproc.simulation.assembly import System, assemble


def held_to(data: DataSet, model: Model, windows: Windows, off: FloatArray) -> Held | None:
    """Return the motion towards which runs are nudged in all tests; None where they are free.

    Parameters
    ----------
    data, model, windows
        As for `residuals.predict`.
    off : (n_tests, n_coordinates) array
        By how much coordinates seem to lie off, by the offsets of sensors [m].
    """
    if windows.rate is None:
        return None
    places, seen = assemble(model).places, seen_of(model)
    measured = _measured(data, seen)
    if np.any(off):
        shown = off @ _sees(data, seen)[:, : off.shape[1]].T
        measured = tuple(rows - own[:, None] for rows, own in zip(measured, shown, strict=True))
    return Held(windows.rate, measured, seen_by(seen, places), windows.lead)


def _sees(data: DataSet, seen: Seen) -> FloatArray:
    n, alone = data.model.n_coordinates, coordinates_of(data.model, ())
    return seen_by(seen, {at: alone.at(at)[:n] for at in data.model.moving})


_MEASURED: WeakKeyDictionary[DataSet, tuple[FloatArray, ...]] = WeakKeyDictionary()


def _measured(data: DataSet, seen: Seen) -> tuple[FloatArray, ...]:
    if data not in _MEASURED:
        sees = _sees(data, seen)
        _MEASURED[data] = tuple(sees @ motion for motion in data.motions)
    return _MEASURED[data]


def begun(data: DataSet, model: Model, table: NDArray[np.int64], off: FloatArray) -> FloatArray:
    """Return the motion where pieces begin, (n_pieces, n_motions) array.

    Of masses and structures as measured; of attached and further modes, and of states, none:
    they are driven while the run forgets where it began. `off` is that of `held_to` [m].
    """
    system = assemble(model)
    n, masses = len(system.names), model.n_coordinates
    starts = np.zeros((len(table), 2 * n + len(largest_states(model))))
    for i, own in enumerate(data.motions):
        here = np.flatnonzero((table[:, 0] == i) & (table[:, 1] > 0))
        starts[here, :masses] = own[:masses, table[here, 1]].T - off[i]
        starts[here, n : n + masses] = own[masses:, table[here, 1]].T
    places = [own[0] for own in resting_places(data, model, table)]
    starts[:, :masses] += np.reshape(places, (-1, masses))
    return _with_modes(system, starts, masses)


def _with_modes(system: System, starts: FloatArray, masses: int) -> FloatArray:
    """Let attached and further modes begin as far along as what holds them at rest does."""
    n, matrix = len(system.names), system.machine.matrix
    if n == masses:
        return starts
    own, given = slice(masses, n), slice(0, masses)
    along = -np.linalg.solve(matrix[own, own], matrix[own, given])
    starts[:, own] = starts[:, given] @ along.T
    starts[:, n + masses : 2 * n] = starts[:, n : n + masses] @ along.T
    return starts
