"""Friction of bristles that bend before they slide."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models.effects.base import AbstractEffect, Parameter, check_parameters
from shakerproc.models.kernels.along import lugre_along
from shakerproc.models.laws import Law, Row


@final
@dataclass(frozen=True, slots=True)
class LuGreFriction(AbstractEffect):
    r"""Friction of a bristled interface: presliding stiffness, Stribeck fall, viscous part.

    .. math::

        F &= \sigma_0 s + \sigma_1 \dot s + \sigma_2 v \\
        \dot s &= v - \frac{\sigma_0 |v|}{F_c + (F_s - F_c) e^{-(v / v_s)^2}} s

    Attributes
    ----------
    sliding_force : float
        Force at high velocity without the viscous part, :math:`F_c` [N].
    breakaway_force : float
        Force at which the bristles give way, :math:`F_s`, at least `sliding_force` [N].
    stribeck_velocity : float
        Velocity over which the force falls, :math:`v_s` [m/s].
    bristle_stiffness : float
        Stiffness before sliding, :math:`\sigma_0` [N/m].
    bristle_damping : float
        Damping of the bristles, :math:`\sigma_1` [N s/m].
    viscous_damping : float
        Damping while sliding, :math:`\sigma_2` [N s/m].

    References
    ----------
    .. [1] C. Canudas de Wit, H. Olsson, K. J. Åström and P. Lischinsky, "A new model for
       control of systems with friction", IEEE Transactions on Automatic Control 40, 419-425,
       1995.
    """

    kind: ClassVar[str] = "lugre_friction"
    formula: ClassVar[str] = (
        "F = σ₀ s + σ₁ s' + σ₂ v; s' = v - σ₀ |v| s / (Fc + (Fs - Fc) exp(-(v / vs)²))"
    )
    signature: ClassVar[str] = (
        "A rectangle with rounded, leaning corners: stiff before it slides, friction "
        "after; depends on velocity."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "sliding_force": Parameter("N", "Fc", "sliding force"),
        "breakaway_force": Parameter("N", "Fs", "breakaway force"),
        "stribeck_velocity": Parameter("m/s", "vs", "Stribeck velocity"),
        "bristle_stiffness": Parameter("N/m", "σ₀", "stiffness before sliding"),
        "bristle_damping": Parameter(
            "N s/m", "σ₁", "damping of the bristles", sign="not negative"
        ),
        "viscous_damping": Parameter(
            "N s/m", "σ₂", "damping while sliding", linear=True, sign="not negative"
        ),
    })

    sliding_force: float
    breakaway_force: float
    stribeck_velocity: float
    bristle_stiffness: float
    bristle_damping: float
    viscous_damping: float

    def __post_init__(self) -> None:
        check_parameters(self, self.parameters)
        if self.breakaway_force < self.sliding_force:
            raise ValueError(
                f"breakaway_force must be at least the sliding force {self.sliding_force:g} N, "
                f"not {self.breakaway_force:g} N"
            )

    def force_along(
        self, displacement: FloatArray, velocity: FloatArray, sample_rate: float
    ) -> FloatArray:
        values = np.array(self.rows()[0].values)
        return lugre_along(velocity + 0.0 * displacement, 1.0 / sample_rate, values)

    def rows(self) -> tuple[Row, ...]:
        values = (
            self.sliding_force,
            self.breakaway_force,
            self.stribeck_velocity,
            self.bristle_stiffness,
            self.bristle_damping,
            self.viscous_damping,
        )
        return (Row(Law.LUGRE, values),)
