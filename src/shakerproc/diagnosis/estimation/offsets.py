"""Offsets of sensors that a test is too short to tell: each test's own, fitted with the rest.

The mean of a recording is the offset of its sensor only to the mean of the motion. That is none
in a minute; in half a second, or where friction lets a mass rest beside its place, a gap around
a wrong zero is a gap with two clearances.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.data import PreparedTest
from shakerproc.models import BASE, Model
from shakerproc.models.coordinates import coordinates_of


@final
@dataclass(frozen=True, slots=True, eq=False)
class Offsets:
    """Sensors whose offset in some test is known worse than a sample of it.

    Attributes
    ----------
    sensors : tuple of int
        Which.
    sizes : (n_offsets, n_tests) array
        Rms of their responses, which offsets are compared with [unit of the sensor].
    spread : (n_offsets, n_tests) array
        Standard deviation of each over that [-].
    moves : (n_coordinates, n_offsets) array
        By how much coordinates lie elsewhere by unit offsets of displacements [m/m].
    """

    sensors: tuple[int, ...]
    sizes: FloatArray
    spread: FloatArray
    moves: FloatArray

    @property
    def hide_places(self) -> bool:
        """Whether the mean of a motion is not told, and with it none of a displacement."""
        return bool(self.sensors) and not np.any(self.moves)

    def shown(self, shares: FloatArray, n_sensors: int) -> FloatArray:
        """Return offsets as sensors show them, (n_sensors, n_tests) [unit of the sensor]."""
        found = np.zeros((n_sensors, self.sizes.shape[1]))
        found[list(self.sensors)] = shares * self.sizes
        return found

    def moved(self, shares: FloatArray) -> FloatArray:
        """Return how far coordinates seem to lie off, (n_tests, n_coordinates) array [m]."""
        return np.asarray((self.moves @ (shares * self.sizes)).T)


def offsets_of(model: Model, tests: Sequence[PreparedTest]) -> Offsets:
    """Return the offsets that are to be fitted; none where a displacement is imposed.

    Of every motion of a mass: laws count displacements from where it rests, and what a push
    leaves of the mean of a velocity or an acceleration is no offset either.
    """
    error = np.array([test.offset_error for test in tests]).T
    noise = np.array([test.noise for test in tests]).T
    asked = [] if model.excitation.imposed else _of_masses(model)
    chosen = tuple(i for i in asked if np.any(error[i] > noise[i]))
    sizes = np.array([
        [np.sqrt(np.mean(test.responses[i] ** 2)) for test in tests] for i in chosen
    ]).reshape(-1, len(tests))
    spread = np.maximum(error, noise)[list(chosen)] / np.maximum(sizes, 1e-300)
    return Offsets(chosen, sizes, spread, _moves(model, chosen))


def _moves(model: Model, chosen: Sequence[int]) -> FloatArray:
    """Return the shifts of coordinates by unit offsets, (n_coordinates, n) array.

    None by offsets of velocities and accelerations.
    """
    n, sensors = model.n_coordinates, list(model.sensors.values())
    placed = [i for i in _of_masses(model) if sensors[i].measures.endswith("displacement")]
    alone = coordinates_of(model, ())
    sees = np.reshape([alone.at(sensors[i].at)[:n] for i in placed], (-1, n))
    moved = np.zeros((n, len(sensors)))
    moved[:, placed] = np.linalg.pinv(sees)
    return moved[:, list(chosen)]


def _of_masses(model: Model) -> list[int]:
    """Return the sensors that measure the motion of a mass."""
    return [i for i, sensor in enumerate(model.sensors.values()) if sensor.at != BASE]
