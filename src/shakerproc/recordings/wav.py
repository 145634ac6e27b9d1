"""Read WAV: RIFF, RIFX and RF64 with samples as numbers, a slice at a time.

Whole numbers are shares of full scale, from -1 to 1, as in every other program; what full
scale stands for is in no field of the format, and the log says it: ``unit: 10 V``.

References
----------
.. [1] IBM and Microsoft, "Multimedia programming interface and data specifications 1.0", 1991.
.. [2] Microsoft, "Multiple channel audio data and WAVE files", 2007 (WAVE_FORMAT_EXTENSIBLE).
.. [3] EBU Tech 3306, "RF64: an extended file format for audio data", 2018; EBU Tech 3285,
   "Specification of the Broadcast Wave Format", 2011.
"""

import os
import re
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, BinaryIO, Final, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.errors import RecordingError
from shakerproc.recordings.arrays import ArrayRow, LinesSource
from shakerproc.recordings.guard import AGAIN, foreign, kept_open, opened, shown
from shakerproc.recordings.raw import Frames, RawChannel, RawFile, RawGroup, TimeAxis

_ORDERS: Final = {b"RIFF": "<", b"RF64": "<", b"BW64": "<", b"RIFX": ">"}
_LATER: Final = 0xFFFFFFFF
"""Length of what is longer than four bytes can say, or of what was not known yet."""

_PCM, _FLOAT, _EXTENSIBLE = 1, 3, 0xFFFE
_PACKED: Final = {
    2: "ADPCM", 6: "A-law", 7: "mu-law", 0x11: "IMA ADPCM", 0x50: "MPEG", 0x55: "MP3",
    0x161: "Windows Media", 0xF1AC: "FLAC",
}  # fmt: skip
_GUID: Final = bytes.fromhex("000000001000800000aa00389b71")
"""How the types of WAVE_FORMAT_EXTENSIBLE end that are those of the short form."""

_TEXTS: Final = ("INAM", "ISBJ", "ICMT", "IART", "ISFT", "ICRD")
_LONGEST: Final = 1 << 16
"""Bytes of a chunk that describes the samples which are looked at."""

_DATE: Final = re.compile(
    rb"(\d{4})[-_:. /](\d\d)[-_:. /](\d\d)(\d\d)[-_:. ](\d\d)[-_:. ](\d\d)"
)


@final
@dataclass(frozen=True, slots=True)
class _Chunk:
    """A part of the file: its name, where its content begins, and how long it says to be."""

    name: bytes
    first: int
    size: int


@final
@dataclass(frozen=True, slots=True)
class _Format:
    """How the samples stand: numbers a frame, rate [Hz], bytes a second and a frame, type."""

    tag: int
    channels: int
    rate: int
    per_second: int
    frame: int
    dtype: "np.dtype[Any]"


@final
@dataclass(slots=True, eq=False)
class _Chunks:
    """The chunks of a file: format, samples, texts and start."""

    chunks: dict[bytes, _Chunk] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    promised: int = 0
    unfinished: bool = False


def read_wav(path: Path, run: str) -> RawFile:
    """Return the channels of a WAV file.

    Raises
    ------
    RecordingError
        If it is none, its samples are packed, or it is not what its chunks say.
    """
    with foreign(run, "reading the chunks"):
        return kept_open(opened(path, run), lambda file: _read(file, run))


def _read(file: BinaryIO, run: str) -> RawFile:
    size = os.fstat(file.fileno()).st_size
    head = file.read(12)
    order = _ORDERS.get(head[:4])
    if order is None or head[8:] != b"WAVE":
        raise RecordingError(
            f"{run}: byte 0: {shown(head.decode('latin-1'))} begins no WAV file, which is "
            f"RIFF, RIFX or RF64 with WAVE. {AGAIN}"
        )
    riff = _chunks(file, size, int.from_bytes(head[4:8], _endian(order)), order, run)
    said = _format(_content(file, riff, b"fmt ", run), riff.chunks[b"fmt "].first, order, run)
    data = riff.chunks.get(b"data")
    if data is None:
        raise RecordingError(f"{run}: no samples in it: the chunk 'data' is missing. {AGAIN}")
    there = max(0, min(data.size, size - data.first)) // said.frame
    promised = max(-(-riff.promised // said.frame), there + riff.unfinished)
    samples = Frames(
        run, file, data.first, (there, said.channels), said.dtype, _decoding(said, order)
    )
    if there < promised:
        riff.notes.append(
            "The recorder never wrote how long it is: samples are read to the end of the file."
            if riff.unfinished
            else f"The file is not whole: it ends after {there} of {promised} samples."
        )
    start_time, axes = _times(file, riff, said, run)
    channels = tuple(
        RawChannel(f"channel {number + 1}", number, there, promised,
                   start_time=start_time, axes=axes)
        for number in range(said.channels)
    )  # fmt: skip
    lines = tuple(ArrayRow(samples, number, upright=True) for number in range(said.channels))
    return RawFile(
        (RawGroup("", channels),),
        LinesSource(run, lines, file),
        (*riff.notes, *_described(file, riff, said, run)),
    )


def _endian(order: str) -> Any:
    return "big" if order == ">" else "little"


def _chunks(file: BinaryIO, size: int, whole: int, order: str, run: str) -> _Chunks:
    """Return where the parts of a file are, and how long its samples should be [byte].

    What stands behind the samples has to be chunks too, up to the end of the file or to the
    one that it states: else the length of the samples is wrong.

    Raises
    ------
    RecordingError
        If something else stands there.
    """
    riff, at, longer = _Chunks(), 12, {}
    end = whole + 8
    while at + 8 <= size and at != end:
        file.seek(at)
        name, length = struct.unpack(f"{order}4sI", file.read(8))
        if name == b"ds64":
            longer = _long_sizes(file.read(min(length, _LONGEST)), order)
            end = longer.get(b"", whole) + 8
        if length == _LATER and name in longer:
            length = longer[name]
        known = _is_name(name)
        if name == b"data" and (length == _LATER or (not length and at + 8 < size == end)):
            riff.unfinished, length = True, size - at - 8
        if not known or (b"data" in riff.chunks and at + 8 + length > size >= end):
            raise RecordingError(
                f"{run}: byte {at}: {shown(name.decode('latin-1'))} of {length} bytes is no "
                f"chunk, so that the one before it is not as long as it says. {AGAIN}"
            )
        if name == b"data":
            riff.promised = 0 if riff.unfinished else length
        riff.chunks.setdefault(name, _Chunk(name, at + 8, length))
        at += 8 + length + length % 2
    left = size - at
    if left > 0 and end not in {at, at - 1}:
        if size >= end:
            raise RecordingError(
                f"{run}: byte {at}: {left} bytes at the end belong to no chunk, so that the "
                f"one before them is not as long as it says. {AGAIN}"
            )
        riff.notes.append("The file is not whole: it ends inside the name of a chunk.")
    elif left > 0:
        riff.notes.append(f"{left} bytes behind the end that the file states are left out.")
    return riff


def _is_name(name: bytes) -> bool:
    return all(32 <= letter < 127 for letter in name)


def _long_sizes(content: bytes, order: str) -> dict[bytes, int]:
    """Return the lengths of a file of more than 4 GB, of the whole under an empty name."""
    if len(content) < 28:
        return {}
    whole, data, _, count = struct.unpack_from(f"{order}QQQI", content)
    sizes = {b"": whole, b"data": data}
    for at in range(28, min(28 + 12 * count, len(content) - 11), 12):
        name, length = struct.unpack_from(f"{order}4sQ", content, at)
        sizes[name] = length
    return sizes


def _content(file: BinaryIO, riff: _Chunks, name: bytes, run: str) -> bytes:
    """Return the content of a chunk that describes the samples; empty where it may lack.

    Raises
    ------
    RecordingError
        If there is no format.
    """
    chunk = riff.chunks.get(name)
    if chunk is None:
        if name == b"fmt ":
            raise RecordingError(f"{run}: the chunk 'fmt ' is missing. {AGAIN}")
        return b""
    file.seek(chunk.first)
    return file.read(min(chunk.size, _LONGEST))


def _format(content: bytes, place: int, order: str, run: str) -> _Format:
    """Return how the samples stand.

    Raises
    ------
    RecordingError
        If they are packed, or no numbers can stand as it says.
    """
    if len(content) < 16:
        raise RecordingError(
            f"{run}: byte {place}: the chunk 'fmt ' has {len(content)} bytes, not 16. {AGAIN}"
        )
    tag, channels, rate, per_second, frame, bits = struct.unpack_from(f"{order}HHIIHH", content)
    if tag == _EXTENSIBLE and len(content) >= 40:
        (tag,) = struct.unpack_from(f"{order}H", content, 24)
        if content[26:40] != _GUID and order == "<":
            tag = _EXTENSIBLE
    if tag not in {_PCM, _FLOAT}:
        raise RecordingError(
            f"{run}: its samples are packed as {_PACKED.get(tag, f'type {tag:#06x}')}, which "
            "is no measurement. Export as WAV with PCM or float samples."
        )
    width, rest = divmod(frame, channels) if channels else (0, 1)
    usual = width == -(-bits // 8) or (width == 4 and 16 < bits <= 32)
    fits = usual and width in ({1, 2, 3, 4} if tag == _PCM else {4, 8})
    if rest or not fits:
        raise RecordingError(
            f"{run}: byte {place}: {channels} channels of {bits} bits cannot stand in {frame} "
            f"bytes, as the chunk 'fmt ' says. {AGAIN}"
        )
    kind = f"{order}f{width}" if tag == _FLOAT else {1: "u1", 3: "V3"}.get(width)
    return _Format(tag, channels, rate, per_second, frame, np.dtype(kind or f"{order}i{width}"))


def _decoding(said: _Format, order: str) -> Any:
    """Return the function from numbers of a file to shares of full scale; None for floats."""
    if said.tag == _FLOAT:
        return None
    width = said.dtype.itemsize
    if width == 1:
        return lambda raw: (raw.astype(np.float64) - 128.0) / 128.0
    if width == 3:
        return lambda raw: _of_three_bytes(raw, order)
    return lambda raw: raw.astype(np.float64) / 2.0 ** (8 * width - 1)


def _of_three_bytes(raw: NDArray[Any], order: str) -> NDArray[np.float64]:
    """Return numbers of 24 bits as shares of full scale, by way of 32 bits."""
    wide = np.zeros((raw.size, 4), np.uint8)
    wide[:, slice(1, 4) if order == "<" else slice(0, 3)] = raw.view(np.uint8).reshape(-1, 3)
    return wide.view(f"{order}i4").reshape(raw.shape) / 2.0**31


def _times(
    file: BinaryIO, riff: _Chunks, said: _Format, run: str
) -> tuple[datetime | None, tuple[TimeAxis, ...]]:
    """Return the day on which a recording began, and the times that the file states.

    The rate stands there twice.
    """
    day, start, digit = _broadcast_start(_content(file, riff, b"bext", run), said.rate)
    alike = said.per_second == said.rate * said.frame
    problem = "" if alike else (
        f"the file contradicts itself: {said.rate} samples a second of {said.frame} bytes, but "
        f"{said.per_second} bytes a second"
    )  # fmt: skip
    axis = TimeAxis("'fmt '", rate=said.rate, start=start, start_digit=digit, problem=problem)
    return day, (axis,)


def _broadcast_start(content: bytes, rate: int) -> tuple[datetime | None, float, float]:
    """Return the day on which a broadcast file begins, seconds since midnight, and their digit.

    Samples since midnight count where they agree with its time of day, which is good to a
    second; `rate` is in [Hz].
    """
    match = _DATE.match(content[320:338])
    try:
        begin = datetime(*map(int, match.groups()), tzinfo=UTC) if match else None  # type: ignore[arg-type, misc]
    except ValueError:
        begin = None
    if begin is None:
        return None, 0.0, 0.0
    day = begin.replace(hour=0, minute=0, second=0)
    start = (begin - day).total_seconds()
    since = int.from_bytes(content[338:346], "little")
    if rate and since and abs(since / rate - start) <= 1.0:
        return day, since / rate, 0.0
    return day, start, 0.5


def _described(file: BinaryIO, riff: _Chunks, said: _Format, run: str) -> Iterator[str]:
    """Yield notes on the samples, and the texts that the file carries."""
    bits = 8 * said.dtype.itemsize
    if said.tag == _PCM:
        yield (
            f"Whole numbers of {bits} bits are read as shares of full scale, -1 to 1: the log "
            "says what it stands for, such as unit: 10 V."
        )
    content = _content(file, riff, b"LIST", run)
    if content[:4] != b"INFO":
        return
    at = 4
    while at + 8 <= len(content):
        name = content[at : at + 4].decode("latin-1")
        size = int.from_bytes(content[at + 4 : at + 8], "little")
        text = content[at + 8 : at + 8 + size].split(b"\0")[0].decode("utf-8", "replace")
        if name in _TEXTS and text.strip():
            yield f"The file says of itself ({name}): {shown(text.strip())}."
        at += 8 + size + size % 2
