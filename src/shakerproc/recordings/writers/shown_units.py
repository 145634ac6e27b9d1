"""Which unit a channel is written in."""

from collections.abc import Iterator, Sequence

import numpy as np

from shakerproc.data import Channel, FloatArray, Recording
from shakerproc.recordings.si import UNKNOWN, parse_unit

BLOCK = 1 << 16
"""Samples written at a time."""


def file_unit(channel: Channel) -> tuple[str, float]:
    """Return the unit that a channel is written in, and SI units in it.

    That is the unit of the file it came from, such as g, where that is a plain unit; else SI.
    """
    if channel.unit == UNKNOWN:
        return channel.source_unit, 1.0
    known = parse_unit(channel.source_unit)
    if known is not None and known[0] == channel.unit:
        return channel.source_unit, known[1]
    return channel.unit, 1.0


def headers(channels: Sequence[Channel]) -> list[str]:
    """Return the header of each channel, such as ``control 1 [g]``."""
    found = []
    for channel in channels:
        unit, _ = file_unit(channel)
        found.append(f"{channel.name} [{unit}]" if unit else channel.name)
    return found


def blocks_in_file_units(recording: Recording, size: int = BLOCK) -> Iterator[FloatArray]:
    """Yield the samples in order, (n_channels, at most size) arrays, in the file's units."""
    factors = np.array([[file_unit(channel)[1]] for channel in recording.channels])
    for block in recording.blocks(size=size):
        yield block / factors
