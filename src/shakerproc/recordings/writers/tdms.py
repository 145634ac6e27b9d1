"""Write TDMS as SignalExpress does: a group with all data, and on request decimated copies."""

from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np
from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter

from shakerproc import files
from shakerproc.data import FloatArray, Recording
from shakerproc.recordings.writers.by_libraries import blocks_in_file_units, file_unit

PAIR: Final = 100
"""Samples of which SignalExpress keeps the smallest and the largest in a decimated copy."""

Layout = Literal["signalexpress", "plain"]


def write_tdms(
    path: Path,
    recording: Recording,
    *,
    layout: Layout = "signalexpress",
    decimated: bool = False,
    number: Literal["float64", "float32"] = "float64",
) -> None:
    """Write a recording as TDMS, whole or not at all.

    Parameters
    ----------
    path : Path
        The file.
    recording : Recording
        Written in the units that its file had.
    layout : {'signalexpress', 'plain'}
        Names of the groups as SignalExpress gives them, or one group ``samples``.
    decimated : bool
        Whether to add the decimated copy (smallest and largest of every 100 samples).
    number : {'float64', 'float32'}
        How the numbers are stored.
    """
    title = _title(recording)
    name = f"{title} - All Data" if layout == "signalexpress" else "samples"
    with files.atomic_path(path) as temporary, TdmsWriter(str(temporary)) as writer:
        root = RootObject(_root_properties(recording, title))
        group = GroupObject(name, {"DecimationLevel": 0, "IntervalIndex": 0})
        for first, block in _numbered(blocks_in_file_units(recording)):
            channels = _channels(recording, name, block.astype(number), 1, described=first)
            writer.write_segment([root, group, *channels] if first else channels)
        if decimated:
            copy = f"{title} - Decimated Data_Level1"
            group = GroupObject(copy, {"DecimationLevel": 1, "IntervalIndex": 0})
            extremes = _decimated(recording).astype(number)
            channels = _channels(recording, copy, extremes, PAIR // 2, described=True)
            writer.write_segment([group, *channels])


def _numbered(blocks: Iterator[FloatArray]) -> Iterator[tuple[bool, FloatArray]]:
    for number, block in enumerate(blocks):
        yield number == 0, block


def _title(recording: Recording) -> str:
    start = recording.start_time
    moment = start.strftime("%m/%d/%Y %I:%M:%S %p - ") if start else ""
    return f"{moment}{recording.run.removesuffix('.tdms')}"


def _root_properties(recording: Recording, title: str) -> dict[str, Any]:
    promised = recording.expected_samples or recording.n_samples
    return {
        "name": recording.run.removesuffix(".tdms"),
        "Title": title,
        "WriterName": "shakerproc",
        "log-dt": 1.0 / recording.sample_rate,
        "log-duration": promised / recording.sample_rate,
        "recording-complete": not recording.incomplete,
    }


def _channels(
    recording: Recording, group: str, block: Any, step: int, *, described: bool
) -> list[ChannelObject]:
    found = []
    for channel, samples in zip(recording.channels, block, strict=True):
        properties: dict[str, Any] = {}
        if described:
            unit, _ = file_unit(channel)
            properties = {"wf_increment": step / recording.sample_rate, "wf_start_offset": 0.0}
            if unit:
                properties |= {"unit_string": unit, "NI_UnitDescription": unit}
            if recording.start_time is not None:
                properties["wf_start_time"] = _naive(recording.start_time)
        found.append(ChannelObject(group, channel.name, samples, properties))
    return found


def _naive(moment: datetime) -> np.datetime64:
    return np.datetime64(moment.astimezone(UTC).replace(tzinfo=None), "us")


def _decimated(recording: Recording) -> FloatArray:
    """Return the smallest and the largest of every 100 samples, in turn."""
    parts = []
    for block in blocks_in_file_units(recording, size=PAIR * 512):
        whole = block[:, : block.shape[1] // PAIR * PAIR]
        pairs = whole.reshape(len(block), -1, PAIR)
        low, high = pairs.min(axis=2), pairs.max(axis=2)
        parts.append(np.stack([low, high], axis=2).reshape(len(block), -1))
    return np.concatenate(parts, axis=1)
