"""A linear spring."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models.effects.base import (
    AbstractMemorylessEffect,
    Parameter,
)
from shakerproc.models.laws import Law, Row


@final
@dataclass(frozen=True, slots=True)
class Spring(AbstractMemorylessEffect):
    r"""Linear spring.

    .. math:: F = k z

    Attributes
    ----------
    stiffness : float
        Stiffness :math:`k` [N/m]; below 0 only where something stiffer stands in parallel.

    References
    ----------
    .. [1] S. S. Rao, "Mechanical Vibrations", 5th ed., Pearson, 2011, ch. 1.
    """

    kind: ClassVar[str] = "spring"
    formula: ClassVar[str] = "F = k z"
    signature: ClassVar[str] = (
        "A straight line through rest; the resonance is the same at every level."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "stiffness": Parameter("N/m", "k", "stiffness", linear=True, sign="any")
    })

    stiffness: float

    def force_at(self, displacement: FloatArray, velocity: FloatArray) -> FloatArray:
        return self.stiffness * displacement + 0.0 * velocity

    def slopes(
        self, displacement: FloatArray, velocity: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        none = np.zeros(np.broadcast(displacement, velocity).shape)
        return none + self.stiffness, none

    def rows(self) -> tuple[Row, ...]:
        return (Row(Law.LINEAR, (self.stiffness, 0.0)),)
