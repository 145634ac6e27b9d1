"""Where in a TDMS file the values of each channel stand, and where measurements end.

A program that appends to a file writes the properties of a channel again: when its samples
start, how far apart they are, their unit, their scale. Where these do not continue what stood
before, it is another measurement.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from types import MappingProxyType
from typing import Any, Final, TypeVar, final

import numpy as np

from shakerproc.recordings.si import parse_unit
from shakerproc.recordings.tdms.layout import Layout
from shakerproc.recordings.tdms.objects import Listed, split_path
from shakerproc.recordings.time_base import SAME_RATE, follows

MOST: Final = 100
"""Measurements of a group that can be chosen from."""

T = TypeVar("T")

State = Mapping[str, Any]
"""What a channel says of its samples, by name of the property."""

_NOTHING: State = MappingProxyType({})


@final
@dataclass(frozen=True, slots=True)
class Cut:
    """Where in a group another measurement begins.

    Attributes
    ----------
    extent : int
        Number of its first extent.
    before : mapping
        What each channel said of its samples until then, by path.
    differs : str
        In what the new measurement differs: ``time``, ``rate``, ``unit`` or ``scale``.
    """

    extent: int
    before: Mapping[str, State]
    differs: str


@final
@dataclass(slots=True)
class Waveforms:
    """State of the channels while a file is walked over.

    Attributes
    ----------
    cuts : dict
        Where another measurement begins, by name of the group.
    more : dict
        How many cuts there are beyond those that are kept, by name of the group.
    states : dict
        What each channel says of its samples now, by path.
    starts : dict
        When the samples of a channel begin, by path and number of the measurement from 0.
    """

    cuts: dict[str, list[Cut]] = field(default_factory=dict)
    more: dict[str, int] = field(default_factory=dict)
    states: dict[str, State] = field(default_factory=dict)
    starts: dict[tuple[str, int], Any] = field(default_factory=dict)
    _written: dict[str, dict[str, Any]] = field(default_factory=dict)
    _since: dict[str, int] = field(default_factory=dict)
    _seen: dict[str, int] = field(default_factory=dict)
    _starts: dict[str, Any] = field(default_factory=dict)
    _last_cut: dict[str, int] = field(default_factory=dict)
    _runs: list[tuple[Layout, int, int]] = field(default_factory=list)

    def wrote(self, path: str, name: str, value: Any) -> None:
        """Remember a property of a channel until samples follow it."""
        if split_path(path)[1] is None:
            return
        self._written.setdefault(path, {})[name] = value

    def data(self, number: int, layout: Layout, n_chunks: int, extent: int) -> bool:
        """Count the samples of a segment; return whether another measurement begins with it.

        Parameters
        ----------
        number : int
            Which segment of the file it is.
        layout : Layout
            Its chunks.
        n_chunks : int
            How many.
        extent : int
            Number of the extent that its chunks would begin.
        """
        cut = False
        changed = [
            path
            for path in self._written
            if path in layout.places and layout.places[path].count
        ]
        if changed:
            self._count()
            for path in changed:
                cut |= self._begins(path, number, extent)
        self._runs.append((layout, n_chunks, number))
        if len(self._runs) > 1 and self._runs[-2][0] is layout:
            before = self._runs.pop(-2)
            self._runs[-1] = (layout, before[1] + n_chunks, number)
        return cut

    def _count(self) -> None:
        """Add the samples read since to the number of samples of each channel."""
        for layout, n_chunks, number in self._runs:
            for path, where in layout.places.items():
                if where.count:
                    self._since[path] = self._since.get(path, 0) + n_chunks * where.count
                    self._seen[path] = number
        self._runs.clear()

    def _begins(self, path: str, number: int, extent: int) -> bool:
        """Take over the written part of a channel; return whether it is a new measurement."""
        before, group = self.states.get(path, _NOTHING), split_path(path)[0] or ""
        after = {**before, **self._written.pop(path)}
        since = self._since.get(path, 0)
        old, new = self._starts.get(path), start_of(after)
        differs = difference(before, after) or (
            "" if continues(old, new, since * step_of(before), step_of(before)) else "time"
        )
        differs = differs if path in self._seen else ""
        if new != old or differs:
            self._since[path], self._starts[path] = 0, new
        cut = bool(differs) and self._last_cut.get(group, -1) <= self._seen[path]
        if cut:
            self._cut(group, number, extent, differs)
        self.states[path] = after
        part = len(self.cuts.get(group, ()))
        if new is not None:
            self.starts.setdefault((path, part), new)
        return cut

    def _cut(self, group: str, number: int, extent: int, differs: str) -> None:
        self._last_cut[group] = number
        cuts = self.cuts.setdefault(group, [])
        if len(cuts) >= MOST:
            self.more[group] = self.more.get(group, 0) + 1
            return
        inside = {p: s for p, s in self.states.items() if split_path(p)[0] == group}
        cuts.append(Cut(extent, inside, differs))

    def finish(self) -> None:
        """Take over the part written after the last samples."""
        for path, values in self._written.items():
            self.states[path] = {**self.states.get(path, _NOTHING), **values}
        self._written.clear()


def difference(before: State, after: State) -> str:
    """Return how samples differ from those before, but for their time; empty if they do not.

    Parameters
    ----------
    before, after : State
        What the channel said of its samples, and what it says now.
    """
    old, new = unit_of(before), unit_of(after)
    if old and new and old != new and (parse_unit(old) or old) != (parse_unit(new) or new):
        return "unit"
    step, next_step = step_of(before), step_of(after)
    if step and next_step and abs(next_step / step - 1.0) > SAME_RATE:
        return "rate"
    if any(n.startswith("NI_Scale[") and after[n] != v for n, v in before.items()):
        return "scale"
    return ""


def continues(start: Any, next_start: Any, duration: float, step: float) -> bool:
    """Return whether samples go on where those before end.

    Parameters
    ----------
    start, next_start : numpy time or None
        When the samples before and these start.
    duration : float
        Of the samples before [s].
    step : float
        Time between samples [s]; 0 where it is not said.
    """
    if start is None or next_start is None or start == next_start:
        return True
    elapsed = float((next_start - start).astype(np.int64)) * 1e-6
    return follows(elapsed, duration, step)


def unit_of(state: State) -> str:
    """Return the unit of samples; empty where none is said."""
    for name in ("unit_string", "NI_UnitDescription"):
        text = state.get(name)
        if isinstance(text, str) and text.strip():
            return text.strip()
    return ""


def step_of(state: State) -> float:
    """Return the time between samples [s]; 0 where it is not said."""
    step = state.get("wf_increment")
    if isinstance(step, int | float | np.number) and np.isfinite(step) and step > 0:
        return float(step)
    return 0.0


def start_of(state: State) -> Any:
    """Return when samples start, as numpy time; None where it is not said."""
    start, offset = state.get("wf_start_time"), state.get("wf_start_offset")
    if not isinstance(start, np.datetime64):
        return None
    if isinstance(offset, int | float) and abs(offset) < 1e9:
        return start + np.timedelta64(round(offset * 1e6), "us")
    return start


def divided(cuts: Sequence[Cut], extents: Sequence[T]) -> list[Sequence[T]]:
    """Return the extents of each measurement of a group."""
    edges = [0, *(cut.extent for cut in cuts), len(extents)]
    return [extents[first:beyond] for first, beyond in pairwise(edges)]


@final
@dataclass(frozen=True, slots=True)
class Extent:
    """Equal chunks of raw data at equal distances.

    Attributes
    ----------
    position : int
        First byte in the file.
    n_chunks : int
        How many.
    layout : Layout
        What stands where in each.
    pitch : int
        Bytes from one chunk to the next: those of a chunk, or more where each is a segment
        of its own with a head before it.
    """

    position: int
    n_chunks: int
    layout: Layout
    pitch: int


@final
@dataclass(slots=True)
class TdmsStructure:
    """Result of the walk over a file.

    Attributes
    ----------
    size : int
        Bytes in the file.
    extents : list of Extent
        The raw data, in order.
    known : dict
        The latest entry of every object, by path, in the order of the file.
    missing : dict
        Values that the file says it holds beyond those that are there, by path of the channel.
    index : bytearray
        The metadata without the data, as npTDMS reads it.
    properties : dict
        Name of every property, and whether its text is not UTF-8, by object and name.
    odd_layout : set of str
        What is allowed in a layout but hardly meant.
    cut : str
        How the file stops short; empty where it is whole.
    open_end : bool
        Whether the file does not say how much more there was to come.
    mixed : bool
        Whether interleaved and contiguous segments follow each other.
    waveforms : Waveforms
        What the channels say of their samples, and where another measurement begins.
    """

    size: int
    extents: list[Extent] = field(default_factory=list)
    known: dict[str, Listed] = field(default_factory=dict)
    missing: dict[str, int] = field(default_factory=dict)
    index: bytearray = field(default_factory=bytearray)
    properties: dict[int, str] = field(default_factory=dict)
    odd_layout: set[str] = field(default_factory=set)
    cut: str = ""
    open_end: bool = False
    mixed: bool = False
    waveforms: Waveforms = field(default_factory=Waveforms)

    def present(self) -> dict[str, int]:
        """Return how many values of each channel are there."""
        return present(self.extents)


def present(extents: Sequence[Extent]) -> dict[str, int]:
    """Return how many values of each channel some extents hold."""
    counts: dict[str, int] = {}
    for extent in extents:
        for path, where in extent.layout.places.items():
            counts[path] = counts.get(path, 0) + extent.n_chunks * where.count
    return counts


def append_extent(extents: list[Extent], new: Extent, *, separate: bool = False) -> None:
    """Add an extent; segments of one chunk that follow each other evenly become one extent.

    Unless the new one is to stay apart.
    """
    last = extents[-1] if extents and not separate else None
    if last is not None and last.layout is new.layout and new.n_chunks == 1:
        pitch = (new.position - last.position) // last.n_chunks
        even = last.position + last.n_chunks * pitch == new.position
        if (
            even
            and pitch <= 2 * new.layout.size
            and (last.n_chunks == 1 or last.pitch == pitch)
        ):
            extents[-1] = Extent(last.position, last.n_chunks + 1, last.layout, pitch)
            return
    extents.append(new)
