"""Free play that is not the same on both sides."""

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
)
from shakerproc.models.identification import (
    Contained,
    Identification,
    JointScales,
    Values,
    clearance,
    contact,
    number,
    spread,
)
from shakerproc.models.laws import Law, Row


@final
@dataclass(frozen=True, slots=True)
class OffsetGap(AbstractMemorylessEffect):
    r"""Free play of a part that does not rest in the middle.

    .. math:: F = k (z - a_+) \; (z > a_+), \qquad k (z + a_-) \; (z < -a_-),
        \qquad 0 \text{ inside}

    Attributes
    ----------
    stiffness : float
        Stiffness of both contacts, :math:`k` [N/m].
    clearance_positive : float
        Free play towards positive displacement, :math:`a_+` [m].
    clearance_negative : float
        Free play towards negative displacement, :math:`a_-` [m].

    References
    ----------
    .. [1] S. W. Shaw and P. J. Holmes, "A periodically forced piecewise linear oscillator",
       Journal of Sound and Vibration 90, 129-155, 1983.
    """

    kind: ClassVar[str] = "offset_gap"
    formula: ClassVar[str] = "F = k (z - a₊) for z > a₊, k (z + a₋) for z < -a₋, 0 inside"
    signature: ClassVar[str] = (
        "As a gap, but one wall is nearer: even harmonics and a mean displacement appear "
        "with the odd ones."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "stiffness": Parameter("N/m", "k", "stiffness of both contacts", linear=True),
        "clearance_positive": Parameter(
            "m", "a₊", "free play towards positive displacement", sign="not negative"
        ),
        "clearance_negative": Parameter(
            "m", "a₋", "free play towards negative displacement", sign="not negative"
        ),
    })

    stiffness: float
    clearance_positive: float
    clearance_negative: float

    def force_at(self, displacement: FloatArray, velocity: FloatArray) -> FloatArray:
        above = np.maximum(displacement - self.clearance_positive, 0.0)
        below = np.minimum(displacement + self.clearance_negative, 0.0)
        return self.stiffness * (above + below) + 0.0 * velocity

    def slopes(
        self, displacement: FloatArray, velocity: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        none = np.zeros(np.broadcast(displacement, velocity).shape)
        closed = (displacement > self.clearance_positive) | (
            displacement < -self.clearance_negative
        )
        return none + self.stiffness * closed, none

    def switches(self) -> tuple[Switch, ...]:
        return (
            Switch("displacement", -self.clearance_negative),
            Switch("displacement", self.clearance_positive),
        )

    @classmethod
    def identification(cls, at: JointScales) -> Identification:
        far = _FAR * at.displacement
        steps = spread(0.05, 0.9, 5, at.displacement)
        return Identification(
            free={
                "stiffness": contact(at),
                "clearance_positive": clearance(at, 1.5 * _FAR),
                "clearance_negative": clearance(at, 1.5 * _FAR),
            },
            starts=tuple(
                _values(1.5 * at.steepness, above, below)
                for above in steps
                for below in steps
                if above != below
            ),
            contains=(
                Contained("gap", _around_gap),
                Contained("stop", lambda values: _around_stop(values, far)),
            ),
            scaled=("stiffness",),
        )

    def rows(self) -> tuple[Row, ...]:
        return (
            Row(Law.STOP, (self.stiffness, self.clearance_positive, 1.0)),
            Row(Law.STOP, (self.stiffness, -self.clearance_negative, -1.0)),
        )


_FAR = 1.3
"""Clearance that nothing touches, as a multiple of the largest displacement [-]."""

_SHIFTS = (0.0, -0.3, 0.3)
"""Shifts of the rest position to try about a centred gap, as shares of its clearance [-]."""


def _values(stiffness: float, above: float, below: float) -> Values:
    return {
        "stiffness": stiffness,
        "clearance_positive": above,
        "clearance_negative": below,
    }


def _around_gap(values: Values) -> tuple[Values, ...]:
    stiffness, play = number(values, "stiffness"), number(values, "clearance")
    return tuple(
        _values(stiffness, play * (1.0 - shift), play * (1.0 + shift)) for shift in _SHIFTS
    )


def _around_stop(values: Values, far: float) -> tuple[Values, ...]:
    stiffness, play = number(values, "stiffness"), number(values, "clearance")
    if values["side"] == "positive":
        return tuple(_values(stiffness, play, other) for other in (far, 0.6 * far))
    return tuple(_values(stiffness, other, play) for other in (far, 0.6 * far))
