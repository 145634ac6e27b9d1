"""The power law that smooths a gap: weak between the walls, steep beyond them."""

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
    Contained,
    Free,
    Identification,
    JointScales,
    Values,
    grid,
    number,
    positive,
)
from shakerproc.models.laws import Law, Row


@final
@dataclass(frozen=True, slots=True)
class PowerLaw(AbstractMemorylessEffect):
    r"""Force with a power of displacement.

    .. math:: F = \kappa \left|\frac{z}{a}\right|^n \operatorname{sgn} z

    The thesis prints the exponent as :math:`2n - 1` (eq. 3.15, 3.17) and computes with
    :math:`n` (appendix B and eq. 6.6); `exponent` is the power itself. Its damping, eq. 3.16,
    is the effect `power_law_damping`.

    Attributes
    ----------
    force : float
        Force at the reference displacement, :math:`\kappa` [N].
    reference_displacement : float
        Displacement of the "wall", :math:`a` [m].
    exponent : float
        Power :math:`n`, at least 1 [-]; 1 is a spring of stiffness :math:`\kappa / a`.

    References
    ----------
    .. [1] A. H. Hauglid, "Nonlinear Mechanical Vibrations: The Effect of Gaps", NTNU, 2018,
       eq. 3.15, 3.17 and 6.6.
    .. [2] V. N. Pilipchuk, "Nonlinear Dynamics: Between Linear and Impact Limits", Springer,
       2010.
    """

    kind: ClassVar[str] = "power_law"
    formula: ClassVar[str] = "F = κ |z / a|ⁿ sign z"
    signature: ClassVar[str] = (
        "The frequency runs as a power of the amplitude, A^((n-1)/2), down to nothing at "
        "rest; odd harmonics at every level."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "force": Parameter("N", "κ", "force at the reference displacement", linear=True),
        "reference_displacement": Parameter("m", "a", "reference displacement", reference=True),
        "exponent": Parameter("1", "n", "exponent, at least 1", least=1.0),
    })

    force: float
    reference_displacement: float
    exponent: float

    def force_at(self, displacement: FloatArray, velocity: FloatArray) -> FloatArray:
        share = np.abs(displacement / self.reference_displacement) ** self.exponent
        return self.force * share * np.sign(displacement) + 0.0 * velocity

    def slopes(
        self, displacement: FloatArray, velocity: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        none = np.zeros(np.broadcast(displacement, velocity).shape)
        share = np.abs(displacement / self.reference_displacement) ** (self.exponent - 1.0)
        return none + self.force * self.exponent / self.reference_displacement * share, none

    def switches(self) -> tuple[Switch, ...]:
        odd = self.exponent % 2.0 == 1.0
        return () if odd else (Switch("displacement", 0.0),)

    @classmethod
    def identification(cls, at: JointScales) -> Identification:
        reference = 0.5 * at.displacement
        size = at.steepness * reference
        return Identification(
            free={"force": positive(size), "exponent": Free(1.05, 15.0, "logarithm", 3.0)},
            starts=grid(
                force=(0.3 * size,),
                reference_displacement=(reference,),
                exponent=(1.3, 1.6, 2.0, 2.5, 3.0, 3.6, 4.3, 5.2, 7.0),
            ),
            contains=(
                Contained("cubic_stiffness", lambda values: _from_cubic(values, reference)),
            ),
            scaled=("force",),
        )

    def rows(self) -> tuple[Row, ...]:
        return (Row(Law.ODD_POWER, (self.force, self.reference_displacement, self.exponent)),)


def _from_cubic(values: Values, reference: float) -> tuple[Values, ...]:
    """Return the power laws of a hardening cubic: its own, and one to each side of it."""
    force = number(values, "coefficient") * reference**3
    if force <= 0.0:
        return ()
    return grid(force=(force,), reference_displacement=(reference,), exponent=(3.0, 2.4, 4.0))
