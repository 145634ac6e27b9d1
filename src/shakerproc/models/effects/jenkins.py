"""A spring in series with a slider."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, final

from shakerproc.data import FloatArray
from shakerproc.models.effects.base import AbstractEffect, Parameter, check_parameters
from shakerproc.models.kernels.along import jenkins_along
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

    def __post_init__(self) -> None:
        check_parameters(self, self.parameters)

    def force_along(
        self, displacement: FloatArray, velocity: FloatArray, sample_rate: float
    ) -> FloatArray:
        return jenkins_along(displacement, self.stiffness, self.slip_force)

    def rows(self) -> tuple[Row, ...]:
        return (Row(Law.JENKINS, (self.stiffness, self.slip_force)),)
