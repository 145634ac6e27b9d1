"""The cubic term of the Duffing equation."""

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
class CubicStiffness(AbstractMemorylessEffect):
    r"""Force with the cube of displacement; hardening above 0, softening below.

    .. math:: F = k_3 z^3

    Attributes
    ----------
    coefficient : float
        Coefficient :math:`k_3`, the thesis' :math:`\mu` [N/m^3].

    References
    ----------
    .. [1] A. H. Hauglid, "Nonlinear Mechanical Vibrations: The Effect of Gaps", NTNU, 2018,
       eq. 3.28.
    .. [2] A. H. Nayfeh and D. T. Mook, "Nonlinear Oscillations", Wiley, 1979, ch. 4.
    """

    kind: ClassVar[str] = "cubic_stiffness"
    formula: ClassVar[str] = "F = k₃ z³"
    signature: ClassVar[str] = (
        "The backbone bends steadily, up for k₃ > 0 and down below 0; a third harmonic "
        "that grows with the square of the level."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "coefficient": Parameter("N/m^3", "k₃", "cubic coefficient", linear=True, sign="any")
    })

    coefficient: float

    def force_at(self, displacement: FloatArray, velocity: FloatArray) -> FloatArray:
        return self.coefficient * displacement * displacement**2 + 0.0 * velocity

    def slopes(
        self, displacement: FloatArray, velocity: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        none = np.zeros(np.broadcast(displacement, velocity).shape)
        return none + 3.0 * self.coefficient * displacement**2, none

    @classmethod
    def identification(cls, at: JointScales) -> Identification:
        size = at.steepness / at.displacement**2
        shares = (
            0.03,
            0.3,
            2.0,
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
        return (Row(Law.ODD_POWER, (self.coefficient, 1.0, 3.0)),)
