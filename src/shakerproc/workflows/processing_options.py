"""Options of a test beside its log, checked: those of `process` and `batch`."""

from collections.abc import Mapping
from dataclasses import replace
from math import inf
from types import MappingProxyType
from typing import Any, Final, TypedDict, get_args

from shakerproc.errors import ArgumentError
from shakerproc.recordings.raw import Sampling
from shakerproc.recordings.si import parse_numbered
from shakerproc.runs import UnitOption
from shakerproc.spectra.welch.windows import COSINE_TERMS, PERIODIC
from shakerproc.testlog import Excitation, Test, ThresholdCrop, level_of, threshold_of
from shakerproc.units import near_miss
from shakerproc.workflows.arguments import (
    argument_text,
    number_of,
    positive_of,
    switch_of,
    text_of,
    whole_of,
)


class Options(TypedDict, total=False):
    """Options of one test; None is as the log or the default has it.

    Attributes
    ----------
    excitation : str
        ``sine sweep``, ``random``, ``sine``, ``stepped sine`` or ``shock``.
    level : str
        Demanded level, such as ``0.5 g`` or ``1e-3 g^2/Hz``.
    from_hz, to_hz : float
        Excited band; of a sine `from_hz` alone is its frequency [Hz].
    notch_hz : float
        A tone that is taken out for a second look [Hz].
    no_crop : bool
        Whether to use the whole recording.
    crop_channel, crop_threshold : str
        Control channel to crop by, and the value between which the run lies, with its unit.
    crop_absolute : bool
        Whether magnitudes are compared with the threshold.
    crop_hold_s, skip_s : float
        How long the threshold must hold, and time at the start that is not looked at [s].
    sample_rate_hz : float
        Sample rate, where the recording does not state it [Hz].
    override_rate : bool
        Whether `sample_rate_hz` counts although the recording states another.
    time_unit : str
        Unit of times in the recording that state none: ``s``, ``ms``, ``us``, ...
    resample_hz : float
        Rate of the even times that every channel is interpolated to [Hz].
    ignore_starts : bool
        Whether all channels start together, whatever the recording states.
    bad_rows : str
        ``refuse`` or ``skip`` lines of a text file that are no rows of numbers.
    group : str
        Group of a file of several.
    measurement : int or str
        Which of several that follow each other in the same channels, from 1, or ``all``.
    segment, overlap : int
        Samples of a Welch segment, and how many it shares with the next.
    window, detrend : str
        Window of the segments, and what mean is removed: ``none``, ``mean``, ``segment mean``.
    stitch : bool
        Whether to join the sweeps of one direction to one response.
    uncertainty : bool
        Whether to give every level, peak and damping its uncertainty budget.
    """

    excitation: str | None
    level: str | None
    from_hz: float | None
    to_hz: float | None
    notch_hz: float | None
    no_crop: bool
    crop_channel: str | None
    crop_threshold: str | None
    crop_absolute: bool
    crop_hold_s: float | None
    skip_s: float | None
    sample_rate_hz: float | None
    override_rate: bool
    time_unit: str | None
    resample_hz: float | None
    ignore_starts: bool
    bad_rows: str | None
    group: str | None
    measurement: int | str | None
    segment: int | None
    overlap: int | None
    window: str | None
    detrend: str | None
    stitch: bool
    uncertainty: bool


LONGEST_SEGMENT: Final = 2**24
"""Samples of the longest segment: three channels of it take 400 MB."""

TIME_UNITS: Final = ("s", "ms", "us", "ns", "min", "h", "d")

_TEXT: Final = (
    "excitation", "level", "crop_channel", "crop_threshold", "bad_rows", "group", "window",
    "detrend", "time_unit",
)  # fmt: skip

_SWITCHES: Final = (
    "no_crop", "crop_absolute", "stitch", "uncertainty", "override_rate", "ignore_starts",
)  # fmt: skip

_COUNTS: Final[Mapping[str, int]] = MappingProxyType({"segment": 8, "overlap": 0})

_POSITIVE: Final = ("from_hz", "to_hz", "notch_hz", "sample_rate_hz", "resample_hz")

_NOT_NEGATIVE: Final = ("crop_hold_s", "skip_s")


def check_options(given: Mapping[str, Any]) -> None:
    """Pass options that there are, each of the kind that it must be.

    Raises
    ------
    ArgumentError
        If one is not.
    """
    for name, value in given.items():
        if name not in Options.__annotations__:
            meant = near_miss(name, list(Options.__annotations__))
            known = ", ".join(Options.__annotations__)
            hint = f"did you mean {meant}?" if meant else f"there are {known}"
            raise ArgumentError(name, f"no such option; {hint}")
        if name in _TEXT:
            text_of(name, value)
        elif name in _SWITCHES:
            switch_of(name, value)
        elif name in _COUNTS:
            whole_of(name, value, _COUNTS[name], LONGEST_SEGMENT)
        elif name in _POSITIVE:
            positive_of(name, value)
        elif name in _NOT_NEGATIVE:
            number_of(name, value)


def sampling_of(
    sample_rate_hz: float | None,
    *,
    override_rate: bool,
    time_unit: str | None,
    resample_hz: float | None,
    ignore_starts: bool = False,
) -> Sampling:
    """Return the option on the times of a recording.

    Parameters
    ----------
    sample_rate_hz : float, optional
        Where the recording does not state it, or `override_rate` [Hz].
    override_rate : bool
        Whether it counts although the recording states another.
    time_unit : str, optional
        Unit of times in the recording that state none.
    resample_hz : float, optional
        Rate of the even times that every channel is interpolated to [Hz].
    ignore_starts : bool
        Whether all channels start together, whatever the recording states.

    Raises
    ------
    ArgumentError
        If one is none, or there is no rate to override with.
    """
    for name, value in (("sample_rate_hz", sample_rate_hz), ("resample_hz", resample_hz)):
        if value is not None:
            positive_of(name, value)
    if override_rate and sample_rate_hz is None:
        raise ArgumentError("override_rate", "goes with --sample-rate-hz")
    if time_unit is not None and time_unit not in TIME_UNITS:
        raise ArgumentError("time_unit", f"{time_unit!r} is not one of {', '.join(TIME_UNITS)}")
    return Sampling(sample_rate_hz, override_rate, time_unit or "", resample_hz, ignore_starts)


def bad_rows_of(text: str | None) -> str:
    """Return the option on rows that are no numbers.

    Raises
    ------
    ArgumentError
        If it is not known.
    """
    if text not in {None, "refuse", "skip"}:
        raise ArgumentError("bad_rows", f"{text!r} is not refuse or skip")
    return text or "refuse"


def measurement_of(said: int | str | None) -> int | str | None:
    """Return which measurement was asked for.

    Raises
    ------
    ArgumentError
        If it is no number from 1, nor all.
    """
    if said is None or (isinstance(said, str) and said == "all"):
        return said
    text = str(said)
    if not text.isdecimal() or not 1 <= int(text) <= 10_000:
        raise ArgumentError(
            "measurement", f"expected a number from 1, or all, got {argument_text(said)}"
        )
    return int(text)


def option(name: str) -> str:
    """Return how the command line spells an argument."""
    return f"--{name.replace('_', '-')}"


def unit_of(unit: str | None, *, override: bool) -> UnitOption | None:
    """Return the option on units.

    Raises
    ------
    ArgumentError
        If it is no unit of a channel, or there is none to override with.
    """
    if unit is None:
        if override:
            raise ArgumentError("override_unit", "goes with --unit")
        return None
    wanted = "the unit of a channel such as g, m/s^2 or N"
    if parse_numbered(text_of("unit", unit, wanted)) is None:
        raise ArgumentError("unit", f"expected {wanted}, got {unit!r}")
    return UnitOption(unit, override)


def window_of(value: str | None) -> str | None:
    """Return the name of a window.

    Raises
    ------
    ArgumentError
        If there is none of that name.
    """
    if value is not None and value.removeprefix(PERIODIC) not in COSINE_TERMS:
        raise ArgumentError(
            "window",
            f"no window {value!r}; there are {', '.join(COSINE_TERMS)}, each also with "
            f"{PERIODIC.strip()} in front",
        )
    return value


def detrend_of(value: str | None) -> str | None:
    """Return the option on the mean that is removed.

    Raises
    ------
    ArgumentError
        If it is not known.
    """
    if value not in {None, "none", "mean", "segment mean"}:
        raise ArgumentError("detrend", f"{value!r} is not one of none, mean, segment mean")
    return value


_CROP: Final[Mapping[str, str]] = MappingProxyType({
    "crop_channel": "channel",
    "crop_threshold": "threshold",
    "crop_hold_s": "hold",
    "skip_s": "skip",
    "crop_absolute": "absolute",
})
"""What each option changes in the crop by threshold."""


def described(test: Test, said: Options) -> Test:
    """Return a test with the metadata that the options give.

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
    """Return a test with the excitation that the options give.

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
    """Return a test with the level that the options give, for the excitation `said`.

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
    """Return a test with the reading options of its file."""
    given: dict[str, Any] = {}
    times = {name: said.get(name) for name in ("sample_rate_hz", "time_unit", "resample_hz")}
    override = bool(said.get("override_rate"))
    ignored = bool(said.get("ignore_starts"))
    sampling = sampling_of(override_rate=override, ignore_starts=ignored, **times)
    if sampling.rate is not None:
        given |= {"sample_rate": sampling.rate, "override_rate": override}
    if sampling.unit:
        given["time_unit"] = sampling.unit
    if sampling.resample is not None:
        given["resample"] = sampling.resample
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
    """Return a test with the crop that the options give.

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
    """Return a test with other averaging than its log says, and the further analyses.

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
