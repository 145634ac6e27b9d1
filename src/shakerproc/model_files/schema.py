"""Schema of a model file, before the kinds of its effects are looked at."""

from typing import Annotated, Any, Literal

from pydantic import Field

from shakerproc.documents import FromList, Section
from shakerproc.models.model import Measures
from shakerproc.units import in_unit

_Metre = Annotated[float, in_unit("m")]


class ExcitationSection(Section):
    """``{base: acceleration}``, ``{force on: coupon}`` and so on: one of them."""

    base: Literal["acceleration"] | None = None
    force_on: Annotated[str | None, Field(alias="force on")] = None
    displacement_of: Annotated[str | None, Field(alias="displacement of")] = None
    free: Literal["decay"] | None = None


class SensorSection(Section):
    """Place and quantity of one channel."""

    at: str
    measures: Measures = "acceleration"
    faults: Annotated[tuple[dict[str, Any], ...], FromList] = ()


class ModeSection(Section):
    """One further linear mode."""

    frequency: Annotated[float, in_unit("Hz", positive=True)]
    damping_ratio: float = Field(ge=0.0)
    mass: Any
    participation: dict[str, float]


class ProvenanceSection(Section):
    """Where a fitted part of the model comes from."""

    added: str
    between: Annotated[tuple[str, ...], FromList]
    from_model: Annotated[str, Field(alias="from model")] = ""
    tests: Annotated[tuple[str | int, ...], FromList] = ()
    sha256: dict[str, str] = Field(default_factory=dict)
    intervals: dict[str, Annotated[tuple[str, str], FromList]] = Field(default_factory=dict)
    program: str = ""
    date: str = ""


class StructureModeSection(Section):
    """One mode of a structure."""

    frequency: Annotated[float, in_unit("Hz", not_negative=True)]
    damping_ratio: float = Field(ge=0.0)
    shape: Annotated[tuple[float, ...], FromList]
    participation: Any = None


class StructureSchema(Section):
    """A structure by its modes: a whole file, or a part of a model."""

    structure: Literal[1] = 1
    title: str = ""
    points: Annotated[tuple[str, ...], FromList] = ()
    direction: str | None = None
    modes: Annotated[tuple[StructureModeSection, ...], FromList] = ()
    modes_from: str | None = None
    nodes: dict[str, str] = Field(default_factory=dict)
    damping_ratio: Annotated[float | None, Field(ge=0.0)] = None
    residual: dict[str, Annotated[float, in_unit("m/N", positive=True)]] = Field(
        default_factory=dict
    )
    positions: dict[str, Annotated[tuple[_Metre, _Metre, _Metre], FromList]] = Field(
        default_factory=dict
    )
    mass: Annotated[float | None, in_unit("kg", positive=True)] = None
    mass_unit: str = "kg"
    length_unit: str | None = None


class ModelSchema(Section):
    """The whole file."""

    model: Literal[1]
    title: str = ""
    masses: dict[str, Any] = Field(default_factory=dict)
    structures: dict[str, str | StructureSchema] = Field(default_factory=dict)
    elements: Annotated[tuple[dict[str, Any], ...], FromList]
    excitation: ExcitationSection
    modes: Annotated[tuple[ModeSection, ...], FromList] = ()
    sensors: dict[str, SensorSection] = Field(default_factory=dict)
    provenance: Annotated[tuple[ProvenanceSection, ...], FromList] = ()
