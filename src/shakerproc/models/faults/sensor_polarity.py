"""A sensor mounted the wrong way round."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, final

from shakerproc.data import FloatArray
from shakerproc.models.effects.base import Parameter, check_parameters
from shakerproc.models.faults.base import AbstractFault


@final
@dataclass(frozen=True, slots=True)
class SensorPolarity(AbstractFault):
    """Channel with the wrong sign."""

    kind: ClassVar[str] = "sensor_polarity"
    formula: ClassVar[str] = "-u"
    signature: ClassVar[str] = (
        "The phase is 180 degrees at low frequency, where the coupon must follow the table."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({})

    def __post_init__(self) -> None:
        check_parameters(self, self.parameters)

    def apply(self, samples: FloatArray, sample_rate: float) -> FloatArray:
        return -samples
