"""Data types of TDMS, and numbers, text and properties read out of a block of metadata."""

import struct
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Final

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
    """A TDMS file is not what its own headers say.

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
            left = len(self._block) - self._position
            raise StructureError(
                self.place, f"{what} takes {size} bytes but {left} are left in the metadata"
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
