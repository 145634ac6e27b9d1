"""Response of the sensors to a force in a joint, and to motion left over from before."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TypeAlias, final

import numpy as np

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.diagnosis.data.motion import compliance, input_load
from shakerproc.models import BASE, Model
from shakerproc.models.model import Measures
from shakerproc.simulation.assembly import System, assemble

Joint: TypeAlias = tuple[str, str]
"""Two places; the displacement is that of the second less that of the first."""

_DERIVATIVE: Mapping[Measures, int] = MappingProxyType({
    "acceleration": 2,
    "velocity": 1,
    "displacement": 0,
    "relative velocity": 1,
    "relative displacement": 0,
})
_EDGE_POWERS = (-2, -1, 0, 1, 2, 3)
"""Powers of frequency that the cut edges of a block leave in its spectrum."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class LinearPart:
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

    def direction(self, joint: Joint, *, second_only: bool = False) -> FloatArray:
        """Return how unit coordinates stretch a joint, (n,) array [-]."""
        row = np.zeros(len(self.system.names))
        places = joint[1:] if second_only else joint
        for place, sign in zip(places[::-1], (1.0, -1.0), strict=False):
            if place != BASE:
                row += sign * self.system.places[place]
        return row

    def compliance(self, frequency: FloatArray, forces: FloatArray) -> ComplexArray:
        """Return displacements by forces [m/N] at [Hz]; see `data.motion.compliance`."""
        return compliance(self.system, frequency, forces)

    def by_forces(self, frequency: FloatArray, forces: FloatArray) -> ComplexArray:
        """Return responses over forces, (n_sensors, n_forces, n_frequencies) [unit/N]."""
        moved = self.compliance(frequency, forces)
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

    def leftovers(
        self, frequency: FloatArray, n_samples: int, sample_rate: float
    ) -> ComplexArray:
        """Return spectra of what a block shows of before it, (n, n_sensors, n_frequencies).

        They are the free vibrations of the model over the block, and what its cut edges add to
        the spectrum of each sensor.
        """
        edges = []
        for sensor in range(len(self.sensors)):
            for power in _EDGE_POWERS:
                row = np.zeros((len(self.sensors), frequency.size), complex)
                row[sensor] = (1j * frequency / sample_rate) ** power
                edges.append(row)
        return np.array([*self._free_vibrations(frequency, n_samples, sample_rate), *edges])

    def _free_vibrations(
        self, frequency: FloatArray, n_samples: int, sample_rate: float
    ) -> list[ComplexArray]:
        """Return spectra at the sensors of a free vibration for every state but rigid motion.

        That of a pole p over N samples is a geometric sum; a pair of conjugate poles makes
        two real signals.
        """
        matrix = self.system.machine.matrix
        n = matrix.shape[0]
        below = np.hstack([np.zeros((n, n)), np.eye(n)])
        poles, shapes = np.linalg.eig(np.vstack([below, matrix[:, : 2 * n]]))
        rest = 1e-6 * float(np.max(np.abs(poles), initial=1e-300))
        turn = np.exp(-2j * np.pi * frequency / sample_rate)

        def spectrum(pole: complex, shape: ComplexArray) -> ComplexArray:
            growth = np.exp(pole / sample_rate)
            total = (1.0 - growth**n_samples) / (1.0 - growth * turn)
            at = np.array([
                pole**order * (row @ shape[: row.size]) for row, order, _ in self._sensed
            ])
            return np.asarray(at[:, None] * total)

        found = []
        for pole, shape in zip(poles, shapes.T, strict=True):
            if abs(pole) < rest or pole.imag < 0.0:
                continue
            one, other = spectrum(pole, shape), spectrum(pole.conj(), shape.conj())
            found += [one + other] if pole.imag == 0.0 else [one + other, (one - other) / 1j]
        return found


def linear_model(model: Model) -> LinearPart:
    """Return the linear part of a model."""
    sensors = tuple(i for i, s in enumerate(model.sensors.values()) if s.at != BASE)
    return LinearPart(model, assemble(model), sensors)
