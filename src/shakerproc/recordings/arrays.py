"""Named arrays, as MATLAB and NumPy files hold them, to channels."""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from types import MappingProxyType
from typing import Any, Final, Protocol, final

import numpy as np

from shakerproc.data import FloatArray, SampleSource
from shakerproc.errors import RecordingError
from shakerproc.recordings.columns import RATE_NAME, STEP_NAME
from shakerproc.recordings.guard import foreign, shown
from shakerproc.recordings.raw import SILENT, RawChannel, RawFile, RawGroup, TimeAxis
from shakerproc.recordings.si import split_header
from shakerproc.recordings.time_base import SLOWEST
from shakerproc.recordings.times import FEWEST, axis_of_column, is_time, like_time, steps_of

LARGEST: Final = 1 << 31
"""Bytes of arrays that are held in memory at most."""

_NAMES: Final = re.compile(r"(?:channel_?)?(?:names|labels)", re.IGNORECASE)
_TIME_OF: Final = re.compile(r"(?:(?<=[_.])|^)(?:time|t)(?:_|$)", re.IGNORECASE)
_UNITS: Final = re.compile(r"(?:channel_?)?units", re.IGNORECASE)


_NOTHING: Final[Mapping[str, tuple[str, str]]] = MappingProxyType({})
_NEVER: Final[Mapping[str, datetime]] = MappingProxyType({})


class ArrayLike(Protocol):
    """Samples that are sliced like an array, in memory or in a file."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Length along every axis."""

    @property
    def dtype(self) -> "np.dtype[Any]":
        """Type of a number."""

    def __getitem__(self, key: Any, /) -> Any:
        """Return a slice."""


@final
@dataclass(frozen=True, slots=True)
class ArrayRow:
    """Where the values of a channel stand: a line of an array."""

    array: ArrayLike
    column: int | None
    upright: bool


@final
@dataclass(frozen=True, slots=True, eq=False)
class LinesSource(SampleSource):
    """Samples that are lines of arrays, read when they are asked for.

    Attributes
    ----------
    run : str
        Name of the run, for messages.
    lines : tuple
        Where each row stands.
    handle : object, optional
        What has to be closed.
    """

    run: str
    lines: tuple[ArrayRow, ...]
    handle: Any = None

    def read(self, rows: Sequence[int], start: int, stop: int) -> FloatArray:
        out = np.empty((len(rows), max(0, stop - start)))
        together: dict[int, list[int]] = {}  # columns of one array are read at once
        for number, row in enumerate(rows):
            line = self.lines[row]
            together.setdefault(id(line.array if line.upright else line), []).append(number)
        with foreign(self.run, "reading the samples"):
            for numbers in together.values():
                parts = [self.lines[rows[number]] for number in numbers]
                for number, values in zip(numbers, _block(parts, start, stop), strict=True):
                    out[number] = values
        return out

    def close(self) -> None:
        """Close the file, where there is one."""
        if self.handle is not None:
            self.handle.close()


def _block(lines: Sequence[ArrayRow], start: int, stop: int) -> list[Any]:
    """Return samples of one line, or of several that are columns of one array."""
    columns = [line.column for line in lines if line.column is not None]
    if len(lines) == 1:
        return [_slice(lines[0], start, stop)]
    first = min(columns)
    frames = lines[0].array[start:stop, first : max(columns) + 1]
    return [frames[:, column - first] for column in columns]


def _slice(line: ArrayRow, start: int, stop: int) -> Any:
    if line.column is None:
        return line.array[start:stop]
    if line.upright:
        return line.array[start:stop, line.column]
    return line.array[line.column, start:stop]


def file_of_arrays(
    arrays: Mapping[str, ArrayLike],
    texts: Mapping[str, Sequence[str]],
    run: str,
    *,
    called: Mapping[str, tuple[str, str]] = _NOTHING,
    starts: Mapping[str, datetime] = _NEVER,
    left_out: Sequence[str] = (),
    handle: Any = None,
) -> RawFile:
    """Return the arrays of one length as channels of one group.

    A time vector or a number called such as fs or dt gives the rate. Arrays of other lengths
    (spectra, calibrations) are left out and named in a note.

    Parameters
    ----------
    arrays : mapping
        Real numbers by name, with at most two axes.
    texts : mapping
        Text by name; ``names`` and ``units`` are those of the columns of a matrix.
    run : str
        Name of the run, for messages.
    called : mapping
        Label and unit of arrays that have them, by name; either may be empty.
    starts : mapping
        When time 0 is, by the name of the array, or of the structure, that says it.
    left_out : sequence of str
        Names of what could not be read.
    handle : object, optional
        The open file.

    Raises
    ------
    RecordingError
        If no array holds a time series.
    """
    long = {name: array for name, array in arrays.items() if max(array.shape, default=0) > 1}
    axes = {
        name: axis
        for name, array in long.items()
        if (
            axis := _axis(
                name, array, _unit_of(name, texts, called), paired=bool(_pair_of(name, long))
            )
        )
    }
    within = {name: axis for name, array in long.items() if (axis := _time_axis(name, array))}
    length = _length(
        {n: a for n, a in long.items() if n not in axes}, axes | within, run, left_out
    )
    said = _said(arrays, axes | within, length)
    scopes = {at: _pair_of(at, long) or _scope(at) for at in said}
    shared: dict[tuple[str, ...], tuple[TimeAxis, ...]] = {}
    odd = [*left_out, *(n for n, axis in axes.items() if _size(axis) != length)]
    notes = [
        f"The first line of {shown(name)} is taken for its time in seconds: it advances evenly."
        for name in within
    ]
    channels: list[RawChannel] = []
    lines: list[ArrayRow] = []
    for name, array in long.items():
        if name in axes:
            continue
        found = _lines(array, length)
        if not found:
            odd.append(name)
        elif array.dtype.kind in "iu":
            notes.append(_counts(name, array))
        found = found[1:] if name in within else found
        headers = _headers(name, len(found), texts, called.get(name, ("", "")))
        stated = _stated_of(name, said, scopes, shared), _start_of(name, starts)
        rows = enumerate(zip(found, headers, strict=True), len(lines))
        channels += [_channel(i, line, header, stated, length) for i, (line, header) in rows]
        lines += found
    problems = [f"{shown(c.name)} is no channel: {c.problem}" for c in channels if c.problem]
    notes += [f"{text}." for text in problems]
    if problems and not said:
        doubt = (TimeAxis("the file", problem=f"{SILENT}; {problems[0]}"),)
        channels = [replace(c, axes=doubt) for c in channels]
    if odd:
        notes.append(f"Left out, not of the same length or kind: {_listed(odd)}.")
    return RawFile(
        (RawGroup("", tuple(channels)),),
        LinesSource(run, tuple(lines), handle),
        tuple(notes),
    )


def _counts(name: str, array: ArrayLike) -> str:
    return (
        f"{shown(name)} holds whole numbers ({array.dtype.name}): if they are counts "
        "of a converter they lack their scale."
    )


def _channel(
    row: int,
    line: ArrayRow,
    called: tuple[str, str],
    stated: tuple[tuple[TimeAxis, ...], datetime | None],
    length: int,
) -> RawChannel:
    """Return a line of an array as a channel; `stated` are its axes and when their 0 is."""
    header, unit = called
    name, in_header = called if unit else split_header(header)
    return RawChannel(
        name=name,
        row=row,
        n_samples=length,
        promised=length,
        unit=in_header,
        problem=like_time(header, unit, _head(line, length)),
        alias=header,
        axes=stated[0],
        start_time=stated[1],
    )


def _head(line: ArrayRow, length: int) -> FloatArray:
    """Return the first values of a channel, by which a time is told."""
    return np.asarray(_slice(line, 0, min(length, 1 << 16)), dtype=np.float64)


def _listed(names: Sequence[str]) -> str:
    rest = f" and {len(names) - 20} more" if len(names) > 20 else ""
    return ", ".join(shown(name) for name in names[:20]) + rest


def _flat(array: ArrayLike) -> FloatArray:
    flat: FloatArray = np.asarray(array[...], dtype=np.float64).reshape(-1)
    return flat


def _scope(name: str) -> str:
    """Return the structure in which a variable stands; empty for none."""
    return name.rpartition(".")[0]


def _pair_of(name: str, others: Mapping[str, ArrayLike]) -> str | None:
    """Return the variable whose times a variable holds, such as ``AI_1`` for ``time_AI_1``."""
    other = _TIME_OF.sub("", name, count=1).strip("_")
    return other if other != name and other in others else None


def _stated_of(
    name: str,
    said: Mapping[str, TimeAxis],
    scopes: Mapping[str, str],
    shared: dict[tuple[str, ...], tuple[TimeAxis, ...]],
) -> tuple[TimeAxis, ...]:
    """Return the statements on the times of a variable: nearest to it, or all there are."""
    near: dict[int, list[str]] = {}
    for at, scope in scopes.items():
        if not scope or name == scope or name.startswith(f"{scope}."):
            near.setdefault(len(scope) + (name == scope), []).append(at)
    key = tuple(near[max(near)]) if near else tuple(said)
    return shared.setdefault(key, tuple(said[at] for at in key))


def _start_of(name: str, starts: Mapping[str, datetime]) -> datetime | None:
    """Return the instant of time 0 of a variable, by the nearest statement of the file."""
    near = [at for at in starts if not at or name == at or name.startswith(f"{at}.")]
    return starts[max(near, key=len)] if near else None


def _unit_of(
    name: str, texts: Mapping[str, Sequence[str]], called: Mapping[str, tuple[str, str]]
) -> str:
    """Return the unit of a time vector that stands beside it; empty for none."""
    said = called.get(name, ("", ""))[1]
    return said or next(iter(texts.get(f"{_scope(name)}.TimeInfo.Units", ())), "")


def _axis(name: str, array: ArrayLike, unit: str, *, paired: bool) -> TimeAxis | None:
    """Return a time vector, or None where an array is none.

    One that is called such as t or time is, and one that is called after another variable;
    where the name only begins so, it has to advance as a time does.
    """
    size = max(array.shape)
    short = name.rsplit(".", 1)[-1]
    known = is_time(short) or paired
    named = known or re.match(r"time|zeit|tout", short, re.IGNORECASE)
    if not named or math.prod(array.shape) != size or size > LARGEST // 8:
        return None
    times = _flat(array)
    axis = axis_of_column(short, split_header(short)[1], times, "time vector")
    axis = replace(axis, unit=unit) if unit and not axis.unit else axis
    return axis if known or not steps_of(times, "", "").problem else None


def _size(axis: TimeAxis) -> int:
    return axis.times.size if axis.times is not None else 0


def _time_axis(name: str, array: ArrayLike) -> TimeAxis | None:
    """Return the time vector [s] that is the first of a few lines, or None where it is none.

    Nothing that is measured advances evenly to the last digit; but longer steps may be counts,
    or milliseconds.
    """
    if len(array.shape) != 2 or min(array.shape) < 2 or not _is_slender(array.shape):
        return None
    if array.dtype.kind not in "f" or max(array.shape) > LARGEST // 8:
        return None
    line = ArrayRow(array, 0, upright=array.shape[0] > array.shape[1])
    head = _head(line, max(array.shape))  # the whole line only where it may be one
    if not like_time(name, "", head) or steps_of(head, "", "").problem:
        return None
    times = np.asarray(_slice(line, 0, max(array.shape)), dtype=np.float64)
    if times.size < FEWEST or not like_time(name, "", times):
        return None
    steps = steps_of(times, "", "")
    if steps.problem or steps.step * SLOWEST >= 1.0:
        return None
    return TimeAxis(f"the first line of {shown(name)}", times=times, unit="s")


def _length(
    long: Mapping[str, ArrayLike],
    axes: Mapping[str, TimeAxis],
    run: str,
    left_out: Sequence[str],
) -> int:
    if axes:
        return max(map(_size, axes.values()))
    sizes = {max(a.shape) for a in long.values() if _is_slender(a.shape)}
    if not sizes:
        gone = f" (left out: {_listed(left_out)})" if left_out else ""
        raise RecordingError(
            f"{run}: no time series in it{gone}. Save the channels as vectors of one length, "
            "with a time vector t or a rate fs beside them."
        )
    return max(sizes)


def _is_slender(shape: tuple[int, ...]) -> bool:
    """Return whether an array holds a few long lines."""
    return len(shape) == 1 or min(shape) < max(shape) // 4 + 2


def _said(
    arrays: Mapping[str, ArrayLike], axes: Mapping[str, TimeAxis], length: int
) -> dict[str, TimeAxis]:
    """Return the statements of arrays on times, vectors and single numbers, by their name."""
    said = {name: axis for name, axis in axes.items() if _size(axis) == length}
    for name, array in arrays.items():
        if math.prod(array.shape) != 1:
            continue
        value = float(_flat(array)[0])
        short, unit = split_header(name.rsplit(".", 1)[-1])
        if not math.isfinite(value):
            continue
        if RATE_NAME.fullmatch(name.rsplit(".", 1)[-1]):
            said[name] = TimeAxis(name, rate=value)
        elif STEP_NAME.fullmatch(short):
            said[name] = TimeAxis(name, step=value, unit=unit)
    return said


def _lines(array: ArrayLike, length: int) -> list[ArrayRow]:
    shape = array.shape
    if shape == (length,):
        return [ArrayRow(array, None, upright=True)]
    if len(shape) != 2 or length not in shape or shape[0] == shape[1]:
        return []
    upright = shape[0] == length
    return [ArrayRow(array, column, upright) for column in range(shape[1 if upright else 0])]


def _headers(
    name: str, count: int, texts: Mapping[str, Sequence[str]], called: tuple[str, str]
) -> list[tuple[str, str]]:
    """Return name and unit of each line of an array."""
    units = _of_columns(_UNITS, name, count, texts)
    names = _of_columns(_NAMES, name, count, texts)
    name, unit = called[0] or name, called[1]
    if count == 1 and not names:
        return [(name, unit)]
    headers = names or [f"{name} {number + 1}" for number in range(count)]
    return [(h, u) for h, u in zip(headers, units or [unit] * count, strict=True)]


def _of_columns(
    kind: re.Pattern[str], name: str, count: int, texts: Mapping[str, Sequence[str]]
) -> Sequence[str]:
    """Return the texts of each line of an array: those below its name count first."""
    for scope in dict.fromkeys((name, _scope(name), "")):
        for at, lines in texts.items():
            plain = at.removeprefix(f"{scope}.") if scope else at
            if (plain != at or not scope) and kind.fullmatch(plain) and len(lines) == count:
                return lines
    return ()
