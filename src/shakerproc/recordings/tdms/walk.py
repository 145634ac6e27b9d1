"""The pre-flight: walk over the segments of a TDMS file before anything else reads it.

The walk only unpacks numbers, never leaves the block it is in and never allocates more than a
block of metadata, so that a damaged file costs no more than a good one. What it passes cannot
make npTDMS hang, recurse or allocate beyond the file.
"""

import os
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import BinaryIO, Final, final

from shakerproc.recordings.tdms.layout import Layout, chunk_layout, cut_layout, short_layout
from shakerproc.recordings.tdms.objects import Cursor, Listed, StructureError, read_objects
from shakerproc.recordings.tdms.structure import Extent, TdmsStructure, append_extent

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

MOST_METADATA: Final = 1 << 26
"""Bytes of metadata that the whole file may hold, repetitions aside."""

MOST_SEGMENTS: Final = 2_000_000


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


def walk(file: BinaryIO) -> TdmsStructure:
    """Return the structure of an open TDMS file.

    Raises
    ------
    StructureError
        If a header says what cannot be; a file that merely stops early is no error.
    """
    tdms_structure = TdmsStructure(size=file.seek(0, os.SEEK_END))
    if not tdms_structure.size:
        raise StructureError(0, "the file is empty (0 bytes)")
    state = _State()
    for number, lead in enumerate(_leads(file, tdms_structure)):
        state.number = number
        _check_version(lead, state)
        _read_metadata(file, lead, tdms_structure, state)
        _add_data(file, lead, tdms_structure, state)
    tdms_structure.waveforms.finish()
    if not tdms_structure.known and not tdms_structure.cut:
        raise StructureError(0, "the file lists no groups")
    return tdms_structure


@dataclass(slots=True)
class _State:
    """State that a segment inherits from the one before."""

    number: int = 0
    version: int | None = None
    metadata: bytes = b""
    flags: int = -1
    objects: tuple[Listed, ...] | None = None
    layout: Layout = Layout(0, {})  # noqa: RUF009 frozen
    interleaved: set[bool] = field(default_factory=set)


def _leads(file: BinaryIO, structure: TdmsStructure) -> Iterator[Lead]:
    """Yield the head of each segment that has all its metadata.

    Raises
    ------
    StructureError
        If there are more segments than any recording has.
    """
    position = n_segments = 0
    while position < structure.size:
        n_segments += 1
        if n_segments > MOST_SEGMENTS:
            raise StructureError(position, f"more than {MOST_SEGMENTS} segments")
        file.seek(position)
        head = file.read(LEAD)
        check_tag(head, position)
        if len(head) < LEAD:
            structure.cut = f"it stops at byte {structure.size}, inside the head of a segment"
            structure.open_end = True
            return
        lead = unpack_lead(head, position)
        if lead.data > structure.size:
            structure.cut = (
                f"it stops at byte {structure.size}, inside the metadata of a segment"
            )
            structure.open_end = True
            return
        yield lead
        if lead.end is None or lead.end > structure.size:
            return
        position = lead.end


def _check_version(lead: Lead, state: _State) -> None:
    if lead.version not in VERSIONS:
        raise StructureError(
            lead.position, f"version {lead.version} of the format; known are 4712 and 4713"
        )
    if state.version not in {None, lead.version}:
        raise StructureError(
            lead.position, f"the version changes from {state.version} to {lead.version}"
        )
    state.version = lead.version


def _read_metadata(file: BinaryIO, lead: Lead, structure: TdmsStructure, state: _State) -> None:
    size = lead.data - lead.position - LEAD
    if len(structure.index) + size > MOST_METADATA:
        raise StructureError(
            lead.position,
            f"more than {MOST_METADATA >> 20} MB of metadata, which is no recording",
        )
    block = file.read(size)
    if len(block) != size:
        raise StructureError(lead.position, "the file shrinks while it is read")
    flags = lead.flags & (HAS_METADATA | NEW_LIST | INTERLEAVED | BIG_ENDIAN)
    if state.objects is not None and flags == state.flags and block == state.metadata:
        return  # the same list again: nothing changes
    if lead.flags & HAS_METADATA:
        _new_objects(block, lead, structure, state)
    elif state.objects is None:
        raise StructureError(lead.position, "the first segment lists no channels")
    elif block.strip(b"\0"):
        raise StructureError(lead.position, "metadata where the flags say there are none")
    state.metadata, state.flags = block, flags
    interleaved = bool(lead.flags & INTERLEAVED)
    state.layout = chunk_layout(
        state.objects or (), lead.endian, interleaved=interleaved, place=lead.position
    )
    if state.layout.odd:
        structure.odd_layout.add(state.layout.odd)
    if lead.flags & HAS_METADATA:
        _add_to_index(block, lead, structure, state)


def _new_objects(block: bytes, lead: Lead, structure: TdmsStructure, state: _State) -> None:
    fresh = bool(lead.flags & NEW_LIST)
    before = () if fresh or state.objects is None else state.objects
    cursor = Cursor(block, lead.position + LEAD, lead.endian)
    state.objects = read_objects(
        cursor, before, structure.known, structure.properties, structure.waveforms.wrote
    )
    for entry in state.objects:
        structure.known[entry.path] = entry


def _add_to_index(block: bytes, lead: Lead, structure: TdmsStructure, state: _State) -> None:
    """Write the segment as npTDMS reads it from an index: with one chunk of data, or none."""
    head = struct.pack(
        lead.endian + "IQQ", lead.version, len(block) + state.layout.size, len(block)
    )
    structure.index += b"TDSh" + struct.pack("<I", lead.flags) + head + block


def _add_data(file: BinaryIO, lead: Lead, structure: TdmsStructure, state: _State) -> None:
    end = structure.size if lead.end is None else min(lead.end, structure.size)
    there = end - lead.data
    cut = lead.end is None or lead.end > structure.size
    promised = there if lead.end is None else lead.end - lead.data
    if promised and not lead.flags & HAS_DATA:
        raise StructureError(
            lead.position, f"the segment holds {promised} bytes of data, its flags say none"
        )
    if promised and not state.layout.size:
        raise StructureError(
            lead.position, f"{promised} bytes of data belong to no channel of the segment"
        )
    if cut:
        check_nothing_inside(file, lead, structure.size)
        structure.cut = f"it stops at byte {structure.size}, inside the data of a segment"
        structure.open_end = lead.end is None
    if not state.layout.size:
        return
    if there:
        structure.mixed |= len(state.interleaved | {bool(lead.flags & INTERLEAVED)}) > 1
        state.interleaved.add(bool(lead.flags & INTERLEAVED))
    _add_extents(lead, there, structure, state, cut=cut)
    if cut:
        structure.missing = _missing(lead, there, structure, state)


def _add_extents(
    lead: Lead, there: int, structure: TdmsStructure, state: _State, *, cut: bool
) -> None:
    full, rest = divmod(there, state.layout.size)
    if full:
        separate = structure.waveforms.data(
            state.number, state.layout, full, len(structure.extents)
        )
        new = Extent(lead.data, full, state.layout, state.layout.size)
        append_extent(structure.extents, new, separate=separate)
    if rest:
        tail = (
            cut_layout(state.layout, state.objects or (), rest)
            if cut
            else short_layout(state.layout, rest, lead.position)
        )
        start = lead.data + full * state.layout.size
        structure.waveforms.data(state.number, tail, 1, len(structure.extents))
        structure.extents.append(Extent(start, 1, tail, tail.size))


def _missing(lead: Lead, there: int, structure: TdmsStructure, state: _State) -> dict[str, int]:
    """Return how many values of each channel a cut segment lacks, as far as it says."""
    if lead.end is None:
        return {}
    promised = lead.end - lead.data
    layout = state.layout
    tail = structure.extents[-1].layout.places if there % layout.size else {}
    held = {path: where.count for path, where in tail.items()}
    return {
        path: where.count * promised // layout.size
        - there // layout.size * where.count
        - held.get(path, 0)
        for path, where in layout.places.items()
    }
