"""The keys under ``processing`` in a test log, and those of multisines, tones and hammers."""

from collections.abc import Sequence
from typing import Annotated, Any, Final, Literal, TypeAlias

from pydantic import AfterValidator, BeforeValidator, Discriminator, Field, Tag

from shakerproc.data import BadRows
from shakerproc.documents import FromList, Section
from shakerproc.testlog.excitation import (
    LEVELS,
    Amount,
    DemandedTone,
    LevelUnit,
    LineGrid,
    Multisine,
    level_of,
)
from shakerproc.testlog.fields import Decibels, Hertz, MisfitError, Seconds, Text
from shakerproc.testlog.processing import Baseline
from shakerproc.units import in_unit, is_unit_of, near_miss, quoted, to_si

_NUMBER: Final = "+-0123456789.eE "

Ratio: TypeAlias = Annotated[float | None, in_unit("1", positive=True)]
Frequency: TypeAlias = Annotated[float | None, in_unit("Hz", positive=True)]

WINDOWS = ("hamming", "hann", "rectangular", "blackman", "blackman-harris", "flat top")
"""Names of windows, each also with ``periodic`` in front."""


class MultisineSection(Section):
    """How a multisine repeats."""

    period: Annotated[float, in_unit("s", positive=True)]
    periods: Annotated[int, Field(ge=1, le=1_000_000)] | None = None
    realisations: Annotated[int, Field(ge=1, le=10_000)] = 1
    every: Annotated[float | None, in_unit("s", positive=True)] = None
    lines: LineGrid = "odd with detection"


def multisine_of(section: MultisineSection | None) -> Multisine | None:
    """Return the multisine of the log; None where it states none."""
    return None if section is None else Multisine(**dict(section))


def _amplitude(written: object) -> tuple[float, LevelUnit]:
    return level_of(written, "sine")


class ToneSection(Section):
    """A tone of a sine on random; `start` and `stop` are those of a swept one, refused."""

    frequency: Annotated[float | None, in_unit("Hz", positive=True)] = None
    level: Annotated[tuple[float, LevelUnit] | None, BeforeValidator(_amplitude)] = None
    start: Any = Field(None, alias="from")
    stop: Any = Field(None, alias="to")


def tones_of(
    sections: Sequence[ToneSection],
    band: tuple[float | None, float | None],
    unit: LevelUnit | None,
) -> tuple[DemandedTone, ...]:
    """Return the tones that a log demands.

    Parameters
    ----------
    sections : sequence of ToneSection
        As the log has them.
    band : (float, float)
        From where to where the test excites [Hz]; None where the log does not say.
    unit : LevelUnit, optional
        Of the level of the random vibration.

    Raises
    ------
    MisfitError
        If a tone is swept, stands twice, lies outside the band, or is of another signal.
    """
    demanded_tones: list[DemandedTone] = []
    for i, one in enumerate(sections):
        for key, said in (("from", one.start), ("to", one.stop)):
            if said is not None:
                raise MisfitError(
                    "expected fixed tones only, such as {frequency: 17 Hz, level: 2.5 g}; "
                    "tones that sweep are not known",
                    "tones", i, key,
                )  # fmt: skip
        if one.frequency is None:
            raise MisfitError(
                'expected the key "frequency", such as frequency: 17 Hz', "tones", i
            )
        low, high = band
        if low is not None and high is not None and not low <= one.frequency <= high:
            raise MisfitError(
                f"expected a tone within the band of the test, {low:g} to {high:g} Hz, got "
                f"{one.frequency:g} Hz",
                "tones", i, "frequency",
            )  # fmt: skip
        if any(one.frequency == other.frequency for other in demanded_tones):
            raise MisfitError("expected each tone once", "tones", i, "frequency")
        if one.level is not None and unit is not None:
            signal, wanted = LEVELS[one.level[1]][1], LEVELS[unit][1]
            if signal != wanted:
                raise MisfitError(
                    f"expected an amplitude of the signal of the test's level, in {wanted}, "
                    f"got one in {signal}",
                    "tones", i, "level",
                )  # fmt: skip
        demanded_tones.append(
            DemandedTone(one.frequency, None if one.level is None else one.level[0])
        )
    return tuple(demanded_tones)


def amount_of(written: object, wanted: str) -> Amount:
    """Return a quantity written in a unit, or in % as a share of unit ``1``.

    Raises
    ------
    ValueError
        If it is none, not above 0, or a share that is too large.
    """
    unit = written.lstrip(_NUMBER) if isinstance(written, str) else ""
    chosen = wanted if is_unit_of(unit, wanted) else "1"
    if not isinstance(written, str) or not (chosen == wanted or unit == "%"):
        raise ValueError(f"expected a number in {wanted} or in %, got {quoted(written)}")
    value = to_si(written, chosen)
    if value <= 0.0 or (chosen == "1" and value >= 1.0):
        raise ValueError(
            f"expected more than 0 {wanted}, or between 0 and 100 %, got {quoted(written)}"
        )
    return Amount(value, chosen)


def _trigger(written: object) -> Amount:
    return amount_of(written, "N")


def _exponential(written: object) -> Amount | None:
    return None if written == "none" else amount_of(written, "s")


class HammerSection(Section):
    """How the blows of a hammer test are cut out and windowed."""

    trigger: Annotated[Amount | None, BeforeValidator(_trigger)] = None
    pretrigger: Annotated[float | None, in_unit("s", not_negative=True)] = None
    length: Annotated[float | None, in_unit("s", positive=True)] = None
    force_window: Annotated[float | None, in_unit("s", positive=True)] = None
    exponential: Annotated[Amount | None, BeforeValidator(_exponential)] = None


class ShockSection(Section):
    """Shock response spectra."""

    damping: Annotated[Ratio, Field(lt=1.0)] = None
    low: Frequency = Field(None, alias="from")
    high: Frequency = Field(None, alias="to")
    per_octave: Annotated[int, Field(ge=1, le=96)] | None = None


class OctavesSection(Section):
    """Octave or fractional-octave bands."""

    fraction: Literal[1, 2, 3, 6, 12, 24] | None = None
    low: Frequency = Field(None, alias="from")
    high: Frequency = Field(None, alias="to")


def _is_none(value: object) -> str:
    return "<none>" if value == "none" else "<frequency>"


class IntegrationSection(Section):
    """Velocity and displacement."""

    high_pass: (
        Annotated[
            Annotated[Literal["none"], Tag("<none>")]
            | Annotated[Frequency, Tag("<frequency>")],
            Discriminator(_is_none),
        ]
        | None
    ) = None
    baseline: Baseline | None = None


class DistributionSection(Section):
    """Probability density and exceedance."""

    bins: Annotated[int, Field(ge=10, le=1000)] | None = None


Order: TypeAlias = Annotated[float, Field(gt=0.0, le=1000.0, strict=False)]


class OrdersSection(Section):
    """Orders of a rotating machine."""

    tachometer: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    pulses_per_revolution: Annotated[int, Field(ge=1, le=10_000)] | None = None
    track: Annotated[tuple[Order, ...], FromList, Field(min_length=1, max_length=20)] | None = (
        None
    )
    revolutions: Annotated[float, Field(ge=1.0, le=1000.0, strict=False)] | None = None


class DwellSection(Section):
    """Gain, phase and frequency of a long sine."""

    every: Annotated[float | None, in_unit("s", positive=True)] = None


class WaterfallSection(Section):
    """Spectra one after the other."""

    spectra: Annotated[int, Field(ge=2, le=200)] | None = None


class SpectrogramSection(Section):
    """The spectrogram on the page."""

    channel: Annotated[str, Field(min_length=1, max_length=200)] | None = None


PositiveSeconds: TypeAlias = Annotated[float | None, in_unit("s", positive=True)]


class SplittingSection(Section):
    """A long record in shocks and parts of vibration."""

    crest: Annotated[float, Field(ge=2.0, le=1000.0, strict=False)] | None = None
    least: Annotated[float | None, in_unit("m/s^2", not_negative=True)] = None
    longest: PositiveSeconds = None
    shortest: PositiveSeconds = None
    step: Annotated[float | None, in_unit("dB", positive=True)] = None


class FatigueSection(Section):
    """Vibration response and fatigue damage spectra."""

    damping: Annotated[Ratio, Field(lt=1.0)] = None
    exponent: Annotated[float, Field(ge=1.0, le=30.0, strict=False)] | None = None
    low: Frequency = Field(None, alias="from")
    high: Frequency = Field(None, alias="to")
    per_octave: Annotated[int, Field(ge=1, le=96)] | None = None


class ResponseFunctionSection(Section):
    """A response function between two channels."""

    input: Annotated[str, Field(min_length=1, max_length=200)]
    output: Annotated[str, Field(min_length=1, max_length=200)]


def _checked_window(name: str) -> str:
    if name.removeprefix("periodic ") not in WINDOWS:
        meant = near_miss(name.removeprefix("periodic "), WINDOWS)
        question = f'; did you mean "{meant}"?' if meant else ""
        raise ValueError(
            f"expected one of {', '.join(WINDOWS)} (or periodic hann, ...), "
            f"got {quoted(name)}{question}"
        )
    return name


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


class SampleRateSection(Section):
    """A sample rate that may count although the file states another."""

    value: Annotated[float, in_unit("Hz", positive=True)]
    override: bool = False


def _kind_of_rate(rate: object) -> str:
    return "<corrected>" if isinstance(rate, dict) else "<stated>"


SampleRate: TypeAlias = Annotated[
    Annotated[Hertz, Tag("<stated>")] | Annotated[SampleRateSection, Tag("<corrected>")],
    Discriminator(_kind_of_rate),
]


class ProcessingSection(Section):
    """How recordings are processed."""

    crop: CropSection | None = None
    sample_rate: SampleRate | None = None
    time_unit: Literal["s", "ms", "us", "ns", "min", "h", "d"] | None = None
    resample: Hertz = None
    starts: Literal["stated", "ignore"] | None = None
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
    dwell: DwellSection | None = None
    waterfall: WaterfallSection | None = None
    spectrogram: SpectrogramSection | None = None
    splitting: SplittingSection | None = None
    fatigue: FatigueSection | None = None
    uncertainty: bool | None = None
    response_functions: Annotated[tuple[ResponseFunctionSection, ...], FromList] | None = None
    hammer: HammerSection = Field(default_factory=HammerSection)
