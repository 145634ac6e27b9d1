"""Dry friction with one level for sliding and sticking."""

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
    DRY_SHARES,
    Identification,
    JointScales,
    friction,
    frictions,
    grid,
)
from shakerproc.models.laws import Law, Row


@final
@dataclass(frozen=True, slots=True)
class CoulombFriction(AbstractMemorylessEffect):
    r"""Dry friction.

    .. math:: F = F_c \operatorname{sgn} v, \qquad |F| \le F_c \text{ where } v = 0

    Time integration lets the joint stick exactly; nothing is smoothed. Along a prescribed
    motion the force of rest is not determined, and is given as 0 where v is exactly 0.

    Attributes
    ----------
    sliding_force : float
        Force while the joint slides, and the most it holds at rest, :math:`F_c` [N].

    References
    ----------
    .. [1] A. H. Hauglid, "Nonlinear Mechanical Vibrations: The Effect of Gaps", NTNU, 2018,
       eq. 3.18-3.20; the last line of eq. 3.19 should read :math:`v > 0`.
    .. [2] J. P. Den Hartog, "Forced vibrations with combined Coulomb and viscous friction",
       Transactions of the ASME 53, 107-115, 1931.
    """

    kind: ClassVar[str] = "coulomb_friction"
    formula: ClassVar[str] = "F = Fc sign v; at rest whatever holds it, up to Fc"
    signature: ClassVar[str] = (
        "A rectangle: stuck at low level (the joint is rigid), a high peak at high level;"
        " damping falls as 1 over amplitude, odd harmonics."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "sliding_force": Parameter("N", "Fc", "sliding force", linear=True),
    })

    sliding_force: float

    def force_at(self, displacement: FloatArray, velocity: FloatArray) -> FloatArray:
        return self.sliding_force * np.sign(velocity) + 0.0 * displacement

    def slopes(
        self, displacement: FloatArray, velocity: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        none = np.zeros(np.broadcast(displacement, velocity).shape)
        return none, none.copy()

    def switches(self) -> tuple[Switch, ...]:
        return (Switch("velocity", 0.0),)

    @classmethod
    def identification(cls, at: JointScales) -> Identification:
        return Identification(
            free={"sliding_force": friction(at)},
            starts=grid(sliding_force=frictions(at, DRY_SHARES)),
            scaled=("sliding_force",),
        )

    def rows(self) -> tuple[Row, ...]:
        return (Row(Law.FRICTION, (self.sliding_force, self.sliding_force, 1.0)),)
