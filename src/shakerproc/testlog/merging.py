"""The log's channels, processing and expectations, overridden by those of a test."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeVar

from pydantic import BaseModel

from shakerproc.data import ChannelUse
from shakerproc.documents import Key
from shakerproc.testlog.excitation import threshold_of
from shakerproc.testlog.fields import MisfitError
from shakerproc.testlog.one_test import Expectation
from shakerproc.testlog.processing import (
    Crop,
    Distribution,
    Dwell,
    Fatigue,
    Integration,
    Modal,
    Octaves,
    Orders,
    Processing,
    ResponseFunction,
    Shock,
    ShownSpectrogram,
    Splitting,
    ThresholdCrop,
    TimeCrop,
    Waterfall,
    Welch,
)
from shakerproc.testlog.processing_sections import (
    ProcessingSection,
    SampleRateSection,
    ThresholdSection,
    TimeSection,
    WelchSection,
)
from shakerproc.testlog.schema import ChannelSection, ExpectSection, ModalSection
from shakerproc.units import is_unit_of, near_miss, numbered, quoted

T = TypeVar("T")


def merged_channels(
    log: Mapping[Key, ChannelSection], test: Mapping[Key, ChannelSection]
) -> tuple[ChannelUse, ...]:
    """Return the uses of the channels; a test's entry replaces the log's.

    Raises
    ------
    MisfitError
        If two used channels go by one name, or one has two scales or none to override with.
    """
    uses = [
        ChannelUse(key, **section.model_dump(exclude={"node"}), default=key not in test)
        for key, section in (dict(log) | dict(test)).items()
    ]
    named: dict[str, Key] = {}
    for use in uses:
        _check_scale(use)
        name = use.name or str(use.key)
        if use.role != "ignore" and named.setdefault(name, use.key) != use.key:
            raise MisfitError(
                f"expected a name of its own, got {quoted(name)} as for channel "
                f"{quoted(named[name])}",
                use.key,
                "name",
            )
    return tuple(uses)


def _check_scale(use: ChannelUse) -> None:
    """Pass a channel whose numbers are described once.

    Raises
    ------
    MisfitError
        If its sensitivity stands beside a unit that is not volts, or nothing is overridden.
    """
    if use.sensitivity and use.unit and not is_unit_of(numbered(use.unit)[1], "V"):
        raise MisfitError(
            f"expected volts beside sensitivity: {use.sensitivity}, got {quoted(use.unit)}; "
            "take the sensitivity out if the numbers are in that unit",
            use.key,
            "unit",
        )
    if use.override and not (use.unit or use.sensitivity):
        raise MisfitError(
            "expected unit or sensitivity beside it: what is to count instead of the file's",
            use.key,
            "override",
        )


def merged_processing(
    base: Processing, section: ProcessingSection, channels: Sequence[ChannelUse]
) -> Processing:
    """Return how recordings are processed: `base`, overridden where the section says so.

    Raises
    ------
    MisfitError
        If what comes out does not fit together.
    """
    given = _set_fields(section)
    band = base.band if section.band is None else (section.band.low, section.band.high)
    if section.band is not None and section.band.low >= section.band.high:
        raise MisfitError("expected from below to", "band", "to")
    tolerance = _overridden(base.tolerance, section.tolerance)
    if tolerance.alarm > tolerance.abort:
        key = "alarm" if section.tolerance.alarm is not None else "abort"
        raise MisfitError("expected alarm at most abort", "tolerance", key)
    notch = _overridden(base.notch, section.notch)
    rate, override = sample_rate_of(section.sample_rate)
    if "sample_rate" not in given:
        rate, override = base.sample_rate, base.override_rate
    return Processing(
        crop=_crop(base.crop, section, channels),
        sample_rate=rate,
        override_rate=override,
        time_unit=given.get("time_unit", base.time_unit),
        resample=given.get("resample", base.resample),
        ignore_starts=base.ignore_starts
        if section.starts is None
        else section.starts == "ignore",
        bad_rows=given.get("bad_rows", base.bad_rows),
        group=given.get("group", base.group),
        measurement=given.get("measurement", base.measurement),
        welch=_welch(base.welch, section.welch),
        detrend=given.get("detrend", base.detrend),
        stitch=given.get("stitch", base.stitch),
        band=band,
        peaks=_overridden(base.peaks, section.peaks),
        notch=notch,
        tolerance=tolerance,
        shock=_settings_of(base.shock, section.shock, Shock(), "shock"),
        octaves=_settings_of(base.octaves, section.octaves, Octaves(), "octaves"),
        distribution=_settings_of(
            base.distribution, section.distribution, Distribution(), "distribution"
        ),
        orders=_settings_of(base.orders, section.orders, Orders(), "orders"),
        dwell=_settings_of(base.dwell, section.dwell, Dwell(), "dwell"),
        waterfall=_settings_of(base.waterfall, section.waterfall, Waterfall(), "waterfall"),
        spectrogram=_settings_of(
            base.spectrogram, section.spectrogram, ShownSpectrogram(), "spectrogram"
        ),
        splitting=_settings_of(base.splitting, section.splitting, Splitting(), "splitting"),
        fatigue=_settings_of(base.fatigue, section.fatigue, Fatigue(), "fatigue"),
        uncertainty=given.get("uncertainty", base.uncertainty),
        response_functions=_functions(base, section),
        integration=_settings_of(
            base.integration, section.integration, Integration(), "integration"
        ),
        hammer=_overridden(base.hammer, section.hammer),
        inherited=base.inherited - section.model_fields_set,
    )


def sample_rate_of(said: float | SampleRateSection | None) -> tuple[float | None, bool]:
    """Return a sample rate [Hz], and whether it counts although the file states another."""
    if isinstance(said, SampleRateSection):
        return said.value, said.override
    return said, False


def _functions(base: Processing, section: ProcessingSection) -> tuple[ResponseFunction, ...]:
    """Return the response functions that are asked for; a test's replace the log's.

    Raises
    ------
    MisfitError
        If one is from a channel to itself, or stands twice.
    """
    if section.response_functions is None:
        return base.response_functions
    functions = [ResponseFunction(one.input, one.output) for one in section.response_functions]
    for i, one in enumerate(functions):
        if one.input == one.output:
            text = f"expected another channel than the input, got {quoted(one.output)}"
            raise MisfitError(text, "response_functions", i, "output")
        if one in functions[:i]:
            raise MisfitError("expected each function once", "response_functions", i)
    return tuple(functions)


def _settings_of(base: T | None, section: BaseModel | None, usual: T, key: str) -> T | None:
    """Return the settings of an analysis; None where neither log nor test asks for it.

    Raises
    ------
    MisfitError
        If its band does not rise.
    """
    if section is None:
        return base
    settings = _overridden(base or usual, section)
    low, high = (getattr(settings, name, None) for name in ("low", "high"))
    if low is not None and high is not None and low >= high:
        raise MisfitError("expected from below to", key, "to")
    return settings


def modal_of(section: ModalSection) -> Modal:
    """Return how modes are looked for.

    Raises
    ------
    MisfitError
        If the band is empty, or a pole to keep lies outside of it.
    """
    band = None if section.band is None else (section.band.low, section.band.high)
    if band is not None:
        if band[0] >= band[1]:
            raise MisfitError("expected from below to", "band", "to")
        for i, wanted in enumerate(section.keep or ()):
            if not band[0] <= wanted <= band[1]:
                raise MisfitError(
                    f"expected a frequency of the band from {band[0]:g} to {band[1]:g} Hz, got "
                    f"{wanted:g} Hz",
                    "keep",
                    i,
                )
    return _overridden(Modal(band=band), section, without=("band",))


def merged_expectation(base: Expectation, section: ExpectSection) -> Expectation:
    """Return the expectations of recordings: `base`, overridden by the section."""
    return _overridden(base, section)


def _set_fields(section: BaseModel) -> dict[str, Any]:
    return {name: getattr(section, name) for name in section.model_fields_set}


def _overridden(base: T, section: BaseModel, without: Sequence[str] = ()) -> T:
    given = {name: v for name, v in _set_fields(section).items() if name not in without}
    if not given:
        return base
    kept = {name: getattr(base, name) for name in base.__dataclass_fields__}  # type: ignore[attr-defined]
    return type(base)(**(kept | given))


def _welch(base: Welch, section: WelchSection) -> Welch:
    """Return the segments; where only their length is given, they overlap by half.

    Raises
    ------
    MisfitError
        If the overlap is not below the segment, or the padded length is.
    """
    welch = _overridden(base, section)
    if section.segment is not None and section.overlap is None:
        welch = replace(welch, overlap=section.segment // 2)
    if welch.overlap >= welch.segment:
        raise MisfitError(
            f"expected an overlap below the segment of {welch.segment}, got {welch.overlap}",
            "welch",
            "overlap" if "overlap" in section.model_fields_set else "segment",
        )
    if welch.n_fft is not None and welch.n_fft < welch.segment:
        raise MisfitError(
            f"expected at least the segment of {welch.segment}, got {welch.n_fft}",
            "welch",
            "n_fft" if "n_fft" in section.model_fields_set else "segment",
        )
    return welch


def _crop(
    base: Crop | None, section: ProcessingSection, channels: Sequence[ChannelUse]
) -> Crop | None:
    crop = section.crop
    if crop is None:
        return _with_channel(base, channels) if isinstance(base, ThresholdCrop) else base
    if isinstance(crop, TimeSection):
        return _time_crop(crop)
    if isinstance(crop, ThresholdSection):
        return _threshold_crop(base, crop, channels)
    return None


def _time_crop(section: TimeSection) -> TimeCrop:
    """Return a crop by times.

    Raises
    ------
    MisfitError
        If it ends before it starts.
    """
    start = section.start or 0.0
    if section.stop is not None and section.stop <= start:
        raise MisfitError("expected an end after the start", "crop", "to")
    return TimeCrop(start, section.stop)


def _threshold_crop(
    base: Crop | None, section: ThresholdSection, channels: Sequence[ChannelUse]
) -> ThresholdCrop:
    """Return a crop by threshold.

    Raises
    ------
    MisfitError
        If the channel is none of the log's, or the threshold no acceleration or force.
    """
    given = _set_fields(section)
    if "threshold" in given:
        try:
            given["threshold"] = threshold_of(section.threshold)
        except ValueError as error:
            raise MisfitError(str(error), "crop", "threshold") from error
    crop = _overridden_crop(base if isinstance(base, ThresholdCrop) else ThresholdCrop(), given)
    if "channel" in given:
        _check_channel(crop.channel, channels)
        return crop
    return _with_channel(crop, channels)


def _overridden_crop(base: ThresholdCrop, given: Mapping[str, Any]) -> ThresholdCrop:
    kept = {name: getattr(base, name) for name in base.__dataclass_fields__}
    return ThresholdCrop(**(kept | {k: v for k, v in given.items() if v is not None}))


def _with_channel(crop: ThresholdCrop, channels: Sequence[ChannelUse]) -> ThresholdCrop:
    """Return the crop on the only control channel where there is no second."""
    controls = [use for use in channels if use.role == "control"]
    known = _names(channels)
    if not channels or crop.channel in known or len(controls) != 1:
        return crop
    return _overridden_crop(crop, {"channel": controls[0].name or controls[0].key})


def _check_channel(channel: Key, channels: Sequence[ChannelUse]) -> None:
    """Pass a channel that the log names.

    Raises
    ------
    MisfitError
        If it does not, although it names others.
    """
    known = _names(channels)
    if not channels or channel in known:
        return
    texts = [str(name) for name in known]
    meant = near_miss(str(channel), texts)
    question = f'; did you mean "{meant}"?' if meant else f"; the log has {', '.join(texts)}"
    raise MisfitError(
        f"expected a channel of the log, got {quoted(channel)}{question}", "crop", "channel"
    )


def _names(channels: Sequence[ChannelUse]) -> list[Key]:
    used = [use for use in channels if use.role != "ignore"]
    n_controls = sum(use.role == "control" for use in used)
    names = [*(use.key for use in used), *(use.name for use in used if use.name)]
    return [*names, *(f"control {n}" for n in range(1, n_controls + 1))]
