"""What sensors tell of the motion of a model: what nudged runs are held to, and begin with."""

from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.parts import Windows
from shakerproc.diagnosis.estimation.resting_places import resting_places
from shakerproc.models import Model
from shakerproc.simulation import Held, largest_states
from shakerproc.simulation.assembly import System, assemble

Seen = tuple[tuple[int, bool], ...]
"""Masses whose motion is measured, by number, and whether their place is, too."""


def seen_of(model: Model) -> Seen:
    """Return which masses sensors tell the velocity of, and of which the place."""
    masses = list(model.masses)
    placed: dict[int, bool] = {}
    for sensor in model.sensors.values():
        if sensor.at in model.masses and sensor.measures != "force":
            own = masses.index(sensor.at)
            place = sensor.measures.endswith("displacement")
            placed[own] = placed.get(own, False) or place
    return tuple(sorted(placed.items()))


def held_to(data: DataSet, model: Model, windows: Windows) -> Held | None:
    """Return what runs of a model are held to in all tests; None where they are free."""
    if windows.rate is None:
        return None
    seen, n = seen_of(model), len(assemble(model).names)
    return Held(windows.rate, _measured(data, seen), _sees(seen, n), windows.lead)


def _rows(seen: Seen, n: int) -> list[int]:
    """Return which of n displacements, then n velocities, are measured."""
    return [n + mass for mass, _ in seen] + [mass for mass, placed in seen if placed]


def _sees(seen: Seen, n: int) -> FloatArray:
    rows = _rows(seen, n)
    sees = np.zeros((len(rows), 2 * n))
    sees[np.arange(len(rows)), rows] = 1.0
    return sees


_MEASURED: WeakKeyDictionary[DataSet, tuple[FloatArray, ...]] = WeakKeyDictionary()


def _measured(data: DataSet, seen: Seen) -> tuple[FloatArray, ...]:
    if data not in _MEASURED:
        rows = _rows(seen, len(data.model.masses))
        _MEASURED[data] = tuple(motion[rows] for motion in data.motions)
    return _MEASURED[data]


def begun(data: DataSet, model: Model, table: NDArray[np.int64]) -> FloatArray:
    """Return the motion where pieces begin, (n_pieces, n_motions) array.

    Of masses as measured; of attached and further modes, and of states, none: they are driven
    while the run forgets where it began.
    """
    system = assemble(model)
    n, masses = len(system.names), len(model.masses)
    starts = np.zeros((len(table), 2 * n + len(largest_states(model))))
    for i, own in enumerate(data.motions):
        here = np.flatnonzero((table[:, 0] == i) & (table[:, 1] > 0))
        starts[here, :masses] = own[:masses, table[here, 1]].T
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
