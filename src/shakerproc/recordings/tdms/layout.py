"""Where in a chunk of raw data the values of each channel stand."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, final

from shakerproc.recordings.guard import shown
from shakerproc.recordings.tdms.objects import (
    NUMBERS,
    SIZES,
    TIMESTAMP,
    Index,
    Listed,
    Scaler,
    StructureError,
)

LARGEST: Final = 1 << 50
"""Values and bytes of a channel in a chunk."""

WIDEST: Final = 1 << 24
"""Bytes of a row of interleaved or DAQmx channels."""


@final
@dataclass(frozen=True, slots=True)
class Column:
    """One run of numbers in the rows of a band.

    Attributes
    ----------
    scale : int, optional
        Number of the DAQmx scale that they feed.
    dtype : str
        Type of a number, with its byte order.
    byte : int
        First byte in the row.
    bit : int, optional
        Bit of a digital line.
    """

    scale: int | None
    dtype: str
    byte: int
    bit: int | None = None


@final
@dataclass(frozen=True, slots=True)
class Place:
    """Where the values of one channel stand in a chunk.

    Attributes
    ----------
    count : int
        Values in the chunk.
    offset : int
        First byte of the band in the chunk.
    width : int
        Bytes from one value to the next.
    columns : tuple of Column
        One, or one for each DAQmx scale; none where the values are not numbers.
    """

    count: int
    offset: int
    width: int
    columns: tuple[Column, ...]


@final
@dataclass(frozen=True, slots=True)
class Layout:
    """A chunk.

    Attributes
    ----------
    size : int
        Bytes in the chunk.
    places : mapping
        Path of a channel to where its values stand.
    odd : str
        What is allowed but hardly meant; empty where nothing is.
    """

    size: int
    places: Mapping[str, Place]
    odd: str = ""


def chunk_layout(
    objects: Sequence[Listed], endian: str, *, interleaved: bool, place: int
) -> Layout:
    """Return where everything stands in a full chunk.

    Raises
    ------
    StructureError
        If the objects cannot share a chunk.
    """
    data = [(entry.path, entry.index) for entry in objects if entry.has_data and entry.index]
    for path, index in data:
        if max(index.size, index.count) > LARGEST:
            raise StructureError(place, f"{shown(path)} holds {index.count} values in a chunk")
    daqmx = [bool(index.scalers) for _, index in data]
    if any(daqmx):
        if not all(daqmx):
            raise StructureError(place, "DAQmx and other channels share a segment")
        return _daqmx(data, endian, place)
    odd = _mixed_types(data)
    sized = [index.code in SIZES for _, index in data]
    if interleaved and len(data) > 1 and not all(sized):
        raise StructureError(place, "text stands among interleaved channels")
    if interleaved and all(sized):
        return _interleaved(data, endian, place, odd)
    return _contiguous(data, endian, odd)


def _mixed_types(data: Sequence[tuple[str, Index]]) -> str:
    """Return a remark if channels of equal width hold different kinds of numbers."""
    kinds: dict[str, str] = {}
    for path, index in data:
        name = NUMBERS.get(index.code)
        if name and kinds.setdefault(name[1], name) != name:
            return f"{shown(path)} holds numbers of type {name}, others {kinds[name[1]]}"
    return ""


def _check_width(width: int, place: int) -> None:
    """Pass a row that fits into memory.

    Raises
    ------
    StructureError
        If it does not.
    """
    if width > WIDEST:
        raise StructureError(place, f"a row of {width} bytes")


def _column(index: Index, endian: str, byte: int = 0) -> tuple[Column, ...]:
    if index.code == TIMESTAMP:  # a fraction of a second, and whole seconds
        fraction, seconds = (0, 8) if endian == "<" else (8, 0)
        whole = Column(1, f"{endian}i8", byte + seconds)
        return (Column(0, f"{endian}u8", byte + fraction), whole)
    name = NUMBERS.get(index.code)
    return () if name is None else (Column(None, endian + name, byte),)


def _contiguous(data: Sequence[tuple[str, Index]], endian: str, odd: str) -> Layout:
    places, offset = {}, 0
    for path, index in data:
        width = SIZES.get(index.code, 0)
        places[path] = Place(index.count, offset, width, _column(index, endian))
        offset += index.size
    return Layout(offset, places, odd)


def _interleaved(
    data: Sequence[tuple[str, Index]], endian: str, place: int, odd: str
) -> Layout:
    counts = {index.count for _, index in data}
    if len(counts) > 1:
        raise StructureError(place, "interleaved channels have different numbers of values")
    width = sum(SIZES[index.code] for _, index in data)
    _check_width(width, place)
    places, byte = {}, 0
    for path, index in data:
        places[path] = Place(index.count, 0, width, _column(index, endian, byte))
        byte += SIZES[index.code]
    return Layout(width * max(counts, default=0), places, odd)


def _daqmx(data: Sequence[tuple[str, Index]], endian: str, place: int) -> Layout:
    widths = data[0][1].widths
    _check_width(sum(widths), place)
    rows = [0] * len(widths)
    for path, index in data:
        if index.widths != widths:
            raise StructureError(
                place, f"{shown(path)} has another DAQmx row than its neighbours"
            )
        buffers = {scaler.buffer for scaler in index.scalers}
        if len(buffers) != 1:
            raise StructureError(place, f"{shown(path)} takes its scales from several buffers")
        buffer = buffers.pop()
        rows[buffer] = max(rows[buffer], index.count)
    starts = [
        sum(n * width for n, width in zip(rows[:k], widths[:k], strict=True))
        for k in range(len(widths) + 1)
    ]
    places = {}
    for path, index in data:
        buffer = index.scalers[0].buffer
        columns = tuple(
            Column(s.scale, endian + NUMBERS[s.code], s.byte, s.bit) for s in index.scalers
        )
        places[path] = Place(index.count, starts[buffer], widths[buffer], columns)
    return Layout(starts[-1], places, _check_rows(data, place))


def _check_rows(data: Sequence[tuple[str, Index]], place: int) -> str:
    """Return a remark if DAQmx channels hold the same numbers, or numbers of mixed types.

    Channels may share a scaler (the reference junction of thermocouples) besides their own.

    Raises
    ------
    StructureError
        If scalers overlap in part.
    """
    owners: dict[tuple[int, int], Scaler] = {}
    wholes: dict[tuple[tuple[int, int], ...], str] = {}
    remarks = []
    analog = [(path, [s for s in index.scalers if s.bit is None]) for path, index in data]
    for path, scalers in analog:
        for scaler in scalers:
            for byte in range(scaler.byte, scaler.byte + SIZES[scaler.code]):
                owner = owners.setdefault((scaler.buffer, byte), scaler)
                if (owner.byte, owner.code) != (scaler.byte, scaler.code):
                    raise StructureError(
                        place, f"{shown(path)} claims DAQmx bytes of another channel"
                    )
        other = wholes.setdefault(tuple((s.buffer, s.byte) for s in scalers), path)
        if scalers and other != path:
            remarks.append(f"{shown(path)} and {shown(other)} hold the same numbers")
    if len({scaler.code for _, scalers in analog for scaler in scalers}) > 1:
        remarks.append("DAQmx channels hold numbers of different types")
    return "; ".join(remarks[:3])


def cut_layout(layout: Layout, objects: Sequence[Listed], rest: int) -> Layout:
    """Return the layout of a chunk that was cut off after its first bytes."""
    sizes = {e.path: e.index.size for e in objects if e.has_data and e.index}
    places = {}
    for path, old in layout.places.items():
        behind = rest - old.offset
        if old.width:
            count = min(old.count, max(0, behind // old.width))
        else:
            count = old.count if behind >= sizes[path] else 0
        places[path] = Place(count, old.offset, old.width, old.columns)
    return Layout(rest, places)


def short_layout(layout: Layout, rest: int, place: int) -> Layout:
    """Return the layout of a last chunk that was written shorter than the others on purpose.

    Raises
    ------
    StructureError
        If the bytes do not divide into the same share of every channel.
    """
    places, offset = {}, 0
    shared = len({(p.offset, p.width) for p in layout.places.values()}) == 1
    buffers = any(c.scale is not None for p in layout.places.values() for c in p.columns)
    for path, old in layout.places.items():
        count, odd = divmod(old.count * rest, layout.size)
        if odd or (buffers and not shared) or (old.count and not old.width):
            raise StructureError(
                place,
                f"{rest} bytes are left after the last full chunk of {layout.size} bytes, "
                "which is no whole number of rows",
            )
        start = 0 if shared else offset
        places[path] = Place(count, start, old.width, old.columns)
        offset += count * old.width
    return Layout(rest, places)
