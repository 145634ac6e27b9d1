"""A force that never changes."""

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
from shakerproc.models.identification import Identification, JointScales, grid, signed
from shakerproc.models.laws import Law, Row

SHARES = tuple(map(float, np.geomspace(0.01, 0.3, 12)))
"""Forces to start from, over the largest that the joint carries: 1.36 from one to the next,
as a contact that the force shifts is met or missed [-]."""


@final
@dataclass(frozen=True, slots=True)
class ConstantForce(AbstractMemorylessEffect):
    r"""Dead weight, a preload, or the offset of a drive.

    .. math:: F = F_0

    A simulation starts at zero displacement, not where this force would leave the joint at
    rest: the joint settles first. Beside a spring alone it only shifts the mean; it matters
    where a law is not linear, or where nothing but friction holds the mass.

    Attributes
    ----------
    force : float
        The force :math:`F_0`; it resists positive displacement where it is positive [N].

    References
    ----------
    .. [1] S. S. Rao, "Mechanical Vibrations", 5th ed., Pearson, 2011, sec. 2.2.
    """

    kind: ClassVar[str] = "constant_force"
    formula: ClassVar[str] = "F = F₀"
    signature: ClassVar[str] = (
        "A mean displacement that is the same at every level; beside a gap or a stop, contact "
        "on one side first."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "force": Parameter("N", "F₀", "constant force", linear=True, sign="any")
    })

    force: float

    def force_at(self, displacement: FloatArray, velocity: FloatArray) -> FloatArray:
        return self.force + 0.0 * displacement + 0.0 * velocity

    def slopes(
        self, displacement: FloatArray, velocity: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        none = np.zeros(np.broadcast(displacement, velocity).shape)
        return none, none.copy()

    @classmethod
    def identification(cls, at: JointScales) -> Identification:
        return Identification(
            free={"force": signed(at.force, 10.0)},
            starts=grid(
                force=(sign * share * at.force for share in SHARES for sign in (1, -1))
            ),
            scaled=("force",),
        )

    def rows(self) -> tuple[Row, ...]:
        return (Row(Law.CONSTANT, (self.force,)),)
