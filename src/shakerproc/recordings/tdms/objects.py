"""The objects (root, groups, channels) that the metadata of a segment lists."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Final, TypeAlias, final

from shakerproc.recordings.guard import shown
from shakerproc.recordings.tdms.types import (
    DAQMX,
    NUMBERS,
    PROPERTY_SIZES,
    SCALERS,
    SIZES,
    STRING,
    Cursor,
    StructureError,
    is_tracked,
    value_of,
)

NO_DATA: Final = 0xFFFFFFFF
AS_BEFORE: Final = 0
FORMAT_SCALER: Final = 0x1269
LINE_SCALER: Final = 0x126A
LONGEST_PATH: Final = 4096
MOST_OBJECTS: Final = 50_000
MOST_PROPERTIES: Final = 200_000
_PATH: Final = re.compile(r"/|/'((?:[^']|'')*)'(?:/'((?:[^']|'')*)')?", re.DOTALL)

Wrote: TypeAlias = Callable[[str, str, Any], None]
"""Told path of the object, name and value of a property."""


@final
@dataclass(frozen=True, slots=True)
class Scaler:
    """Where the raw integers of a DAQmx channel stand in a row.

    Attributes
    ----------
    scale : int
        Number of the scale that the integers feed.
    code : int
        Type of the integers.
    buffer : int
        Which raw buffer, from 0.
    byte : int
        First byte in the row.
    bit : int, optional
        Bit of a digital line.
    """

    scale: int
    code: int
    buffer: int
    byte: int
    bit: int | None = None


@final
@dataclass(frozen=True, slots=True)
class Index:
    """Values of a channel in one chunk.

    Attributes
    ----------
    code : int
        Data type.
    count : int
        Values in a chunk.
    size : int
        Bytes in a chunk; 0 for DAQmx, whose channels share rows.
    scalers : tuple of Scaler
        Of a DAQmx channel.
    widths : tuple of int
        Bytes in a row of each DAQmx buffer.
    """

    code: int
    count: int
    size: int
    scalers: tuple[Scaler, ...] = ()
    widths: tuple[int, ...] = ()


@final
@dataclass(frozen=True, slots=True)
class Listed:
    """An object as one segment lists it.

    Attributes
    ----------
    path : str
        Such as ``/'group'/'channel'``.
    index : Index, optional
        What it holds in a chunk, where that was ever said.
    has_data : bool
        Whether this segment holds data of it.
    """

    path: str
    index: Index | None
    has_data: bool


@lru_cache(maxsize=4096)
def split_path(path: str) -> tuple[str | None, str | None]:
    """Return group and channel of a path that `read_objects` has passed.

    Raises
    ------
    ValueError
        If it has not.
    """
    match = _PATH.fullmatch(path)
    if match is None:
        raise ValueError(f"not a TDMS path: {path!r}")
    group, channel = match.groups()
    return (
        None if group is None else group.replace("''", "'"),
        None if channel is None else channel.replace("''", "'"),
    )


def read_objects(
    cursor: Cursor,
    before: tuple[Listed, ...],
    known: Mapping[str, Listed],
    properties: dict[int, str],
    wrote: Wrote,
) -> tuple[Listed, ...]:
    """Return the list of objects after one block of metadata.

    Parameters
    ----------
    cursor : Cursor
        At the start of the block.
    before : tuple of Listed
        What the list starts from: empty for a new list.
    known : mapping
        The latest entry of every path seen so far.
    properties : dict
        Where to note every property, by the hash of object and name, with its name if its text
        is not UTF-8.
    wrote : callable
        Told path, name and value of each property that says how samples are to be read.

    Raises
    ------
    StructureError
        If the block is not what it should be.
    """
    listed = {entry.path: entry for entry in before}
    seen: set[str] = set()
    for _ in range(cursor.u32("the number of objects")):
        place = cursor.place
        entry = _read_object(cursor, known)
        if entry.path in seen:
            raise StructureError(cursor.place, f"{shown(entry.path)} is listed twice")
        seen.add(entry.path)
        if len(seen) + len(known) > MOST_OBJECTS:
            raise StructureError(place, f"more than {MOST_OBJECTS} channels")
        listed[entry.path] = entry
        _read_properties(cursor, entry.path, properties, wrote)
    cursor.finish()
    return tuple(listed.values())


def _read_object(cursor: Cursor, known: Mapping[str, Listed]) -> Listed:
    place = cursor.place
    path = cursor.text("the path of an object")
    if len(path) > LONGEST_PATH or _PATH.fullmatch(path) is None:
        raise StructureError(place, f"{shown(path)} is not the path of a group or channel")
    previous = known.get(path)
    header = cursor.u32(f"the data index of {shown(path)}")
    if header == NO_DATA:
        return Listed(path, previous.index if previous else None, has_data=False)
    if header == AS_BEFORE:
        if previous is None or previous.index is None:
            raise StructureError(
                place, f"{shown(path)} holds the same as before, but nothing came before"
            )
        return replace(previous, has_data=True)
    index = _read_index(cursor, header, path)
    if (
        previous is not None
        and previous.index is not None
        and not _alike(previous.index, index)
    ):
        raise StructureError(place, f"{shown(path)} changes its data type on the way")
    return Listed(path, index, has_data=True)


def _alike(old: Index, new: Index) -> bool:
    return old.code == new.code and (
        {s.scale: s.code for s in old.scalers} == {s.scale: s.code for s in new.scalers}
    )


def _read_index(cursor: Cursor, header: int, path: str) -> Index:
    place = cursor.place
    what = f"the data index of {shown(path)}"
    code, dimension, count = cursor.u32(what), cursor.u32(what), cursor.u64(what)
    if dimension != 1:
        raise StructureError(place, f"{shown(path)} has {dimension} dimensions instead of 1")
    if header in {FORMAT_SCALER, LINE_SCALER}:
        return _read_daqmx(cursor, path, code, count, line=header == LINE_SCALER)
    if code == STRING:
        return Index(code, count, cursor.u64(what))
    if code == 0 and count == 0:
        return Index(code, 0, 0)
    if code not in SIZES:
        raise StructureError(place, f"{shown(path)} has the data type {code:#x}, unknown here")
    return Index(code, count, count * SIZES[code])


def _read_daqmx(cursor: Cursor, path: str, code: int, count: int, *, line: bool) -> Index:
    place = cursor.place
    what = f"the DAQmx index of {shown(path)}"
    n_scalers = cursor.u32(what)
    scalers = tuple(_read_scaler(cursor, path, line=line) for _ in range(n_scalers))
    n_widths = cursor.u32(what)
    widths = tuple(cursor.u32(what) for _ in range(n_widths))
    if len({scaler.scale for scaler in scalers}) != len(scalers) or not scalers:
        raise StructureError(place, f"{shown(path)} has no DAQmx scaler, or one twice")
    if code != DAQMX and (len(scalers) != 1 or scalers[0].code != code):
        raise StructureError(place, f"{shown(path)} has a scaler of another type than its own")
    for scaler in scalers:
        if scaler.buffer >= len(widths) or (
            scaler.byte + SIZES[scaler.code] > widths[scaler.buffer]
        ):
            raise StructureError(place, f"{shown(path)} reads beyond its DAQmx row")
    return Index(code, count, 0, scalers, widths)


def _read_scaler(cursor: Cursor, path: str, *, line: bool) -> Scaler:
    place = cursor.place
    what = f"a DAQmx scaler of {shown(path)}"
    kind, buffer, offset = cursor.u32(what), cursor.u32(what), cursor.u32(what)
    if line:
        cursor.skip(1, what)
    else:
        cursor.u32(what)
    scale = cursor.u32(what)
    if kind not in SCALERS or SCALERS[kind] not in NUMBERS:
        raise StructureError(place, f"{what} has the type {kind}, unknown here")
    if line:
        return Scaler(scale, SCALERS[kind], buffer, offset // 8, offset % 8)
    return Scaler(scale, SCALERS[kind], buffer, offset)


def _read_properties(
    cursor: Cursor, path: str, properties: dict[int, str], wrote: Wrote
) -> None:
    for _ in range(cursor.u32("the number of properties")):
        name = cursor.text("the name of a property")
        place = cursor.place
        code = cursor.u32(f"the type of {shown(name)}")
        odd = False
        if code == STRING:
            raw = cursor.raw_text(shown(name))
            odd = not _is_utf8(raw)
        elif code in PROPERTY_SIZES:
            raw = cursor.skip(PROPERTY_SIZES[code], shown(name))
        else:
            raise StructureError(
                place, f"property {shown(name)} has the type {code:#x}, unknown here"
            )
        if is_tracked(name):
            wrote(path, name, value_of(code, raw, cursor.endian))
        properties[hash((path, name))] = name if odd else ""
        if len(properties) > MOST_PROPERTIES:
            raise StructureError(place, f"more than {MOST_PROPERTIES} properties")


def _is_utf8(content: bytes) -> bool:
    try:
        content.decode("utf-8")
    except UnicodeDecodeError:
        return False
    return True
