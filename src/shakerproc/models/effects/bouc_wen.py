"""Smooth hysteresis."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, Final, final

import numpy as np

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
from shakerproc.models.laws import Law, Row, curve_back

RIGID: Final = 0.05
"""Least yield displacement over a tenth of the motion: a bristle that yields at half a per cent
of the motion is rigid, and the law is that of dry friction [-]."""


@final
@dataclass(frozen=True, slots=True)
class BoucWen(AbstractEffect):
    r"""Hysteretic spring that yields smoothly.

    .. math:: F = k h, \qquad
        \dot h = v \left(1 - \tfrac{1}{2} (1 + \operatorname{sgn}(v h))
        \left|\frac{h}{z_y}\right|^n\right)

    Attributes
    ----------
    stiffness : float
        Stiffness before yield, :math:`k` [N/m].
    yield_displacement : float
        Largest elastic displacement, :math:`z_y`; the force ends at :math:`k z_y` [m].
    exponent : float
        Sharpness of the yield, :math:`n`, at least 1 [-].

    References
    ----------
    .. [1] Y. K. Wen, "Method for random vibration of hysteretic systems", Journal of the
       Engineering Mechanics Division 102, 249-263, 1976; its A = 1, beta = gamma.
    """

    kind: ClassVar[str] = "bouc_wen"
    formula: ClassVar[str] = "F = k h; h' = v (1 - (1 + sign(v h)) / 2 · |h / zy|ⁿ)"
    signature: ClassVar[str] = (
        "A smooth leaning loop: the resonance falls with level, damping has a maximum in "
        "between."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "stiffness": Parameter("N/m", "k", "stiffness before yield", linear=True),
        "yield_displacement": Parameter("m", "zy", "yield displacement"),
        "exponent": Parameter("1", "n", "exponent, at least 1", least=1.0),
    })

    stiffness: float
    yield_displacement: float
    exponent: float

    def force_along(
        self, displacement: FloatArray, velocity: FloatArray, sample_rate: float
    ) -> FloatArray:
        from shakerproc.models.kernels import bouc_wen_along  # loads the compiler: late

        values = self.rows()[0].values
        return bouc_wen_along(displacement, np.array(values), curve_back(values))

    @classmethod
    def identification(cls, at: JointScales) -> Identification:
        return Identification(
            free={
                "stiffness": sticking_stiffness(at),
                "yield_displacement": positive(0.1 * at.displacement, RIGID, 1e2),
                "exponent": Free(1.0, _SHARPEST, "logarithm", 2.0),
            },
            starts=grid(
                stiffness=(0.1 * at.steepness, 0.6 * at.steepness),
                yield_displacement=spread(0.01, 0.8, 6, at.displacement),
                exponent=(2.0,),
            ),
            contains=(
                Contained("jenkins", _around_jenkins),
                Contained("iwan", _around_iwan, limit=False),
            ),
            scaled=("stiffness",),
        )

    def rows(self) -> tuple[Row, ...]:
        values = (self.stiffness, self.yield_displacement, self.exponent, 1.0, 0.0)
        return (Row(Law.BOUC_WEN, values),)


_SHARPEST = 20.0
"""Exponent beyond which the loop cannot be told from the sharp one of a Jenkins element [-]."""


def _around_jenkins(values: Values) -> tuple[Values, ...]:
    stiffness, force = number(values, "stiffness"), number(values, "slip_force")
    return grid(
        stiffness=(stiffness,),
        yield_displacement=(force / stiffness,),
        exponent=(_SHARPEST, 1.0, 2.0, 4.0),
    )


def _around_iwan(values: Values) -> tuple[Values, ...]:
    """Return elements of the same stiffness and final force."""
    return grid(
        stiffness=(number(values, "stiffness"),),
        yield_displacement=(0.5 * number(values, "slip_displacement"),),
        exponent=(1.0, 2.0),
    )
