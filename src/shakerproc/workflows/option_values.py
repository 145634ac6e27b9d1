"""Values of options, checked: what is wrong is told as of the option."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Final, TypedDict

from shakerproc.errors import ArgumentError
from shakerproc.recordings.raw import Sampling
from shakerproc.recordings.si import parse_numbered
from shakerproc.runs import UnitOption
from shakerproc.spectra.welch.windows import COSINE_TERMS, PERIODIC
from shakerproc.units import near_miss
from shakerproc.workflows.arguments import (
    number_of,
    positive_of,
    switch_of,
    text_of,
    told,
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
            "measurement", f"expected a number from 1, or all, got {told(said)}"
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
