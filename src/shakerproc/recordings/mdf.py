"""Read ASAM MDF, versions 2 to 4 (.mf4, .mdf, .dat): channels by rate, a slice at a time.

asammdf reads the blocks. A file holds one group of channels for each time channel, and many
recorders write a group for each channel: groups of one rate are one group here.

References
----------
.. [1] ASAM e.V., "ASAM MDF, measurement data format 4.2", 2019.
"""

import gc
import logging
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Any, Final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.errors import RecordingError
from shakerproc.recordings.guard import AGAIN, first_bytes, foreign, shown
from shakerproc.recordings.raw import (
    RawChannel,
    RawFile,
    RawGroup,
    SlicedSource,
    TimeAxis,
    TimesInFile,
)
from shakerproc.recordings.time_base import CLOCKS

MAGIC: Final = (b"MDF     ", b"UnFinMF ")
"""How a file begins; the second way, where the recorder did not close it."""

_QUANTITIES: Final = {2: "Angle", 3: "Distance", 4: "Index"}
"""What a master channel of version 4 counts that is no time."""

_FIRST_YEAR: Final = 1990
"""Dates before are of recorders without a clock."""


def read_mdf(path: Path, run: str) -> RawFile:
    """Return the channels of an MDF file, those of one rate as a group.

    Raises
    ------
    RecordingError
        If it cannot be read.
    """
    if first_bytes(path, run, 8) not in MAGIC:
        raise RecordingError(f"{run}: does not begin as an MDF file does. {AGAIN}")
    with foreign(run, "reading the channels"):
        return _described(_opened(path, run), run)


@contextmanager
def quiet_deletion() -> Iterator[None]:
    """Keep errors of half-opened files off the terminal when they are deleted."""
    hook = sys.unraisablehook
    sys.unraisablehook = lambda _: None
    try:
        yield
    finally:
        sys.unraisablehook = hook


def _opened(path: Path, run: str) -> Any:
    """Return an open file.

    Raises
    ------
    RecordingError
        If it cannot be opened.
    """
    from asammdf import MDF

    logging.getLogger("asammdf").setLevel(logging.CRITICAL + 1)  # told here, in one line
    with quiet_deletion():
        try:
            return MDF(path.open("rb"))
        except Exception as error:  # noqa: BLE001 - whatever the library raises is one line
            cause = " ".join(str(error).split()) or "no reason given"
            problem = f"{type(error).__name__}: {shown(cause, 160)}"
        gc.collect()  # what is half open complains when it is deleted: here, not later
    raise RecordingError(f"{run}: opening the file failed: {problem}. {AGAIN}")


def _times(file: Any, groups: Sequence[int], start: int, stop: int) -> Iterator[Any]:
    """Yield times of groups, as their time channels say."""
    for group in groups:
        yield file.get_master(group, record_offset=start, record_count=stop - start)


def _samples(
    file: Any, places: Sequence[tuple[int, int]], rows: Sequence[int], start: int, stop: int
) -> Iterator[FloatArray]:
    """Yield samples of rows; NaN where they are not valid.

    The records of a group are read once for all of its channels.
    """
    for signal in file.select(
        [(None, *places[row]) for row in rows], record_offset=start,
        record_count=stop - start, copy_master=False,
    ):  # fmt: skip
        values = np.array(signal.samples, dtype=np.float64)
        if signal.invalidation_bits is not None:
            values[np.asarray(signal.invalidation_bits, dtype=bool)] = np.nan
        yield values


def _values(file: Any, place: tuple[int, int], start: int, stop: int) -> Any:
    """Return samples of a channel and which are not valid, None where all are."""
    group, index = place
    return file.get(
        group=group, index=index, record_offset=start, record_count=stop - start,
        samples_only=True, ignore_invalidation_bits=True,
    )  # fmt: skip


def _described(file: Any, run: str) -> RawFile:
    """Return the channels and times of an open file."""
    start = file.start_time
    start = start if start is not None and start.year >= _FIRST_YEAR else None
    rows: list[tuple[float, str, list[RawChannel]]] = []
    places: list[tuple[int, int]] = []
    notes: list[str] = []
    for number, group in enumerate(file.groups):
        axis, step = _axis(file, number, run)
        channels = []
        for index, channel in enumerate(group.channels):
            if index == file.masters_db.get(number):
                continue
            made = _channel(file, (number, index), channel, axis, start)
            channels.append(replace(made, row=-1 if made.problem else len(places)))
            if not made.problem:
                places.append((number, index))
                notes += _counts(channel, made.name)
        _join(rows, step, _name(group, number), channels)
    groups = [RawGroup(name, tuple(channels)) for _, name, channels in rows if channels]
    if len(groups) == 1:
        groups = [replace(groups[0], name="")]
    return RawFile(
        tuple(groups), SlicedSource(run, partial(_samples, file, places), file), tuple(notes)
    )


def _join(
    groups: list[tuple[float, str, list[RawChannel]]],
    step: float,
    name: str,
    channels: list[RawChannel],
) -> None:
    """Add channels to the group that has their step [s], or as a group of its own."""
    same_step = (there for there in groups if step and abs(there[0] / step - 1.0) <= CLOCKS)
    there = next(same_step, None)
    if there is not None:
        there[2].extend(channels)
        return
    names = {other for _, other, _ in groups}
    unique = name if name not in names else f"{name} ({len(groups) + 1})"
    groups.append((step, unique, channels))


def _axis(file: Any, number: int, run: str) -> tuple[TimeAxis | None, float]:
    """Return the time axis of a group as stated, and its mean step [s]; 0 without one."""
    group, index = file.groups[number], file.masters_db.get(number)
    count = int(group.channel_group.cycles_nr)
    if index is None:
        return None, 0.0
    master = group.channels[index]
    times = TimesInFile(SlicedSource(run, partial(_times, file), file), number, count)
    quantity = _QUANTITIES.get(getattr(master, "sync_type", 1), "")
    name = master.name or "master channel"
    axis = TimeAxis(
        f"time channel {shown(name, 40)}", times=times, quantity=quantity,
        unit=_unit(file, (number, index)) or ("" if quantity else "s"), name=name,
    )  # fmt: skip
    if count < 2:
        return axis, 0.0
    return axis, float(times[count - 1 : count][0] - times[:1][0]) / (count - 1)


def _unit(file: Any, place: tuple[int, int]) -> str:
    return str(file.get_channel_unit(group=place[0], index=place[1]) or "").strip("\0 ")


def _channel(
    file: Any,
    place: tuple[int, int],
    channel: Any,
    axis: TimeAxis | None,
    start: datetime | None,
) -> RawChannel:
    """Return a channel; its first value shows whether it holds numbers."""
    count, problem = int(file.groups[place[0]].channel_group.cycles_nr), ""
    if count:
        try:
            first = np.asarray(_values(file, place, 0, 1)[0])
            if first.dtype.kind not in "iufb" or first.ndim != 1:
                problem = "it holds text or arrays, not numbers"
        except Exception as error:  # noqa: BLE001 - other channels may be whole
            problem = f"it cannot be read: {type(error).__name__}"
    return RawChannel(
        name=channel.name,
        row=-1,
        n_samples=count,
        promised=count,
        unit=_unit(file, place),
        problem=problem,
        axes=() if axis is None else (axis,),
        start_time=start,
    )


def _counts(channel: Any, name: str) -> list[str]:
    """Return a note on whole numbers that no rule of the file converts."""
    dtype = getattr(channel, "dtype_fmt", None)
    if channel.conversion is not None or dtype is None or np.dtype(dtype).kind not in "iu":
        return []
    return [
        f"{shown(name)} holds whole numbers without a conversion: if they are counts of a "
        "converter they lack their scale."
    ]


def _name(group: Any, number: int) -> str:
    """Return the name of a group: of its source or its comment, where they are plain."""
    about = group.channel_group
    for text in (getattr(about, "acq_name", None), about.comment):
        if text and not str(text).startswith("<"):
            return str(text)
    return f"group {number + 1}"
