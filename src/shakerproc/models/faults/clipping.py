"""An amplifier that overloads."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models.effects.base import Parameter, check_parameters
from shakerproc.models.faults.base import AbstractFault


@final
@dataclass(frozen=True, slots=True)
class Clipping(AbstractFault):
    """Signal cut off where it exceeds the range of the amplifier.

    Attributes
    ----------
    level : float
        Largest value that is recorded, in the SI unit of the channel [m/s^2 or N].
    """

    kind: ClassVar[str] = "clipping"
    formula: ClassVar[str] = "u held to ±L"
    signature: ClassVar[str] = (
        "Flat tops at one value; odd harmonics at high level only, the same value in every run."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "level": Parameter("m/s^2", "L", "largest value recorded")
    })

    level: float

    def __post_init__(self) -> None:
        check_parameters(self, self.parameters)

    def apply(self, samples: FloatArray, sample_rate: float) -> FloatArray:
        return np.clip(samples, -self.level, self.level)
