"""The data types of TDMS and what is wrong with a file's structure."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

import numpy as np

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
