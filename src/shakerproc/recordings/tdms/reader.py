"""Open a TDMS file."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, BinaryIO, Final, final

import numpy as np

from shakerproc.errors import RecordingError
from shakerproc.recordings.guard import AGAIN, kept_open, opened, shown
from shakerproc.recordings.raw import SILENT, RawChannel, RawFile, RawGroup, TimeAxis
from shakerproc.recordings.tdms.metadata import (
    Properties,
    Scaling,
    read_properties,
    read_scaling,
    unused_scales,
)
from shakerproc.recordings.tdms.objects import (
    DAQMX,
    NUMBERS,
    STRING,
    TIMESTAMP,
    Listed,
    StructureError,
    is_tracked,
    split_path,
)
from shakerproc.recordings.tdms.source import (
    SampleClock,
    ServedChannel,
    StampScaling,
    TdmsSource,
    clocks,
    with_times,
)
from shakerproc.recordings.tdms.structure import (
    Extent,
    TdmsStructure,
    divided,
    present,
    start_of,
    unit_of,
)
from shakerproc.recordings.tdms.walk import walk
from shakerproc.recordings.time_base import time_base

_REDUCED: Final = re.compile(r" - Decimated Data_Level\d+\Z")
_EMPTY: Properties = {}


def read_tdms(path: Path, run: str) -> RawFile:
    """Return the groups of a TDMS file; its samples are read when they are asked for.

    Raises
    ------
    RecordingError
        If the file cannot be opened or is not what its headers say.
    """
    try:
        return kept_open(opened(path, run), lambda file: _open(file, run))
    except StructureError as error:
        raise RecordingError(f"{run}: byte {error.place}: {error}. {AGAIN}") from error


def _open(file: BinaryIO, run: str) -> RawFile:
    structure = walk(file)
    properties = read_properties(bytes(structure.index), run) if structure.index else {}
    table = _Table(run, structure)
    by_group: dict[str, list[str]] = {}
    for path in structure.known:
        group, channel = split_path(path)
        if channel is not None:
            by_group.setdefault(group or "", []).append(path)
    groups = tuple(_group(name, paths, table, properties) for name, paths in by_group.items())
    source = TdmsSource(run, file, structure.size, tuple(table.served), tuple(table.clocks))
    stamped = {
        row: one.scaling for row, one in enumerate(table.served)
        if isinstance(one.scaling, StampScaling)
    }  # fmt: skip
    groups = tuple(with_times(group, source, stamped) for group in groups)
    loose = [
        path
        for paths in by_group.values()
        for path in paths
        if not _problem(structure.known[path]) and unused_scales(properties.get(path, _EMPTY))
    ]
    return RawFile(groups, source, _notes(structure, table.served, loose))


def _group(
    name: str, paths: Sequence[str], table: "_Table", properties: Mapping[str, Properties]
) -> RawGroup:
    """Return a group, and the measurements that follow each other in it."""
    waveforms, extents = table.structure.waveforms, table.structure.extents
    cuts = waveforms.cuts.get(name, [])
    reduced = _is_reduced(name, properties)
    measurements = []
    for number, part in enumerate(divided(cuts, extents) if cuts else []):
        last = number == len(cuts)
        said = properties if last else _as_of(properties, cuts[number].before, paths)
        if last and name in waveforms.more:
            break  # what is left is several
        channels = table.add(_Part(part, said, number, last=last), paths)
        measurements.append(RawGroup(name, channels, reduced))
    whole = _Part(extents, properties, 0, last=True)
    return RawGroup(
        name,
        table.add(whole, paths),
        reduced,
        tuple(measurements),
        tuple(cut.differs for cut in cuts),
        waveforms.more[name] + 1 if name in waveforms.more else 0,
    )


def _as_of(
    properties: Mapping[str, Properties], before: Mapping[str, Properties], paths: Sequence[str]
) -> dict[str, Properties]:
    """Return the properties as they were when a measurement ended."""
    then = {
        path: {n: v for n, v in properties.get(path, _EMPTY).items() if not is_tracked(n)}
        | dict(before.get(path, _EMPTY))
        for path in paths
    }
    return {**properties, **then}


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Part:
    """A measurement: its samples and their description; `last` where it is open."""

    extents: Sequence[Extent]
    properties: Mapping[str, Properties]
    number: int
    last: bool


@final
@dataclass(slots=True, eq=False)
class _Table:
    """The rows of a file: a channel has one for all its samples, and one for a measurement."""

    run: str
    structure: TdmsStructure
    served: list[ServedChannel] = field(default_factory=list)
    clocks: list[SampleClock] = field(default_factory=list)

    def add(self, part: _Part, paths: Sequence[str]) -> tuple[RawChannel, ...]:
        """Return the channels of a part; those that can be served get a row each."""
        numbers = [path for path in paths if _is_served(self.structure.known[path])]
        rows = {path: len(self.served) + i for i, path in enumerate(numbers)}
        clock_of = clocks(numbers, part.extents)
        self.served += [
            ServedChannel(
                path,
                StampScaling()
                if _is_stamped(self.structure.known[path])
                else read_scaling(self.run, path, _levels(path, part.properties)),
            )
            for path in numbers
        ]
        self.clocks += [clock_of[path] for path in numbers]
        there = present(part.extents)
        return tuple(
            _channel(path, self.structure, part, there.get(path, 0), rows.get(path, -1))
            for path in paths
        )


def _group_path(name: str) -> str:
    return "/'" + name.replace("'", "''") + "'"


def _levels(
    path: str, properties: Mapping[str, Properties]
) -> tuple[Properties, Properties, Properties]:
    group = _group_path(split_path(path)[0] or "")
    return (
        properties.get(path, _EMPTY),
        properties.get(group, _EMPTY),
        properties.get("/", _EMPTY),
    )


def _is_stamped(entry: Listed) -> bool:
    return entry.index is not None and entry.index.code == TIMESTAMP


def _is_served(entry: Listed) -> bool:
    """Return whether a channel holds numbers, or times that become numbers."""
    return _is_stamped(entry) or not _problem(entry)


def _problem(entry: Listed) -> str:
    """Return why a channel holds nothing that can be served, or an empty text."""
    if entry.index is None:
        return "it holds no data"
    if entry.index.code in NUMBERS or entry.index.code == DAQMX:
        return ""
    kinds = {STRING: "text", TIMESTAMP: "times", 0x21: "true and false"}
    return f"it holds {kinds.get(entry.index.code, 'no real numbers')}"


def _channel(
    path: str, structure: TdmsStructure, part: _Part, there: int, row: int
) -> RawChannel:
    levels = _levels(path, part.properties)
    start = structure.waveforms.starts.get((path, part.number))
    if start is None and part.number == 0:
        start = start_of(levels[0])
    moment = _time(start)
    axis = _axis(levels[0], dated=moment is not None)
    promised = max(
        _promised(path, structure, there), _logged(levels, time_base((axis,)).sample_rate)
    )
    return RawChannel(
        name=split_path(path)[1] or "",
        row=row,
        n_samples=there,
        promised=promised if part.last else there,
        unit=unit_of(levels[0]),
        axes=(axis,),
        start_time=moment,
        problem=_problem(structure.known[path]),
    )


def _promised(path: str, structure: TdmsStructure, there: int) -> int:
    """Return how many values there should be; where the file cannot say, one chunk more."""
    missing = structure.missing.get(path, 0)
    entry = structure.known[path]
    if structure.open_end and missing <= 0 and entry.index:
        return there + max(1, entry.index.count)
    return there + missing


def _logged(levels: tuple[Properties, Properties, Properties], rate: float | None) -> int:
    """Return the length of the measurement where SignalExpress says it did not finish."""
    root = levels[2]
    duration = root.get("log-duration")
    if root.get("recording-complete") is not False or not isinstance(duration, float):
        return 0
    length = duration * rate if rate and not levels[1].get("DecimationLevel") else 0.0
    return round(length) if 0.0 < length < 2.0**50 else 0


def _axis(properties: Properties, *, dated: bool) -> TimeAxis:
    """Return the statement of a channel on its times; a date of its start holds the offset.

    The interval of a waveform is in seconds where no unit of its axis says otherwise.
    """
    quantity, unit = properties.get("wf_xname"), properties.get("wf_xunit_string")
    offset = properties.get("wf_start_offset")
    axis = TimeAxis(
        "wf_increment",
        start=float(offset) if isinstance(offset, float) and not dated else 0.0,
        quantity=quantity if isinstance(quantity, str) else "",
        unit=unit if isinstance(unit, str) else "",
    )
    if "wf_increment" not in properties:
        return replace(axis, problem=f"{SILENT} (no wf_increment)")
    step = properties["wf_increment"]
    if isinstance(step, int | float | np.number):
        if step == 1:
            default = f"{axis.where}, 1 as LabVIEW writes it where none is given,"
            return replace(axis, step=1.0, where=default)
        waveform = not axis.quantity or axis.quantity.casefold().startswith("time")
        seconds = "s" if waveform else ""
        return replace(axis, step=float(step), unit=axis.unit or seconds)
    return replace(axis, problem=f"wf_increment is {shown(step, 30)}, which is no interval")


def _time(value: Any) -> datetime | None:
    """Return a time stamp of the file; the year 1904 is LabVIEW's word for no time."""
    if not isinstance(value, np.datetime64) or np.isnat(value):
        return None
    moment = value.astype("datetime64[us]").item()
    if not isinstance(moment, datetime) or moment.year <= 1904:
        return None
    return moment.replace(tzinfo=UTC)


def _is_reduced(name: str, properties: Mapping[str, Properties]) -> bool:
    level = properties.get(_group_path(name), _EMPTY).get("DecimationLevel", 0)
    return bool(_REDUCED.search(name)) or (isinstance(level, int) and level > 0)


def _notes(
    structure: TdmsStructure, served: Sequence[ServedChannel], loose: Sequence[str]
) -> tuple[str, ...]:
    notes = []
    if structure.cut:
        notes.append(f"The file is not whole: {structure.cut}.")
    if structure.mixed:
        notes.append("Interleaved and contiguous segments follow each other.")
    notes += [f"Odd: {remark}." for remark in sorted(structure.odd_layout)[:5]]
    odd_text = {name for name in structure.properties.values() if name}
    if odd_text:
        names = ", ".join(shown(name, 40) for name in sorted(odd_text)[:5])
        notes.append(f"Text that is not UTF-8 in the properties {names}.")
    wide = [
        channel.path
        for channel in served
        if structure.known[channel.path].index.code in {0x04, 0x08}  # type: ignore[union-attr]
        and isinstance(channel.scaling, Scaling)
        and channel.scaling.steps is None
    ]
    if wide:
        notes.append(f"64-bit integers without a scale in {', '.join(map(shown, wide[:5]))}.")
    if loose:
        notes.append(f"Scales that nothing uses in {', '.join(map(shown, loose[:5]))}.")
    return tuple(notes)
