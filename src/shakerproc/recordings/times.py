"""Columns of time: which they are, their even steps, and the sample rate that they say."""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.numerals import numeral
from shakerproc.recordings.guard import shown
from shakerproc.recordings.raw import TimeAxis, Times
from shakerproc.recordings.si import parse_unit, split_header

_UNIT_IN_NAME: Final = (
    r"s|secs?|seconds?|ms|msecs?|millis|milliseconds?|us|\u00b5s|usecs?|micros|microseconds?|ns|"
    r"min|minutes?|h|hours?|days?"
)
_TIME: Final = re.compile(
    r"(?:x[_ ]?values?|(?:(?:elapsed|absolute|abs|relative|rel|unix|epoch|utc|local|log|sample)"
    r"[_ ]?)?(?:time[_ ]?stamps?|times?)|t|zeit(?:stempel)?|uhrzeit|elapsed|epoch|utc|"
    r"date[_ /]?(?:and[_ ])?times?)"
    rf"(?:[_ ]?(?P<unit>{_UNIT_IN_NAME}))?(?:[._ ]?\d{{1,3}})?",
    re.IGNORECASE,
)
_COUNT: Final = re.compile(
    r"(?P<unit>secs?|seconds?|msecs?|millis|milliseconds?|usecs?|micros|microseconds?)",
    re.IGNORECASE,
)
"""Units that stand for the name of a time."""

FEWEST: Final = 8
"""Samples from which on an even advance is no accident."""

SECONDS: Final = {
    **dict.fromkeys(("s", "sec", "secs", "second", "seconds"), 1.0),
    **dict.fromkeys(("ms", "msec", "msecs", "millis", "millisecond", "milliseconds"), 1e-3),
    **dict.fromkeys(("us", "usec", "usecs", "micros", "microsecond", "microseconds"), 1e-6),
    "\u00b5s": 1e-6,  # the micro sign
    "\u03bcs": 1e-6,  # the Greek letter
    **dict.fromkeys(("ns", "nanosecond", "nanoseconds"), 1e-9),
    **dict.fromkeys(("min", "mins", "minute", "minutes"), 60.0),
    **dict.fromkeys(("h", "hr", "hour", "hours"), 3600.0),
    **dict.fromkeys(("d", "day", "days"), 86400.0),
}
"""Seconds in the units of a time."""

_TICKS: Final = re.compile(
    r"s(?:ec(?:onds?)?)? \* (?P<per>[1-9]\d{0,17})(?: / (?P<by>[1-9]\d{0,17}))?"
)
"""Unit of a counter, as openDAQ writes it: ``s * 1000`` counts a thousand in a second."""

SKEW: Final = 1.0 / 180.0
"""Part of a sample that is none between two: one degree of phase at half the sample rate."""

LEAST_DOUBT: Final = 1e-9
"""How far a rate from times may be off at least, relative: what doubles hold for sure."""

JUDGED: Final = 1 << 20
"""Times that are judged at once."""


def seconds_in(unit: str) -> float:
    """Return the seconds in a unit of time; 0 for another text.

    Examples
    --------
    >>> seconds_in("ms"), seconds_in("s * 51200 / 2"), seconds_in("g")
    (0.001, 3.90625e-05, 0.0)
    """
    ticks = _TICKS.fullmatch(unit.strip())
    if ticks is None:
        return SECONDS.get(unit.casefold(), 0.0)
    return int(ticks["by"] or 1) / int(ticks["per"])


def iso_date(text: str) -> datetime | None:
    """Return a date; one that says no zone is taken as UTC."""
    try:
        date = datetime.fromisoformat(text.strip().replace(" UTC", "+00:00"))
    except ValueError:
        return None
    return date if date.tzinfo is not None else date.replace(tzinfo=UTC)


def unit_in_name(name: str) -> str:
    """Return the unit in the name of a time, such as ``time_ms``; empty without one."""
    match = _TIME.fullmatch(name.strip()) or _COUNT.fullmatch(name.strip())
    return (match["unit"] or "") if match else ""


def time_name(header: str, unit: str = "") -> tuple[str, str] | None:
    """Return name and unit of a time, or None if a header names none, or in another unit.

    The unit is empty where nothing states it: `time_base` finds out.
    """
    name, in_header = split_header(header)
    said = unit.strip() or in_header.strip()
    named = _TIME.fullmatch(name.strip()) or _COUNT.fullmatch(name.strip())
    if not named and not _TICKS.fullmatch(said):
        return None
    said = said or unit_in_name(name)
    return None if said and not seconds_in(said) else (name.strip(), said)


def is_time(header: str, unit: str = "") -> bool:
    """Return whether a header names a time in a unit of time, or in one that is not said."""
    return time_name(header, unit) is not None


def time_columns(headers: Sequence[str], units: Sequence[str] = ()) -> list[int]:
    """Return which columns are times."""
    said = units or [""] * len(headers)
    return [row for row, (h, u) in enumerate(zip(headers, said, strict=True)) if is_time(h, u)]


def axis_of_column(header: str, unit: str, times: Times, kind: str = "time column") -> TimeAxis:
    """Return the axis that a column of times states, in `unit` or that of the header."""
    _, said = time_name(header, unit) or ("", unit)
    name = split_header(header)[0]
    return TimeAxis(f"{kind} {shown(name)}", times=times, unit=said, name=name)


@final
@dataclass(frozen=True, slots=True)
class Steps:
    """How times advance.

    Attributes
    ----------
    step : float
        From sample to sample, the mean [unit of the times]; 0 where there is none.
    doubt : float
        How far that may be off, relative [-].
    problem : str
        Why the step is none of an even axis; empty where it is one.
    """

    step: float = 0.0
    doubt: float = 0.0
    problem: str = ""


def steps_of(times: Times, where: str, unit: str) -> Steps:
    """Return the steps of times, and their problems.

    Every time lies within half a step of its place, and no step is longer or shorter by more
    than a half unless rounding makes it so: a row that was lost or doubled is seen.

    Parameters
    ----------
    times : (n,) array
        Times of the samples, rounded as they may be [unit].
    where : str
        Where they stand, for messages.
    unit : str
        Of the times, for messages; empty where it is not known.
    """
    if times.size <= JUDGED:
        return _steps_at_once(np.asarray(times[:], dtype=np.float64), where, unit)
    ends = [float(times[at : at + 1][0]) for at in (0, times.size - 1)]
    whole = _steps_at_once(np.array(ends), where, unit)
    if not whole.step:
        return whole
    step = whole.step / (times.size - 1)
    for first in range(0, times.size - 1, JUDGED):  # pieces that overlap by a sample
        last = min(first + JUDGED, times.size - 1)
        piece = _steps_at_once(np.asarray(times[first : last + 1]), where, unit)
        problem = f"{piece.problem} (counted from sample {first})" if piece.problem else ""
        if not problem and abs(piece.step / step - 1.0) * (last - first) > 1.0:
            problem = (
                f"{where} does not advance evenly: by {_length(piece.step, unit)} from sample "
                f"{first} to {last}, by {_length(step, unit)} on the whole"
            )
        if problem:
            return Steps(step if _advances(times) else 0.0, 0.0, problem)
    return Steps(step, max(0.5 / times.size, LEAST_DOUBT))


@final
@dataclass(frozen=True, slots=True)
class Ticks:
    """Times that repeat because they are rounded to more than a step.

    Attributes
    ----------
    tick : float
        What they are rounded to [unit of the times].
    step : float
        From sample to sample, as far as the ticks tell it [unit]; 0 where there is no second.
    doubt : float
        How far that may be off, relative [-].
    """

    tick: float
    step: float = 0.0
    doubt: float = 0.0


def ticks_of(times: Times) -> Ticks | None:
    """Return how times are rounded of which most repeat the one before; None of others.

    Parameters
    ----------
    times : (n,) array
        Times of the samples [any unit].
    """
    changes: list[tuple[int, float]] = []
    fewest, repeats = math.inf, 0
    for first, piece in _pieces(times):
        steps = np.diff(piece)
        if not np.all(steps >= 0.0):
            return None
        at = np.flatnonzero(steps)
        repeats += steps.size - at.size
        fewest = min(fewest, float(steps[at].min(initial=math.inf)))
        changes += [(first + int(n) + 1, float(piece[n + 1])) for n in (*at[:1], *at[-1:])]
    if 2 * repeats < times.size:
        return None
    if not changes:
        return Ticks(float(_resolution(np.asarray(times[:1]))[0]))
    (begin, early), (end, late) = changes[0], changes[-1]
    if end == begin:
        return Ticks(fewest)
    return Ticks(fewest, (late - early) / (end - begin), 1.0 / (end - begin))


def strays(times: Times, step: float) -> float:
    """Return by how much times part from even ones, from the earliest to the latest [unit].

    Parameters
    ----------
    times : (n,) array
        Times of the samples [any unit].
    step : float
        Of the even ones [unit].
    """
    low, high = math.inf, -math.inf
    for first, piece in _pieces(times):
        off = piece - float(times[:1][0]) - step * (first + np.arange(piece.size))
        low, high = min(low, float(off.min())), max(high, float(off.max()))
    return high - low


def _pieces(times: Times) -> Iterator[tuple[int, FloatArray]]:
    """Yield the times a piece at a time, each with the number of its first; they overlap."""
    for first in range(0, max(times.size - 1, 1), JUDGED):
        yield first, np.asarray(times[first : first + JUDGED + 1], dtype=np.float64)


def _steps_at_once(times: FloatArray, where: str, unit: str) -> Steps:
    if times.size < 2 or not np.all(np.isfinite(times)):
        return Steps(problem=f"{where} has gaps")
    span = float(times[-1]) - float(times[0])
    if span <= 0.0:
        return Steps(problem=f"{where} does not advance")
    step = span / (times.size - 1)
    if not (math.isfinite(step) and math.isfinite(1.0 / step if step else math.inf)):
        return Steps(
            problem=f"{where} advances by {numeral(step)} a sample, which is no interval"
        )
    mean = step if np.all(np.diff(times) > 0.0) else 0.0
    uneven = _unevenness(times, step, unit)
    if uneven:
        return Steps(mean, 0.0, f"{where} does not advance evenly: {uneven}")
    return Steps(_slope(times), rate_doubt(times))


def _slope(times: FloatArray) -> float:
    """Return the step of the straight line through times, by least squares [unit of the times].

    One time that strays counts 6 / n as much as between the ends alone, were it one of them.
    """
    number = np.arange(times.size) - 0.5 * (times.size - 1)
    return float(number @ (times - times[0]) / (number @ number))


def _unevenness(times: FloatArray, step: float, unit: str) -> str:
    """Return why times are none of even steps [unit]; empty where they are."""
    odd = _odd_step(times, step)
    if odd is not None:
        return (
            f"from sample {odd} to {odd + 1} it takes "
            f"{_length(times[odd + 1] - times[odd], unit)}, most often "
            f"{_length(float(np.median(np.diff(times))), unit)}"
        )
    jitter = jitter_of(times)
    if jitter > SKEW:
        return f"its times stray by {numeral(100.0 * jitter)} % rms of {_length(step, unit)}"
    off = np.abs(times - times[0] - step * np.arange(times.size))
    worst = int(np.argmax(off))
    if off[worst] > 0.5 * step:
        far = _length(off[worst], unit)
        return f"sample {worst} is {far} off a step of {_length(step, unit)}"
    return ""


def jitter_of(times: FloatArray) -> float:
    """Return how far times stray from even ones, rms over their step [-].

    0 where rounding to the digits that they are written with explains it.

    Parameters
    ----------
    times : (n,) array
        Times of the samples, rounded as they may be [any unit].
    """
    steps = np.diff(times)
    mean = float(np.mean(steps))  # no step that is rounded itself, as their median is
    jitter = float(np.std(steps)) / mean / math.sqrt(2.0)
    strays = np.abs(steps - mean)
    if jitter > SKEW and np.all(strays <= _resolution(times)[1:] * (1.0 + 1e-6)):
        return 0.0
    return jitter


def _resolution(times: FloatArray) -> FloatArray:
    """Return the last digit that each time is written with [unit of the times].

    All have so many decimals, or so many digits, or are floats of 32 bits; else it is what a
    double resolves.
    """
    size = np.abs(times)
    finest = 4.0 * np.spacing(size.max())
    values = np.full(times.size, finest)
    if np.all(times == times.astype(np.float32)):
        values = np.maximum(values, np.spacing(size.astype(np.float32)).astype(np.float64))
    for decimals in range(13):
        digit = 10.0**-decimals
        if digit <= finest:
            break
        if np.all(np.abs(times - digit * np.rint(times / digit)) <= finest):
            values = np.maximum(values, digit)
            break
    power = np.floor(np.log10(size, where=size > 0.0, out=np.zeros(times.size)))
    for digits in range(1, 14):
        last: FloatArray = 10.0 ** (power + 1 - digits)
        if np.all(np.abs(times - last * np.rint(times / last)) <= 4.0 * np.spacing(size)):
            values = np.maximum(values, last)
            break
    return values


def _advances(times: Times) -> bool:
    """Return whether every time is later than the one before."""
    return all(bool(np.all(np.diff(piece) > 0.0)) for _, piece in _pieces(times))


def _length(value: float, unit: str) -> str:
    return f"{numeral(value)} {unit}".strip()


def _odd_step(times: FloatArray, step: float) -> int | None:
    """Return the first step that is off by more than a half and not by rounding, if any is.

    Of an even axis that is rounded to a digit near its step, some steps are one digit longer
    (or shorter) than most, and they follow each other at equal distances, give or take one.

    References
    ----------
    .. [1] R. Klette and A. Rosenfeld, "Digital straightness - a review", Discrete Applied
       Mathematics 139, 197-230, 2004.
    """
    steps = np.diff(times)
    usual = float(np.median(steps))
    odd = np.flatnonzero(np.abs(steps - usual) > 0.5 * step)
    if not odd.size:
        return None
    off = steps[odd] - usual
    apart = np.diff(odd)
    one_digit = np.allclose(off, _digit(step) * np.sign(off[0]), rtol=1e-3)
    if one_digit and apart.size and np.ptp(apart) <= 1:
        most = int(apart.max())
        if odd[0] <= most and steps.size - 1 - odd[-1] <= most:
            return None
    return int(odd[0])


def _digit(step: float) -> float:
    """Return the largest power of ten that is no longer than a step [s]."""
    return float(10.0 ** math.floor(math.log10(step) + 1e-3))


def like_time(header: str, unit: str, values: FloatArray) -> str:
    """Return why a column is taken for a time rather than a channel, or an empty text.

    Nothing that is measured advances evenly to the last digit; only a column in the unit of
    something measured is believed to be that.
    """
    name, in_header = split_header(header)
    said = (unit or in_header).strip()
    if _TIME.fullmatch(name.strip()) and len(name.strip()) > 1 and not is_time(header, unit):
        return f"it is a time in {shown(said, 20)}, not in s, ms, us, ns, min, h or d"
    if values.size < FEWEST or parse_unit(said) is not None:
        return ""
    step = (float(values[-1]) - float(values[0])) / (values.size - 1)
    if not (math.isfinite(step) and step > 0.0 and _is_even(values, step)):
        return ""
    return (
        f"it advances evenly by {step:.6g}, as a time or a count does; if it is a time in "
        'seconds, call it "time [s]", and a vector of its own "t"'
    )


def _is_even(values: FloatArray, step: float) -> bool:
    """Return whether values advance as a time does, whose mean step is given [of the values].

    Rounded, a time has steps of two lengths; what wobbles at the last digit makes four.
    """
    with np.errstate(over="ignore", invalid="ignore"):  # values that are infinite, or nearly
        steps = np.diff(values) / step
    return bool(np.all(steps >= 0.0) and np.unique(np.round(steps, 3)).size <= 4)


def rate_doubt(times: FloatArray) -> float:
    """Return how far the rate of an even time axis may be off, relative [-].

    Times that are printed to so many digits lie off their line by up to the last one, and the
    rate is wrong by twice that over the whole length.

    Parameters
    ----------
    times : (n,) array
        Times of the samples [s].
    """
    span = float(times[-1]) - float(times[0])
    line = times[0] + span / (times.size - 1) * np.arange(times.size)
    return max(2.0 * float(np.abs(times - line).max()) / span, LEAST_DOUBT)
