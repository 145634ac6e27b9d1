"""A channel with the wrong sensitivity."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, final

from shakerproc.data import FloatArray
from shakerproc.models.effects.base import Parameter, check_parameters
from shakerproc.models.faults.base import AbstractFault


@final
@dataclass(frozen=True, slots=True)
class SensorGain(AbstractFault):
    """Channel whose sensitivity is not what the log says.

    Attributes
    ----------
    gain : float
        Recorded over true [-].
    """

    kind: ClassVar[str] = "sensor_gain"
    formula: ClassVar[str] = "g u"
    signature: ClassVar[str] = (
        "The gain is off by one factor at every frequency and level, where nothing should"
        " move against the table as well."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "gain": Parameter("1", "g", "recorded over true")
    })

    gain: float

    def __post_init__(self) -> None:
        check_parameters(self, self.parameters)

    def apply(self, samples: FloatArray, sample_rate: float) -> FloatArray:
        return self.gain * samples
