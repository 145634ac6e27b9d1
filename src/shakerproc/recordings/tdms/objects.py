"""Data types of TDMS, and the objects (root, groups, channels) that a segment lists."""

import re
import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from types import MappingProxyType
from typing import Any, Final, TypeAlias, final

import numpy as np

from shakerproc.recordings.guard import shown

STRING: Final = 0x20
TIMESTAMP: Final = 0x44
DAQMX: Final = 0xFFFFFFFF

NUMBERS: Mapping[int, str] = MappingProxyType({
    0x01: "i1",
    0x02: "i2",
    0x03: "i4",
    0x04: "i8",
    0x05: "u1",
    0x06: "u2",
    0x07: "u4",
    0x08: "u8",
    0x09: "f4",
    0x0A: "f8",
    0x19: "f4",
    0x1A: "f8",
})
"""Types of which a channel can be served, as numpy names them."""

SIZES: Mapping[int, int] = MappingProxyType(
    {code: np.dtype(name).itemsize for code, name in NUMBERS.items()}
    | {0x21: 1, TIMESTAMP: 16, 0x08000C: 8, 0x10000D: 16}
)
"""Bytes of every type of fixed size."""

PROPERTY_SIZES: Mapping[int, int] = MappingProxyType({
    code: size for code, size in SIZES.items() if code < 0x080000
})
"""Bytes of every type a property may have, text aside."""

SCALERS: Mapping[int, int] = MappingProxyType({
    0: 5,
    1: 1,
    2: 6,
    3: 2,
    4: 7,
    5: 3,
    6: 8,
    7: 4,
    8: 9,
    9: 10,
})
"""DAQmx numbers its types differently: its number to the number above."""

_TO_1970: Final = 2_082_844_800
"""Seconds from 1904, where TDMS begins to count, to 1970."""

MOST_SECONDS: Final = 1 << 36
"""Seconds since 1904 that a time may be at most."""

_TRACKED: Final = (
    "wf_start_time",
    "wf_start_offset",
    "wf_increment",
    "wf_xname",
    "wf_xunit_string",
    "unit_string",
)


class StructureError(Exception):
    """A TDMS file contradicts its own headers.

    Attributes
    ----------
    place : int
        Byte in the file.
    """

    def __init__(self, place: int, message: str) -> None:
        self.place = place
        super().__init__(message)


class Cursor:
    """A place in a block of metadata that only moves forward.

    Parameters
    ----------
    block : bytes
        The metadata of one segment.
    place : int
        Byte of the file at which the block starts, for messages.
    endian : str
        ``<`` or ``>``.
    """

    def __init__(self, block: bytes, place: int, endian: str) -> None:
        self._block = block
        self._start = place
        self._position = 0
        self._endian = endian

    @property
    def endian(self) -> str:
        """Byte order of the block."""
        return self._endian

    @property
    def place(self) -> int:
        """Byte of the file that comes next."""
        return self._start + self._position

    def skip(self, size: int, what: str) -> bytes:
        """Return the next bytes.

        Raises
        ------
        StructureError
            If the block ends before them.
        """
        end = self._position + size
        if end > len(self._block):
            remaining = len(self._block) - self._position
            raise StructureError(
                self.place,
                f"{what} takes {size} bytes but {remaining} are left in the metadata",
            )
        part = self._block[self._position : end]
        self._position = end
        return part

    def u32(self, what: str) -> int:
        """Return the next unsigned 32-bit number."""
        number: int = struct.unpack(self._endian + "I", self.skip(4, what))[0]
        return number

    def u64(self, what: str) -> int:
        """Return the next unsigned 64-bit number."""
        number: int = struct.unpack(self._endian + "Q", self.skip(8, what))[0]
        return number

    def raw_text(self, what: str) -> bytes:
        """Return the next text as bytes."""
        return self.skip(self.u32(f"the length of {what}"), what)

    def text(self, what: str) -> str:
        """Return the next text.

        Raises
        ------
        StructureError
            If it is not UTF-8.
        """
        place = self.place
        content = self.raw_text(what)
        try:
            return content.decode("utf-8")
        except UnicodeDecodeError as error:
            raise StructureError(place, f"{what} is not text: {shown(content, 40)}") from error

    def finish(self) -> None:
        """Pass zeros up to the end of the block.

        Raises
        ------
        StructureError
            If something else stands there.
        """
        rest = self._block[self._position :]
        if rest.strip(b"\0"):
            raise StructureError(
                self.place,
                f"{len(rest)} bytes of metadata are left over that belong to nothing",
            )


def is_tracked(name: str) -> bool:
    """Return whether a property of a channel says how its samples are to be read."""
    return name in _TRACKED or name.startswith("NI_")


def value_of(code: int, raw: bytes, endian: str) -> Any:
    """Return the value of a property; None where it is none that says something here."""
    if code == STRING:
        return raw.decode("utf-8", errors="replace")
    if code == TIMESTAMP:
        fraction, seconds = struct.unpack("<Qq", raw if endian == "<" else raw[::-1])
        if not 0 < seconds < MOST_SECONDS:  # 1904 is LabVIEW's word for no time
            return None
        return np.datetime64((seconds - _TO_1970) * 10**6 + (fraction * 10**6 >> 64), "us")
    name = NUMBERS.get(code)
    return None if name is None else np.frombuffer(raw, endian + name)[0].item()


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
        and not _same_layout(previous.index, index)
    ):
        raise StructureError(place, f"{shown(path)} changes its data type on the way")
    return Listed(path, index, has_data=True)


def _same_layout(old: Index, new: Index) -> bool:
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
