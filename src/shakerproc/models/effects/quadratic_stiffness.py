"""A force that is the same for both signs of displacement."""

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
from shakerproc.models.identification import (
    Identification,
    JointScales,
    grid,
    signed,
)
from shakerproc.models.laws import Law, Row


@final
@dataclass(frozen=True, slots=True)
class QuadraticStiffness(AbstractMemorylessEffect):
    r"""Force with the square of displacement, an even law: stiffer on one side.

    .. math:: F = k_2 z^2

    With :math:`k_2 > 0` the joint is stiffer where z is positive and softer where it is
    negative: the tangent stiffness :math:`2 k_2 z` has the sign of :math:`k_2 z`. The law
    holds nothing by itself; a spring must stand in parallel.

    Attributes
    ----------
    coefficient : float
        Coefficient :math:`k_2` [N/m^2].

    References
    ----------
    .. [1] A. H. Nayfeh and D. T. Mook, "Nonlinear Oscillations", Wiley, 1979, sec. 4.2.
    """

    kind: ClassVar[str] = "quadratic_stiffness"
    formula: ClassVar[str] = "F = k₂ z²"
    signature: ClassVar[str] = (
        "Softer one way than the other: a second harmonic and a mean displacement, both "
        "in proportion to level."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "coefficient": Parameter(
            "N/m^2", "k₂", "quadratic coefficient", linear=True, sign="any"
        )
    })

    coefficient: float

    def force_at(self, displacement: FloatArray, velocity: FloatArray) -> FloatArray:
        return self.coefficient * displacement**2 + 0.0 * velocity

    def slopes(
        self, displacement: FloatArray, velocity: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        none = np.zeros(np.broadcast(displacement, velocity).shape)
        return none + 2.0 * self.coefficient * displacement, none

    @classmethod
    def identification(cls, at: JointScales) -> Identification:
        size = at.steepness / at.displacement
        shares = (
            0.02,
            0.1,
            0.4,
            -0.02,
            -0.1,
            -0.4,
        )  # of steepness, at full motion
        return Identification(
            free={"coefficient": signed(size)},
            starts=grid(coefficient=(share * size for share in shares)),
            scaled=("coefficient",),
        )

    def rows(self) -> tuple[Row, ...]:
        return (Row(Law.EVEN_POWER, (self.coefficient, 1.0, 2.0)),)
