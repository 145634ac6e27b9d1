"""Effects of one's own in one file: shakerproc simulate model.yaml log.yaml --effects FILE.

A detent, as of a magnet or of teeth: a force that repeats with displacement.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models import AbstractSampledEffect, Parameter
from shakerproc.models.identification import Identification, JointScales, grid, positive


@dataclass(frozen=True, slots=True)
class Detent(AbstractSampledEffect):
    r"""Force that holds a part in places at equal distances.

    .. math:: F = F_d \sin(2 \pi z / p)

    Attributes
    ----------
    force : float
        Largest force, :math:`F_d` [N].
    pitch : float
        Distance from one place to the next, :math:`p` [m].
    """

    kind: ClassVar[str] = "detent"
    formula: ClassVar[str] = "F = Fd sin(2π z / p)"
    signature: ClassVar[str] = (
        "Softens with level and hardens again, once the motion reaches the next place."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "force": Parameter("N", "Fd", "largest force", linear=True),
        "pitch": Parameter("m", "p", "distance of the places"),
    })

    force: float
    pitch: float

    def force_at(self, displacement: FloatArray, velocity: FloatArray) -> FloatArray:
        return self.force * np.sin(2.0 * np.pi * displacement / self.pitch) + 0.0 * velocity

    @classmethod
    def identification(cls, at: JointScales) -> Identification:
        """Where to look for it: pitches of 0.4 to 6 times the motion."""
        return Identification(
            free={
                "force": positive(0.1 * at.force),
                "pitch": positive(at.displacement, 0.05, 100.0),
            },
            starts=grid(
                force=(0.1 * at.force,),
                pitch=tuple(share * at.displacement for share in (0.4, 0.8, 1.5, 3.0, 6.0)),
            ),
            scaled=("force",),
        )
