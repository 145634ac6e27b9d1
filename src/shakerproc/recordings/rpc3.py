"""Read MTS RPC III (.rsp, .rpc): a header of named values, then groups of samples.

The format is short, and a drive file of some GB is read a slice at a time. Samples of 16 bits
are multiplied by the scale of their channel.

References
----------
.. [1] MTS Systems Corporation, "RPC III file specification", 2000.
"""

import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO, Final, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.errors import RecordingError
from shakerproc.recordings.guard import AGAIN, foreign, kept_open, opened, shown
from shakerproc.recordings.raw import (
    Frames,
    RawChannel,
    RawFile,
    RawGroup,
    SlicedSource,
    TimeAxis,
    half_digit,
)

_KEY, _RECORD = 32, 128
"""Bytes of a name, and of a name with its value."""

_BLOCK: Final = 512
_MOST_BLOCKS: Final = 1024
_ORDERS: Final = {"BINARY": "<", "BINARY_IEEE_LITTLE_END": "<", "BINARY_IEEE_BIG_END": ">"}
_NUMBERS: Final = {"SHORT_INTEGER": "i2", "FLOATING_POINT": "f4"}
_OTHER_ORDERS: Final = {2: ((1, 0),), 4: ((3, 2, 1, 0), (1, 0, 3, 2), (2, 3, 0, 1))}
"""In what other orders the bytes of a number may stand: of other machines, or of VMS."""

_PIECES, _PIECE = 16, 1024
"""How many pieces of so many samples tell in what order the bytes stand."""

_LARGEST: Final = np.finfo(np.float32).max
"""Stands for a float that is not finite, where powers of two are compared."""

_KNOWN: Final = {"PARTITIONS": 1, "HALF_FRAMES": 0}
"""Where a header says more, programs differ on which sample is which."""

_Numbers: TypeAlias = Callable[[Sequence[int], int, int], NDArray[Any]]
"""From rows, first sample and the one behind the last to their numbers in the file."""


def read_rpc3(path: Path, run: str) -> RawFile:
    """Return the channels of an RPC III time history.

    Raises
    ------
    RecordingError
        If it is none, or its header is not whole.
    """
    return kept_open(opened(path, run), lambda file: _read(file, run))


def _read(file: BinaryIO, run: str) -> RawFile:
    """Return the channels of an open file."""
    header = _header(file.read(_MOST_BLOCKS * _BLOCK), run)
    layout = _layout(header, os.fstat(file.fileno()).st_size, run)
    shape = (layout.whole // layout.per_group, layout.channels * layout.per_group)
    frames = Frames(run, file, layout.first, shape, np.dtype(layout.dtype))
    numbers = partial(_numbers, frames, layout)
    with foreign(run, "reading the samples"):
        _check_order(numbers, layout, header["FORMAT"], run)
    source = SlicedSource(run, partial(_samples, numbers, layout.scales), file)
    step = _number(header, "DELTA_T", run)
    axes = (TimeAxis("DELTA_T", step=step, unit="s",
                     digit=half_digit(header["DELTA_T"])),)  # fmt: skip
    channels = tuple(
        RawChannel(
            name=header.get(f"DESC.CHAN_{number}") or f"channel {number}",
            row=number - 1,
            n_samples=min(layout.promised, layout.whole),
            promised=layout.promised,
            unit=header.get(f"UNITS.CHAN_{number}", ""),
            axes=axes,
        )
        for number in range(1, layout.channels + 1)
    )
    notes = [] if "SAMPLES" in header else [
        "The header does not say how many samples there are (SAMPLES): the last group may end "
        "with values that only fill it."
    ]  # fmt: skip
    return RawFile((RawGroup("", channels),), source, tuple(notes))


@final
@dataclass(frozen=True, slots=True)
class SampleLayout:
    """Where the samples are: groups, in each the same number of samples of every channel.

    Attributes
    ----------
    dtype : str
        Of a number.
    first : int
        Byte of the first.
    channels, per_group : int
        How many channels, and samples of each in a group.
    promised, whole : int
        Samples of a channel that the header says, and that are there in whole groups.
    scales : tuple of float
        Of each channel [unit of the channel per count].
    """

    dtype: str
    first: int
    channels: int
    per_group: int
    promised: int
    whole: int
    scales: tuple[float, ...]


def _numbers(
    frames: Frames, layout: SampleLayout, rows: Sequence[int], start: int, stop: int
) -> NDArray[Any]:
    """Return numbers as they stand in the file, a line for each row [-]."""
    size, first = layout.per_group, start // layout.per_group
    at, count = start - first * size, stop - start
    if at + count <= size:  # of a group that is the whole file, no more than asked for
        ends = [(row * size + at, row * size + at + count) for row in rows]
        return np.stack([frames[first, begin:end] for begin, end in ends])
    groups = frames[first : -(-stop // size)].reshape(-1, layout.channels, size)
    lines = groups.swapaxes(0, 1)[list(rows)].reshape(len(rows), -1)
    return lines[:, at : at + count]


def _samples(
    numbers: _Numbers, scales: Sequence[float], rows: Sequence[int], start: int, stop: int
) -> Iterator[FloatArray]:
    """Yield samples of rows [unit of the channel]."""
    for row, line in zip(rows, numbers(rows, start, stop), strict=True):
        yield line * np.float64(scales[row])


def _header(content: bytes, run: str) -> Mapping[str, str]:
    """Return the values of a header by their names.

    Raises
    ------
    RecordingError
        If it is no such header, or is cut.
    """
    records = [content[at : at + _RECORD] for at in range(0, len(content), _RECORD)]
    pairs = [(_text(one[:_KEY]), _text(one[_KEY:])) for one in records[:3]]
    if [key for key, _ in pairs] != ["FORMAT", "NUM_HEADER_BLOCKS", "NUM_PARAMS"]:
        raise RecordingError(
            f"{run}: does not begin as an RPC III file does (FORMAT, NUM_HEADER_BLOCKS, "
            f"NUM_PARAMS). {AGAIN}"
        )
    entries = dict(pairs)
    count = _whole(entries, "NUM_PARAMS", run)
    blocks = _whole(entries, "NUM_HEADER_BLOCKS", run)
    if not (3 <= count <= 4 * blocks <= 4 * _MOST_BLOCKS) or len(content) < count * _RECORD:
        raise RecordingError(
            f"{run}: the header says {count} values in {blocks} blocks: no fit. {AGAIN}"
        )
    return {_text(one[:_KEY]): _text(one[_KEY:]) for one in records[:count]}


def _text(cell: bytes) -> str:
    return cell.decode("latin-1").partition("\0")[0].strip()


def _layout(header: Mapping[str, str], size: int, run: str) -> SampleLayout:
    """Return where the samples are.

    Raises
    ------
    RecordingError
        If the header does not say it, or they are of a kind that is not read.
    """
    kind = header.get("FILE_TYPE", "TIME_HISTORY")
    if kind != "TIME_HISTORY":
        raise RecordingError(
            f"{run}: holds {shown(kind, 40)}, no time history. Export the samples over time."
        )
    stated = header["FORMAT"], header.get("DATA_TYPE", "SHORT_INTEGER")
    order, number = _ORDERS.get(stated[0]), _NUMBERS.get(stated[1])
    if order is None or number is None:
        raise RecordingError(
            f"{run}: numbers of {shown(' '.join(stated), 60)} are not read. Save the file as "
            "BINARY with SHORT_INTEGER or FLOATING_POINT."
        )
    channels, per_group = (_whole(header, k, run) for k in ("CHANNELS", "PTS_PER_GROUP"))
    frames, per_frame = (_whole(header, k, run) for k in ("FRAMES", "PTS_PER_FRAME"))
    for key, most in _KNOWN.items():
        if key in header and _whole(header, key, run) > most:
            raise RecordingError(
                f"{run}: {key} is {shown(header[key], 30)}; programs differ on where the "
                f"samples stand then. Export the file with {key} {most}."
            )
    if not channels or not per_group or per_group % max(per_frame, 1):
        raise RecordingError(
            f"{run}: {channels} channels in groups of {per_group} and frames of {per_frame} "
            f"samples do not fit. {AGAIN}"
        )
    first = _whole(header, "NUM_HEADER_BLOCKS", run) * _BLOCK
    dtype = np.dtype(order + number)
    groups = max(0, size - first) // (dtype.itemsize * channels * per_group)
    framed = frames * per_frame
    promised = _whole(header, "SAMPLES", run) if "SAMPLES" in header else framed
    if promised > framed:
        raise RecordingError(
            f"{run}: the header says {promised} samples in {framed} places. {AGAIN}"
        )
    if not groups:
        raise RecordingError(f"{run}: the file ends before its first samples. {AGAIN}")
    scaled = stated[1] == "SHORT_INTEGER"
    numbers = range(1, channels + 1)
    scales = [_number(header, f"SCALE.CHAN_{n}", run) if scaled else 1.0 for n in numbers]
    return SampleLayout(
        dtype.str, first, channels, per_group, promised, groups * per_group, tuple(scales),
    )  # fmt: skip


def _check_order(
    numbers: _Numbers,
    layout: SampleLayout,
    said: str,
    run: str,
) -> None:
    """Pass numbers whose neighbours are as near as in any other order of their bytes.

    Raises
    ------
    RecordingError
        If the differences take a bit less, in the mean, in another order.
    """
    rows, whole = range(layout.channels), layout.whole
    starts = np.linspace(0, max(0, whole - _PIECE), _PIECES).astype(int).tolist()
    pieces = [numbers(rows, at, min(at + _PIECE, whole)) for at in sorted(set(starts))]
    size = pieces[0].itemsize
    as_said, *others = (
        np.mean([_bits(piece, order) for piece in pieces])
        for order in (tuple(range(size)), *_OTHER_ORDERS[size])
    )
    saved = as_said - min(others)
    if saved > 1.0:
        raise RecordingError(
            f"{run}: FORMAT says {shown(said, 40)}, but with their bytes in another "
            f"order numbers differ from the next by {saved:.0f} bits less: the order is wrong. "
            "Correct FORMAT (BINARY_IEEE_BIG_END, BINARY_IEEE_LITTLE_END), or export the file "
            "as BINARY_IEEE_LITTLE_END with FLOATING_POINT."
        )


def _bits(numbers: NDArray[Any], order: Sequence[int]) -> float:
    """Return the mean size of differences of neighbours, their bytes in an order [bit].

    Of floats, that of their powers of two: a wrong order gives any. Zero has none.
    """
    stored = np.ascontiguousarray(numbers)
    places = stored.view(np.uint8).reshape(*stored.shape, -1)[..., list(order)]
    whole = places.copy().view(stored.dtype)[..., 0]
    if stored.dtype.kind == "i":
        steps = np.diff(whole.astype(np.int64), axis=-1)
    else:
        finite = np.where(np.isfinite(whole), whole, _LARGEST)
        steps = np.diff(np.frexp(finite)[1], axis=-1)[
            (finite[:, 1:] != 0.0) & (finite[:, :-1] != 0.0)
        ]
    return float(np.log2(1.0 + np.abs(steps)).mean()) if steps.size else 0.0


def _number(header: Mapping[str, str], key: str, run: str) -> float:
    """Return a number of the header.

    Raises
    ------
    RecordingError
        If it is none.
    """
    try:
        value = float(header.get(key, ""))
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise RecordingError(
            f"{run}: the header has {key} {shown(header.get(key, 'nowhere'), 30)}, which is no "
            f"number. {AGAIN}"
        )
    return value


def _whole(header: Mapping[str, str], key: str, run: str) -> int:
    """Return a whole number of the header, at least 0.

    Raises
    ------
    RecordingError
        If it is none.
    """
    value = _number(header, key, run)
    if value != int(value) or not 0 <= value < 1 << 40:
        raise RecordingError(
            f"{run}: {key} is {shown(header[key], 30)}, no whole number. {AGAIN}"
        )
    return int(value)
