"""Measurement faults: named, and never explained by physics."""

from collections.abc import Mapping
from types import MappingProxyType

from shakerproc.models.faults.base import AbstractFault
from shakerproc.models.faults.clipping import Clipping
from shakerproc.models.faults.mains_hum import MainsHum
from shakerproc.models.faults.sensor_delay import SensorDelay
from shakerproc.models.faults.sensor_gain import SensorGain
from shakerproc.models.faults.sensor_polarity import SensorPolarity

FAULTS: Mapping[str, type[AbstractFault]] = MappingProxyType({
    SensorDelay.kind: SensorDelay,
    SensorGain.kind: SensorGain,
    SensorPolarity.kind: SensorPolarity,
    Clipping.kind: Clipping,
    MainsHum.kind: MainsHum,
})

__all__ = [
    "FAULTS",
    "AbstractFault",
    "Clipping",
    "MainsHum",
    "SensorDelay",
    "SensorGain",
    "SensorPolarity",
]
