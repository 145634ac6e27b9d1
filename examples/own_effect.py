"""An effect of one's own, from Python: a crack that opens one way and closes the other.

Nothing of shakerproc is changed; to make the effect known to model files and to the diagnosis,
see "Add an effect of my own" in the manual.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models import Element, Excitation, Model, Sensor
from shakerproc.models.effects.base import (
    AbstractMemorylessEffect,
    Parameter,
    Switch,
)
from shakerproc.models.laws import Law, Row
from shakerproc.simulation import simulate
from shakerproc.simulation.excitations import rest


@final
@dataclass(frozen=True, slots=True)
class BreathingCrack(AbstractMemorylessEffect):
    r"""Spring that is softer one way than the other, as a crack that opens and closes.

    .. math:: F = k_o z \quad (z > 0), \qquad k_c z \quad (z < 0)

    Attributes
    ----------
    open_stiffness : float
        Stiffness with the crack open, :math:`k_o` [N/m].
    closed_stiffness : float
        Stiffness with the crack closed, :math:`k_c` [N/m].

    References
    ----------
    .. [1] S. W. Shaw and P. J. Holmes, "A periodically forced piecewise linear oscillator",
       Journal of Sound and Vibration 90, 129-155, 1983.
    """

    kind: ClassVar[str] = "breathing_crack"
    formula: ClassVar[str] = "F = ko z for z > 0, kc z for z < 0"
    signature: ClassVar[str] = (
        "Even harmonics and a mean displacement at every level, in proportion to it; the "
        "resonance stays."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "open_stiffness": Parameter("N/m", "ko", "stiffness with the crack open", linear=True),
        "closed_stiffness": Parameter("N/m", "kc", "stiffness with it closed", linear=True),
    })

    open_stiffness: float
    closed_stiffness: float

    def force_at(self, displacement: FloatArray, velocity: FloatArray) -> FloatArray:
        return self.slopes(displacement, velocity)[0] * displacement

    def slopes(
        self, displacement: FloatArray, velocity: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        none = np.zeros(np.broadcast(displacement, velocity).shape)
        stiffness = np.where(displacement > 0.0, self.open_stiffness, self.closed_stiffness)
        return none + stiffness, none

    def switches(self) -> tuple[Switch, ...]:
        return (Switch("displacement", 0.0),)

    def rows(self) -> tuple[Row, ...]:  # two stops without play make it up
        return (
            Row(Law.STOP, (self.open_stiffness, 0.0, 1.0)),
            Row(Law.STOP, (self.closed_stiffness, 0.0, -1.0)),
        )


MASS, OPEN, CLOSED, START, RATE = 28.6e-3, 0.8e5, 1.2e5, 1e-4, 10_000.0
model = Model(
    title="cracked coupon",
    masses={"coupon": MASS},
    elements=(Element(BreathingCrack(OPEN, CLOSED), ("base", "coupon")),),
    excitation=Excitation("base acceleration"),
    sensors={"ch3": Sensor("coupon", "relative displacement")},
)
free = simulate(model, rest(), RATE, duration=0.1, start={"coupon": (START, 0.0)})
motion = free.outputs["ch3"]
rising = np.flatnonzero((motion[:-1] < 0.0) & (motion[1:] >= 0.0))
crossings = (rising - motion[rising] / (motion[rising + 1] - motion[rising])) / RATE
frequency = float((crossings.size - 1) / (crossings[-1] - crossings[0]))

if __name__ == "__main__":
    print(
        f"free motion at {frequency:.3f} Hz, from {motion.min():.4g} m to {motion.max():.4g} m"
    )
