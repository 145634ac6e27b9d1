"""Response functions of the linear part of a model, between its input and its sensors."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import final

import numpy as np

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.diagnosis.data.motion import compliance, input_load
from shakerproc.models import BASE, Model
from shakerproc.models.model import Measures
from shakerproc.simulation.assembly import System, assemble

_DERIVATIVE: Mapping[Measures, int] = MappingProxyType({
    "acceleration": 2,
    "velocity": 1,
    "displacement": 0,
    "relative velocity": 1,
    "relative displacement": 0,
})


@final
@dataclass(frozen=True, slots=True, eq=False)
class LinearModel:
    """The linear part of a model between its forces and its sensors.

    Attributes
    ----------
    model : Model
        The model.
    system : System
        The same, assembled.
    sensors : tuple of int
        Sensors that do not sit on the base, by their place among those of the model.
    """

    model: Model
    system: System
    sensors: tuple[int, ...]

    @property
    def _sensed(self) -> list[tuple[FloatArray, int, Measures]]:
        """Displacement by unit coordinates, derivative and quantity of every sensor used."""
        every = [list(self.model.sensors.values())[i] for i in self.sensors]
        places = self.system.places
        return [(places[s.at], _DERIVATIVE[s.measures], s.measures) for s in every]

    def by_forces(self, frequency: FloatArray, forces: FloatArray) -> ComplexArray:
        """Return responses over forces, (n_sensors, n_forces, n_frequencies) [unit/N]."""
        moved = compliance(self.system, frequency, forces)
        s = 2j * np.pi * frequency
        shown = [
            s**order * np.tensordot(row, moved, axes=(0, 1)).T for row, order, _ in self._sensed
        ]
        return np.array(shown)

    def by_input(self, frequency: FloatArray) -> ComplexArray:
        """Return responses over the input at `frequency` [Hz], (n_sensors, n_frequencies)."""
        shown = self.by_forces(frequency, input_load(self.system))[:, 0]
        if self.model.excitation.moves_base:
            s = 2j * np.pi * frequency
            shown = shown + np.array([
                0.0 * s if quantity.startswith("relative") else s ** (order - 2)
                for _, order, quantity in self._sensed
            ])
        return np.asarray(shown)


def linear_model(model: Model) -> LinearModel:
    """Return the linear part of a model."""
    sensors = tuple(i for i, s in enumerate(model.sensors.values()) if s.at != BASE)
    return LinearModel(model, assemble(model), sensors)
