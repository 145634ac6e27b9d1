"""A sine of the mains on the signal."""

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
class MainsHum(AbstractFault):
    """Sine of the mains frequency, picked up by a ground loop; of phase 0 at the start.

    Attributes
    ----------
    frequency : float
        Frequency of the mains, or of a harmonic of it [Hz].
    amplitude : float
        Amplitude of the sine, in the SI unit of the channel [m/s^2 or N].
    """

    kind: ClassVar[str] = "mains_hum"
    formula: ClassVar[str] = "u + A sin 2π f t"
    signature: ClassVar[str] = (
        "A line at 50 or 60 Hz and its multiples that is there while nothing shakes."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "frequency": Parameter("Hz", "f", "frequency of the hum"),
        "amplitude": Parameter("m/s^2", "A", "amplitude of the hum"),
    })

    frequency: float
    amplitude: float

    def __post_init__(self) -> None:
        check_parameters(self, self.parameters)

    def apply(self, samples: FloatArray, sample_rate: float) -> FloatArray:
        time = np.arange(samples.size) / sample_rate
        return samples + self.amplitude * np.sin(2.0 * np.pi * self.frequency * time)
