"""Response functions of the linear part of a model, by its poles."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, TypeAlias, final

import numpy as np

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.models import Model
from shakerproc.models.coordinates import coordinates_of
from shakerproc.models.model import Measures
from shakerproc.simulation.assembly import assemble

_Sensed: TypeAlias = Callable[[ComplexArray, ComplexArray, float], ComplexArray]

_OF_DISPLACEMENT: Final[Mapping[Measures, _Sensed]] = MappingProxyType({
    "acceleration": lambda z, s, base: s**2 * z + base,
    "velocity": lambda z, s, base: s * z + base / s,
    "displacement": lambda z, s, base: z + base / s**2,
    "relative velocity": lambda z, s, _: s * z,
    "relative displacement": lambda z, _, __: z,
})
"""What a sensor shows, by the displacement against the base, s and the base's acceleration."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Poles:
    r"""Displacements relative to the base as partial fractions.

    .. math:: x_i(s) = \sum_r \frac{R_{ir}}{s - \lambda_r} \, u(s)

    Attributes
    ----------
    poles : (n_poles,) complex array
        :math:`\lambda_r` [rad/s].
    residues : (n_motions, n_poles) complex array
        :math:`R_{ir}` of every displacement [unit of displacement over input, times 1/s].
    """

    poles: ComplexArray
    residues: ComplexArray

    @property
    def frequencies(self) -> FloatArray:
        """Natural frequencies above 0 of the modes that oscillate, rising [Hz]."""
        found = np.abs(self.poles[self.poles.imag > 0.0]) / (2.0 * np.pi)
        return np.asarray(np.sort(found), float)

    @property
    def decay(self) -> float:
        """Time in which the slowest motion that dies out falls to 1/e; 0 if none does [s]."""
        damped = -self.poles.real[self.poles.real < 0.0]
        return float(1.0 / damped.min()) if damped.size else 0.0


@final
@dataclass(frozen=True, slots=True, eq=False)
class DrivenMode:
    r"""A further mode that the drive excites, and that does not react on the model.

    .. math:: a_i = -\frac{p_i s^2}{s^2 + 2 \zeta \omega s + \omega^2} \, a

    Every mode of a real specimen is one, of any sign at a sensor: 1.6 and -0.9 are those of the
    tip of a beam in its first two. What an attached mass adds (see `Mode`) is a special case.

    Attributes
    ----------
    frequency : float
        Natural frequency [Hz].
    damping_ratio : float
        Over the critical one [-].
    participation : (n_sensors,) array
        Of the sensors, over the acceleration of the base or the force over all masses [-].
    """

    frequency: float
    damping_ratio: float
    participation: FloatArray

    def responses(self, model: Model, frequency: FloatArray) -> ComplexArray:
        """Return what it adds to every sensor, (n_sensors, n) array; frequencies above 0 [Hz].

        Nothing to a sensor of force.
        """
        s = np.asarray(2j * np.pi * frequency, np.complex128)
        omega = 2.0 * np.pi * self.frequency
        of_drive = -1.0 if model.excitation.moves_base else 1.0 / sum(model.masses.values())
        z = of_drive / (s**2 + 2.0 * self.damping_ratio * omega * s + omega**2)
        measures = [sensor.measures for sensor in model.sensors.values()]
        return np.array([
            _OF_DISPLACEMENT[kind](share * z, s, 0.0) if kind in _OF_DISPLACEMENT else 0.0 * z
            for share, kind in zip(self.participation, measures, strict=True)
        ])


def poles_of(model: Model) -> Poles:
    """Return the linear part of a model; laws that are not linear are left out."""
    matrix = assemble(model).machine.matrix
    n = len(matrix)
    state = np.block([[np.zeros((n, n)), np.eye(n)], [matrix[:, :n], matrix[:, n : 2 * n]]])
    poles, vectors = np.linalg.eig(state)
    load = np.concatenate([np.zeros(n), matrix[:, 2 * n]])
    shares = np.linalg.solve(vectors, load.astype(complex))
    return Poles(poles, vectors[:n] * shares)


def sensor_responses(model: Model, frequency: FloatArray) -> ComplexArray:
    """Return the response function of every sensor, (n_sensors, n_frequencies) array.

    Parameters
    ----------
    model : Model
        The model; faults of its sensors are left out.
    frequency : (n_frequencies,) array
        Above 0 [Hz].
    """
    found = poles_of(model)
    s = 2j * np.pi * frequency
    fractions = 1.0 / (s - found.poles[:, np.newaxis])
    base = 1.0 if model.excitation.moves_base else 0.0
    alone = coordinates_of(model)
    rows = []
    for sensor in model.sensors.values():
        residues = alone.at(sensor.at) @ found.residues
        z = np.asarray(residues @ fractions, np.complex128)
        rows.append(_OF_DISPLACEMENT[sensor.measures](z, np.asarray(s, np.complex128), base))
    return np.array(rows)
