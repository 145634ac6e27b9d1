"""The kinds of study, and the mapping of them all."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from shakerproc.studies.kinds.base import AbstractKind, Option
from shakerproc.studies.kinds.curves import BackboneKind, ForceLaw, ResponseKind
from shakerproc.studies.kinds.formula import Formula
from shakerproc.studies.kinds.grid import Grid
from shakerproc.studies.kinds.runs import (
    Bifurcation,
    MotionKind,
    Poincare,
    Spectra,
    SpectrogramKind,
)

KINDS: Final[Mapping[str, AbstractKind]] = MappingProxyType({
    "grid": Grid(),
    "spectra": Spectra(),
    "motion": MotionKind(),
    "response": ResponseKind(),
    "backbone": BackboneKind(),
    "bifurcation": Bifurcation(),
    "poincare": Poincare(),
    "spectrogram": SpectrogramKind(),
    "force law": ForceLaw(),
    "formula": Formula(),
})

OPTIONS: Final[Mapping[str, Mapping[str, Option]]] = MappingProxyType({
    name: kind.options for name, kind in KINDS.items()
})
