"""Microslip whose slip displacements follow a power law."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, final

from shakerproc.data import FloatArray
from shakerproc.models.effects.base import AbstractEffect, Parameter
from shakerproc.models.identification import (
    Contained,
    Free,
    Identification,
    JointScales,
    Values,
    grid,
    number,
    positive,
    spread,
    sticking_stiffness,
)
from shakerproc.models.laws import Law, Row


@final
@dataclass(frozen=True, slots=True)
class PowerIwan(AbstractEffect):
    r"""Jenkins elements in parallel whose stiffness is spread as a power of slip displacement.

    .. math:: F = k z \left(1 - \frac{(|z| / z_s)^{\chi + 1}}{\chi + 2}\right)
        \quad (|z| \le z_s), \qquad k z_s \frac{\chi + 1}{\chi + 2} \text{ beyond}

    That is first loading; Masing's rules follow. The energy lost in a cycle of small amplitude
    grows with the power :math:`\chi + 3` of it. In a model file it is ``iwan`` with ``chi``.

    Attributes
    ----------
    stiffness : float
        Stiffness before any slip, :math:`k` [N/m].
    slip_displacement : float
        Displacement at which all has slipped on first loading, :math:`z_s` [m].
    chi : float
        Exponent of the distribution of slip displacements, :math:`\chi`, above -1 [-]; 0 is
        `iwan`, a large one a Jenkins element.

    References
    ----------
    .. [1] D. J. Segalman, "A four-parameter Iwan model for lap-type joints", Journal of Applied
       Mechanics 72, 752-760, 2005; its beta is 0 here.
    """

    kind: ClassVar[str] = "power_iwan"
    formula: ClassVar[str] = (
        "F = k z (1 - |z / zs|^(χ + 1) / (χ + 2)) on first loading, constant beyond zs; then "
        "Masing's rules"
    )
    signature: ClassVar[str] = (
        "Slip that grows from the smallest motion. The energy lost in a cycle is a power of "
        "amplitude between 2 and 3, as measured on lap joints."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "stiffness": Parameter("N/m", "k", "stiffness before slip", linear=True),
        "slip_displacement": Parameter("m", "zs", "displacement of full slip"),
        "chi": Parameter("1", "χ", "exponent of the distribution", sign="any", least=-0.999),
    })

    stiffness: float
    slip_displacement: float
    chi: float

    def force_along(
        self, displacement: FloatArray, velocity: FloatArray, sample_rate: float
    ) -> FloatArray:
        from shakerproc.models.kernels import iwan_along  # loads the compiler: late

        return iwan_along(displacement, *self.rows()[0].values)

    @classmethod
    def identification(cls, at: JointScales) -> Identification:
        return Identification(
            free={
                "stiffness": sticking_stiffness(at),
                "slip_displacement": positive(0.3 * at.displacement, 1e-3, 1e2),
                "spread": Free(0.05, _NARROWEST, "logarithm", 1.0),
            },
            starts=grid(
                stiffness=(0.1 * at.steepness, 0.6 * at.steepness),
                slip_displacement=spread(0.1, 3.0, 4, at.displacement),
                spread=(0.4, 2.0),
            ),
            contains=(
                Contained("iwan", _around_iwan),
                Contained("jenkins", _around_jenkins),
            ),
            numbers=_numbers,
            scaled=("stiffness",),
        )

    def rows(self) -> tuple[Row, ...]:
        return (Row(Law.IWAN, (self.stiffness, self.slip_displacement, self.chi + 2.0)),)


_NARROWEST = 20.0
"""Largest chi + 1: the sliders then slip within a tenth of the slip displacement [-]."""


def _numbers(values: Values) -> Values:
    """Return the parameters: `spread` is chi + 1 [-]."""
    return {
        "stiffness": number(values, "stiffness"),
        "slip_displacement": number(values, "slip_displacement"),
        "chi": number(values, "spread") - 1.0,
    }


def _around_iwan(values: Values) -> tuple[Values, ...]:
    return grid(
        stiffness=(number(values, "stiffness"),),
        slip_displacement=(number(values, "slip_displacement"),),
        spread=(1.0, 0.5, 2.0),
    )


def _around_jenkins(values: Values) -> tuple[Values, ...]:
    """Return elements of the same stiffness and final force."""
    stiffness, force = number(values, "stiffness"), number(values, "slip_force")
    return tuple(
        {
            "stiffness": stiffness,
            "slip_displacement": force / stiffness * (share + 1.0) / share,
            "spread": share,
        }
        for share in (_NARROWEST, 1.0, 4.0)
    )
