"""The keys of a test log: where each may stand, and its meaning.

Levels stay text until the kind of excitation is known. Whatever is not listed here is refused;
further columns go under `tags`.
"""

from collections.abc import Callable
from datetime import date, datetime
from pathlib import Path
from typing import Annotated, Any, Final, Literal, TypeAlias

from pydantic import AfterValidator, BeforeValidator, Discriminator, Field, Tag

from shakerproc.data import Role
from shakerproc.documents import FromList, Section
from shakerproc.testlog.excitation import Excitation
from shakerproc.testlog.fields import (
    Decibels,
    Direction,
    HashText,
    Hertz,
    Identity,
    Length,
    Metre,
    MisfitError,
    Quantity,
    Remark,
    SensitivityText,
    Text,
    UnitText,
    Written,
    one_line,
)
from shakerproc.testlog.header import (
    Header,
    Instrument,
    checked_photo,
    checked_template,
    chosen_units,
)
from shakerproc.testlog.processing_sections import (
    BandSection,
    MultisineSection,
    ProcessingSection,
    SampleRate,
    ToneSection,
)
from shakerproc.units import in_unit, quoted

MOST_NODE: Final = 999_999_999
"""Largest number of a node that a universal file can hold beside another."""


def _as_text(written: object) -> object:
    """Return numbers and days, such as an order of digits alone, as the text that they are."""
    plain = isinstance(written, int | float | date) and not isinstance(written, bool)
    return str(written) if plain else written


def _as_list(written: object) -> object:
    """Return one text, such as ``g, in/s, mil``, as the list that it stands for."""
    return written.split(",") if isinstance(written, str) else written


def _day(text: str) -> str:
    for form in ("%Y-%m-%d", "%d.%m.%Y"):
        try:
            return datetime.strptime(text.strip(), form).date().isoformat()  # noqa: DTZ007
        except ValueError:
            continue
    raise ValueError(f"expected a day such as 2026-03-31, got {quoted(text)}")


Line: TypeAlias = Annotated[str, BeforeValidator(_as_text), AfterValidator(one_line)]
Day: TypeAlias = Annotated[str, BeforeValidator(_as_text), AfterValidator(_day)]


class InstrumentSection(Section):
    """An instrument and its calibration."""

    instrument: Line
    serial: Line | None = None
    calibrated: Day | None = None
    valid_until: Day | None = None


class HeaderSection(Section):
    """The head of the report."""

    client: Line | None = None
    order: Line | None = None
    specimen: Line | None = None
    photo: str | None = None
    template: str | None = None
    operator: Line | None = None
    standard: Line | None = None
    instruments: Annotated[tuple[InstrumentSection, ...], FromList] = ()
    units: Annotated[tuple[str, ...], FromList, BeforeValidator(_as_list)] = ()


def header_of(section: HeaderSection, below: Callable[[str], Path]) -> Header:
    """Return the head of the report.

    Parameters
    ----------
    section : HeaderSection
        What the log says.
    below : callable
        From a path in the log to one below its folder.

    Raises
    ------
    MisfitError
        If photo, template, a unit or the days of an instrument cannot be used.
    """
    paths: dict[str, Path] = {}
    for key, name, check in (
        ("photo", section.photo, checked_photo),
        ("template", section.template, checked_template),
    ):
        if name is not None:
            try:
                paths[key] = check(below(name))
            except ValueError as error:
                raise MisfitError(str(error), key) from error
    try:
        shown = chosen_units(section.units)
    except ValueError as error:
        raise MisfitError(str(error), "units") from error
    for i, one in enumerate(section.instruments):
        if one.calibrated and one.valid_until and one.valid_until < one.calibrated:
            raise MisfitError(
                f"expected a day after {one.calibrated}, when it was calibrated, got "
                f"{one.valid_until}",
                "instruments",
                i,
                "valid_until",
            )
    return Header(
        client=section.client or "",
        order=section.order or "",
        specimen=section.specimen or "",
        operator=section.operator or "",
        standard=section.standard or "",
        photo=paths.get("photo"),
        template=paths.get("template"),
        instruments=tuple(
            Instrument(
                one.instrument, one.serial or "", one.calibrated or "", one.valid_until or ""
            )
            for one in section.instruments
        ),
        units=shown,
    )


class ChannelSection(Section):
    """One channel of the recordings."""

    role: Role
    name: Text | None = None
    at: Text | None = None
    unit: UnitText | None = None
    sensitivity: SensitivityText | None = None
    override: bool = False
    position: Annotated[tuple[Metre, Metre, Metre], FromList] | None = None
    direction: Direction | None = None
    node: Annotated[int, Field(ge=1, le=MOST_NODE)] | None = None
    sensor: (
        Annotated[str, BeforeValidator(lambda v: str(v) if type(v) is int else v)] | None
    ) = None


Channels: TypeAlias = dict[Text | Annotated[int, Field(ge=1, le=10_000)], ChannelSection]


class ExpectSection(Section):
    """Expected properties of recordings."""

    duration: Annotated[float | None, in_unit("s", positive=True)] = None
    duration_tolerance: Annotated[float | None, in_unit("%", not_negative=True)] = None
    sample_rate: Hertz = None
    channels: Annotated[int, Field(ge=1, le=10_000)] | None = None
    unit: UnitText | None = None
    sha256: HashText | None = None


class SpecimenSection(Section):
    """Measured dimensions of one coupon and the bushing it was tested with."""

    nominal: Length = None
    hole: Length = None
    bushing: Length = None
    clearance: Length = None
    thickness: Length = None
    bushing_thickness: Length = None
    material: Text | None = None
    comment: Remark = ""


Joints: TypeAlias = dict[Text, dict[Text, SpecimenSection]]


class SpecimensFile(Section):
    """A file of measured dimensions."""

    specimens: Literal[1]
    title: Remark = ""
    joints: Joints


class ProfileNotchSection(Section):
    """A part of a profile in which the control may be lower."""

    low: Annotated[float, in_unit("Hz", positive=True)] = Field(alias="from")
    high: Annotated[float, in_unit("Hz", positive=True)] = Field(alias="to")
    depth: Annotated[float, in_unit("dB", positive=True)]


class ProfileSection(Section):
    """Demanded level at every frequency."""

    breakpoints: (
        Annotated[
            tuple[Annotated[tuple[Written, Written], FromList], ...],
            Field(strict=False, min_length=2, max_length=1000),
        ]
        | None
    ) = None
    file: str | None = None
    alarm: Decibels = None
    abort: Decibels = None
    notches: Annotated[tuple[ProfileNotchSection, ...], FromList] = ()


class BesideSection(Section):
    """Channels of another recorder, or of another group of the recording."""

    recording: str | None = None
    group: Text | None = None
    sample_rate: SampleRate | None = None
    common: (
        Annotated[dict[Text | int, Text | int], Field(min_length=1, max_length=1)] | None
    ) = None
    channels: Annotated[Channels, Field(min_length=1)]


class EventSection(Section):
    """Something that happened during a test."""

    at: Annotated[float, in_unit("s", not_negative=True)]
    note: Text


class TestSection(Section):
    """One test."""

    __test__ = False

    id: Identity
    recording: str | None = None
    continued: Annotated[tuple[str, ...], FromList] = ()
    beside: Annotated[tuple[BesideSection, ...], FromList] = ()
    events: Annotated[tuple[EventSection, ...], FromList] = ()
    joint: Text | None = None
    specimen: Text | None = None
    clearance: Length = None
    actual_clearance: Length = None
    orientation: Text | None = None
    excitation: Excitation | None = None
    level: Any = None
    start: Hertz = Field(None, alias="from")
    stop: Hertz = Field(None, alias="to")
    rate: Any = None
    frequency: Hertz = None
    notch: Hertz = None
    multisine: MultisineSection | None = None
    tones: Annotated[tuple[ToneSection, ...], FromList, Field(min_length=1)] | None = None
    discarded: bool = False
    comment: Remark = ""
    hold_out: bool = False
    planned: bool = False
    duration: Annotated[float | None, in_unit("s", positive=True)] = None
    profile: Text | None = None
    tags: dict[Text, str | int | float | bool] = Field(default_factory=dict)
    conditions: dict[Text, Quantity] = Field(default_factory=dict)
    channels: Channels = Field(default_factory=dict)
    processing: ProcessingSection = Field(default_factory=ProcessingSection)
    expect: ExpectSection = Field(default_factory=ExpectSection)


class ShakerSection(Section):
    """Limits of the shaker."""

    stroke: Annotated[float | None, in_unit("m", positive=True)] = None
    velocity: Annotated[float | None, in_unit("m/s", positive=True)] = None
    acceleration: Annotated[float | None, in_unit("m/s^2", positive=True)] = None
    force: Annotated[float | None, in_unit("N", positive=True)] = None
    moving_mass: Annotated[float | None, in_unit("kg", positive=True)] = None


class ModalSection(Section):
    """How modes are looked for."""

    band: BandSection | None = None
    modes: Annotated[int, Field(ge=1, le=200)] | None = None
    order: Annotated[int, Field(ge=4, le=400)] | None = None
    keep: (
        Annotated[
            tuple[Annotated[float, in_unit("Hz", positive=True)], ...],
            Field(strict=False, min_length=1, max_length=200),
        ]
        | None
    ) = None
    inputs: Literal["control", "force", "none"] | None = None
    together: bool | None = None


Node: TypeAlias = Annotated[int, Field(ge=1, le=MOST_NODE)]
Rows: TypeAlias = Annotated[tuple[Annotated[tuple[Node, ...], FromList], ...], FromList]


class GeometrySection(Section):
    """Nodes, lines and surfaces of the structure."""

    nodes: Annotated[
        Annotated[str, Tag("<file>")]
        | Annotated[
            dict[Node, Annotated[tuple[Metre, Metre, Metre], FromList]], Tag("<inline>")
        ],
        Discriminator(lambda value: "<file>" if isinstance(value, str) else "<inline>"),
    ]
    lines: Rows = ()
    surfaces: Rows = ()


class LogSection(Section):
    """The whole log."""

    testlog: Literal[1]
    title: Remark = ""
    recordings: str = "recordings"
    report: HeaderSection | None = None
    calibration: str | None = None
    channels: Channels = Field(default_factory=dict)
    processing: ProcessingSection = Field(default_factory=ProcessingSection)
    expect: ExpectSection = Field(default_factory=ExpectSection)
    shaker: ShakerSection = Field(default_factory=ShakerSection)
    modal: ModalSection = Field(default_factory=ModalSection)
    geometry: (
        Annotated[
            Annotated[str, Tag("<file>")] | Annotated[GeometrySection, Tag("<inline>")],
            Discriminator(lambda value: "<file>" if isinstance(value, str) else "<inline>"),
        ]
        | None
    ) = None
    profiles: dict[Text, ProfileSection] = Field(default_factory=dict)
    limits: dict[Text, Any] = Field(default_factory=dict)
    specimens: Annotated[
        Annotated[str, Tag("<file>")] | Annotated[Joints, Tag("<inline>")],
        Discriminator(lambda value: "<file>" if isinstance(value, str) else "<inline>"),
    ] = Field(default_factory=dict)
    tests: Annotated[tuple[TestSection, ...], FromList]
