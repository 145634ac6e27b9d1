"""Options of a test beside its log, checked: those of `process` and `batch`."""

from collections.abc import Mapping
from dataclasses import replace
from math import inf
from types import MappingProxyType
from typing import Any, Final, get_args

from shakerproc.errors import ArgumentError
from shakerproc.testlog import Excitation, Test, ThresholdCrop, level_of, threshold_of
from shakerproc.workflows.option_values import (
    Options,
    bad_rows_of,
    check_options,
    detrend_of,
    measurement_of,
    option,
    sampling_of,
    window_of,
)

_CROP: Final[Mapping[str, str]] = MappingProxyType({
    "crop_channel": "channel",
    "crop_threshold": "threshold",
    "crop_hold_s": "hold",
    "skip_s": "skip",
    "crop_absolute": "absolute",
})
"""What each option changes in the crop by threshold."""


def described(test: Test, said: Options) -> Test:
    """Return a test with what a person says of it.

    Raises
    ------
    ArgumentError
        If an option is unknown, cannot be used, or contradicts another or the log.
    """
    given = {k: v for k, v in said.items() if v is not None and v is not False}
    check_options(given)
    test = _with_excitation(test, given)
    test = _with_crop(test, given)
    return with_averaging(_with_reading(test, given), given)


def _with_excitation(test: Test, said: Mapping[str, Any]) -> Test:
    """Return a test with what is said of its excitation.

    Raises
    ------
    ArgumentError
        If a kind or a level is none.
    """
    excitation, level = said.get("excitation"), said.get("level")
    kind = test.excitation
    if excitation is not None:
        kind = excitation.replace("-", " ").lower()
    if kind is not None and kind not in get_args(Excitation):
        raise ArgumentError(
            "excitation",
            f"{excitation or kind!r} is not one of {', '.join(get_args(Excitation))}",
        )
    if kind == "multisine" and test.multisine is None:
        raise ArgumentError(
            "excitation",
            "a multisine needs its period: give a log with multisine: {period: ...} instead",
        )
    test = _with_level(replace(test, excitation=kind), excitation, level)
    if "notch_hz" in said:
        test = replace(test, notch_hz=said["notch_hz"])
    from_hz, to_hz = said.get("from_hz"), said.get("to_hz")
    if from_hz is to_hz is None:
        return test
    return (
        _with_tone(test, from_hz, to_hz) if kind == "sine" else _with_band(test, from_hz, to_hz)
    )


def _with_level(test: Test, said: str | None, level: str | None) -> Test:
    """Return a test, whose kind of excitation is what is `said` of it, with its level.

    Raises
    ------
    ArgumentError
        If the level is none, or none of this kind.
    """
    kind = test.excitation
    if kind == "measured":
        if level is not None:
            raise ArgumentError("level", "a measured excitation has none; leave it out")
        return replace(test, level=None, level_unit=None, level_text="")
    if level is not None:
        try:
            value, unit = level_of(level, kind)
        except ValueError as error:
            raise ArgumentError("level", str(error)) from error
        return replace(test, level=value, level_unit=unit, level_text=level)
    if said is not None and test.level_text:
        try:
            level_of(test.level_text, kind)
        except ValueError as error:
            raise ArgumentError(
                "excitation",
                f"the log's level {test.level_text} is none of a {kind} test; give --level too",
            ) from error
    return test


def _with_reading(test: Test, said: Mapping[str, Any]) -> Test:
    """Return a test with what is said of how its file is read."""
    given: dict[str, Any] = {}
    times = {name: said.get(name) for name in ("sample_rate_hz", "time_unit", "resample_hz")}
    override = bool(said.get("override_rate"))
    ignored = bool(said.get("ignore_starts"))
    found = sampling_of(override_rate=override, ignore_starts=ignored, **times)
    if found.rate is not None:
        given |= {"sample_rate": found.rate, "override_rate": override}
    if found.unit:
        given["time_unit"] = found.unit
    if found.resample is not None:
        given["resample"] = found.resample
    if ignored:
        given["ignore_starts"] = True
    if "group" in said:
        given["group"] = said["group"]
    if "measurement" in said:
        given["measurement"] = measurement_of(said["measurement"])
    if "bad_rows" in said:
        given["bad_rows"] = bad_rows_of(said["bad_rows"])
    return replace(test, processing=replace(test.processing, **given))


def _with_tone(test: Test, from_hz: float | None, to_hz: float | None) -> Test:
    """Return a sine test at the frequency that is said.

    Raises
    ------
    ArgumentError
        If a band is said.
    """
    if to_hz is not None:
        raise ArgumentError("to_hz", "a sine has one frequency, which --from-hz says")
    return replace(test, frequency_hz=from_hz)


def _with_band(test: Test, from_hz: float | None, to_hz: float | None) -> Test:
    """Return a test with the excited band that is said, here and in the log.

    Raises
    ------
    ArgumentError
        If an end is missing, or the band does not rise.
    """
    band = test.processing.band or test.band or (None, None)
    low = band[0] if from_hz is None else from_hz
    high = band[1] if to_hz is None else to_hz
    if low is None or high is None:
        given, other = ("from_hz", "--to-hz") if high is None else ("to_hz", "--from-hz")
        raise ArgumentError(given, f"a band has two ends: give {other} too (the log says none)")
    if not low < high:
        raise ArgumentError("from_hz", f"the band from {low:g} to {high:g} Hz does not rise")
    processing = replace(test.processing, band=None)
    if (test.from_hz or 0.0) > (test.to_hz or inf):  # the log sweeps down, and so it stays
        low, high = high, low
    return replace(test, from_hz=low, to_hz=high, processing=processing)


def _with_crop(test: Test, given: Mapping[str, Any]) -> Test:
    """Return a test with what is said of the crop.

    Raises
    ------
    ArgumentError
        If it contradicts itself or the crop of the log, or holds no threshold.
    """
    crop = test.processing.crop
    said = {name: given[name] for name in _CROP if name in given}
    if given.get("no_crop"):
        if said:
            others = " and ".join(option(name) for name in said)
            raise ArgumentError("no_crop", f"contradicts {others}; give one or the other")
        return replace(test, processing=replace(test.processing, crop=None))
    if not said:
        return test
    if not isinstance(crop, ThresholdCrop):
        if "crop_threshold" not in said:
            has = "does not crop" if crop is None else "crops from one time to another"
            raise ArgumentError(
                next(iter(said)),
                f"goes with a threshold, and the log {has}; give --crop-threshold too",
            )
        crop = ThresholdCrop()
    changed = {_CROP[name]: value for name, value in said.items()}
    if "crop_threshold" in said:
        try:
            changed["threshold"] = threshold_of(said["crop_threshold"])
        except ValueError as error:
            raise ArgumentError("crop_threshold", str(error)) from error
    return replace(test, processing=replace(test.processing, crop=replace(crop, **changed)))


def with_averaging(test: Test, said: Mapping[str, Any]) -> Test:
    """Return a test with other averaging than its log says, and what else is asked for.

    Raises
    ------
    ArgumentError
        If the values do not fit each other.
    """
    welch, processing = test.processing.welch, test.processing
    segment, overlap = said.get("segment"), said.get("overlap")
    if segment is not None:
        welch = replace(welch, segment=segment, overlap=segment // 2, n_fft=None)
    if overlap is not None:
        welch = replace(welch, overlap=overlap)
    if not welch.overlap < welch.segment:
        raise ArgumentError(
            "overlap", f"{welch.overlap} samples do not fit a segment of {welch.segment}"
        )
    if (window := window_of(said.get("window"))) is not None:
        welch = replace(welch, window=window)
    if (detrend := detrend_of(said.get("detrend"))) is not None:
        processing = replace(processing, detrend=detrend)  # type: ignore[arg-type]
    stitch = bool(said.get("stitch")) or processing.stitch
    asked = bool(said.get("uncertainty")) or processing.uncertainty
    return replace(
        test,
        processing=replace(processing, welch=welch, stitch=stitch, uncertainty=asked),
    )
