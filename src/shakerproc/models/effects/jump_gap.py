"""Free play as the thesis prints it: the force jumps at the wall."""

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
from shakerproc.models.laws import Law, Row


@final
@dataclass(frozen=True, slots=True)
class JumpGap(AbstractMemorylessEffect):
    r"""Stiffness that is switched on outside :math:`\pm a`, the literal eq. 3.14.

    .. math:: F = k z \quad (|z| > a), \qquad 0 \text{ inside}

    The force jumps by :math:`k a` at the wall, which no elastic contact does; it is here to
    repeat the thesis. `gap` is the law of a joint with play.

    Attributes
    ----------
    stiffness : float
        Stiffness outside, :math:`k` [N/m].
    clearance : float
        Half width of the free play, :math:`a` [m].

    References
    ----------
    .. [1] A. H. Hauglid, "Nonlinear Mechanical Vibrations: The Effect of Gaps", NTNU, 2018,
       eq. 3.14.
    """

    kind: ClassVar[str] = "jump_gap"
    formula: ClassVar[str] = "F = k z for |z| > a, 0 inside"
    signature: ClassVar[str] = (
        "The force jumps by k a at the wall: strong harmonics and chatter, the resonance "
        "hardly falls."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "stiffness": Parameter("N/m", "k", "stiffness outside", linear=True),
        "clearance": Parameter("m", "a", "half width of the free play", sign="not negative"),
    })

    stiffness: float
    clearance: float

    def force_at(self, displacement: FloatArray, velocity: FloatArray) -> FloatArray:
        outside = np.abs(displacement) > self.clearance
        return self.stiffness * displacement * outside + 0.0 * velocity

    def slopes(
        self, displacement: FloatArray, velocity: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        none = np.zeros(np.broadcast(displacement, velocity).shape)
        return none + self.stiffness * (np.abs(displacement) > self.clearance), none

    def switches(self) -> tuple[Switch, ...]:
        return (
            Switch("displacement", -self.clearance),
            Switch("displacement", self.clearance),
        )

    def rows(self) -> tuple[Row, ...]:
        return (
            Row(Law.JUMP, (self.stiffness, self.clearance, 1.0)),
            Row(Law.JUMP, (self.stiffness, -self.clearance, -1.0)),
        )
