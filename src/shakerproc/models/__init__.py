"""Physics only: masses, the elements between them, and the effects they are made of."""

from shakerproc.models.effects import EFFECTS
from shakerproc.models.effects.base import AbstractEffect, AbstractMemorylessEffect, Parameter
from shakerproc.models.faults import FAULTS
from shakerproc.models.faults.base import AbstractFault
from shakerproc.models.mode import Mode
from shakerproc.models.model import BASE, Element, Excitation, Model, Sensor
from shakerproc.models.sampling import AbstractSampledEffect

__all__ = [
    "BASE",
    "EFFECTS",
    "FAULTS",
    "AbstractEffect",
    "AbstractFault",
    "AbstractMemorylessEffect",
    "AbstractSampledEffect",
    "Element",
    "Excitation",
    "Mode",
    "Model",
    "Parameter",
    "Sensor",
]
