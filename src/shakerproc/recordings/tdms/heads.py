"""The head of a segment: the first 28 bytes, and what may stand in them."""

import struct
from dataclasses import dataclass
from typing import BinaryIO, Final, final

from shakerproc.recordings.tdms.types import StructureError

LEAD: Final = 28
"""Bytes of a head."""

HAS_METADATA: Final = 1 << 1
NEW_LIST: Final = 1 << 2
HAS_DATA: Final = 1 << 3
INTERLEAVED: Final = 1 << 5
BIG_ENDIAN: Final = 1 << 6
VERSIONS: Final = (4712, 4713)
OPEN_END: Final = 0xFFFFFFFFFFFFFFFF
"""Length of a segment that was never closed."""

LONGEST: Final = 1 << 50
"""Bytes of a segment that are believed."""


@final
@dataclass(frozen=True, slots=True)
class Lead:
    """The first 28 bytes of a segment.

    Attributes
    ----------
    position : int
        First byte of the segment in the file.
    flags : int
        What the segment holds.
    version : int
        Version of the format.
    data : int
        First byte of the raw data in the file.
    end : int, optional
        First byte of the next segment, as promised; None where the writer never said it.
    """

    position: int
    flags: int
    version: int
    data: int
    end: int | None

    @property
    def endian(self) -> str:
        """Byte order of everything behind the flags."""
        return ">" if self.flags & BIG_ENDIAN else "<"


def check_tag(head: bytes, position: int) -> None:
    """Pass bytes that begin a segment, be they cut off.

    Raises
    ------
    StructureError
        If something else stands there.
    """
    if head[:4] == b"TDSh":
        raise StructureError(
            position, "this is an index (.tdms_index), which holds no data; give the .tdms file"
        )
    if head[:4] != b"TDSm"[: len(head)]:
        raise StructureError(
            position, f"a segment should begin here with b'TDSm' but {head[:4]!r} stands there"
        )


def unpack_lead(head: bytes, position: int) -> Lead:
    """Return a head.

    Raises
    ------
    StructureError
        If its lengths cannot be.
    """
    flags: int = struct.unpack("<I", head[4:8])[0]
    endian = ">" if flags & BIG_ENDIAN else "<"
    version, to_next, to_data = struct.unpack(endian + "IQQ", head[8:LEAD])
    if to_next != OPEN_END and to_data > to_next:
        raise StructureError(
            position, f"the data of a segment begin {to_data - to_next} bytes behind its end"
        )
    if to_next != OPEN_END and to_next > LONGEST:
        raise StructureError(position, f"a segment says that it is {to_next} bytes long")
    start = position + LEAD
    end = None if to_next == OPEN_END else start + to_next
    return Lead(position, flags, version, start + to_data, end)


def check_nothing_inside(file: BinaryIO, lead: Lead, size: int) -> None:
    """Pass a cut segment unless it would swallow others, because its length is damaged.

    Raises
    ------
    StructureError
        If another segment begins inside.
    """
    step, overlap = 1 << 20, LEAD
    for start in range(lead.data, size, step):
        file.seek(start)
        part = file.read(step + overlap)
        at = part.find(b"TDSm")
        while at >= 0:
            version = part[at + 8 : at + 12]
            if version in {struct.pack(e + "I", v) for e in "<>" for v in VERSIONS}:
                raise StructureError(
                    lead.position,
                    f"the segment says it is longer than the file, but another begins inside "
                    f"it at byte {start + at}",
                )
            at = part.find(b"TDSm", at + 1)
