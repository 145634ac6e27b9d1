"""Free play, the same on both sides: the thesis' piecewise stiffness, continuous."""

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
    clearance,
    clearances,
    contact,
    contacts,
    grid,
)
from shakerproc.models.laws import Law, Row


@final
@dataclass(frozen=True, slots=True)
class Gap(AbstractMemorylessEffect):
    r"""Free play of :math:`\pm a` between two elastic stops.

    .. math:: F = k (|z| - a) \operatorname{sgn} z \quad (|z| > a), \qquad 0 \text{ inside}

    Attributes
    ----------
    stiffness : float
        Stiffness of the contact, :math:`k` [N/m].
    clearance : float
        Free play to each side, :math:`a` [m].

    References
    ----------
    .. [1] A. H. Hauglid, "Nonlinear Mechanical Vibrations: The Effect of Gaps", NTNU, 2018,
       eq. 3.14, read as a stiffness in series with play (`jump_gap` is the printed form).
    .. [2] S. W. Shaw and P. J. Holmes, "A periodically forced piecewise linear oscillator",
       Journal of Sound and Vibration 90, 129-155, 1983.
    """

    kind: ClassVar[str] = "gap"
    formula: ClassVar[str] = "F = k (|z| - a) sign z for |z| > a, 0 inside"
    signature: ClassVar[str] = (
        "Nothing inside the play, a straight line outside. The resonance rises with level"
        " towards that of the closed joint, a sweep up jumps, odd harmonics appear."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "stiffness": Parameter("N/m", "k", "stiffness of the contact", linear=True),
        "clearance": Parameter("m", "a", "free play to each side", sign="not negative"),
    })

    stiffness: float
    clearance: float

    def force_at(self, displacement: FloatArray, velocity: FloatArray) -> FloatArray:
        beyond = np.maximum(np.abs(displacement) - self.clearance, 0.0)
        return self.stiffness * beyond * np.sign(displacement) + 0.0 * velocity

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

    @classmethod
    def identification(cls, at: JointScales) -> Identification:
        return Identification(
            free={"stiffness": contact(at), "clearance": clearance(at)},
            starts=grid(stiffness=contacts(at), clearance=clearances(at, 9)),
            scaled=("stiffness",),
        )

    def rows(self) -> tuple[Row, ...]:
        return (
            Row(Law.STOP, (self.stiffness, self.clearance, 1.0)),
            Row(Law.STOP, (self.stiffness, -self.clearance, -1.0)),
        )
