"""Read enDAQ IDE (.ide): each sensor is a group, its samples read a slice at a time.

idelib reads the elements and applies the calibration that the file holds. By itself it keeps
all samples of a file in memory: it is given the blocks of a slice alone, and whole only the
sensors that others are calibrated by, such as a thermometer.
"""

import gc
import logging
import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO, Final, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.recordings.guard import foreign, kept_open, opened, shown
from shakerproc.recordings.raw import (
    RawChannel,
    RawFile,
    RawGroup,
    SlicedSource,
    TimeAxis,
    TimesInFile,
)

_LIBRARIES: Final = ("idelib", "ebmlite")
_BLOCKS: Final = ("ChannelDataBlock", "SimpleChannelDataBlock")
"""Elements that hold samples; a file has one of the two kinds."""


def read_ide(path: Path, run: str) -> RawFile:
    """Return the channels of an IDE file, those of one sensor as a group.

    Raises
    ------
    RecordingError
        If it cannot be read.
    """
    for name in _LIBRARIES:  # they would tell on the terminal what is told here in one line
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    try:
        with foreign(run, "reading the file"):
            return kept_open(opened(path, run), lambda stream: _described(stream, run))
    except BaseException:
        gc.collect()  # the parts of the data set refer to each other, and to the file
        raise


@final
@dataclass(frozen=True, slots=True, eq=False)
class SensorBlocks:
    """Where the samples of a sensor are.

    Attributes
    ----------
    sensor : idelib.dataset.Channel
        The sensor, in an open file.
    kind : type
        Class of its blocks; one is made of an element of the file.
    offsets : (n_blocks,) array
        Byte at which each begins [-].
    starts, ends : (n_blocks,) array
        Time of the first and of the last sample of each [us].
    firsts : (n_blocks + 1,) array
        Number of the first sample of each, and of all [-].
    """

    sensor: Any
    kind: Any
    offsets: NDArray[np.int64]
    starts: FloatArray
    ends: FloatArray
    firsts: NDArray[np.int64]

    @property
    def size(self) -> int:
        """How many samples there are."""
        return int(self.firsts[-1])

    def times(self, first: int, last: int) -> FloatArray:
        """Return times of samples, even within a block [us]."""
        index = np.arange(first, last)
        place = np.searchsorted(self.firsts, index, side="right") - 1
        steps = (self.ends - self.starts) / np.maximum(np.diff(self.firsts) - 1, 1)
        values: FloatArray = steps[place] * (index - self.firsts[place]) + self.starts[place]
        return values

    def values(self, first: int, last: int) -> FloatArray:
        """Return calibrated samples of each channel of the sensor [as the file says]."""
        dataset = self.sensor.dataset
        events = type(self.sensor.getSession())(self.sensor, dataset.lastSession)
        begin, end = np.searchsorted(self.firsts, [first, last - 1], side="right").tolist()
        for place in range(begin - 1, end):
            dataset.ebmldoc.stream.seek(self.offsets[place])
            block = self.kind(dataset.ebmldoc.parseElement(dataset.ebmldoc.stream)[0])
            block.startTimeOriginal, block.endTimeOriginal = (
                self.starts[place],
                self.ends[place],
            )
            events.append(block)
        events.fillCache()
        skipped = first - int(self.firsts[begin - 1])
        values: FloatArray = events.arraySlice(skipped, skipped + last - first)[1:]
        return values


def _imported(stream: BinaryIO) -> tuple[Any, list[SensorBlocks]]:
    """Return an open file, and where the samples of each sensor that has any are."""
    from idelib.importer import openFile, readData

    dataset = openFile(stream, quiet=True)
    needed = {getattr(one, "channelId", None) for one in dataset.transforms.values()}
    blocks: dict[Any, list[Any]] = {number: [] for number in dataset.channels}
    for number, sensor in dataset.channels.items():
        events, kept = sensor.getSession(), number in needed
        events.append = partial(_noted, sensor, blocks[number], events.append if kept else None)
        events.fillCache = events.fillCache if kept else lambda: None
    readData(dataset)
    found = []
    for number, noted in blocks.items():
        if noted:
            kinds, offsets, starts, ends, counts = zip(*noted, strict=True)
            begins, stops = np.array([starts, ends], dtype=np.float64)
            firsts = np.cumsum([0, *counts], dtype=np.int64)
            found.append(
                SensorBlocks(
                    dataset.channels[number], kinds[0], np.array(offsets), begins, stops, firsts
                )
            )
    return dataset, found


def _noted(
    sensor: Any, noted: list[Any], keep: Callable[[Any], None] | None, block: Any
) -> None:
    """Note where a block is, in place of keeping its samples in memory.

    Raises
    ------
    ValueError
        If a part of a sample is left.
    """
    count, element = block.getNumSamples(sensor.parser), block.element
    if count < 1 or element.payloadOffset + element.size > sensor.dataset.ebmldoc.size:
        return  # what is missing is told by the count of `_promised`
    if not block.isValidLength(sensor.parser):
        raise ValueError(f"the block at byte {element.offset} holds no whole samples")
    if sensor.singleSample is None:  # the first block says it, not the first of a slice
        sensor.singleSample = count == 1
    times = block.startTimeOriginal, block.endTimeOriginal
    noted.append((type(block), element.offset, *times, count))
    if keep is not None:
        keep(block)


def _times(blocks: SensorBlocks, _: Sequence[int], start: int, stop: int) -> list[FloatArray]:
    return [blocks.times(start, stop)]


def _samples(
    places: Sequence[tuple[SensorBlocks, int]], rows: Sequence[int], start: int, stop: int
) -> Iterator[FloatArray]:
    """Yield samples of rows, calibrated as the file says; blocks of a sensor are read once."""
    read: dict[int, FloatArray] = {}
    for blocks, index in (places[row] for row in rows):
        if id(blocks) not in read:
            read[id(blocks)] = blocks.values(start, stop)
        yield read[id(blocks)][index]


def _promised(dataset: Any) -> tuple[dict[Any, int], bool]:
    """Return how many samples of each sensor a file holds, and whether it is damaged.

    It is where its elements end before it does, stand where the format has no such element, or
    hold samples of no sensor or none at all: idelib leaves out without a word what it cannot
    place.
    """
    numbers: dict[Any, int] = dict.fromkeys(dataset.channels, 0)
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
            stray = stray or sensor not in numbers or not payload
            if sensor in numbers:
                numbers[sensor] += payload // dataset.channels[sensor].parser.size
    size = dataset.ebmldoc.stream.seek(0, os.SEEK_END)
    damaged = bool(getattr(dataset, "fileDamaged", False)) or stray or end != size
    return numbers, damaged or len(kinds) > 1


def _described(stream: BinaryIO, run: str) -> RawFile:
    """Return the channels and times of an open file."""
    dataset, found = _imported(stream)
    promised, damaged = _promised(dataset)
    base = dataset.lastSession.utcStartTime
    start = None if not base else datetime.fromtimestamp(float(base), UTC)
    places: list[tuple[SensorBlocks, int]] = []
    groups: list[RawGroup] = []
    for blocks in found:
        sensor = blocks.sensor
        where = f"times of {shown(sensor.name, 40)}"
        source = SlicedSource(run, partial(_times, blocks), dataset)
        axes = (TimeAxis(where, times=TimesInFile(source, 0, blocks.size), unit="us"),)
        blocks.values(0, 1)  # may be of a kind that idelib does not read
        channels = []
        for index, one in enumerate(sensor.subchannels):
            channels.append(
                RawChannel(
                    name=str(one.name or one.displayName),
                    row=len(places),
                    n_samples=blocks.size,
                    promised=max(promised[sensor.id], blocks.size + damaged),
                    unit=str(one.units[1] or ""),
                    axes=axes,
                    start_time=start,
                )
            )
            places.append((blocks, index))
        groups.append(RawGroup(str(sensor.name), tuple(channels)))
    notes = ("The file is damaged or cut: samples behind that are missing.",) * damaged
    return RawFile(tuple(groups), SlicedSource(run, partial(_samples, places), dataset), notes)
