"""Physics only: masses, the elements between them, and the effects they are made of."""

from shakerproc.models.conditions import NO_CONDITIONS, Conditions, Scale
from shakerproc.models.effects import EFFECTS
from shakerproc.models.effects.base import AbstractEffect, AbstractMemorylessEffect, Parameter
from shakerproc.models.faults import FAULTS
from shakerproc.models.model import BASE, Element, Excitation, Model, Sensor
from shakerproc.models.structure import Mode
from shakerproc.models.tabulated import AbstractSampledEffect
