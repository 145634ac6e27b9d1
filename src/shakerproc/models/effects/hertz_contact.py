"""A contact of curved surfaces that loses energy in every impact, on one side or on both."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, Literal, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models.effects.base import (
    AbstractMemorylessEffect,
    Parameter,
    Switch,
)
from shakerproc.models.identification import (
    Contained,
    Identification,
    JointScales,
    Values,
    clearance,
    grid,
    number,
    positive,
    spread,
)
from shakerproc.models.laws import Law, Row


@final
@dataclass(frozen=True, slots=True)
class HertzContact(AbstractMemorylessEffect):
    r"""Contact of curved surfaces that rebound slower than they met (Hunt and Crossley).

    .. math:: F = s k d^{3/2} \max(1 + \tfrac32 \alpha \dot d, 0), \qquad
        d = s z - a > 0, \quad s = \pm 1

    Nothing where d is below 0. An impact at :math:`v_i` rebounds at :math:`e v_i` with
    :math:`e = 1 - \alpha v_i` for small :math:`\alpha v_i`; exactly, whatever mass and
    stiffness, with :math:`b = \tfrac32 \alpha v_i`,

    .. math:: b - \ln(1 + b) = -e b - \ln(1 - e b)

    Surfaces that part faster than they recover carry no force: the contact never pulls.

    Attributes
    ----------
    stiffness : float
        Force at unit depth, :math:`k` [N/m^1.5]; :math:`\tfrac43 E^* \sqrt R` of a sphere.
    clearance : float
        Free play to each wall, :math:`a` [m].
    restitution_loss : float
        Loss of restitution by the velocity of impact, :math:`\alpha` [s/m]; 0 loses nothing.
    side : {"both", "positive", "negative"}
        Towards which displacement there is a wall.

    References
    ----------
    .. [1] K. H. Hunt and F. R. E. Crossley, "Coefficient of restitution interpreted as damping
       in vibroimpact", Journal of Applied Mechanics 42, 440-445, 1975.
    .. [2] K. L. Johnson, "Contact Mechanics", Cambridge University Press, 1985, ch. 4, 11.4.
    """

    kind: ClassVar[str] = "hertz_contact"
    formula: ClassVar[str] = "F = s k d^1.5 (1 + 1.5 α dd/dt), d = s z - a > 0, never pulling"
    signature: ClassVar[str] = (
        "A wall that stiffens with depth: the resonance rises with level beyond that of a gap. "
        "The loop is open only past the play, more so the harder it hits."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "stiffness": Parameter("N/m^1.5", "k", "force at unit depth", linear=True),
        "clearance": Parameter("m", "a", "free play to each wall", sign="not negative"),
        "restitution_loss": Parameter(
            "s/m", "α", "loss of restitution by velocity of impact", sign="not negative"
        ),
        "side": Parameter(
            "", "s", "side of the wall", sign="any", choices=("both", "positive", "negative")
        ),
    })

    stiffness: float
    clearance: float
    restitution_loss: float
    side: Literal["both", "positive", "negative"]

    @property
    def directions(self) -> tuple[float, ...]:
        """+1 for a wall on the positive side, -1 for one on the negative."""
        return _DIRECTIONS[self.side]

    @property
    def velocity_factor(self) -> float:
        """Share of the force by the velocity of approach [s/m]."""
        return 1.5 * self.restitution_loss

    def force_at(self, displacement: FloatArray, velocity: FloatArray) -> FloatArray:
        total = np.zeros(np.broadcast(displacement, velocity).shape)
        for side in self.directions:
            depth, held = self._contact(side, displacement, velocity)
            total += side * self.stiffness * depth**1.5 * held
        return total

    def slopes(
        self, displacement: FloatArray, velocity: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        by_displacement = np.zeros(np.broadcast(displacement, velocity).shape)
        by_velocity = np.zeros_like(by_displacement)
        for side in self.directions:
            depth, held = self._contact(side, displacement, velocity)
            by_displacement += 1.5 * self.stiffness * np.sqrt(depth) * held
            by_velocity += self.stiffness * depth**1.5 * self.velocity_factor * (held > 0.0)
        return by_displacement, by_velocity

    def switches(self) -> tuple[Switch, ...]:
        places = [Switch("displacement", side * self.clearance) for side in self.directions]
        if self.restitution_loss > 0.0:
            fastest = 1.0 / self.velocity_factor
            places += [Switch("velocity", -side * fastest) for side in self.directions]
        return tuple(sorted(places, key=lambda switch: (switch.variable, switch.at)))

    @classmethod
    def identification(cls, at: JointScales) -> Identification:
        size = at.steepness / at.displacement**0.5
        loss = 0.3 / at.velocity
        return Identification(
            free={
                "stiffness": positive(size),
                "clearance": clearance(at),
                "restitution_loss": positive(loss, 1e-3, 10.0),
            },
            starts=grid(
                stiffness=(2.0 * size,),
                clearance=spread(0.05, 0.85, 5, at.displacement),
                restitution_loss=(loss,),
                side=tuple(_DIRECTIONS),
            ),
            contains=(
                Contained("gap", lambda values: _around(values, "both", at, loss), limit=False),
                Contained(
                    "stop",
                    lambda values: _around(values, str(values["side"]), at, loss),
                    limit=False,
                ),
            ),
            scaled=("stiffness",),
        )

    def rows(self) -> tuple[Row, ...]:
        return tuple(
            Row(Law.HERTZ, (self.stiffness, side * self.clearance, side, self.velocity_factor))
            for side in self.directions
        )

    def _contact(
        self, side: float, displacement: FloatArray, velocity: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return depth [m] and by how much the velocity scales the force [-]."""
        depth = np.maximum(side * displacement - self.clearance, 0.0)
        return depth, np.maximum(1.0 + self.velocity_factor * side * velocity, 0.0)


_DIRECTIONS: Mapping[str, tuple[float, ...]] = MappingProxyType({
    "both": (1.0, -1.0),
    "positive": (1.0,),
    "negative": (-1.0,),
})


def _around(values: Values, side: str, at: JointScales, loss: float) -> tuple[Values, ...]:
    """Return contacts with the force of a straight one at half its depth and at all of it."""
    stiffness, play = number(values, "stiffness"), number(values, "clearance")
    deepest = max(at.displacement - play, 0.05 * at.displacement)
    return grid(
        stiffness=tuple(stiffness / (share * deepest) ** 0.5 for share in (0.5, 1.0)),
        clearance=(play,),
        restitution_loss=(0.1 * loss,),
        side=(side,),
    )
