"""The keys of a study file."""

from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Field

from shakerproc.documents import FromList, Section
from shakerproc.units import in_unit

Hertz: TypeAlias = Annotated[float, in_unit("Hz", positive=True)]
FromZero: TypeAlias = Annotated[float, in_unit("Hz", not_negative=True)]
Seconds: TypeAlias = Annotated[float, in_unit("s", positive=True)]


class RunSection(Section):
    """One simulated run."""

    excitation: Literal["free", "sine", "sine sweep", "random"]
    level: Any = None
    start: FromZero = Field(0.0, alias="from")
    stop: FromZero = Field(0.0, alias="to")
    frequency: FromZero = 0.0
    phase: Annotated[float, in_unit("rad")] = 0.0
    duration: Seconds = 30.0
    sample_rate: Hertz = Field(500.0, alias="sample rate")
    direction: Literal["up", "down"] = "up"
    spacing: Literal["linear", "octaves"] = "linear"
    initial_displacement: Annotated[float, in_unit("m")] = Field(
        0.0, alias="initial displacement"
    )
    initial_velocity: Annotated[float, in_unit("m/s")] = Field(0.0, alias="initial velocity")
    settle: Annotated[float | int, Field(ge=0.0, lt=1.0)] = 0.0
    seed: Annotated[int, Field(ge=0)] = 0
    method: Literal["exact", "Newmark", "RK45", "BDF"] = "exact"
    tolerance: Annotated[float, Field(gt=0.0, lt=1.0)] = 1e-3


class MeasureSection(Section):
    """Reading taken from a run."""

    of: Literal["acceleration", "velocity", "displacement"] = "acceleration"
    estimator: Literal["periodogram", "welch"] = "periodogram"
    segment: Annotated[int, Field(ge=16)] = 2048
    take: Literal["tallest", "first"] = "tallest"
    start: FromZero = Field(0.0, alias="from")
    stop: FromZero = Field(0.0, alias="to")
    ensemble: Annotated[int, Field(ge=0, le=1000)] = 16


class VariationSection(Section):
    """One parameter that takes several values."""

    name: str
    set: str | Annotated[tuple[str, ...], FromList]
    values: Annotated[tuple[Any, ...], FromList, Field(min_length=1)]


class CheckSection(Section):
    """One check: a quantity, one thing that is wanted of it, a tolerance."""

    quantity: str | None = None
    equals: Any = None
    above: Any = None
    below: Any = None
    falls_with: str | None = Field(None, alias="falls with")
    rises_with: str | None = Field(None, alias="rises with")
    changes_with: str | None = Field(None, alias="changes with")
    within: Any = None


class ClaimSection(Section):
    """A published statement, and the checks that it must pass."""

    statement: str
    quantity: str | None = None
    falls_with: str | None = Field(None, alias="falls with")
    rises_with: str | None = Field(None, alias="rises with")
    checks: Annotated[tuple[CheckSection, ...], FromList] = ()
    comment: str = ""


class StudySection(Section):
    """A study file."""

    study: Literal[1]
    title: str
    kind: str
    figure: str = ""
    model: str | None = None
    coupon: str | None = None
    formula: str = ""
    run: RunSection | None = None
    measure: MeasureSection = Field(default_factory=MeasureSection)
    vary: Annotated[tuple[VariationSection, ...], FromList] = ()
    claim: ClaimSection | None = None
    options: dict[str, Any] = Field(default_factory=dict)
