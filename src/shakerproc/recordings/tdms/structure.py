"""What the walk over a TDMS file finds: where the values of every channel stand."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import final

from shakerproc.recordings.tdms.layout import Layout
from shakerproc.recordings.tdms.measurements import Waveforms
from shakerproc.recordings.tdms.objects import Listed


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
class Structure:
    """What the walk has found.

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


def append_extent(extents: list[Extent], new: Extent, *, apart: bool = False) -> None:
    """Add an extent; segments of one chunk that follow each other evenly become one extent.

    Unless the new one is to stay apart.
    """
    last = extents[-1] if extents and not apart else None
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
