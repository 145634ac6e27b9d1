"""Drag: a force with the square of velocity."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models.effects.base import (
    AbstractMemorylessEffect,
    Parameter,
    Switch,
)
from shakerproc.models.identification import (
    Identification,
    JointScales,
    grid,
    positive,
)
from shakerproc.models.laws import Law, Row


@final
@dataclass(frozen=True, slots=True)
class QuadraticDamping(AbstractMemorylessEffect):
    r"""Damping force with the square of velocity, as of air or of oil squeezed out of a gap.

    .. math:: F = c_2 v |v|

    Attributes
    ----------
    coefficient : float
        Coefficient :math:`c_2` [N s^2/m^2].

    References
    ----------
    .. [1] S. S. Rao, "Mechanical Vibrations", 5th ed., Pearson, 2011, sec. 3.9.
    """

    kind: ClassVar[str] = "quadratic_damping"
    formula: ClassVar[str] = "F = c₂ v |v|"
    signature: ClassVar[str] = (
        "Damping in proportion to velocity: the gain at resonance falls with level, the "
        "frequency stays."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "coefficient": Parameter("N s^2/m^2", "c₂", "quadratic damping", linear=True),
    })

    coefficient: float

    def force_at(self, displacement: FloatArray, velocity: FloatArray) -> FloatArray:
        return self.coefficient * velocity * np.abs(velocity) + 0.0 * displacement

    def slopes(
        self, displacement: FloatArray, velocity: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        none = np.zeros(np.broadcast(displacement, velocity).shape)
        return none, none + 2.0 * self.coefficient * np.abs(velocity)

    def switches(self) -> tuple[Switch, ...]:
        return (Switch("velocity", 0.0),)

    @classmethod
    def identification(cls, at: JointScales) -> Identification:
        size = 0.03 * at.critical_damping / at.velocity  # damping ratio 3 % at full velocity
        return Identification(
            free={"coefficient": positive(size)},
            starts=grid(coefficient=(0.1 * size, size, 10.0 * size)),
            scaled=("coefficient",),
        )

    def rows(self) -> tuple[Row, ...]:
        return (Row(Law.QUADRATIC_DAMPING, (self.coefficient,)),)
