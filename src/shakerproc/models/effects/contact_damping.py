"""A damper that acts only where the parts touch."""

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
    grid,
    positive,
)
from shakerproc.models.laws import Law, Row


@final
@dataclass(frozen=True, slots=True)
class ContactDamping(AbstractMemorylessEffect):
    r"""Viscous damping of a contact: nothing inside the free play.

    .. math:: F = c v \quad (|z| > a), \qquad 0 \text{ inside}

    Attributes
    ----------
    damping : float
        Damping in contact, :math:`c` [N s/m].
    clearance : float
        Free play to each side, :math:`a` [m].

    References
    ----------
    .. [1] R. A. Ibrahim, "Vibro-Impact Dynamics", Springer, 2009, ch. 1.
    """

    kind: ClassVar[str] = "contact_damping"
    formula: ClassVar[str] = "F = c v for |z| > a, 0 inside"
    signature: ClassVar[str] = (
        "Damping only past the play: the loop is open in the middle; the gain falls once "
        "the walls are reached."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "damping": Parameter("N s/m", "c", "damping in contact", linear=True),
        "clearance": Parameter("m", "a", "free play to each side", sign="not negative"),
    })

    damping: float
    clearance: float

    def force_at(self, displacement: FloatArray, velocity: FloatArray) -> FloatArray:
        return self.damping * velocity * (np.abs(displacement) > self.clearance)

    def slopes(
        self, displacement: FloatArray, velocity: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        none = np.zeros(np.broadcast(displacement, velocity).shape)
        return none, none + self.damping * (np.abs(displacement) > self.clearance)

    def switches(self) -> tuple[Switch, ...]:
        return (
            Switch("displacement", -self.clearance),
            Switch("displacement", self.clearance),
        )

    @classmethod
    def identification(cls, at: JointScales) -> Identification:
        size = 0.1 * at.critical_damping
        return Identification(
            free={"damping": positive(size), "clearance": clearance(at)},
            starts=grid(damping=(0.3 * size, 2.0 * size), clearance=clearances(at, 9)),
            scaled=("damping",),
        )

    def rows(self) -> tuple[Row, ...]:
        return (
            Row(Law.CONTACT_DAMPING, (self.damping, self.clearance, 1.0)),
            Row(Law.CONTACT_DAMPING, (self.damping, -self.clearance, -1.0)),
        )
