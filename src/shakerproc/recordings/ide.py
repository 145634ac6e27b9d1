"""Read enDAQ IDE (.ide): each sensor is a group, its samples read a slice at a time.

idelib reads the elements and applies the calibration that the file holds.
"""

import gc
import logging
import os
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, BinaryIO, Final, final

import numpy as np

from shakerproc.data import FloatArray, SampleSource
from shakerproc.errors import RecordingError
from shakerproc.late import without
from shakerproc.recordings.guard import foreign, shown
from shakerproc.recordings.raw import RawChannel, RawFile, RawGroup, TimeAxis

_LIBRARIES: Final = ("idelib", "ebmlite")
_BLOCKS: Final = ("ChannelDataBlock", "SimpleChannelDataBlock")
"""Elements that hold samples; a file has one of the two kinds."""


def read_ide(path: Path, run: str) -> RawFile:
    """Return the channels of an IDE file, those of one sensor as a group.

    Raises
    ------
    RecordingError
        If it cannot be read, holds no samples, or idelib is not installed.
    """
    if lacks := without("idelib", "IDE", "recorders", "export it as CSV or MAT"):
        raise RecordingError(f"{run}: {lacks}")
    for name in _LIBRARIES:  # they would tell on the terminal what is told here in one line
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    stream = path.open("rb")
    try:
        with foreign(run, "reading the file"):
            return _described(_imported(stream), run)
    except BaseException:
        stream.close()
        gc.collect()  # the parts of the data set refer to each other, and to the file
        raise


def _imported(stream: BinaryIO) -> Any:
    from idelib.importer import openFile, readData

    dataset = openFile(stream, quiet=True)
    readData(dataset)
    return dataset


@final
@dataclass(frozen=True, slots=True, eq=False)
class EventTimes:
    """Times of the samples of a sensor, read a piece at a time [us]."""

    run: str
    events: Any
    size: int

    def __getitem__(self, key: slice) -> FloatArray:
        first, last, _ = key.indices(self.size)
        with foreign(self.run, "reading the times"):
            return np.asarray(self.events.arraySlice(first, last)[0], dtype=np.float64)


@final
@dataclass(frozen=True, slots=True, eq=False)
class IdeSource(SampleSource):
    """Samples of sensors, calibrated as the file says, read when they are asked for.

    Attributes
    ----------
    run : str
        Name of the run, for messages.
    dataset : idelib.dataset.Dataset
        The open file.
    places : tuple of (object, int)
        Events of a sensor and the channel of each row.
    """

    run: str
    dataset: Any
    places: tuple[tuple[Any, int], ...]

    def read(self, rows: Sequence[int], start: int, stop: int) -> FloatArray:
        out = np.empty((len(rows), max(0, stop - start)))
        blocks: dict[int, FloatArray] = {}
        if out.size:
            with foreign(self.run, "reading the samples"):
                for line, row in zip(out, rows, strict=True):
                    events, index = self.places[row]
                    if id(events) not in blocks:
                        blocks[id(events)] = events.arraySlice(start, stop)
                    line[:] = blocks[id(events)][1 + index]
        return out

    def close(self) -> None:
        """Close the file."""
        self.dataset.close()


def _promised(dataset: Any) -> tuple[dict[Any, int], bool]:
    """Return how many samples of each sensor a file holds, and whether it is damaged.

    It is where its elements end before it does, stand where the format has no such element, or
    hold samples of no sensor or none at all: idelib leaves out without a word what it cannot
    place.
    """
    found: dict[Any, int] = dict.fromkeys(dataset.channels, 0)
    allowed = dataset.ebmldoc.schema.document.children
    end, kinds, stray = 0, set(), False
    for element in dataset.ebmldoc:
        end = element.payloadOffset + element.size
        stray = stray or element.id not in allowed
        if element.name in _BLOCKS:
            kinds.add(element.name)
        if element.name == "ChannelDataBlock":
            parts = {part.name: part for part in element}
            sensor = getattr(parts.get("ChannelIDRef"), "value", None)
            payload = getattr(parts.get("ChannelDataPayload"), "size", 0)
            stray = stray or sensor not in found or not payload
            if sensor in found:
                found[sensor] += payload // dataset.channels[sensor].parser.size
    size = dataset.ebmldoc.stream.seek(0, os.SEEK_END)
    damaged = bool(getattr(dataset, "fileDamaged", False)) or stray or end != size
    return found, damaged or len(kinds) > 1


def _described(dataset: Any, run: str) -> RawFile:
    """Return the channels and times of an open file.

    Raises
    ------
    RecordingError
        If it holds no samples.
    """
    promised, damaged = _promised(dataset)
    base = dataset.lastSession.utcStartTime
    start = None if not base else datetime.fromtimestamp(float(base), UTC)
    places: list[tuple[Any, int]] = []
    groups: list[RawGroup] = []
    for sensor in dataset.channels.values():
        events = sensor.getSession()
        count = len(events)
        if not count:
            continue
        events.removeMean = False
        where = f"times of {shown(sensor.name, 40)}"
        axes = (TimeAxis(where, times=EventTimes(run, events, count), unit="us"),)
        channels = []
        for index, one in enumerate(sensor.subchannels):
            channels.append(
                RawChannel(
                    name=str(one.name or one.displayName),
                    row=len(places),
                    n_samples=count,
                    promised=max(promised[sensor.id], count + damaged),
                    unit=str(one.units[1] or ""),
                    axes=axes,
                    start_time=start,
                )
            )
            places.append((events, index))
        groups.append(RawGroup(str(sensor.name), tuple(channels)))
    if not groups:
        raise RecordingError(f"{run}: the file holds no samples. Copy it again.")
    notes = ("The file is damaged or cut: samples behind that are missing.",) * damaged
    return RawFile(tuple(groups), IdeSource(run, dataset, tuple(places)), notes)
