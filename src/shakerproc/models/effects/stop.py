"""An elastic stop on one side."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, Literal, final

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
    clearance,
    clearances,
    contact,
    contacts,
    grid,
)
from shakerproc.models.laws import Law, Row


@final
@dataclass(frozen=True, slots=True)
class Stop(AbstractMemorylessEffect):
    r"""Elastic stop that is met on one side only.

    .. math:: F = k (z - s a) \quad (s z > a), \qquad 0 \text{ else}, \qquad s = \pm 1

    Attributes
    ----------
    stiffness : float
        Stiffness of the stop, :math:`k` [N/m].
    clearance : float
        Way to the stop, :math:`a` [m].
    side : {"positive", "negative"}
        Towards which displacement the stop stands.

    References
    ----------
    .. [1] S. W. Shaw and P. J. Holmes, "A periodically forced piecewise linear oscillator",
       Journal of Sound and Vibration 90, 129-155, 1983.
    """

    kind: ClassVar[str] = "stop"
    formula: ClassVar[str] = "F = k (z - s a) for s z > a, 0 else; s = +1 or -1, the side"
    signature: ClassVar[str] = (
        "A wall on one side: even harmonics, a mean displacement away from the wall, the "
        "resonance rises with level."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "stiffness": Parameter("N/m", "k", "stiffness of the stop", linear=True),
        "clearance": Parameter("m", "a", "way to the stop", sign="not negative"),
        "side": Parameter(
            "", "s", "side of the stop", sign="any", choices=("positive", "negative")
        ),
    })

    stiffness: float
    clearance: float
    side: Literal["positive", "negative"]

    @property
    def direction(self) -> float:
        """+1 for the positive side, -1 for the negative."""
        return 1.0 if self.side == "positive" else -1.0

    def force_at(self, displacement: FloatArray, velocity: FloatArray) -> FloatArray:
        beyond = np.maximum(self.direction * displacement - self.clearance, 0.0)
        return self.stiffness * self.direction * beyond + 0.0 * velocity

    def slopes(
        self, displacement: FloatArray, velocity: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        none = np.zeros(np.broadcast(displacement, velocity).shape)
        return none + self.stiffness * (self.direction * displacement > self.clearance), none

    def switches(self) -> tuple[Switch, ...]:
        return (Switch("displacement", self.direction * self.clearance),)

    @classmethod
    def identification(cls, at: JointScales) -> Identification:
        sides = ("positive", "negative")
        return Identification(
            free={"stiffness": contact(at), "clearance": clearance(at)},
            starts=grid(side=sides, stiffness=contacts(at), clearance=clearances(at, 9)),
            scaled=("stiffness",),
        )

    def rows(self) -> tuple[Row, ...]:
        wall = self.direction * self.clearance
        return (Row(Law.STOP, (self.stiffness, wall, self.direction)),)
