"""Damping that grows with displacement, the companion of the power law."""

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
class PowerLawDamping(AbstractMemorylessEffect):
    r"""Viscous damping whose coefficient grows with a power of displacement.

    .. math:: F = c \left|\frac{z}{a}\right|^n v

    The exponent :math:`2p` of eq. 3.16 is `exponent` here.

    Attributes
    ----------
    damping : float
        Damping at the reference displacement, :math:`c` [N s/m].
    reference_displacement : float
        Displacement of the "wall", :math:`a` [m].
    exponent : float
        Power :math:`n` [-].

    References
    ----------
    .. [1] A. H. Hauglid, "Nonlinear Mechanical Vibrations: The Effect of Gaps", NTNU, 2018,
       eq. 3.16.
    """

    kind: ClassVar[str] = "power_law_damping"
    formula: ClassVar[str] = "F = c |z / a|ⁿ v"
    signature: ClassVar[str] = (
        "Damping that sets in with displacement: the gain at resonance falls with level "
        "while the frequency stays."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "damping": Parameter("N s/m", "c", "damping at the reference", linear=True),
        "reference_displacement": Parameter("m", "a", "reference displacement", reference=True),
        "exponent": Parameter("1", "n", "exponent, at least 1", least=1.0),
    })

    damping: float
    reference_displacement: float
    exponent: float

    def force_at(self, displacement: FloatArray, velocity: FloatArray) -> FloatArray:
        share = np.abs(displacement / self.reference_displacement) ** self.exponent
        return self.damping * share * velocity

    def slopes(
        self, displacement: FloatArray, velocity: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        ratio = displacement / self.reference_displacement
        by_velocity = self.damping * np.abs(ratio) ** self.exponent + 0.0 * velocity
        steepness = np.abs(ratio) ** (self.exponent - 1.0) * np.sign(displacement)
        scale = self.damping * self.exponent / self.reference_displacement
        return scale * steepness * velocity, by_velocity

    def switches(self) -> tuple[Switch, ...]:
        even = self.exponent % 2.0 == 0.0
        return () if even else (Switch("displacement", 0.0),)

    def rows(self) -> tuple[Row, ...]:
        return (
            Row(Law.POWER_DAMPING, (self.damping, self.reference_displacement, self.exponent)),
        )
