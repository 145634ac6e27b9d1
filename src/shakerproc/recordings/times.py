"""Columns of time: which they are, their even steps, and the sample rate that they say."""

import math
import re
from collections.abc import Sequence
from typing import Final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.recordings.guard import shown
from shakerproc.recordings.si import parse_unit, split_header

_TIME: Final = re.compile(
    r"(?:x[_ ]?values?|time ?stamp|times?|t|zeit|seconds?|elapsed(?: time)?)"
    r"(?:[_ ]?(?P<unit>s|sec|ms|msec|us|\u00b5s|ns|min|h))?(?:[._ ]?\d{1,3})?",
    re.IGNORECASE,
)

FEWEST: Final = 8
"""Samples from which on an even advance is no accident."""

SECONDS: Final = {
    "": 1.0,
    "s": 1.0,
    "sec": 1.0,
    "secs": 1.0,
    "seconds": 1.0,
    "second": 1.0,
    "ms": 1e-3,
    "msec": 1e-3,
    "us": 1e-6,
    "\u00b5s": 1e-6,  # the micro sign
    "\u03bcs": 1e-6,  # the Greek letter
    "ns": 1e-9,
    "min": 60.0,
    "h": 3600.0,
}
"""Seconds in the units of a time column."""


def is_time(header: str, unit: str = "") -> float:
    """Return the seconds in a unit of a time column, or 0 if the header names no time."""
    name, in_header = split_header(header)
    match = _TIME.fullmatch(name.strip())
    if match is None:
        return 0.0
    said = unit.strip() or in_header or match["unit"] or ""
    return SECONDS.get(said.strip().casefold(), 0.0)


def time_columns(headers: Sequence[str], units: Sequence[str] = ()) -> list[tuple[int, float]]:
    """Return which columns are times, each with the seconds in its unit."""
    said = units or [""] * len(headers)
    every = [(row, is_time(h, u)) for row, (h, u) in enumerate(zip(headers, said, strict=True))]
    return [(row, seconds) for row, seconds in every if seconds]


def rate_of_times(times: FloatArray) -> tuple[float | None, str]:
    """Return the sample rate [Hz] of a time axis, or what is wrong with it.

    Every time lies within half a step of its place, and no step is longer or shorter by more
    than a half unless rounding makes it so: a row that was lost or doubled is seen.

    Parameters
    ----------
    times : (n,) array
        Times of the samples, rounded as they may be [s].
    """
    if times.size < 2 or not np.all(np.isfinite(times)):
        return None, "the time column has gaps"
    span = float(times[-1]) - float(times[0])
    if span <= 0.0:
        return None, "the time column does not advance"
    step = span / (times.size - 1)
    rate = 1.0 / step if step > 0.0 else math.inf
    if not (math.isfinite(step) and math.isfinite(rate)):
        return None, f"the time column advances by {step:.3g} s a sample, which is no interval"
    odd = _odd_step(times, step)
    if odd is not None:
        return None, (
            f"the time column does not advance evenly: from sample {odd} to {odd + 1} it "
            f"takes {times[odd + 1] - times[odd]:.3g} s, most often "
            f"{np.median(np.diff(times)):.3g} s"
        )
    off = np.abs(times - times[0] - step * np.arange(times.size))
    worst = int(np.argmax(off))
    if off[worst] > 0.5 * step:
        return None, (
            f"the time column does not advance evenly: sample {worst} is {off[worst]:.3g} s "
            f"off a step of {step:.3g} s"
        )
    whole = round(rate)
    doubt = rate_doubt(times)
    return (float(whole) if whole and abs(rate / whole - 1.0) <= doubt else rate), ""


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
        return f"it is a time in {shown(said, 20)}, not in s, ms, us, ns, min or h"
    if values.size < FEWEST or parse_unit(said) is not None:
        return ""
    step = (float(values[-1]) - float(values[0])) / (values.size - 1)
    if not (math.isfinite(step) and step > 0.0 and _is_even(np.diff(values) / step)):
        return ""
    return (
        f"it advances evenly by {step:.6g}, as a time or a count does; if it is a time in "
        'seconds, call it "time [s]", and a vector of its own "t"'
    )


def _is_even(steps: FloatArray) -> bool:
    """Return whether steps, as shares of their mean, are those of a time.

    Rounded, a time has steps of two lengths; what wobbles at the last digit makes four.
    """
    return bool(np.unique(np.round(steps, 3)).size <= 4 and np.all(steps >= 0.0))


def rate_doubt(times: FloatArray) -> float:
    """Return how far the rate of an even time axis may be off, relative [-].

    Times that are printed to so many digits lie off their line by up to the last one, and the
    rate is wrong by twice that over the whole length; a double holds no more than nine digits
    of a rate for sure.

    Parameters
    ----------
    times : (n,) array
        Times of the samples [s].
    """
    span = float(times[-1]) - float(times[0])
    line = times[0] + span / (times.size - 1) * np.arange(times.size)
    return max(2.0 * float(np.abs(times - line).max()) / span, 1e-9)
