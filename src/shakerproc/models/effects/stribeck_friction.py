"""Dry friction that falls from breaking away to sliding."""

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
    check_parameters,
)
from shakerproc.models.identification import (
    Contained,
    Identification,
    JointScales,
    Values,
    friction,
    frictions,
    grid,
    number,
    positive,
)
from shakerproc.models.laws import Law, Row


@final
@dataclass(frozen=True, slots=True)
class StribeckFriction(AbstractMemorylessEffect):
    r"""Dry friction that is higher at rest than while sliding.

    .. math:: F = \left(F_c + (F_s - F_c) e^{-(v / v_s)^2}\right) \operatorname{sgn} v,
        \qquad |F| \le F_s \text{ where } v = 0

    Time integration lets the joint stick exactly. Along a prescribed motion the force is
    given as 0 where v is exactly 0.

    Attributes
    ----------
    sliding_force : float
        Force at high velocity, :math:`F_c` [N].
    breakaway_force : float
        The most the joint holds at rest, :math:`F_s`, at least `sliding_force` [N].
    stribeck_velocity : float
        Velocity over which the force falls, :math:`v_s` [m/s].

    References
    ----------
    .. [1] B. Armstrong-Hélouvry, P. Dupont and C. Canudas de Wit, "A survey of models, analysis
       tools and compensation methods for the control of machines with friction", Automatica
       30, 1083-1138, 1994.
    """

    kind: ClassVar[str] = "stribeck_friction"
    formula: ClassVar[str] = "F = (Fc + (Fs - Fc) exp(-(v / vs)²)) sign v; at rest up to Fs"
    signature: ClassVar[str] = (
        "As dry friction, but it holds better than it slides: stick-slip, jerks where the"
        " motion turns."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "sliding_force": Parameter("N", "Fc", "sliding force", linear=True),
        "breakaway_force": Parameter("N", "Fs", "breakaway force", linear=True),
        "stribeck_velocity": Parameter("m/s", "vs", "Stribeck velocity"),
    })

    sliding_force: float
    breakaway_force: float
    stribeck_velocity: float

    def __post_init__(self) -> None:
        check_parameters(self, self.parameters)
        if self.breakaway_force < self.sliding_force:
            raise ValueError(
                f"breakaway_force must be at least the sliding force {self.sliding_force:g} N, "
                f"not {self.breakaway_force:g} N"
            )

    def force_at(self, displacement: FloatArray, velocity: FloatArray) -> FloatArray:
        excess = self.breakaway_force - self.sliding_force
        fall = np.exp(-((velocity / self.stribeck_velocity) ** 2))
        return (self.sliding_force + excess * fall) * np.sign(velocity) + 0.0 * displacement

    def slopes(
        self, displacement: FloatArray, velocity: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        none = np.zeros(np.broadcast(displacement, velocity).shape)
        excess = self.breakaway_force - self.sliding_force
        fall = np.exp(-((velocity / self.stribeck_velocity) ** 2))
        steepness = -2.0 * excess * np.abs(velocity) / self.stribeck_velocity**2 * fall
        return none, none + steepness

    def switches(self) -> tuple[Switch, ...]:
        return (Switch("velocity", 0.0),)

    @classmethod
    def identification(cls, at: JointScales) -> Identification:
        speed = at.velocity
        return Identification(
            free={
                "breakaway_force": friction(at),
                "excess": positive(0.3, 1e-3, 30.0),
                "stribeck_velocity": positive(0.1 * speed, 1e-3, 100.0),
            },
            starts=grid(
                breakaway_force=tuple(1.4 * force for force in frictions(at)),
                excess=(0.4,),
                stribeck_velocity=(0.02 * speed, 0.1 * speed, 0.4 * speed),
            ),
            contains=(
                Contained("coulomb_friction", lambda values: _around_coulomb(values, speed)),
            ),
            numbers=_numbers,
            scaled=("breakaway_force",),
        )

    def rows(self) -> tuple[Row, ...]:
        values = (self.sliding_force, self.breakaway_force, self.stribeck_velocity)
        return (Row(Law.FRICTION, values),)


def _numbers(values: Values) -> Values:
    """Return the parameters: `excess` is the breakaway over the sliding force, less 1 [-].

    A joint that mostly sticks tells the breakaway force and how fast the force falls next to
    rest, not what it falls to: with the sliding force for a coordinate that is a bent valley.
    """
    breakaway = number(values, "breakaway_force")
    return {
        "sliding_force": breakaway / (1.0 + number(values, "excess")),
        "breakaway_force": breakaway,
        "stribeck_velocity": number(values, "stribeck_velocity"),
    }


def _around_coulomb(values: Values, speed: float) -> tuple[Values, ...]:
    """Return the friction itself, with no excess to speak of, and some that fall.

    It lies between both forces where the joint slides, and is the breakaway force where it
    mostly sticks.
    """
    sliding = number(values, "sliding_force")
    pairs = ((1.0, 1e-3), (0.95, 0.15), (0.8, 0.5), (0.87, 0.15), (0.67, 0.5))  # of it; excess
    return tuple(
        {
            "breakaway_force": share * (1.0 + excess) * sliding,
            "excess": excess,
            "stribeck_velocity": fall * speed,
        }
        for share, excess in pairs
        for fall in ((0.1,) if excess < 0.01 else (0.02, 0.1, 0.4, 2.0))
    )
