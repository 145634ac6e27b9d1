"""The keys of further analyses in a test log."""

from typing import Annotated, Literal, TypeAlias

from pydantic import Discriminator, Field, Tag

from shakerproc.documents import FromList, Section
from shakerproc.testlog.analyses import Baseline
from shakerproc.units import in_unit

Ratio: TypeAlias = Annotated[float | None, in_unit("1", positive=True)]
Frequency: TypeAlias = Annotated[float | None, in_unit("Hz", positive=True)]


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


Seconds: TypeAlias = Annotated[float | None, in_unit("s", positive=True)]


class SplittingSection(Section):
    """A long record in shocks and parts of vibration."""

    crest: Annotated[float, Field(ge=2.0, le=1000.0, strict=False)] | None = None
    least: Annotated[float | None, in_unit("m/s^2", not_negative=True)] = None
    longest: Seconds = None
    shortest: Seconds = None
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
