"""Smooth hysteresis whose loop may soften or harden."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models.effects.base import AbstractEffect, Parameter
from shakerproc.models.effects.bouc_wen import RIGID
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


@final
@dataclass(frozen=True, slots=True)
class GeneralBoucWen(AbstractEffect):
    r"""Bouc-Wen hysteresis with all its parameters.

    .. math:: F = h, \qquad
        \dot h = \alpha v - \beta |v| |h|^{n - 1} h - \gamma v |h|^n

    The tangent stiffness is :math:`\alpha - (\beta + \gamma) |h|^n` away from rest and
    :math:`\alpha - (\gamma - \beta) |h|^n` back towards it, so that the loop softens or
    hardens. `bouc_wen` is its case of :math:`\beta = \gamma`. In a model file it is
    ``bouc_wen`` with ``alpha``, ``beta`` and ``gamma``.

    Attributes
    ----------
    alpha : float
        Stiffness at no force, :math:`\alpha` [N/m].
    beta : float
        Half the difference of the two branches, :math:`\beta`; it dissipates where it is
        positive [N^(1-n)/m, written as 1/m].
    gamma : float
        Half their sum, :math:`\gamma`; below 0 the loop hardens [N^(1-n)/m, written as 1/m].
    exponent : float
        Exponent :math:`n`, at least 1 [-].

    References
    ----------
    .. [1] Y. K. Wen, "Method for random vibration of hysteretic systems", Journal of the
       Engineering Mechanics Division 102, 249-263, 1976.
    .. [2] J. P. Noël and M. Schoukens, "Hysteretic benchmark with a dynamic nonlinearity",
       Workshop on Nonlinear System Identification Benchmarks, 7-14, 2016.
    """

    kind: ClassVar[str] = "general_bouc_wen"
    formula: ClassVar[str] = "F = h; h' = α v - β |v| |h|ⁿ⁻¹ h - γ v |h|ⁿ"
    signature: ClassVar[str] = (
        "A smooth loop that may harden as well as soften, whatever the velocity; odd harmonics."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "alpha": Parameter("N/m", "α", "stiffness at no force"),
        "beta": Parameter("1/m", "β", "half the difference of the branches", sign="any"),
        "gamma": Parameter("1/m", "γ", "half the sum of the branches", sign="any"),
        "exponent": Parameter("1", "n", "exponent, at least 1", least=1.0),
    })

    alpha: float
    beta: float
    gamma: float
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
                "alpha": sticking_stiffness(at),
                "yield_displacement": positive(0.1 * at.displacement, RIGID, 1e3),
                "branch": Free(-0.75 * math.pi, 0.25 * math.pi, "identity", 1.0),
                "exponent": Free(1.0, 10.0, "logarithm", 2.0),
            },
            starts=grid(
                alpha=(0.1 * at.steepness, 0.6 * at.steepness),
                yield_displacement=spread(0.05, 2.0, 4, at.displacement),
                branch=(-0.6, -1.7, 0.25 * math.pi),
                exponent=(1.0,),
            ),
            contains=(Contained("bouc_wen", _around_bouc_wen),),
            numbers=_numbers,
            scaled=("alpha",),
        )

    def rows(self) -> tuple[Row, ...]:
        loading, unloading = self.beta + self.gamma, self.gamma - self.beta
        larger = max(abs(loading), abs(unloading))
        if larger == 0.0:
            return (Row(Law.BOUC_WEN, (self.alpha, 1.0, 1.0, 0.0, 0.0)),)
        # in logarithms: the power alone overflows where draws of a forecast try 60 for 6
        power = math.log(larger) + (self.exponent - 1.0) * math.log(self.alpha)
        scale = math.exp(-power / self.exponent)
        shares = (loading / larger, unloading / larger)
        return (Row(Law.BOUC_WEN, (self.alpha, scale, self.exponent, *shares)),)


def _numbers(values: Values) -> Values:
    """Return the parameters.

    With s the extension h / alpha over `yield_displacement`, the tangent stiffness falls by
    the shares cos(branch) |s|^n away from rest and sin(branch) |s|^n back towards it: 0 is
    `bouc_wen`, and beta is positive between -3/4 pi and pi/4.
    """
    alpha, power = number(values, "alpha"), number(values, "exponent")
    size = alpha ** (1.0 - power) * number(values, "yield_displacement") ** -power
    branch = number(values, "branch")
    return {
        "alpha": alpha,
        "beta": 0.5 * size * (math.cos(branch) - math.sin(branch)),
        "gamma": 0.5 * size * (math.cos(branch) + math.sin(branch)),
        "exponent": power,
    }


def _around_bouc_wen(values: Values) -> tuple[Values, ...]:
    return grid(
        alpha=(number(values, "stiffness"),),
        yield_displacement=(number(values, "yield_displacement"),),
        branch=(0.0, -0.4, 0.2),
        exponent=(number(values, "exponent"),),
    )
