"""Motion of the model from its sensors: target of nudged runs, and their start."""

from collections.abc import Mapping
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.parts import Windows
from shakerproc.diagnosis.estimation.resting_places import resting_places
from shakerproc.models import BASE, Model
from shakerproc.models.coordinates import coordinates_of
from shakerproc.simulation import Held, largest_states
from shakerproc.simulation.assembly import System, assemble
from shakerproc.simulation.free_runs import led_by

Seen = tuple[tuple[str, bool], ...]
"""Places whose motion is measured, and whether where they are is, too."""


def seen_of(model: Model) -> Seen:
    """Return which places sensors tell the velocity of, and of which the displacement."""
    placed: dict[str, bool] = {}
    for sensor in model.sensors.values():
        if sensor.at != BASE and sensor.measures != "force":
            place = sensor.measures.endswith("displacement")
            placed[sensor.at] = placed.get(sensor.at, False) or place
    return tuple((at, placed[at]) for at in model.moving if at in placed)


def seen_by(seen: Seen, places: Mapping[str, FloatArray]) -> FloatArray:
    """Return the outputs of sensors by unit displacements, then unit velocities."""
    still = np.zeros_like(next(iter(places.values())))
    velocities = [np.concatenate([still, places[at]]) for at, _ in seen]
    displacements = [np.concatenate([places[at], still]) for at, placed in seen if placed]
    return np.reshape([*velocities, *displacements], (-1, 2 * still.size))


def slowest_decay(model: Model, rate: float) -> float:
    r"""Return the decay rate of what is forgotten last by a model that is held [1/s].

    .. math:: \min_r -\operatorname{Re} \lambda_r (A - \text{rate} \, L S)

    over what turns, with the linear part of the model, :math:`A`. A mass with a sensor forgets
    at half the rate; a mode that no sensor sees by its own damping alone.

    Parameters
    ----------
    model : Model
        What is held.
    rate : float
        Nudging rate [1/s].
    """
    linear = coordinates_of(model)
    n, by_mass = linear.mass.size, 1.0 / linear.mass[:, None]
    sees = seen_by(seen_of(model), linear.places)
    held = rate * (led_by(sees, linear.mass) @ sees)
    state = np.block([
        [np.zeros((n, n)), np.eye(n)],
        [-by_mass * linear.stiffness, -by_mass * linear.damping],
    ])
    poles = np.linalg.eigvals(state - held)
    turning = -poles.real[poles.imag > 0.0]
    return float(min(0.5 * rate, np.min(turning, initial=np.inf)))


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
        # sample by sample, as the stepper reads them: it takes no copy then
        _MEASURED[data] = tuple(np.asfortranarray(sees @ own) for own in data.motions)
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
