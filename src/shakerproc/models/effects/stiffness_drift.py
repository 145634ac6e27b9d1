"""A stiffness that changes slowly while the test runs."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import ClassVar, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models.effects.base import (
    AbstractEffect,
    DependsOnSurroundings,
    Parameter,
)
from shakerproc.models.identification import (
    Free,
    Identification,
    JointScales,
    grid,
)
from shakerproc.models.laws import Law, Row


@final
@dataclass(frozen=True, slots=True)
class StiffnessDrift(AbstractEffect, DependsOnSurroundings):
    r"""Steady relative change of the stiffness of the springs in parallel.

    .. math:: F = k r (t - t_0) z

    A joint that loosens, or a polymer that warms up, at :math:`r < 0`.

    Attributes
    ----------
    rate : float
        Relative change of stiffness in one second, :math:`r` [1/s].
    reference : float
        Time at which the springs have the stiffness that they are given, :math:`t_0` [s].
    stiffness : float, optional
        Stiffness that changes, :math:`k`; in a model, where it is left out, that of the springs
        between the same two places [N/m].

    References
    ----------
    .. [1] J. S. Bendat and A. G. Piersol, "Random Data", 4th ed., Wiley, 2010, ch. 12.
    """

    kind: ClassVar[str] = "stiffness_drift"
    formula: ClassVar[str] = "F = k r (t - t₀) z, k the stiffness of the springs in parallel"
    signature: ClassVar[str] = (
        "The peak shifts with time, whatever the level; a repeated run differs from the first."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "rate": Parameter("1/s", "r", "relative change a second", linear=True, sign="any"),
        "reference": Parameter("s", "t₀", "time of no change", sign="any", reference=True),
        "stiffness": Parameter("N/m", "k", "stiffness that changes", optional=True),
    })

    rate: float
    reference: float
    stiffness: float | None = None

    def force_along(
        self, displacement: FloatArray, velocity: FloatArray, sample_rate: float
    ) -> FloatArray:
        if self.stiffness is None:
            raise ValueError("a stiffness drift without stiffness has no force; use in_place")
        time = np.arange(displacement.size) / sample_rate
        change = self.stiffness * self.rate * (time - self.reference)
        return change * displacement + 0.0 * velocity

    @classmethod
    def identification(cls, at: JointScales) -> Identification | None:
        if at.stiffness <= 0.0:  # there is nothing that could drift
            return None
        size = 0.1 / at.duration
        # Below -1 over the test, nothing would be left of the stiffness.
        return Identification(
            free={"rate": Free(-9.5 * size, 30.0 * size, "identity", size)},
            starts=grid(
                rate=(-2.0 * size, -0.3 * size, 0.3 * size, 2.0 * size), reference=(0.0,)
            ),
            scaled=("rate",),
        )

    def rows(self) -> tuple[Row, ...]:
        if self.stiffness is None:
            raise ValueError("a stiffness drift without stiffness has no force; use in_place")
        return (Row(Law.DRIFT, (self.stiffness * self.rate, self.reference)),)

    def in_place(self, stiffness: float, mass: float) -> "StiffnessDrift":
        return self if self.stiffness is not None else replace(self, stiffness=stiffness)
