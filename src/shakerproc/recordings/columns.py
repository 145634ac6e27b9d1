"""Named columns of numbers in memory: what the text and array formats come down to."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import ArraySource, FloatArray
from shakerproc.recordings.raw import RawChannel, RawFile, RawGroup
from shakerproc.recordings.si import split_header

_TIME: Final = re.compile(
    r"(?:x[_ ]?value|time ?stamp|time|t|zeit|seconds?|elapsed(?: time)?)(?:[_ ]?(?:s|sec|ms))?",
    re.IGNORECASE,
)
SECONDS: Final = {"": 1.0, "s": 1.0, "sec": 1.0, "seconds": 1.0, "second": 1.0, "ms": 1e-3}
"""Seconds in the units of a time column."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Columns:
    """A table.

    Attributes
    ----------
    headers : sequence of str
        What stands over each column, such as ``ch3 [g]``.
    values : (n_columns, n_rows) array
        Not a number where nothing stood.
    units : sequence of str
        Where they stand in a row of their own; else empty.
    """

    headers: Sequence[str]
    values: FloatArray
    units: Sequence[str] = ()


def is_time(header: str, unit: str = "") -> float:
    """Return the seconds in a unit of a time column, or 0 if the header names no time."""
    name, in_header = split_header(header)
    if not _TIME.fullmatch(name.strip()):
        return 0.0
    return SECONDS.get((unit or in_header).strip().casefold(), 0.0)


def rate_of_times(times: FloatArray) -> tuple[float | None, str]:
    """Return the sample rate [Hz] of a time axis, or what is wrong with it.

    Parameters
    ----------
    times : (n,) array
        Times of the samples, rounded as they may be [s].
    """
    if times.size < 2 or not np.all(np.isfinite(times)):
        return None, "the time column has gaps"
    span = float(times[-1] - times[0])
    if span <= 0.0:
        return None, "the time column does not advance"
    step = span / (times.size - 1)
    off = np.abs(times - times[0] - step * np.arange(times.size))
    worst = int(np.argmax(off))
    if off[worst] > 0.5 * step:
        return None, (
            f"the time column does not advance evenly: sample {worst} is {off[worst]:.3g} s "
            f"off a step of {step:.3g} s"
        )
    rate = 1.0 / step
    whole = round(rate)
    doubt = max(2.0 * float(off[worst]) / span, 1e-9)
    return (float(whole) if whole and abs(rate / whole - 1.0) <= doubt else rate), ""


def file_of_columns(
    table: Columns, *, sample_rate: float | None = None, rate_problem: str = "", cut: str = ""
) -> RawFile:
    """Return a table as a file of one group; a time column gives the rate and is no channel.

    Parameters
    ----------
    table : Columns
        The table.
    sample_rate : float, optional
        What the file says elsewhere [Hz].
    rate_problem : str
        Why it says nothing usable.
    cut : str
        How the file stops short; empty where it is whole.
    """
    units = list(table.units) or [""] * len(table.headers)
    seconds = [is_time(h, u) for h, u in zip(table.headers, units, strict=True)]
    axis = next((i for i, value in enumerate(seconds) if value), None)
    lengths = [length_of(row) for row in table.values]
    if axis is not None and sample_rate is None and not rate_problem:
        times = table.values[axis, : lengths[axis]] * seconds[axis]
        sample_rate, rate_problem = rate_of_times(times)
    channels = []
    for row, (header, unit) in enumerate(zip(table.headers, units, strict=True)):
        if row == axis:
            continue
        name, in_header = split_header(header)
        if unit:
            name = header.strip()
        channels.append(
            RawChannel(
                name=name or f"column {row + 1}",
                row=row,
                n_samples=lengths[row],
                promised=lengths[row] + bool(cut),
                unit=unit.strip() or in_header,
                sample_rate=sample_rate,
                rate_problem=rate_problem or "the file does not say the sample rate",
                problem="" if lengths[row] else "it holds no numbers",
                alias=header,
            )
        )
    notes = (f"The file is not whole: {cut}.",) if cut else ()
    return RawFile((RawGroup("", tuple(channels)),), ArraySource(table.values), notes)


def length_of(values: FloatArray) -> int:
    """Return the number of values up to the last one that is there."""
    there = np.flatnonzero(~np.isnan(values))
    return int(there[-1]) + 1 if there.size else 0


def is_number(text: str, decimal: str = ".") -> bool:
    """Return whether a cell holds a number."""
    if decimal == "," and "." in text:
        return False
    try:
        return not math.isinf(float(text.strip().replace(decimal, ".")))
    except ValueError:
        return False
