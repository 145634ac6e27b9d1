"""A channel that comes late."""

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
class SensorDelay(AbstractFault):
    """Channel that is late against the others, as by a filter or a multiplexer.

    The delay is exact for a band-limited signal; the ends are treated as periodic.

    Attributes
    ----------
    delay : float
        Delay of the channel, below 0 where it is early [s].
    """

    kind: ClassVar[str] = "sensor_delay"
    formula: ClassVar[str] = "u(t - d)"
    signature: ClassVar[str] = (
        "The phase falls in proportion to frequency, the gain stays: a slope of the phase"
        " of every channel pair."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "delay": Parameter("s", "d", "delay of the channel", sign="any")
    })

    delay: float

    def __post_init__(self) -> None:
        check_parameters(self, self.parameters)

    def apply(self, samples: FloatArray, sample_rate: float) -> FloatArray:
        frequency = np.fft.rfftfreq(samples.size, 1.0 / sample_rate)
        late = np.fft.rfft(samples) * np.exp(-2j * np.pi * frequency * self.delay)
        return np.fft.irfft(late, samples.size)
