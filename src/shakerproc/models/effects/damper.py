"""A linear viscous damper, given by its damping or by a damping ratio."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models.effects.base import (
    AbstractMemorylessEffect,
    DependsOnSurroundings,
    Parameter,
    check_parameters,
)
from shakerproc.models.laws import Law, Row


@final
@dataclass(frozen=True, slots=True)
class Damper(AbstractMemorylessEffect, DependsOnSurroundings):
    r"""Linear viscous damper; exactly one of the two parameters is given.

    .. math:: F = c v, \qquad c = 2 \zeta \sqrt{k m}

    k is the stiffness of the springs between the same two places (of the contact, where there
    is no spring) and m the reduced mass of the two, :math:`1/m = 1/m_1 + 1/m_2`, in which the
    base counts as infinitely heavy: for one mass on the base this is its damping ratio.

    Attributes
    ----------
    damping : float, optional
        Damping :math:`c` [N s/m].
    damping_ratio : float, optional
        Damping ratio :math:`\zeta` of the two places on the springs between them [-].

    References
    ----------
    .. [1] S. S. Rao, "Mechanical Vibrations", 5th ed., Pearson, 2011, sec. 2.6.
    """

    kind: ClassVar[str] = "damper"
    formula: ClassVar[str] = "F = c v, with c = 2 ζ √(k m) where the damping ratio is given"
    signature: ClassVar[str] = (
        "An ellipse that widens in proportion to frequency; the peak keeps its place and "
        "its Q at every level."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "damping": Parameter(
            "N s/m", "c", "damping", linear=True, sign="not negative", optional=True
        ),
        "damping_ratio": Parameter(
            "1",
            "ζ",
            "damping ratio on the parallel springs",
            sign="not negative",
            optional=True,
        ),
    })

    damping: float | None = None
    damping_ratio: float | None = None

    def __post_init__(self) -> None:
        check_parameters(self, self.parameters)
        if (self.damping is None) == (self.damping_ratio is None):
            raise ValueError("damper needs damping or damping_ratio, and not both")

    def in_place(self, stiffness: float, mass: float) -> "Damper":
        if self.damping_ratio is None:
            return self
        return Damper(damping=2.0 * self.damping_ratio * math.sqrt(stiffness * mass))

    def force_at(self, displacement: FloatArray, velocity: FloatArray) -> FloatArray:
        return _known(self.damping) * velocity + 0.0 * displacement

    def slopes(
        self, displacement: FloatArray, velocity: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        none = np.zeros(np.broadcast(displacement, velocity).shape)
        return none, none + _known(self.damping)

    def rows(self) -> tuple[Row, ...]:
        return (Row(Law.LINEAR, (0.0, _known(self.damping))),)


def _known(damping: float | None) -> float:
    """Return the damping where it is known [N s/m].

    Raises
    ------
    ValueError
        If only the ratio is given.
    """
    if damping is None:
        raise ValueError("a damper with a damping ratio has no force by itself; use in_place")
    return damping
