"""Friction of bristles that bend before they slide."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models.effects.base import AbstractEffect, Parameter, check_parameters
from shakerproc.models.identification import (
    Contained,
    Identification,
    JointScales,
    Values,
    friction,
    number,
    positive,
    sticking_stiffness,
)
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
        from shakerproc.models.kernels import lugre_along  # loads the compiler: late

        values = np.array(self.rows()[0].values)
        return lugre_along(velocity + 0.0 * displacement, 1.0 / sample_rate, values)

    @classmethod
    def identification(cls, at: JointScales) -> Identification:
        return Identification(
            free={
                "sliding_force": friction(at),
                "excess": positive(0.3, 1e-3, 30.0),
                "stribeck_velocity": positive(0.1 * at.velocity, 1e-3, 100.0),
                "bristle_stiffness": sticking_stiffness(at),
                "bristle_time": positive(_bristle_time(at, at.steepness), 1e-3, 1e2),
            },
            starts=tuple(
                _start(at, share * at.force, excess, speed * at.velocity, bend)
                for share in (0.01, 0.04, 0.15, 0.5)
                for excess, speed in ((0.2, 0.1), (0.6, 0.3))
                for bend in (0.01, 0.05)
            ),
            contains=(
                Contained("coulomb_friction", lambda values: _around_coulomb(values, at)),
                Contained("stribeck_friction", lambda values: _around_stribeck(values, at)),
                Contained("jenkins", lambda values: _around_jenkins(values, at), limit=False),
            ),
            numbers=_numbers,
            scaled=("sliding_force", "bristle_stiffness"),
        )

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


_BRISTLE_RATIO = 0.2
"""Damping of the bristles to start from, as a share of critical on the joint's mass [-]."""

_STIFF = 0.003
"""Deflection of bristles that can hardly be told from none, of the largest displacement [-]."""


def _bristle_time(at: JointScales, stiffness: float) -> float:
    """Return bristle damping over bristle stiffness at the ratio to start from [s]."""
    return float(_BRISTLE_RATIO * np.sqrt(at.mass / stiffness))


def _start(at: JointScales, sliding: float, excess: float, speed: float, bend: float) -> Values:
    """Return coordinates; `bend` is the deflection while sliding over the displacement [-]."""
    stiffness = sliding / (bend * at.displacement)
    return {
        "sliding_force": sliding,
        "excess": excess,
        "stribeck_velocity": speed,
        "bristle_stiffness": stiffness,
        "bristle_time": _bristle_time(at, stiffness),
        "viscous_damping": 0.0,
    }


def _around_coulomb(values: Values, at: JointScales) -> tuple[Values, ...]:
    sliding, speed = number(values, "sliding_force"), 0.1 * at.velocity
    stiff = _start(at, sliding, 1e-3, speed, _STIFF)
    soft = (
        _start(at, 0.95 * sliding, 0.3, share * speed, bend)
        for share in (1.0, 4.0)
        for bend in (0.01, 0.05)
    )
    return (stiff, *soft)


def _around_stribeck(values: Values, at: JointScales) -> tuple[Values, ...]:
    excess, speed = number(values, "excess"), number(values, "stribeck_velocity")
    sliding = number(values, "breakaway_force") / (1.0 + excess)
    return tuple(_start(at, sliding, excess, speed, bend) for bend in (_STIFF, 0.01, 0.05))


def _around_jenkins(values: Values, at: JointScales) -> tuple[Values, ...]:
    sliding, stiffness = number(values, "slip_force"), number(values, "stiffness")
    bend = sliding / (stiffness * at.displacement)
    return tuple(_start(at, sliding, excess, 0.1 * at.velocity, bend) for excess in (1e-3, 0.3))


def _numbers(values: Values) -> Values:
    """Return the parameters.

    `excess` is the breakaway over the sliding force, less 1 [-], `bristle_time` the damping of
    the bristles over their stiffness [s].
    """
    sliding, stiffness = number(values, "sliding_force"), number(values, "bristle_stiffness")
    return {
        "sliding_force": sliding,
        "breakaway_force": sliding * (1.0 + number(values, "excess")),
        "stribeck_velocity": number(values, "stribeck_velocity"),
        "bristle_stiffness": stiffness,
        "bristle_damping": stiffness * number(values, "bristle_time"),
        "viscous_damping": number(values, "viscous_damping"),
    }
