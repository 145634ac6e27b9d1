"""The keys of a test log: what may stand where, and what each means.

Quantities are written with their unit and held in SI; levels stay text until the kind of
excitation is known. Whatever is not listed here is refused; further columns go under `tags`.
"""

import math
import re
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import AfterValidator, BeforeValidator, Discriminator, Field, Tag

from shakerproc.data import ROLE_UNITS, BadRows, Role
from shakerproc.documents import FromList, Section
from shakerproc.testlog.analysis_sections import (
    DistributionSection,
    FatigueSection,
    IntegrationSection,
    OctavesSection,
    OrdersSection,
    ResponseFunctionSection,
    ShockSection,
    SplittingSection,
    WaterfallSection,
)
from shakerproc.testlog.excitation import Excitation
from shakerproc.testlog.hammer import HammerSection
from shakerproc.testlog.header_section import HeaderSection
from shakerproc.testlog.multisine import MultisineSection
from shakerproc.units import in_unit, is_unit_of, problem_of_unit, quoted, spelled, to_si

WINDOWS = ("hamming", "hann", "rectangular", "blackman", "blackman-harris", "flat top")
"""Names of windows, each also with ``periodic`` in front."""

CHANNEL_UNITS = tuple(dict.fromkeys(ROLE_UNITS.values()))
"""SI unit of each quantity that a channel may measure."""

Hertz: TypeAlias = Annotated[float | None, in_unit("Hz", positive=True)]
Seconds: TypeAlias = Annotated[float | None, in_unit("s", not_negative=True)]
Length: TypeAlias = Annotated[float | None, in_unit("m", not_negative=True)]
Decibels: TypeAlias = Annotated[float | None, in_unit("dB", positive=True)]


def _checked_text(text: str) -> str:
    if not text.strip() or not text.isprintable() or len(text) > 200:
        raise ValueError(f"expected one line of text, got {quoted(text)}")
    return text.strip()


def _checked_remark(text: str) -> str:
    if len(text) > 5000:
        raise ValueError("expected text of at most 5000 characters")
    return " ".join(text.split())


def _checked_unit(text: str) -> str:
    unit = spelled(text)
    problem = problem_of_unit(unit)
    if problem is None and not any(is_unit_of(unit, wanted) for wanted in CHANNEL_UNITS):
        problem = "no channel measures that"
    if problem is not None:
        raise ValueError(
            f"expected a unit such as g, m/s^2 or N, got {quoted(text)}; {problem}"
        )
    return unit


def _checked_sensitivity(text: str) -> str:
    for unit in CHANNEL_UNITS if "/" in text else ():
        try:
            if to_si(text, f"V/({unit})") != 0.0:
                return text
        except ValueError:
            continue
    raise ValueError(f"expected volts per unit, such as 100 mV/g, got {quoted(text)}")


def _checked_id(identity: int | str) -> int | str:
    text = str(identity)
    if len(text) > 60 or re.fullmatch(r"\w(?:[\w .,+=@()#-]*[\w)#+])?", text) is None:
        raise ValueError(
            f"expected an id of letters, digits and - _ . +, such as 7 or 7b, "
            f"got {quoted(text)}; it becomes part of file names"
        )
    return identity


def _checked_window(name: str) -> str:
    if name.removeprefix("periodic ") not in WINDOWS:
        from shakerproc.units import near_miss

        meant = near_miss(name.removeprefix("periodic "), WINDOWS)
        question = f'; did you mean "{meant}"?' if meant else ""
        raise ValueError(
            f"expected one of {', '.join(WINDOWS)} (or periodic hann, ...), "
            f"got {quoted(name)}{question}"
        )
    return name


def _checked_hash(text: str) -> str:
    if re.fullmatch(r"[0-9a-fA-F]{64}", text) is None:
        raise ValueError(f"expected 64 hexadecimal digits, got {quoted(text)}")
    return text.lower()


_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


def _direction(written: object) -> tuple[float, ...]:
    """Return the unit vector of a direction: an axis such as -z, or three numbers.

    Raises
    ------
    ValueError
        If it is neither.
    """
    if isinstance(written, str) and written.strip().lower().lstrip("+-") in _AXES:
        axis = written.strip().lower()
        return tuple(-v if axis[0] == "-" and v else v for v in _AXES[axis.lstrip("+-")])
    numbers = written if isinstance(written, list | tuple) else ()
    plain = all(isinstance(v, int | float) and not isinstance(v, bool) for v in numbers)
    length = math.hypot(*numbers) if plain and len(numbers) == 3 else 0.0
    if not 0.0 < length < math.inf:
        raise ValueError(
            f"expected x, y, z, -x, -y, -z or three numbers such as [0, 0.5, 0.5], got "
            f"{quoted(written)}"
        )
    return tuple(v / length for v in numbers)


def _as_text(written: object) -> object:
    """Return a number as text: what lacks its unit is told of by those who know which."""
    return str(written) if type(written) in {int, float} else written


Written: TypeAlias = Annotated[str, BeforeValidator(_as_text)]
Metre: TypeAlias = Annotated[float, in_unit("m")]
Text: TypeAlias = Annotated[str, AfterValidator(_checked_text)]
Remark: TypeAlias = Annotated[str, AfterValidator(_checked_remark)]
Identity: TypeAlias = Annotated[int | str, AfterValidator(_checked_id)]


class ChannelSection(Section):
    """One channel of the recordings."""

    role: Role
    name: Text | None = None
    at: Text | None = None
    unit: Annotated[str, AfterValidator(_checked_unit)] | None = None
    sensitivity: Annotated[str, AfterValidator(_checked_sensitivity)] | None = None
    override: bool = False
    position: Annotated[tuple[Metre, Metre, Metre], FromList] | None = None
    direction: Annotated[tuple[float, float, float], BeforeValidator(_direction)] | None = None
    sensor: (
        Annotated[str, BeforeValidator(lambda v: str(v) if type(v) is int else v)] | None
    ) = None


Channels: TypeAlias = dict[Text | Annotated[int, Field(ge=1, le=10_000)], ChannelSection]


class ThresholdSection(Section):
    """Crop by a threshold on a control channel."""

    channel: Text | int | None = None
    threshold: Any = None
    absolute: bool | None = None
    hold: Seconds = None
    skip: Seconds = None
    remove_offset: bool | None = None


class TimeSection(Section):
    """Crop by two times."""

    start: Seconds = Field(None, alias="from")
    stop: Seconds = Field(None, alias="to")


def _kind_of_crop(crop: object) -> str:
    if isinstance(crop, dict):
        return "<times>" if "from" in crop or "to" in crop else "<threshold>"
    return "<nothing>"


CropSection: TypeAlias = Annotated[
    Annotated[Literal["none"], Tag("<nothing>")]
    | Annotated[TimeSection, Tag("<times>")]
    | Annotated[ThresholdSection, Tag("<threshold>")],
    Discriminator(_kind_of_crop),
]


class WelchSection(Section):
    """Segments of which spectra are averages."""

    segment: Annotated[int, Field(ge=8, le=2**24)] | None = None
    overlap: Annotated[int, Field(ge=0, lt=2**24)] | None = None
    window: Annotated[str, AfterValidator(_checked_window)] | None = None
    n_fft: Annotated[int, Field(ge=8, le=2**26)] | None = None


class BandSection(Section):
    """Limits of tables and peaks."""

    low: Annotated[float, in_unit("Hz", not_negative=True)] = Field(alias="from")
    high: Annotated[float, in_unit("Hz", positive=True)] = Field(alias="to")


class PeaksSection(Section):
    """Which peaks are listed."""

    distance: Annotated[float | None, in_unit("Hz", not_negative=True)] = None
    count: Annotated[int, Field(ge=1, le=1000)] | None = None


class NotchSection(Section):
    """How the notch of a test is cut."""

    width: Hertz = None
    harmonics: (
        Annotated[
            tuple[Annotated[int, Field(ge=1, le=100)], ...],
            Field(strict=False, min_length=1, max_length=50),
        ]
        | None
    ) = None
    trim: Seconds = None


class ToleranceSection(Section):
    """How far the control may stray from the demanded level."""

    alarm: Decibels = None
    abort: Decibels = None


class ProcessingSection(Section):
    """How recordings are processed."""

    crop: CropSection | None = None
    sample_rate: Hertz = None
    bad_rows: BadRows | None = None
    group: Text | None = None
    measurement: Annotated[int, Field(ge=1, le=10_000)] | Literal["all"] | None = None
    welch: WelchSection = Field(default_factory=WelchSection)
    detrend: Literal["none", "mean", "segment mean"] | None = None
    band: BandSection | None = None
    peaks: PeaksSection = Field(default_factory=PeaksSection)
    notch: NotchSection = Field(default_factory=NotchSection)
    tolerance: ToleranceSection = Field(default_factory=ToleranceSection)
    stitch: bool | None = None
    shock: ShockSection | None = None
    octaves: OctavesSection | None = None
    integration: IntegrationSection | None = None
    distribution: DistributionSection | None = None
    orders: OrdersSection | None = None
    waterfall: WaterfallSection | None = None
    splitting: SplittingSection | None = None
    fatigue: FatigueSection | None = None
    response_functions: Annotated[tuple[ResponseFunctionSection, ...], FromList] | None = None
    hammer: HammerSection = Field(default_factory=HammerSection)


class ExpectSection(Section):
    """What recordings must be."""

    duration: Annotated[float | None, in_unit("s", positive=True)] = None
    duration_tolerance: Annotated[float | None, in_unit("%", not_negative=True)] = None
    sample_rate: Hertz = None
    channels: Annotated[int, Field(ge=1, le=10_000)] | None = None
    unit: Annotated[str, AfterValidator(_checked_unit)] | None = None
    sha256: Annotated[str, AfterValidator(_checked_hash)] | None = None


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
    """What a test demands at every frequency."""

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
    sample_rate: Hertz = None
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
    discarded: bool = False
    comment: Remark = ""
    hold_out: bool = False
    profile: Text | None = None
    tags: dict[Text, str | int | float | bool] = Field(default_factory=dict)
    channels: Channels = Field(default_factory=dict)
    processing: ProcessingSection = Field(default_factory=ProcessingSection)
    expect: ExpectSection = Field(default_factory=ExpectSection)


class ShakerSection(Section):
    """What the shaker can do."""

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
    profiles: dict[Text, ProfileSection] = Field(default_factory=dict)
    specimens: Annotated[
        Annotated[str, Tag("<file>")] | Annotated[Joints, Tag("<inline>")],
        Discriminator(lambda value: "<file>" if isinstance(value, str) else "<inline>"),
    ] = Field(default_factory=dict)
    tests: Annotated[tuple[TestSection, ...], FromList]
