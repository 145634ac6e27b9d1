"""Sliders that let go one after the other: microslip of a bolted joint."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, final

from shakerproc.data import FloatArray
from shakerproc.models.effects.base import AbstractEffect, Parameter
from shakerproc.models.identification import (
    Contained,
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
class Iwan(AbstractEffect):
    r"""Jenkins elements in parallel whose slip displacements are spread evenly from 0 to z_s.

    .. math:: F = k z \left(1 - \frac{|z|}{2 z_s}\right) \quad (|z| \le z_s), \qquad
        \tfrac{1}{2} k z_s \text{ beyond}

    That is first loading. Unloading and reloading follow it at twice the scale from the last
    turning point, and a closed loop is forgotten (Masing's rules), which is what the infinitely
    many sliders do exactly; none is discretised.

    Attributes
    ----------
    stiffness : float
        Stiffness before any slip, :math:`k` [N/m].
    slip_displacement : float
        Displacement at which all has slipped on first loading, :math:`z_s` [m].

    References
    ----------
    .. [1] W. D. Iwan, "On a class of models for the yielding behavior of continuous and
       composite systems", Journal of Applied Mechanics 34, 612-617, 1967.
    .. [2] D. J. Segalman, "A four-parameter Iwan model for lap-type joints", Journal of Applied
       Mechanics 72, 752-760, 2005; this is its case of chi = 0, beta = 0.
    """

    kind: ClassVar[str] = "iwan"
    formula: ClassVar[str] = (
        "F = k z (1 - |z| / (2 zs)) on first loading, k zs / 2 beyond zs; then Masing's rules"
    )
    signature: ClassVar[str] = (
        "Slip that grows from the smallest motion: the resonance falls and damping rises "
        "with level, both steadily."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "stiffness": Parameter("N/m", "k", "stiffness before slip", linear=True),
        "slip_displacement": Parameter("m", "zs", "displacement of full slip"),
    })

    stiffness: float
    slip_displacement: float

    def force_along(
        self, displacement: FloatArray, velocity: FloatArray, sample_rate: float
    ) -> FloatArray:
        from shakerproc.models.kernels import iwan_along  # loads the compiler: late

        return iwan_along(displacement, self.stiffness, self.slip_displacement, 2.0)

    @classmethod
    def identification(cls, at: JointScales) -> Identification:
        return Identification(
            free={
                "stiffness": sticking_stiffness(at),
                "slip_displacement": positive(0.3 * at.displacement, 1e-3, 1e2),
            },
            starts=grid(
                stiffness=(0.1 * at.steepness, 0.6 * at.steepness),
                slip_displacement=spread(0.03, 3.0, 8, at.displacement),
            ),
            contains=(Contained("jenkins", _around_jenkins, limit=False),),
            scaled=("stiffness",),
        )

    def rows(self) -> tuple[Row, ...]:
        return (Row(Law.IWAN, (self.stiffness, self.slip_displacement, 2.0)),)


def _around_jenkins(values: Values) -> tuple[Values, ...]:
    """Return the elements with the same stiffness, or about it, and the same final force."""
    stiffness, force = number(values, "stiffness"), number(values, "slip_force")
    return tuple(
        {"stiffness": share * stiffness, "slip_displacement": 2.0 * force / (share * stiffness)}
        for share in (1.0, 1.6)
    )
