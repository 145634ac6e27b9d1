"""What a channel says of its samples: the properties that matter, as values."""

import struct
from typing import Any, Final

import numpy as np

from shakerproc.recordings.tdms.types import NUMBERS, STRING, TIMESTAMP

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
