"""A spring in series with a slider."""

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
    friction,
    number,
    spread,
    sticking_stiffness,
)
from shakerproc.models.laws import Law, Row


@final
@dataclass(frozen=True, slots=True)
class Jenkins(AbstractEffect):
    r"""Spring in series with a Coulomb slider: elastic first, then slip at a constant force.

    .. math:: \dot F = k v \text{ while } |F| < F_s \text{ or } F v < 0, \qquad |F| \le F_s

    Attributes
    ----------
    stiffness : float
        Stiffness before slip, :math:`k` [N/m].
    slip_force : float
        Force of the slider, :math:`F_s` [N].

    References
    ----------
    .. [1] W. D. Iwan, "A distributed-element model for hysteresis and its steady-state dynamic
       response", Journal of Applied Mechanics 33, 893-900, 1966.
    """

    kind: ClassVar[str] = "jenkins"
    formula: ClassVar[str] = "F' = k v, held to |F| ≤ Fs"
    signature: ClassVar[str] = (
        "A leaning parallelogram: the resonance falls from stuck to free with level, "
        "damping has a maximum in between."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "stiffness": Parameter("N/m", "k", "stiffness before slip"),
        "slip_force": Parameter("N", "Fs", "slip force"),
    })

    stiffness: float
    slip_force: float

    def force_along(
        self, displacement: FloatArray, velocity: FloatArray, sample_rate: float
    ) -> FloatArray:
        from shakerproc.models.kernels import jenkins_along  # loads the compiler: late

        return jenkins_along(displacement, self.stiffness, self.slip_force)

    @classmethod
    def identification(cls, at: JointScales) -> Identification:
        return Identification(
            free={"stiffness": sticking_stiffness(at), "slip_force": friction(at)},
            starts=tuple(
                _values(share * at.steepness, slip)
                for share in (0.1, 0.6)
                for slip in spread(0.01, 0.8, 8, at.displacement)
            ),
            contains=(
                Contained(
                    "coulomb_friction",
                    lambda values: tuple(
                        _slider(number(values, "sliding_force"), share * at.displacement)
                        for share in (0.003, 0.02, 0.1)
                    ),
                ),
            ),
            scaled=("stiffness", "slip_force"),
        )

    def rows(self) -> tuple[Row, ...]:
        return (Row(Law.JENKINS, (self.stiffness, self.slip_force)),)


def _values(stiffness: float, slip: float) -> Values:
    """Return the element that slips at this displacement [m]."""
    return {"stiffness": stiffness, "slip_force": stiffness * slip}


def _slider(force: float, slip: float) -> Values:
    """Return the element of this slip force [N] that slips at this displacement [m]."""
    return {"stiffness": force / slip, "slip_force": force}
